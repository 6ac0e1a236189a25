"""What can be asked of a system: one class a kind of analysis, with the keywords of its function.

A keyword that the scene leaves out is not passed on, so that its default stands in one place: the function.
"""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from chaosdrill.scene.numerics import Numerics, Steps, Tolerance
from chaosdrill.scene.strict import Strict

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import xarray as xr

MOST_POINTS = 1_000_000

# what is longer than this would not end; it is a slip of the pen
LONGEST = 10**10

Count = Annotated[int, Field(ge=1, le=MOST_POINTS)]
Periods = Annotated[int, Field(ge=1, le=LONGEST)]
Amount = Annotated[float | int, Field(gt=0, le=LONGEST)]
Transient = Annotated[float | int, Field(ge=0, le=LONGEST)]


class Analysis(Strict):
    """What all kinds share."""

    parallel: ClassVar[bool] = False
    own_numerics: ClassVar[bool] = False
    """Whether the kind names methods and tolerances itself, and takes none from the table numerics."""

    kind: str

    def keywords(self) -> dict[str, Any]:
        """Arguments of the analysis function that the scene gives."""
        return self.model_dump(exclude={"kind"}, exclude_unset=True)

    def run(
        self,
        system: Any,
        numerics: Numerics,
        *,
        workers: int = 1,
        scheduler: str | None = None,
        store: "Path | None" = None,
        progress: "Callable[..., None] | None" = None,
    ) -> "xr.Dataset":
        """Run the analysis.

        Parameters
        ----------
        system : HybridSystem
        numerics : Numerics
            Method and tolerance.
        workers : int
            Points computed at a time, where the kind has several; results do not depend on it.
        scheduler : str, optional
            Address of a Dask scheduler whose workers compute them instead.
        store : path, optional
            Folder for finished chunks, where the kind has several points.
        progress : callable, optional
            Called with points or periods done, their total, and counts by outcome.

        Returns
        -------
        xarray.Dataset
        """
        import chaosdrill.analysis
        from chaosdrill.analysis.registry import ANALYSES

        function = getattr(chaosdrill.analysis, ANALYSES[self.kind].function)
        keywords = self.keywords()
        if self.parallel:
            keywords |= {"workers": workers, "scheduler": scheduler, "store": store}
        if not self.own_numerics:
            keywords |= numerics.keywords()
        result: xr.Dataset = function(system, **keywords, progress=progress)
        return result


class Record(Analysis):
    """A run of one length: in forcing periods, or in time units for a system without a period."""

    periods: Periods | None = None
    duration: Amount | None = None
    transient: Transient = 0

    @model_validator(mode="after")
    def _one_length(self) -> "Record":
        if (self.periods is None) == (self.duration is None):
            raise PydanticCustomError("length", "give either periods (forcing periods) or duration (time units)")
        return self


class Trajectory(Record):
    """Keywords of `trajectory`."""

    samples: Count | None = None


class PoincareSection(Record):
    """Keywords of `poincare_section`."""

    at: str = "strobe"
    max_period: Count | None = None


class LyapunovSpectrum(Record):
    """Keywords of `lyapunov_spectrum`."""

    exponents: Count | None = None
    blocks: Count | None = None


class Range(Strict):
    """Equally spaced values, both ends included."""

    start: float
    stop: float
    num: Annotated[int, Field(ge=1, le=MOST_POINTS)]

    @model_validator(mode="after")
    def _distinct(self) -> "Range":
        if self.start == self.stop and self.num > 1:
            raise PydanticCustomError("distinct", "start and stop are the same; give num = 1, or another stop")
        return self

    def values(self) -> Any:
        """The values as an array of shape (num,)."""
        import numpy as np

        return np.linspace(self.start, self.stop, self.num)


def _distinct(values: list[Any]) -> list[Any]:
    if len(set(values)) < len(values):
        raise PydanticCustomError("distinct", "holds a value twice; each may stand there once")
    return values


List = Annotated[list[float], Field(min_length=1, max_length=MOST_POINTS), AfterValidator(_distinct)]
Values = Annotated[
    Annotated[Range, Tag("range")] | Annotated[List, Tag("list")],
    Discriminator(lambda raw: "list" if isinstance(raw, list) else "range"),
]


Box = Annotated[list[float], Field(min_length=2, max_length=2)]


class Random(Strict):
    """Random initial states; all other keys are states with the range from which they are drawn."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Box]

    count: Annotated[int, Field(ge=1, le=10_000)]
    seed: Annotated[int, Field(ge=0, le=2**53)]
    mode: str | None = None

    @model_validator(mode="after")
    def _ranges(self) -> "Random":
        if not self.__pydantic_extra__:
            raise PydanticCustomError("no_range", "names no state; give the range of at least one, as in y = [-1, 1]")
        for name, (low, high) in self.__pydantic_extra__.items():
            if not low < high:
                raise PydanticCustomError("range", f"the range of {name} is to rise: [low, high] with low < high")
        return self


class Points(Analysis):
    """What sweeps and basins share: every point is a run of its own."""

    parallel: ClassVar[bool] = True

    transient: Annotated[int, Field(ge=0, le=LONGEST)]
    periods: Annotated[int, Field(ge=2, le=LONGEST)]
    exponents: Annotated[int, Field(ge=0)] | None = None
    at: str = "strobe"
    max_period: Annotated[int, Field(ge=1, le=10_000)] | None = None
    patience: Annotated[int, Field(ge=0, le=LONGEST)] | None = None

    def keywords(self) -> dict[str, Any]:
        """Arguments of the function, the values of sweeps and grids as arrays."""
        axes = {
            key: {name: array_of(values) for name, values in getattr(self, key).items()}
            for key in ("sweep", "grid")
            if key in type(self).model_fields
        }
        return super().keywords() | axes


def array_of(values: Range | list[float]) -> Any:
    """The values of a sweep as an array."""
    import numpy as np

    return values.values() if isinstance(values, Range) else np.array(values, dtype=float)


class Seeded(Points):
    """A sweep from several initial states."""

    seeds: Annotated[list[dict[str, float | str]], Field(min_length=1)] | None = None
    random: Random | None = None


class BifurcationDiagram(Seeded):
    """Keywords of `bifurcation_diagram`."""

    sweep: Annotated[dict[str, Values], Field(min_length=1, max_length=1)]
    follow: Literal["forward", "backward", "both"] | None = None


class ParameterChart(Seeded):
    """Keywords of `parameter_chart`."""

    sweep: Annotated[dict[str, Values], Field(min_length=2, max_length=2)]


class Basins(Points):
    """Keywords of `basins`."""

    grid: Annotated[dict[str, Values], Field(min_length=2, max_length=2)]


class WorkPrecision(Record):
    """Keywords of `work_precision`."""

    own_numerics: ClassVar[bool] = True

    methods: Annotated[list[str], Field(min_length=1), AfterValidator(_distinct)] | None = None
    tolerances: Annotated[list[Tolerance], Field(min_length=1), AfterValidator(_distinct)] | None = None
    steps: Annotated[list[Steps], Field(min_length=1)] | None = None
    repeats: Annotated[int, Field(ge=1, le=1000)] | None = None


KINDS: dict[str, type[Analysis]] = {
    "trajectory": Trajectory,
    "poincare-section": PoincareSection,
    "lyapunov-spectrum": LyapunovSpectrum,
    "bifurcation-diagram": BifurcationDiagram,
    "parameter-chart": ParameterChart,
    "basins": Basins,
    "work-precision": WorkPrecision,
}

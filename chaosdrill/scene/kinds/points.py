"""Many points: diagrams and charts over parameters, basins over initial states."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from chaosdrill.scene.kinds.base import LONGEST, MOST_POINTS, Analysis, all_different
from chaosdrill.scene.strict import Strict


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


List = Annotated[list[float], Field(min_length=1, max_length=MOST_POINTS), AfterValidator(all_different)]
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
    counts_periods: ClassVar[bool] = True

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

    section_points: Annotated[int, Field(ge=0, le=10_000)] | None = None

    sweep: Annotated[dict[str, Values], Field(min_length=2, max_length=2)]


class Basins(Points):
    """Keywords of `basins`."""

    grid: Annotated[dict[str, Values], Field(min_length=2, max_length=2)]

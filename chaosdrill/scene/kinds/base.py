"""What all kinds of analysis share, and the numbers that they may be given."""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field
from pydantic_core import PydanticCustomError

from chaosdrill.scene.numerics import Numerics
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
    counts_periods: ClassVar[bool] = False
    """Whether its lengths are forcing periods and nothing else, so that it needs a system that is forced."""

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


def all_different(values: list[Any]) -> list[Any]:
    """Refuse a list that holds a value twice."""
    if len(set(values)) < len(values):
        raise PydanticCustomError("distinct", "holds a value twice; each may stand there once")
    return values

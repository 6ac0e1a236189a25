"""Declaration of a picture, and the list of all pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from inspect import signature
from typing import TYPE_CHECKING, Any, TypeVar

from chaosdrill.errors import SettingsError
from chaosdrill.plots.companions import swept

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

F = TypeVar("F", bound="Callable[..., Figure]")


@dataclass(frozen=True)
class Picture:
    """A picture that can be drawn of one kind of dataset.

    Parameters
    ----------
    kind : str
        Kind of analysis that it shows.
    name : str
        Its name, part of the file's name.
    summary : str
        What it shows, in a few words.
    function : callable
        It takes the dataset and returns a matplotlib figure. That of a picture with ``over`` takes all datasets that
        belong together, and what they lie over as ``over``.
    states, seeds : int, default 1
        How many states the system, and how many seeds the dataset, must have for it.
    needs : str, default ""
        Variable of which it must hold a finite value.
    parameters : int, default 0
        How many parameters the analysis ran through; 0 if that does not matter.
    listed : bool, optional
        Whether it is of runs in a list, with the dimension ``run``, or of others; default: of either.
    values : int, default 0
        How many values of them there must be; 0 if that does not matter.
    over : str, default ""
        Kind of dataset that it is drawn over, where the archive holds one of the same system over the same parameters.
        All groups over these, and over the same range of a single one, go into one picture.
    """

    kind: str
    name: str
    summary: str
    function: "Callable[..., Any]"
    states: int = 1
    seeds: int = 1
    needs: str = ""
    parameters: int = 0
    listed: bool | None = None
    values: int = 0
    over: str = ""

    @property
    def shows_states(self) -> bool:
        """Whether it shows states of which one can be chosen."""
        return "state" in signature(self.function).parameters

    def draw(
        self,
        *datasets: "xr.Dataset",
        over: "xr.Dataset | None" = None,
        ax: "Axes | None" = None,
        state: "str | Sequence[str] | None" = None,
    ) -> "Figure":
        """Return the figure of a dataset, or of several that belong together.

        Parameters
        ----------
        *datasets : xarray.Dataset
        over : xarray.Dataset, optional
            What it is drawn over.
        ax : matplotlib.axes.Axes, optional
            Where its main panel alone is drawn.
        state : str or sequence of str, optional
            States that it shows.

        Raises
        ------
        SettingsError
            It shows no states of which one could be chosen, or has no main panel.
        """
        given = {name: value for name, value in (("ax", ax), ("state", state)) if value is not None}
        taken = signature(self.function).parameters
        if "ax" in given and "ax" not in taken:
            raise SettingsError(f"ax is one, but the panels of the picture {self.name!r} belong together; leave it out")
        if "state" in given and not self.shows_states:
            raise SettingsError(f"state is {state!r:.60}, but the picture {self.name!r} shows no single states")
        return self.function(*datasets, **given, **({"over": over} if self.over else {}))

    def suits(self, dataset: "xr.Dataset") -> bool:
        """Return whether the picture can be drawn of this dataset."""
        import numpy as np

        return (
            dataset.attrs.get("kind") == self.kind
            and dataset.sizes.get("state", self.states) >= self.states
            and dataset.sizes.get("seed", 1) >= self.seeds
            and self.listed in (None, "run" in (dataset.dims if self.listed else dataset.coords))
            and self.parameters in (0, len(swept(dataset)))
            and self.values in (0, *(dataset.sizes.get(name, 1) for name in swept(dataset)))
            and (
                not self.needs
                or (self.needs in dataset.variables and bool(np.isfinite(dataset[self.needs].values).any()))
            )
        )


PICTURES: list[Picture] = []
"""All pictures; `chaosdrill.plots` imports every module that has some."""


def picture(kind: str, name: str, summary: str, **when: Any) -> Callable[[F], F]:
    """Make a picture of a function: its kind, name and summary, and when it suits, as in `Picture`."""

    def wrap(function: F) -> F:
        PICTURES.append(Picture(kind, name, summary, function, **when))
        return function

    return wrap

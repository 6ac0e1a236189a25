"""What the study shares: archives, special points with the orbits around them, tables, systems of datasets."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

import chaosdrill as cd
from chaosdrill.dataset.outcomes import flag_names


def read(path: Path, group: str) -> xr.Dataset:
    """Return one group of an archive, in memory."""
    with xr.open_datatree(path) as tree:
        return tree[group].to_dataset().load()


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table."""
    names = list(head)
    return "".join("| " + " | ".join(line) + " |\n" for line in [names, ["---"] * len(names), *rows])


def parameter(branches: xr.Dataset) -> str:
    """Return the name of the parameter that branches were followed in."""
    return str(next(iter(json.loads(branches.attrs["settings"])["sweep"])))


def system_of(branches: xr.Dataset, value: float) -> "cd.HybridSystem":
    """Return the system of branches at a value of their parameter."""
    parameters = json.loads(branches.attrs["parameters"]) | {parameter(branches): value}
    if branches.attrs["system"] == "percussive-drill":
        return cd.drill(**parameters)
    return cd.build(branches.attrs["system"], parameters)


TWIN = 1e-12
"""Distance in the parameter within which a neighbour of a special point is the same point."""


@dataclass(frozen=True)
class Special:
    """A special point of a branch.

    Parameters
    ----------
    branches : xarray.Dataset
    point : int
        Its number among all points.
    value : float
        Parameter there.
    text : str
        What happens, in words.
    """

    branches: xr.Dataset
    point: int
    value: float
    text: str

    @property
    def period(self) -> int:
        """Period of the orbit."""
        return int(self.branches["period"].values[self.point])

    @property
    def branch(self) -> int:
        """Number of the branch."""
        return int(self.branches["branch"].values[self.point])

    def orbit(self, point: int) -> tuple[np.ndarray, str]:
        """Return the strobes of the orbit at a point, shape (k, n), and the mode at the first."""
        period = int(self.branches["period"].values[point])
        mode = flag_names(self.branches["mode"])[int(self.branches["mode"].values[point])]
        return self.branches["section"].values[point, :period], mode

    def along(self, way: int) -> np.ndarray:
        """Return the points of the branch from here on, forward (1) or backward (-1), this one first."""
        points = np.flatnonzero(self.branches["branch"].values == self.branch)
        here = int(np.flatnonzero(points == self.point)[0])
        points = points[here:] if way > 0 else points[here::-1]
        values = self.branches[parameter(self.branches)].values[points]
        # the same orbit may stand there twice, with and without an event of no speed
        return points[(np.abs(values - self.value) > TWIN) | (np.arange(len(points)) == 0)]

    def stretch(self, way: int) -> np.ndarray:
        """Return these points up to where the parameter turns back."""
        return until_turning(self.branches[parameter(self.branches)].values, self.along(way))


def until_turning(values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points in a row up to where the parameter turns back."""
    steps = np.diff(values[points])
    back = np.flatnonzero(steps * steps[:1] <= 0)
    return points[: int(back[0]) + 1] if len(back) else points


def special_points(branches: xr.Dataset, kind: str, numbers: Iterable[int] | None = None) -> Iterator[Special]:
    """Yield the special points of one kind, of all branches or some."""
    names = flag_names(branches["special_kind"])
    wanted = None if numbers is None else set(numbers)
    for i in range(branches.sizes["special"]):
        point = int(branches["special_index"].values[i])
        special = Special(
            branches, point, float(branches["special_value"].values[i]), str(branches["special_text"].values[i])
        )
        if names[int(branches["special_kind"].values[i])] == kind and (wanted is None or special.branch in wanted):
            yield special


def start(system: "cd.HybridSystem", state: np.ndarray, mode: str) -> dict[str, float | str]:
    """Return an initial state by name."""
    return {**{name: float(x) for name, x in zip(system.state_names, state, strict=True)}, "mode": mode}

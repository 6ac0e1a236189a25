"""Branches of periodic orbits over a parameter, over the bifurcation diagram where there is one."""

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.plots.bifurcation import first_that_varies
from chaosdrill.plots.companions import limits, swept
from chaosdrill.plots.looks import BACKGROUND, Look
from chaosdrill.plots.marks import bar, end_label, ends, mark, named_once, period_looks, specials, warn
from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import axis_label, legend_outside, new_figure, state_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_MARK, _BAR = 6.5, 11.0
_JUMP = 12.0
"""A step of the section this many times as long as both its neighbours is a jump."""
_SEEN = 0.01
"""Jumps below this part of the extent are not seen."""


@picture(
    "continuation",
    "branches",
    "branches of orbits and their special points, over the bifurcation diagram if there is one",
    parameters=1,
    over="bifurcation-diagram",
)
def branches(*datasets: "xr.Dataset", over: "xr.Dataset | None" = None) -> "Figure":
    """Draw branches of periodic orbits over the parameter.

    Parameters
    ----------
    *datasets : xarray.Dataset
        Of kind ``continuation``, all over the same one parameter.
    over : xarray.Dataset, optional
        Of kind ``bifurcation-diagram`` over that parameter, to be drawn behind.

    Returns
    -------
    matplotlib.figure.Figure
        The first state that varies, at all points of each orbit on the section: a line an iterate, a colour a period,
        solid where the orbit is stable and dashed where it is not. Special points have a shape a kind. Ends of branches
        inside of the parameter's range are marked by a bar, and the legend says what they are. The axis shows the range
        asked for, whatever that of the diagram.
    """
    name = swept(datasets[0])[0]
    figure = new_figure(4.6)
    axes = figure.subplots()
    states = [dataset["section"].values for dataset in datasets]
    index = first_that_varies(np.concatenate([values.reshape(-1, values.shape[-1]) for values in states]))
    low, high = zip(*(limits(dataset)[name] for dataset in datasets), strict=True)
    edge = 0.02 * (max(high) - min(low))
    axes.set_xlim(min(low) - edge, max(high) + edge)
    if over is not None:
        _attractors(axes, over, index)
    looks = period_looks(datasets)
    for dataset in datasets:
        _lines(axes, dataset, name, index, looks)
    for look in dict.fromkeys(looks.values()):
        axes.plot([], [], color=look.colour, linewidth=1.8, label=look.name)
    for dashes, text in (("-", "stable"), ((0, (4, 2)), "unstable")):
        axes.plot([], [], color="0.25", linestyle=dashes, linewidth=1.2, label=text)
    _marks(axes, datasets, name, index)
    axes.set_xlabel(axis_label(datasets[0], name))
    axes.set_ylabel(state_label(datasets[0], index))
    legend_outside(figure, named_once(axes), handlelength=2.0)
    warn(figure, datasets)
    behind = "" if over is None else ", over the bifurcation diagram"
    figure.set_label(f"branches of orbits and their special points{behind}")
    return figure


def _attractors(axes: "Axes", diagram: "xr.Dataset", index: int) -> None:
    name = swept(diagram)[0]
    section = diagram["section"].transpose(name, "seed", "iterate", "state").values[..., index]
    x = np.broadcast_to(diagram[name].values[:, None, None], section.shape)
    left, right = axes.get_xlim()
    known = np.isfinite(section) & (x >= left) & (x <= right)
    # a cloud has many small points, a cycle few that have to be seen under lines
    cloud = float(np.sqrt(np.clip(2e4 / max(known.sum(), 1), 0.25, 2.0)))
    cycle = np.broadcast_to(diagram["period"].transpose(name, "seed").values[..., None] > 0, section.shape)
    options: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": BACKGROUND, "markeredgewidth": 0}
    for part, size in ((known & ~cycle, cloud), (known & cycle, 2.0)):
        axes.plot(x[part], section[part], markersize=size, rasterized=True, zorder=1, **options)
    axes.plot([], [], markersize=3, label="bifurcation diagram", **options)


def _lines(axes: "Axes", dataset: "xr.Dataset", name: str, index: int, looks: dict[int, Look]) -> None:
    x, section = dataset[name].values, dataset["section"].values
    for number in np.unique(dataset["branch"].values):
        points = np.flatnonzero(dataset["branch"].values == number)
        period = int(dataset["branch_period"].values[number])
        thin = _thinner(period)
        stable = _stretches(dataset["stable"].values[points] != 0, dataset["special_point"].values[points] != 0)
        cuts = {0, len(points) - 1, *(np.flatnonzero(np.diff(stable)) + 1).tolist()}
        jumps = set(_jumps(section[points]).tolist())
        edges = sorted(cuts | jumps | {jump + 1 for jump in jumps})
        used = np.isfinite(section[points, :, index]).any(axis=0)
        for first, last in pairwise(edges):
            if first in jumps:
                continue
            part = points[first : last + 1]
            width = 1.5 if stable[first] else 0.9
            options: dict[str, Any] = {"linewidth": width * thin, "linestyle": "-" if stable[first] else (0, (4, 2))}
            axes.plot(
                x[part],
                section[part][:, used, index],
                color=looks[period].colour,
                zorder=3 if stable[first] else 2,
                **options,
            )


def _stretches(stable: "NDArray[np.bool_]", special: "NDArray[np.bool_]") -> "NDArray[np.bool_]":
    """Return whether each stretch between neighbouring points is stable, shape (m - 1,).

    At a special point, and where one branch leaves another, round-off decides what is stored: the neighbour tells.
    """
    told: NDArray[np.bool_] = np.where(special[:-1] | (np.arange(len(stable) - 1) == 0), stable[1:], stable[:-1])
    return told


def _jumps(section: "NDArray[np.float64]") -> "NDArray[np.int64]":
    """Numbers of the stretches over which the section jumps, as where an event comes to the section's phase."""
    if len(section) < 2:
        return np.zeros(0, dtype=np.int64)
    used = ~np.isnan(section[0]).any(axis=1)
    values = section[:, used]
    extent = np.maximum(np.ptp(values, axis=(0, 1)), 1e-300)
    step = np.max(np.abs(np.diff(values, axis=0)) / extent, axis=(1, 2))
    padded = np.pad(step, 1)
    return np.flatnonzero((step > _SEEN) & (step > _JUMP * np.maximum(padded[:-2], padded[2:])))


def _marks(axes: "Axes", datasets: "tuple[xr.Dataset, ...]", name: str, index: int) -> None:
    reasons: dict[str, None] = {}
    for dataset in datasets:
        x, section = dataset[name].values, dataset["section"].values[..., index]
        for kind, points in specials(dataset):
            for here, size in _sizes(section, points):
                shown = section[here]
                mark(axes, np.broadcast_to(x[here, None], shown.shape), shown, kind, _MARK * size)
        last, names = ends(dataset)
        reasons.update(dict.fromkeys(names))
        for here, size in _sizes(section, last):
            shown = section[here]
            bar(axes, np.broadcast_to(x[here, None], shown.shape), shown, _BAR * size)
    if reasons:
        bar(axes, [], [], _BAR, end_label(reasons))


def _sizes(section: "NDArray[np.float64]", points: "NDArray[np.int64]") -> "list[tuple[NDArray[np.int64], float]]":
    """Sort points by the number of their marks, each with a factor for the size of these."""
    periods = np.isfinite(section[points]).sum(axis=1)
    return [(points[periods == n], _thinner(n)) for n in np.unique(periods)]


def _thinner(period: int) -> float:
    """Factor for lines and marks: the many ones of a long orbit would fill the picture."""
    return max(0.4, 1 - 0.12 * float(np.log2(max(period, 1))))

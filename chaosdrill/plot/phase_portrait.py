"""Phase portrait: the first state against the second, with the strobe points and the stop."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.curve import join, stops, strobe
from chaosdrill.plot.joined import is_joined, runs_left_out, runs_of
from chaosdrill.plot.style import PALETTE, legend_above, legend_outside, new_figure, readable, shorten, state_label

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DOTS = (0, (1, 2))


def phase_portrait(dataset: "xr.Dataset") -> "Figure":
    """Draw the first two states of a trajectory against each other.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``trajectory``, or several joined; with two states or more.

    Returns
    -------
    matplotlib.figure.Figure
        Flow as lines, jumps of a reset as dotted lines, the states at whole forcing periods as points, and walls at
        which the state is reset as dashed lines. Of joined runs each has a colour.
    """
    runs = runs_of(dataset)
    figure = new_figure(4.6)
    axes = figure.subplots()
    if is_joined(dataset):
        jumps = [
            _draw(axes, run, (colour, colour), (name, None, None))
            for (name, run), colour in zip(runs, PALETTE, strict=False)
        ]
        _explain(axes, jumps=any(jumps))
    else:
        _draw(axes, dataset, PALETTE[:2], ("flow", "jump", "once a forcing period"))
    _walls(axes, [run for _, run in runs])
    axes.set_xlabel(state_label(dataset, 0))
    axes.set_ylabel(state_label(dataset, 1))
    if is_joined(dataset):
        axes.set_title(runs_left_out(dataset))
        legend_outside(figure, axes.get_legend_handles_labels()[0])
    else:
        legend_above(axes)
    symbols = " against ".join(str(name) for name in dataset["state_name"].values[1::-1])
    figure.set_label(f"{symbols}{', a colour for each run' if is_joined(dataset) else ''}")
    return figure


def _draw(axes: "Axes", run: "xr.Dataset", colours: "Sequence[str]", labels: "Sequence[str | None]") -> bool:
    """Draw a run: flow, jumps and points once a forcing period, with a label each; tell whether there are jumps."""
    curve = join(run)
    x, y = curve.state[:, 0], curve.state[:, 1]
    # both sides of an event share their time: the piece between them is the jump, everything else is flow
    jump = (np.diff(curve.time) == 0) & (np.hypot(np.diff(x), np.diff(y)) > 0)
    breaks = np.flatnonzero(jump) + 1
    weight = 1.1 if breaks.size < 60 else 0.5
    axes.plot(*_split(x, y, breaks), color=colours[0], linewidth=weight, label=labels[0])
    if breaks.size:
        pairs = np.column_stack([breaks - 1, breaks])
        gap = np.full((breaks.size, 1), np.nan)
        jumps = [np.hstack([values[pairs], gap]).ravel() for values in (x, y)]
        axes.plot(*jumps, color=colours[0], linewidth=0.6 * weight, linestyle=_DOTS, alpha=0.7, label=labels[1])
    points = strobe(run)
    if points.size:
        size = 26 if len(np.unique(np.round(points[:, :2], 6), axis=0)) < 30 else 7
        axes.scatter(
            points[:, 0],
            points[:, 1],
            s=size,
            color=colours[1],
            edgecolor="white",
            linewidth=0.4,
            zorder=3,
            label=labels[2],
        )
    return bool(breaks.size)


def _explain(axes: "Axes", jumps: bool) -> None:
    """Name in the legend, in grey, what is drawn in the colours of several runs."""
    if jumps:
        axes.plot([], [], color="0.4", linewidth=0.8, linestyle=_DOTS, label="jump")
    if axes.collections:
        axes.scatter([], [], s=20, color="0.4", edgecolor="white", linewidth=0.4, label="once a forcing period")


def _walls(axes: "Axes", runs: "Sequence[xr.Dataset]") -> None:
    names = [str(name) for name in runs[0]["state_name"].values[:2]]
    for index, (line, symbol) in enumerate(zip((axes.axvline, axes.axhline), names, strict=True)):
        walls = list(dict.fromkeys((name, round(value, 12)) for run in runs for name, value in stops(run, index)))
        for level in sorted({value for _, value in walls}):
            kinds = ", ".join(readable(name) for name, value in walls if value == level)
            line(
                level,
                color="0.25",
                linewidth=0.9,
                linestyle="--",
                zorder=1,
                label=f"{kinds} at {symbol} = {shorten(level)}",
            )


def _split(x: np.ndarray, y: np.ndarray, breaks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both coordinates with a gap at each break."""
    return np.insert(x, breaks, np.nan), np.insert(y, breaks, np.nan)

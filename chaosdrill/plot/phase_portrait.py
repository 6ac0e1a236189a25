"""Phase portrait: the first state against the second, with the strobe points and the stop."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.curve import join, stops, strobe
from chaosdrill.plot.style import PALETTE, legend_above, new_figure, readable, shorten, state_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def phase_portrait(dataset: "xr.Dataset") -> "Figure":
    """Draw the first two states of a trajectory against each other.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``trajectory``; with two states or more.

    Returns
    -------
    matplotlib.figure.Figure
        Flow as lines, jumps of a reset as dotted lines, the states at whole forcing periods as points, and walls at
        which the state is reset as dashed lines.
    """
    curve = join(dataset)
    x, y = curve.state[:, 0], curve.state[:, 1]
    figure = new_figure(4.6)
    axes = figure.subplots()
    # both sides of an event share their time: the piece between them is the jump, everything else is flow
    jump = (np.diff(curve.time) == 0) & (np.hypot(np.diff(x), np.diff(y)) > 0)
    breaks = np.flatnonzero(jump) + 1
    weight = 1.1 if breaks.size < 60 else 0.5
    axes.plot(*_split(x, y, breaks), color=PALETTE[0], linewidth=weight, label="flow")
    if breaks.size:
        pairs = np.column_stack([breaks - 1, breaks])
        gap = np.full((breaks.size, 1), np.nan)
        jumps = [np.hstack([values[pairs], gap]).ravel() for values in (x, y)]
        axes.plot(*jumps, color=PALETTE[0], linewidth=0.6 * weight, linestyle=(0, (1, 2)), alpha=0.7, label="jump")
    points = strobe(dataset)
    if points.size:
        size = 26 if len(np.unique(np.round(points[:, :2], 6), axis=0)) < 30 else 7
        axes.scatter(
            points[:, 0],
            points[:, 1],
            s=size,
            color=PALETTE[1],
            edgecolor="white",
            linewidth=0.4,
            zorder=3,
            label="once a forcing period",
        )
    names = [str(name) for name in dataset["state_name"].values[:2]]
    for line, walls, symbol in (
        (axes.axvline, stops(dataset, 0), names[0]),
        (axes.axhline, stops(dataset, 1), names[1]),
    ):
        for level in sorted({round(value, 12) for _, value in walls}):
            kinds = ", ".join(readable(name) for name, value in walls if round(value, 12) == level)
            line(
                level,
                color="0.25",
                linewidth=0.9,
                linestyle="--",
                zorder=1,
                label=f"{kinds} at {symbol} = {shorten(level)}",
            )
    axes.set_xlabel(state_label(dataset, 0))
    axes.set_ylabel(state_label(dataset, 1))
    legend_above(axes)
    return figure


def _split(x: np.ndarray, y: np.ndarray, breaks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both coordinates with a gap at each break."""
    return np.insert(x, breaks, np.nan), np.insert(y, breaks, np.nan)

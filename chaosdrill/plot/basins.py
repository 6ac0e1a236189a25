"""Basins of attraction: to which attractor each initial state leads."""

import json
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.cells import bounds, draw_kinds, legend_entry
from chaosdrill.plot.looks import FURTHER, MOTIONS, UNRECOGNISED, attractor_look, outcomes, sort_out
from chaosdrill.plot.style import EVENT_MARKERS, axis_label, flag_names, new_figure, readable, subscript, uncertain

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

_MOST = 12
"""Attractors that are told apart; more do not find room in the legend, nor colours."""
_SIZE = (6.3, 4.6)
_IN_PLANE = 1e-6
"""Distance from the plane of the grid, relative to the state, at which a point still lies in it."""


def basins(dataset: "xr.Dataset") -> "Figure":
    """Draw the basins over a grid of initial states.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``basins``.

    Returns
    -------
    matplotlib.figure.Figure
        A colour for each of the twelve attractors that the table names first; the legend says what each is, its largest
        exponent and its part of the grid. Points of attractors are marked where they lie in the plane of the grid.
    """
    across, up = (str(name) for name in dataset["attractor"].dims)
    ordered = dataset.sortby([across, up]).transpose(up, across, ...)
    reached = ordered["attractor"].values
    numbers = dataset["attractor_number"].values.tolist()
    table = [
        (reached == number, attractor_look(place, _describe(dataset.isel(attractor_number=place), number)))
        for place, number in enumerate(numbers[:_MOST])
    ]
    if len(numbers) > _MOST:
        table.append((np.isin(reached, numbers[_MOST:]), FURTHER))
    lost = reached == 0
    ended, others = outcomes(ordered)
    for code, look in enumerate(others):
        if look.name not in MOTIONS:
            table.append((lost & (ended == code), look))
            lost &= ended != code
    kinds, looks = sort_out([*table, (lost, UNRECOGNISED)])
    x, y = (bounds(ordered[name].values) for name in (across, up))

    lines = -(-len(looks) // 2)
    figure = new_figure(_SIZE[1] + 0.7 + 0.18 * lines)
    axes = figure.subplots()
    draw_kinds(axes, x, y, kinds, looks, _SIZE)
    handles = [legend_entry(look) for look in looks] + _mark_attractors(axes, dataset, across, up)
    axes.set_xlabel(axis_label(dataset, across))
    axes.set_ylabel(axis_label(dataset, up))
    figure.legend(handles=handles, loc="outside upper left", ncols=2, handlelength=1.6, handleheight=1.1, borderpad=0)
    return figure


def _describe(attractor: "xr.Dataset", number: int) -> str:
    """What an attractor is: its period or kind, its largest exponent, and its part of the grid."""
    period = int(attractor["attractor_period"])
    kind = flag_names(attractor["attractor_outcome"]).get(int(attractor["attractor_outcome"]), "")
    parts = [f"period {period}" if period else "period not found" if kind in ("ok", "periodic") else readable(kind)]
    if "attractor_exponent" in attractor.variables:
        error = float(attractor["attractor_error"][0]) if "attractor_error" in attractor.variables else np.nan
        parts.append(f"{subscript('λ', 1)} = {uncertain(float(attractor['attractor_exponent'][0]), error)}")
    share, error = 100 * float(attractor["fraction"]), 100 * float(attractor["fraction_error"])
    return f"{number}: {', '.join(parts)}; {uncertain(share, error)} %"


def _mark_attractors(axes: "Axes", dataset: "xr.Dataset", across: str, up: str) -> "list[Line2D]":
    """Mark the attractors' points that lie in the plane and within the grid, and return the handles of the marks."""
    from matplotlib.patheffects import withStroke

    names = [str(name) for name in dataset["state_name"].values]
    initial = json.loads(dataset.attrs.get("initial", "{}"))
    plane = np.array([np.nan if name in (across, up) else initial.get(name, np.nan) for name in names])
    points = dataset["attractor_state"].transpose("attractor_number", "state").values[:_MOST]
    off = np.array([name not in (across, up) for name in names])
    near = np.abs(points - plane) <= _IN_PLANE * (1 + np.abs(points))
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    marks = []
    for place, point in enumerate(points):
        x, y = point[names.index(across)], point[names.index(up)]
        if near[place, off].all() and left <= x <= right and low <= y <= high:
            look = attractor_look(place, "")
            marks += axes.plot(
                x,
                y,
                EVENT_MARKERS[place % len(EVENT_MARKERS)],
                markersize=8,
                color=look.colour,
                markeredgecolor="black",
                markeredgewidth=1.2,
                path_effects=[withStroke(linewidth=3.5, foreground="white")],
                linestyle="none",
                label=f"point of attractor {place + 1}",
            )
    return marks

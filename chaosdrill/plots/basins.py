"""Basins of attraction: the attractor that each initial state leads to."""

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots.cells import legend_entry
from chaosdrill.plots.charts import kind_panels
from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import (
    ATTRACTED,
    EVENT_MARKERS,
    FURTHER,
    UNRECOGNISED,
    attractor_category,
    by_outcome,
    classify,
    label,
    legend_outside,
    one_panel,
    places_of,
    readable,
    shorten,
    state_label,
    subscript,
    uncertain,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

    from chaosdrill.plots.style import Category

_MOST = 12
"""Most attractors that are distinguished; for more the legend has no room and the palette no colours."""
_HEIGHT = 5.5
"""Height in inches of the figure without its legend."""
_SHORT = 54
"""Letters of an entry of the legend of which two stand side by side."""
_IN_PLANE = 1e-6
"""Distance from the plane of the grid, relative to the state, at which a point still lies in it."""


@picture("basins", "basins", "the attractor that each initial state leads to", listed=False)
def basins(dataset: "xr.Dataset", *, ax: "Axes | None" = None) -> "Figure":
    """Draw the basins over a grid of initial states.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``basins``.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        A colour for each of the twelve attractors that the table names first; the legend says what each is, its largest
        exponent and its part of the grid. Points of attractors are marked where they lie in the plane of the grid.
    """
    dims = [str(name) for name in dataset["attractor"].dims]
    kinds, looks = _kinds(dataset)
    drawn = kind_panels(dataset, kinds, looks, "attractor", ax)
    figure, axes = drawn.figure, drawn.panels[0][0]
    handles = [legend_entry(look) for look in looks] + _mark_attractors(axes, dataset, *dims)
    if plane := _plane(dataset):
        axes.set_title("at " + ", ".join(f"{name} = {shorten(value)}" for name, value in plane.items()))
    if ax is not None:
        ax.legend(handles=handles)
        return figure
    columns = 2 if max(len(str(handle.get_label())) for handle in handles) <= _SHORT else 1
    figure.set_figheight(_HEIGHT + 0.18 * -(-len(handles) // columns))
    figure.legend(
        handles=handles, loc="outside upper left", ncols=columns, handlelength=1.6, handleheight=1.1, borderpad=0
    )
    return figure


@picture("basins", "starts", "initial states by the attractor that each leads to", listed=True)
def starts(dataset: "xr.Dataset", *, ax: "Axes | None" = None, state: "str | Sequence[str] | None" = None) -> "Figure":
    """Draw a list of initial states, each in the colour of the attractor to which it leads.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``basins``, from initial states in a list.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn.
    state : str or pair of str, optional
        States of the plane, the one across first; default: the first two. One alone is drawn against the number of the
        attractor.

    Returns
    -------
    matplotlib.figure.Figure
        A marker for each start; the legend says what each attractor is, as in `basins`.
    """
    kinds, looks = _kinds(dataset)
    count = 1 if isinstance(state, str) or dataset.sizes["state"] == 1 else 2
    places = places_of(dataset, state, count)
    figure, axes = one_panel(ax, _HEIGHT)
    states = dataset["initial_state"].transpose("run", "state").values
    x, y = states[:, places[0]], states[:, places[1]] if count == 2 else dataset["attractor"].values
    for index, look in enumerate(looks):
        here = kinds == index
        marker = EVENT_MARKERS[index % len(EVENT_MARKERS)]
        axes.scatter(
            x[here], y[here], s=18, color=look.colour, marker=marker, edgecolor="0.3", linewidth=0.3, label=look.name
        )
    axes.set_xlabel(state_label(dataset, places[0]))
    axes.set_ylabel(state_label(dataset, places[1]) if count == 2 else label(dataset["attractor"]))
    legend_outside(figure, axes.get_legend_handles_labels()[0], ax=ax)
    return figure


def _kinds(dataset: "xr.Dataset") -> "tuple[NDArray[np.int64], list[Category]]":
    """The kind of every cell: its attractor, or how its run ended on none."""
    reached = dataset["attractor"].values
    numbers = dataset["attractor_number"].values.tolist()
    table = [
        (reached == number, attractor_category(place, _describe(dataset.isel(attractor_number=place), number)))
        for place, number in enumerate(numbers[:_MOST])
    ]
    table.append((np.isin(reached, numbers[_MOST:]), FURTHER))
    lost = reached == 0
    ended, others = by_outcome(dataset)
    for code, look in enumerate(others):
        if look.name not in ATTRACTED:
            table.append((lost & (ended == code), look))
            lost &= ended != code
    table.append((lost, UNRECOGNISED))
    for place, (mask, look) in enumerate(table[len(numbers[:_MOST]) :], start=len(numbers[:_MOST])):
        part = float(mask.mean())
        error = float(np.sqrt(part * (1 - part) / mask.size))
        table[place] = mask, replace(look, name=f"{look.name}; {_percent(part, error)}")
    return classify(table)


def _describe(attractor: "xr.Dataset", number: int) -> str:
    """What an attractor is: its period or kind, its largest exponent, and its part of the grid."""
    period = int(attractor["attractor_period"])
    kind = flag_names(attractor["attractor_outcome"]).get(int(attractor["attractor_outcome"]), "")
    parts = [f"period {period}" if period else "period not found" if kind in ("ok", "periodic") else readable(kind)]
    exponent = float(attractor["attractor_exponent"][0]) if "attractor_exponent" in attractor.variables else np.nan
    if not np.isnan(exponent):
        error = float(attractor["attractor_error"][0]) if "attractor_error" in attractor.variables else np.nan
        parts.append(f"{subscript('λ', 1)} = {uncertain(exponent, error)}")
    if "attractor_rate" in attractor.variables and np.isfinite(attractor["attractor_rate"]):
        spread = float(attractor.get("attractor_rate_error", np.nan))
        parts.append(f"progression {uncertain(float(attractor['attractor_rate']), spread)}")
    share = _percent(float(attractor["fraction"]), float(attractor["fraction_error"]))
    return f"{number}: {', '.join(parts)}; {share}"


def _percent(part: float, error: float) -> str:
    return f"{uncertain(100 * part, 100 * error)} %"


def _plane(dataset: "xr.Dataset") -> dict[str, float]:
    """The states that the grid does not vary, and their values, as far as the archive tells."""
    initial = json.loads(dataset.attrs.get("initial", "{}"))
    names = [str(name) for name in dataset["state"].values]
    return {name: float(initial[name]) for name in names if name not in dataset["attractor"].dims and name in initial}


def _mark_attractors(axes: "Axes", dataset: "xr.Dataset", across: str, up: str) -> "list[Line2D]":
    """Mark the attractors' points that lie in the plane and within the grid, and return a handle of the marks."""
    from matplotlib.patheffects import withStroke

    names = [str(name) for name in dataset["state"].values]
    plane = np.array([_plane(dataset).get(name, np.nan) for name in names])
    points = dataset["attractor_state"].transpose("attractor_number", "state").values[:_MOST]
    off = np.array([name not in (across, up) for name in names])
    near = np.abs(points - plane) <= _IN_PLANE * (1 + np.abs(points))
    inside = near[:, off].all(axis=1)
    for axis, (low, high) in ((across, axes.get_xlim()), (up, axes.get_ylim())):
        inside &= (points[:, names.index(axis)] >= low) & (points[:, names.index(axis)] <= high)
    marks = []
    for place in np.flatnonzero(inside).tolist():
        x, y = points[place, names.index(across)], points[place, names.index(up)]
        look = attractor_category(place, "")
        # the number within tells them apart without colours
        layer = 10 + place
        marks += axes.plot(
            x,
            y,
            "o",
            markersize=12,
            color=look.colour,
            markeredgecolor="black",
            markeredgewidth=1.2,
            path_effects=[withStroke(linewidth=3.0, foreground="white")],
            linestyle="none",
            label="points of attractors",
            zorder=layer,
        )
        axes.annotate(look.short, (x, y), ha="center", va="center_baseline", fontsize=8, color=look.ink, zorder=layer)
    return marks[:1]

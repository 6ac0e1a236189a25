"""Invariant manifolds of saddles in the plane of two states, over basins or an attractor."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection

from chaosdrill.dataset.curves import CurveBreak
from chaosdrill.plots._types import Artist, Axes, Dataset, Figure, States
from chaosdrill.plots.charts import attractor_cells
from chaosdrill.plots.contents import places_of
from chaosdrill.plots.figures import legend_outside, one_panel
from chaosdrill.plots.labels import state_label
from chaosdrill.plots.palette import BACKGROUND
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.plane import Plane
from chaosdrill.plots.tuning import TUNING

_COLOURS = {"unstable": "#C9471B", "stable": "#33208A"}
"""Of lines that are seen on white and on the cells of basins."""
_MARKS = {
    CurveBreak.GRAZING: ("o", "grazing"),
    CurveBreak.CHANGE_OF_EVENTS: ("s", "change of events"),
    CurveBreak.NO_IMAGE: ("x", "no image"),
    CurveBreak.NO_PREIMAGE: ("x", "no preimage"),
    CurveBreak.UNEXPLAINED: ("D", "jump of the map"),
}


@picture(
    "manifolds",
    "manifolds",
    "stable and unstable manifolds of saddles, over basins or a section if there are some",
    states=2,
    over="basins poincare-section",
)
def manifolds(*datasets: Dataset, over: Dataset | None = None, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw stable and unstable manifolds in the plane of two states.

    A line for each part of a curve, in one colour for stable and one for unstable manifolds; crosses at the saddles.
    Breaks are marked by their kind, where these are few. The axes show the regions of the curves, or the grid of the
    basins. ``over``, basins over a grid of two states or a section, is drawn behind. ``state``: states of the plane,
    the one across first; default: those of the grid of basins, or else the first two.
    """
    plane = None
    if over is not None and (over.attrs.get("kind") == "basins") and "run" not in over.dims:
        codes, categories = attractor_cells(over)
        plane = Plane(over, "attractor", ax)
        plane.categorise(codes, categories)
        state = (plane.across, plane.up) if state is None else state
        figure, axes = plane.figure, plane.panels[0]
    else:
        figure, axes = one_panel(ax, TUNING.manifold_height)
    x, y = places_of(datasets[0], state, 2)
    if plane is None:
        low = np.min([dataset["region"].values[0] for dataset in datasets], axis=0)
        high = np.max([dataset["region"].values[1] for dataset in datasets], axis=0)
        # sections in SI units do not lie in this plane
        if over is not None and "section" in over and "state_units" not in over:
            points = over["section"].values
            axes.plot(points[:, x], points[:, y], ".", color=BACKGROUND, markersize=2, zorder=0, label="section")
        axes.set(xlim=(low[x], high[x]), ylim=(low[y], high[y]))
    axes.set(xlabel=state_label(datasets[0], x), ylabel=state_label(datasets[0], y))
    handles = [handle for handle in axes.get_legend_handles_labels()[0] if plane is None]
    handles += _draw(axes, datasets, (x, y))
    if plane is not None:
        plane.legend(handles, ncols=2)
    else:
        legend_outside(figure, handles, ax=ax, handlelength=1.8)
    behind = {"basins": ", over the basins", "poincare-section": ", over the section"}
    figure.set_label(f"manifolds of saddles{behind.get(str(over.attrs.get('kind')), '') if over is not None else ''}")
    return figure


def _draw(axes: Axes, datasets: Sequence[Dataset], places: tuple[int, int]) -> list[Artist]:
    """The curves, their breaks and the saddles; returns what the legend shows."""
    lines: dict[str, list[Any]] = {"unstable": [], "stable": []}
    breaks: dict[CurveBreak, list[Any]] = {kind: [] for kind in CurveBreak}
    saddles: list[Any] = []
    chosen = list(places)
    for dataset in datasets:
        states = dataset["curve_state"].values[:, chosen]
        curve, part = dataset["curve"].values, dataset["part"].values
        ends = np.flatnonzero((np.diff(curve) != 0) | (np.diff(part) != 0)) + 1
        stable = dict(zip(dataset["curve_number"].values.tolist(), dataset["curve_stable"].values, strict=True))
        for rows, first in zip(np.split(states, ends), np.concatenate([[0], ends]).astype(int), strict=True):
            if len(rows) > 1:
                lines["stable" if stable[int(curve[first])] else "unstable"].append(rows)
        kinds = dataset["break_kind"].values
        for kind, found in breaks.items():
            points = dataset["break_point"].values[kinds == kind]
            found.extend(states[points])
            if kind == CurveBreak.CHANGE_OF_EVENTS:
                found.extend(states[np.minimum(points + 1, len(states) - 1)])
        saddles.extend(dataset["orbit_section"].values[:, chosen])
    handles: list[Artist] = []
    for name, found in lines.items():
        if found:
            axes.add_collection(LineCollection(found, colors=_COLOURS[name], linewidths=0.9, zorder=2.5))
            handles += axes.plot([], [], color=_COLOURS[name], linewidth=1.4, label=f"{name} manifold")
    for kind, found in breaks.items():
        if 0 < len(found) <= TUNING.most_breaks:
            marker, label = _MARKS[kind]
            options: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": "black", "markeredgewidth": 0.8}
            across, up = np.array(found).T
            handles += axes.plot(across, up, marker, markersize=4, linestyle="none", label=label, zorder=2.8, **options)
    if saddles:
        across, up = np.array(saddles).T
        options = {"color": "black", "markeredgecolor": "white", "markeredgewidth": 0.7}
        handles += axes.plot(across, up, "X", markersize=8, linestyle="none", label="saddle", zorder=3, **options)
    return handles

"""Edge states: the track between two fates in the plane of two states, and the distance of the motions beside it."""

from typing import Any

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.plots._types import Axes, Dataset, Figure
from chaosdrill.plots.figures import legend_above, stacked
from chaosdrill.plots.labels import label, state_label, time_unit, uncertain
from chaosdrill.plots.palette import LINE_COLOURS, PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING


@picture("edge-states", "edge-states", "track along the edge between two fates, and the distance across it")
def edge(dataset: Dataset) -> Figure:
    """Draw the track along the edge, and the distance of the two motions beside it.

    Above, in the plane of the first two states that differ, the two starts, a point of each attractor, the track, its
    later half with full dots, and the edge state, all points of a cycle. Below, the distance of both motions over
    time, on a logarithmic scale: it grows from each bisection to the next. Without a track only the starts and
    attractors are drawn.
    """
    tracked = dataset.sizes["step"] > 0
    figure, panels = stacked([TUNING.panel_height, TUNING.further_panel][: 1 + tracked], 0.9)
    _draw_track(panels[0], dataset)
    if tracked:
        _draw_distance(panels[1], dataset)
    return figure


def _draw_track(axes: Axes, dataset: Dataset) -> None:
    parts = {name: dataset[name].values for name in ("side_start", "side_state", "track_state")}
    every = np.concatenate(list(parts.values()))
    told = np.isfinite(every)
    extent = np.where(told.any(axis=0), np.ptp(np.where(told, every, np.nanmean(every, axis=0)), axis=0), 0.0)
    moving = np.flatnonzero(extent > 0).tolist() or [0]
    flat = len(moving) == 1

    def place(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return points[..., moving[0]], np.zeros_like(points[..., 0]) if flat else points[..., moving[1]]

    for side in np.flatnonzero(np.isfinite(parts["side_start"][:, 0])).tolist():
        word = Outcome(int(dataset["side_outcome"][side])).meaning
        look: dict[str, Any] = {"color": PALETTE[side], "linestyle": ""}
        axes.plot(*place(parts["side_start"][side]), marker="o", mfc="none", label=f"start {side + 1} ({word})", **look)
        if np.isfinite(parts["side_state"][side, 0]):
            axes.plot(*place(parts["side_state"][side]), marker="s", label=f"attractor {side + 1}", **look)
    states = parts["track_state"]
    if len(states):
        apart = np.flatnonzero(np.diff(dataset["bisection"].values) > 0) + 1
        # points of a section are no path
        style = "none" if "forcing_period" in dataset.variables or int(dataset["period"]) else "-"
        joined = np.insert(states, apart, np.nan, axis=0)
        axes.plot(*place(joined), linestyle=style, color="0.6", marker=".", markersize=5, linewidth=0.8, label="track")
        axes.plot(*place(states[len(states) // 2 :]), ".", color=PALETTE[2], markersize=4, label="later half")
        times, period = dataset["track_time"].values, int(dataset["period"])
        # both ends of a bisection have one time
        cycle = states[np.append(np.diff(times) > 0, True)][-period:] if period else dataset["edge_state"].values
        words = Outcome(int(dataset["outcome"])).meaning + f", period {period}" * bool(period)
        axes.plot(*place(cycle), "*", mfc="none", color=LINE_COLOURS[0], markersize=12, label=f"edge state ({words})")
    axes.set_xlabel(state_label(dataset, moving[0]))
    if flat:
        axes.set_yticks([])
    else:
        axes.set_ylabel(state_label(dataset, moving[1]))
    legend_above(axes, 4)


def _draw_distance(axes: Axes, dataset: Dataset) -> None:
    unit, _, units = time_unit(dataset)
    time, distance = dataset["track_time"].values / unit, dataset["track_distance"].values
    apart = np.flatnonzero(np.diff(dataset["bisection"].values) > 0) + 1
    rate, error = float(dataset["growth_rate"]), float(dataset["growth_rate_error"])
    style = ".-" if "forcing_period" in dataset.variables else "-"
    joined = np.insert(time, apart, np.nan), np.insert(distance, apart, np.nan)
    axes.plot(*joined, style, color=PALETTE[0], linewidth=0.8, markersize=3)
    axes.set(yscale="log", xlabel=f"{dataset['track_time'].attrs['long_name']} ({units})")
    axes.set_ylabel(label(dataset["track_distance"]))
    if np.isfinite(rate):
        axes.set_title(f"growth rate {uncertain(rate, error)}")

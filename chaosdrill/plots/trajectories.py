"""Trajectories: every state and integral over time, and the first state against the second."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.colors import to_hex

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots._types import Artist, Axes, Dataset, Figure, Line2D, Patch, States
from chaosdrill.plots.contents import places_of
from chaosdrill.plots.curve import (
    Curve,
    curve_of,
    is_joined,
    last_parts,
    pieces,
    rates_of,
    runs_left_out,
    runs_of,
    smoothed,
    stops,
    strobe,
)
from chaosdrill.plots.figures import legend_above, legend_inside, legend_outside, new_figure, one_panel, owner
from chaosdrill.plots.labels import is_map, label, period_words, readable, shorten, state_label, strobe_words
from chaosdrill.plots.palette import DOTS, MODE_SHADES, PALETTE, event_look
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING

_GREY = "0.4"
_MODE_HATCHES = ("", "///", "...")


@picture("trajectory", "time-history", "integrals and states over time, events and modes")
def time_history(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw the end of a trajectory.

    One panel for each quadrature and state. Shades are modes, markers are events at the state before the reset; only
    the end of a trajectory with many events is shown, from a whole forcing period on, and the title says so. Each of
    several joined runs is a line in its own colour, with its events; their modes differ and are not shaded. On ``ax``
    one state is drawn. ``state``: states that are drawn, and no quadrature; default: the first dozen, on ``ax`` the
    first.
    """
    names, whole = zip(*runs_of(dataset), strict=True)
    joined = is_joined(dataset)
    runs = last_parts(whole, max(TUNING.marked_events // len(whole), TUNING.fewest_events))
    first = runs[0]
    quadratures = [str(name) for name in first.data_vars if first[name].dims == ("time",) and name != "mode"]
    if state is not None or ax is not None:
        quadratures = []
    every = first.sizes["state"]
    if ax is not None or isinstance(state, str):
        count = 1
    else:
        count = min(every, TUNING.most_panels) if state is None else len(state)
    states = places_of(first, state, count)
    rows = len(quadratures) + len(states)
    figure = new_figure(max(2.6, 1.0 + 1.35 * rows), least=0.35 + 1.2 * TUNING.low * rows) if ax is None else owner(ax)
    panels: Any = np.atleast_1d(figure.subplots(rows, 1, sharex=True)) if ax is None else [ax]
    axis_labels = [*(label(first[name]) for name in quadratures), *(state_label(first, i) for i in states)]
    for panel, text in zip(panels, axis_labels, strict=True):
        panel.set_ylabel(text)
        panel.margins(x=0)
    for run, name, colour in zip(runs, names, _unused(panels[0]), strict=False):
        curve = curve_of(run)
        curve = smoothed(curve, partial(rates_of, run, curve))
        for panel, quadrature in zip(panels, quadratures, strict=False):
            panel.plot(run["time"], run[quadrature], color=colour)
        for i, panel in zip(states, panels[len(quadratures) :], strict=True):
            flow, jumps = pieces(curve.time, curve.time, curve.state[:, i])
            panel.plot(*flow.T, color=colour, label=name if joined else None)
            panel.plot(*jumps.T, color=colour, linewidth=0.7, linestyle=DOTS)
            _mark_events(panel, run, i, colour if joined else None)
    panels[-1].set_xlabel(label(first["time"]))
    if ax is None:
        figure.align_ylabels(list(panels))
    modes = {} if joined else flag_names(first["mode"])
    looks = _looks(curve, modes)
    for panel in panels if modes else ():
        for start, end, mode in curve.bands():
            shade, hatch = looks[mode]
            if shade != MODE_SHADES[0] or hatch:
                panel.axvspan(start, end, facecolor=shade, edgecolor="0.7", hatch=hatch, linewidth=0, zorder=0)
    handles = [*panels[-1].get_legend_handles_labels()[0]]
    handles += [
        Patch(facecolor=shade, edgecolor="0.6", hatch=hatch, linewidth=0.5, label=f"{readable(modes[code])} (mode)")
        for code, (shade, hatch) in (looks if len(modes) > 1 else {}).items()
        if code in modes
    ]
    handles += _event_entries(runs) if joined else []
    legend_outside(figure, handles, ax=ax, handlelength=1.4)
    title = [runs_left_out(dataset), _title(first, whole[0]) if first is not whole[0] else ""]
    title += [f"the first {count} of {every} states"] if state is None and ax is None and count < every else []
    panels[0].set_title(", ".join(filter(None, title)))
    figure.set_label(_summary(quadratures, runs, modes, joined))
    return figure


def _summary(quadratures: list[str], runs: list[Dataset], modes: dict[int, str], joined: bool) -> str:
    """Description of the picture, for its title."""
    lines = [*(str(runs[0][name].attrs.get("long_name", name)) for name in quadratures), "states"]
    marked = ["events"] * any(run.sizes["event"] for run in runs) + ["modes"] * (len(modes) > 1)
    parts = [" and ".join(filter(None, [", ".join(lines[:-1]), lines[-1]])) + " over time"]
    parts += ["one colour per run"] * joined
    return ", ".join(parts) + (f", with {' and '.join(marked)}" if marked else "")


def _unused(axes: Axes) -> list[str]:
    """Colours of runs that nothing on the axes has: a run that is drawn over another one looks different."""
    marks: list[Any] = [row for marks in axes.collections for row in marks.get_facecolor()[:1]]
    lines: list[Any] = [line.get_color() for line in axes.lines]
    used = {to_hex(one) for one in (*lines, *marks)}
    free = [colour for colour in PALETTE if to_hex(colour) not in used]
    return free if len(free) > 1 else list(PALETTE)


def _mark_events(panel: Axes, shown: Dataset, i: int, colour: str | None) -> None:
    """Mark the events of a run, in the run's colour, or in one colour per kind, which the legend then names."""
    kinds = shown["event_kind"].values
    for number, (code, name) in enumerate(flag_names(shown["event_kind"]).items() if kinds.size else ()):
        hit = kinds == code
        if hit.any():
            options = _event_marker(number, None if colour else readable(name), colour)
            time, state = shown["event_time"].values[hit], shown["event_state_before"].values[hit, i]
            panel.plot(time, state, clip_on=False, zorder=3, **options)


def _event_marker(number: int, name: str | None, colour: str | None) -> dict[str, Any]:
    marker, own = event_look(number)
    return {
        "marker": marker,
        "color": colour or own,
        "linestyle": "none",
        "markersize": 4,
        "markeredgecolor": "white",
        "markeredgewidth": 0.4,
        "label": name,
    }


def _event_entries(runs: list[Dataset]) -> list[Artist]:
    """Entries of the legend for the kinds of events that any of the runs has."""
    present = set().union(*(run["event_kind"].values.tolist() for run in runs))
    names = enumerate(flag_names(runs[0]["event_kind"]).items() if present else ())
    return [Line2D([], [], **_event_marker(place, readable(name), _GREY)) for place, (c, name) in names if c in present]


def _looks(curve: Curve, modes: dict[int, str]) -> dict[int, tuple[str, str]]:
    """Shade and hatching of each mode that a run was in; shades repeat with hatching."""
    present = set(curve.mode.tolist())
    found = {}
    for number, code in enumerate(code for code in modes if code in present):
        turn, place = divmod(number, len(MODE_SHADES))
        found[code] = MODE_SHADES[place], _MODE_HATCHES[turn % len(_MODE_HATCHES)]
    return found | dict.fromkeys(present - modes.keys(), (MODE_SHADES[0], ""))


def _title(shown: Dataset, dataset: Dataset) -> str:
    part, whole = (float(np.ptp(record["time"].values)) for record in (shown, dataset))
    if "forcing_period" in dataset.variables:
        period = float(dataset["forcing_period"])
        return f"last {part / period:.0f} of {whole / period:.0f} {period_words(dataset)[1]}"
    unit = str(dataset["time"].attrs.get("units", "1"))
    return f"last {part:.4g} of {whole:.4g} {'units of time' if unit == '1' else unit}"


@picture("trajectory", "phase-portrait", "the first state against the second", states=2)
def phase_portrait(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw the first two states of a trajectory against each other.

    Flow as lines, jumps at resets as dotted lines, states at whole forcing periods as points, and walls at which the
    state is reset as dashed lines. Each of several joined runs has its own colour. ``state``: states of the plane, the
    horizontal one first; default: the first two.
    """
    runs = runs_of(dataset)
    figure, axes = one_panel(ax, 4.6)
    across, up = places_of(dataset, state, 2)
    if is_joined(dataset):
        shown = list(zip(runs, _unused(axes), strict=False))
        jumps = [_draw(axes, run, (across, up), (one, one), (name, None, None)) for (name, run), one in shown]
        # in grey, the lines and marks that have the colours of several runs
        if any(jumps):
            axes.plot([], [], color="0.4", linewidth=0.8, linestyle=DOTS, label="jump")
        if axes.collections:
            name = strobe_words(runs[0][1])
            axes.scatter([], [], s=20, color="0.4", edgecolor="white", linewidth=0.4, label=name)
    else:
        words = (None if is_map(dataset) else "flow", "jump", strobe_words(dataset))
        _draw(axes, dataset, (across, up), _unused(axes)[:2], words)
    _walls(axes, [run for _, run in runs], (across, up))
    axes.set(xlabel=state_label(dataset, across), ylabel=state_label(dataset, up))
    if is_joined(dataset):
        axes.set_title(runs_left_out(dataset))
        legend_outside(figure, axes.get_legend_handles_labels()[0], ax=ax)
    elif ax is None:
        legend_above(axes)
    else:
        legend_inside(axes)
    symbols = " against ".join(str(dataset["state"].values[place]) for place in (up, across))
    figure.set_label(f"{symbols}{', one colour per run' if is_joined(dataset) else ''}")
    return figure


def _draw(
    axes: Axes, run: Dataset, plane: tuple[int, int], colours: Sequence[str], labels: Sequence[str | None]
) -> bool:
    """Draw a run: flow, jumps and points once per forcing period, each with a label; return whether there are jumps."""
    curve = curve_of(run)
    curve = smoothed(curve, partial(rates_of, run, curve))
    x, y = (curve.state[:, place] for place in plane)
    flow, jumps = pieces(curve.time, x, y)
    weight = 1.1 if len(jumps) < 180 else 0.5
    axes.plot(*flow.T, color=colours[0], linewidth=weight, label=labels[0])
    if jumps.size:
        axes.plot(*jumps.T, color=colours[0], linewidth=0.6 * weight, linestyle=DOTS, alpha=0.7, label=labels[1])
    points = strobe(run)
    if points.size:
        points = points[:, plane]
        size = 26 if len(np.unique(np.round(points, 6), axis=0)) < 30 else 7
        look: dict[str, Any] = {"edgecolor": "white", "linewidth": 0.4, "zorder": 3}
        axes.scatter(points[:, 0], points[:, 1], s=size, color=colours[1], label=labels[2], **look)
    return bool(jumps.size)


def _walls(axes: Axes, runs: Sequence[Dataset], plane: tuple[int, int]) -> None:
    for index, line in zip(plane, (axes.axvline, axes.axhline), strict=True):
        symbol = str(runs[0]["state"].values[index])
        walls = list(dict.fromkeys((name, round(value, 12)) for run in runs for name, value in stops(run, index)))
        for level in sorted({value for _, value in walls}):
            kinds = ", ".join(readable(name) for name, value in walls if value == level)
            look: dict[str, Any] = {"color": "0.25", "linewidth": 0.9, "linestyle": "--", "zorder": 1}
            line(level, label=f"{kinds} at {symbol} = {shorten(level)}", **look)

"""Periodic orbits: points, events and Newton's method; multipliers, also along branches; cascades of doublings."""

from typing import Any

import numpy as np
from matplotlib.patches import Circle
from matplotlib.transforms import blended_transform_factory

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots._types import Axes, Complexes, Dataset, Figure, Floats, States
from chaosdrill.plots.contents import places_of, swept
from chaosdrill.plots.curve import pieces
from chaosdrill.plots.figures import is_narrow, legend_above, legend_inside, legend_outside, new_figure, note, owner
from chaosdrill.plots.labels import (
    axis_label,
    readable,
    shorten,
    state_label,
    strobe_words,
    subscript,
    uncertain,
    wrapped,
)
from chaosdrill.plots.markers import WARNING, caveat, mark, named_once, period_categories, room, specials, warn
from chaosdrill.plots.palette import DOTS, EVENT_MARKERS, MARKERS, PALETTE, sequential
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING

_SECTION = PALETTE[1]
_EVENT_COLOURS = tuple(colour for colour in PALETTE if colour != _SECTION)
_CROSSINGS = ("fold", "period_doubling", "neimark_sacker")
FEIGENBAUM = 4.669201609102990
"""Feigenbaum, J. Stat. Phys. 19, 25 (1978), doi:10.1007/BF01020332; digits from Briggs, Math. Comp. 57, 435 (1991),
doi:10.1090/S0025-5718-1991-1079009-6.
"""


@picture(
    "periodic-orbit",
    "periodic-orbit",
    "points and events of the orbit, its multipliers, and the steps of Newton's method",
)
def orbit(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw a periodic orbit, or all that a search found.

    On the left the path, the points on the section in their order, and the states before (open) and after (filled) each
    event, joined by a dotted line; in the plane of the first two states, or over time for a system with one state. On
    the right the multipliers in the unit circle, and the residual after each step of Newton's method. Any reason to
    doubt the orbit stands above; without an orbit, only the residuals are shown. The dataset of a search goes to
    `orbits`. On ``ax`` points and events alone are drawn. ``state``: states of the plane; default: the first two.
    """
    if "orbit" in dataset.dims:
        return orbits(dataset, ax=ax, state=state)
    # without the rows that pad one orbit of a search
    dataset = dataset.isel(
        event=dataset["event_kind"].values >= 0,
        iterate=np.isfinite(dataset["section"].values).all(axis=1),
        iteration=np.isfinite(dataset["newton_residual"].values),
    )
    plane = places_of(dataset, state, 2)
    if ax is not None:
        _points(ax, dataset, plane, owns=False)
        return owner(ax)
    # an orbit that does not hold may be there to draw all the same
    found = bool(np.isfinite(dataset["period_time"]))
    figure = new_figure(5.0 if found else 2.8, least=2.6 if found else 0.0)
    heading = [_heading(dataset)] * found
    if not found:
        _newton(figure.subplots(), dataset)
    elif is_narrow():
        # numbers say what the other panels show, for which a column has no room
        _points(figure.subplots(), dataset, plane)
        heading.append("; ".join(_numbers(_multipliers(dataset))))
    else:
        grid = figure.add_gridspec(2, 2, width_ratios=[1.5, 1.0], height_ratios=[1.3, 1.0])
        panels = [figure.add_subplot(place) for place in (grid[:, 0], grid[0, 1], grid[1, 1])]
        _points(panels[0], dataset, plane)
        _circle(panels[1], dataset)
        _newton(panels[2], dataset)
    warning = caveat(dataset)
    text = "\n".join([*heading, *[warning] * bool(warning)])
    figure.suptitle(text, x=0.01, ha="left", fontsize="medium", color=WARNING if warning else "black")
    return figure


def _heading(dataset: Dataset) -> str:
    kind = "stable" if int(dataset["stable"]) else "unstable"
    time, residual = float(dataset["period_time"]), float(dataset["residual"])
    names = flag_names(dataset["event_kind"]) if dataset.sizes["event"] else {}
    events = [readable(names[int(code)]) for code in dataset["event_kind"].values]
    text = f"{kind} orbit of period {int(dataset['period'])}, time {time:.8g}; returns to within {residual:.1e}"
    more = len(events) - TUNING.told_events
    shown = ", ".join(events[: TUNING.told_events]) + f" and {more} more" * (more > 0)
    return f"{text}\nevents: {shown}" if events else text


def _points(axes: Axes, dataset: Dataset, states: tuple[int, ...], owns: bool = True) -> None:
    section, period = dataset["section"].values, dataset["period_time"].values
    before, after = dataset["event_state_before"].values, dataset["event_state_after"].values
    time, kinds = dataset["event_time"].values, dataset["event_kind"].values
    plane, forced = section.shape[1] > 1, "forcing_period" in dataset.variables
    if plane:
        places = [values[:, states] for values in (section, before, after)]
    else:
        instants = np.arange(len(section)) / max(len(section), 1) * float(period)
        if not forced and "path_time" in dataset.variables:
            own = np.isfinite(dataset["path_time"].values)
            nearest = np.abs(dataset["path_state"].values[own, 0] - section[:, :1]).argmin(axis=1)
            instants = dataset["path_time"].values[own][nearest]
        places = [np.column_stack([t, v[:, 0]]) for t, v in ((instants, section), (time, before), (time, after))]
    section, before, after = places
    _path(axes, dataset, states, color="0.35", linewidth=1.0, zorder=1, label="path")
    names = flag_names(dataset["event_kind"]) if kinds.size else {}
    for number, code in enumerate(np.unique(kinds)):
        here = kinds == code
        colour, marker = _EVENT_COLOURS[number % len(_EVENT_COLOURS)], EVENT_MARKERS[number % len(EVENT_MARKERS)]
        gap = np.full((int(here.sum()), 1, 2), np.nan)
        jumps = np.concatenate([before[here][:, None], after[here][:, None], gap], axis=1).reshape(-1, 2)
        axes.plot(*jumps.T, color=colour, linewidth=0.9, linestyle=DOTS, zorder=2)
        options: dict[str, Any] = {"linestyle": "none", "marker": marker, "markersize": 6, "color": colour}
        axes.plot(*before[here].T, markerfacecolor="white", zorder=3, **options)
        axes.plot(*after[here].T, zorder=3, label=readable(names[int(code)]), **options)
    where = strobe_words(dataset) if forced else "on the section"
    axes.plot(*section.T, "o", color=_SECTION, markersize=5, markeredgewidth=0, zorder=4, label=where)
    if 1 < len(section) <= 16:
        for number, (x, y) in enumerate(section, start=1):
            note(axes, str(number), (x, y), (5, 4), zorder=5)
    axes.set_xlabel(state_label(dataset, states[0]) if plane else "time since the start of the period")
    axes.set_ylabel(state_label(dataset, states[-1]))
    axes.margins(0.12)
    legend_above(axes, 3) if owns else legend_inside(axes)


def _path(axes: Axes, orbit: Dataset, states: tuple[int, ...], jumping: bool = False, **options: Any) -> None:
    """Draw the path of one orbit with a gap, or dots, at every jump, as far as the archive holds it."""
    if "path_time" in orbit.variables:
        own = np.isfinite(orbit["path_time"].values)
        time, path = orbit["path_time"].values[own], orbit["path_state"].values[own][:, states]
        across = path[:, 0] if len(states) > 1 else time
        flow, jumps = pieces(time, across, path[:, -1])
        axes.plot(*flow.T, **options)
        if jumping:
            axes.plot(*jumps.T, linestyle=DOTS, **options)


def _circle(axes: Axes, dataset: Dataset) -> None:
    values = _multipliers(dataset)
    outside = unit_circle(axes, values)
    axes.plot(values.real, values.imag, "o", color=PALETTE[0], markersize=5, zorder=3)
    lines = _numbers(values)
    if outside:
        lines.append(f"{outside} outside of the picture")
    axes.set_title("\n".join(lines), fontsize="small")


def _multipliers(dataset: Dataset) -> Complexes:
    values: Complexes = dataset["multiplier_real"].values + 1j * dataset["multiplier_imag"].values
    return values


def _numbers(values: Complexes) -> list[str]:
    """The multipliers as text, one line each; a pair has two lines, and several zeros share one."""
    lines, zeros = [], []
    for i, value in enumerate(values):
        if value == 0:
            zeros.append(subscript("μ", i + 1))
        elif np.isnan(value):
            continue
        elif value.imag == 0:
            lines.append(f"{subscript('μ', i + 1)} = {shorten(value.real)}")
        elif value.imag > 0 or i == 0 or values[i - 1] != value.conjugate():
            pair = [subscript("μ", i + 1), subscript("μ", i + 2)]
            lines.append(f"{', '.join(pair)} = {shorten(value.real)} ± {shorten(abs(value.imag))}i")
            lines.append(f"|{pair[0]}| = |{pair[1]}| = {shorten(abs(value))}")
    return lines + ([f"{' = '.join(zeros)} = 0 (rank lost)"] if zeros else [])


def _newton(axes: Axes, dataset: Dataset) -> None:
    residual = dataset["newton_residual"].values
    axes.semilogy(
        np.arange(len(residual)), np.maximum(residual, TUNING.least_residual), "o-", color=PALETTE[0], markersize=4
    )
    for step in np.flatnonzero(residual == 0):
        note(axes, "0", (step, TUNING.least_residual), (-7, 0), ha="center", va="center")
    axes.axhline(np.finfo(float).eps, color="0.6", linewidth=0.8, linestyle="--", zorder=1)
    note(axes, "ε", (1, np.finfo(float).eps), (2, 0), xycoords=("axes fraction", "data"), va="center")
    # orbits near an attractor start where others end
    axes.set_ylim(0.3 * TUNING.least_residual, max(1e-12, 3 * residual.max(initial=0.0)))
    axes.set(xlabel="step of Newton's method", ylabel="residual")
    axes.set_xticks(np.arange(0, len(residual), max(1, len(residual) // 8)))


def orbits(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw the orbits that a search found.

    On the left all paths and points on the section, a shape and colour for each period, filled where the orbit is
    stable; in the plane of the first two states, or points against the number of the orbit for a system with one state.
    On the right the multipliers in the unit circle. On ``ax`` the points alone are drawn. ``state``: states of the
    plane; default: the first two.
    """
    section, period = dataset["section"].values, dataset["period"].values.astype(np.int64)
    stable = dataset["stable"].values != 0
    values = _multipliers(dataset)
    figure = new_figure(4.0) if ax is None else owner(ax)
    shape: dict[str, Any] = {"nrows": 2} if is_narrow() else {"ncols": 2, "width_ratios": [1.5, 1.0]}
    left, *others = figure.subplots(**shape) if ax is None else [ax]
    outside = [unit_circle(right, values.ravel()) for right in others]
    plane = section.shape[2] > 1
    first, *second = places_of(dataset, state, 2)
    shortest_first = np.unique(period)
    # a shorter orbit has fewer points, which lie on top
    for place, length in reversed(list(enumerate(shortest_first))):
        colour, marker = PALETTE[place % len(PALETTE)], MARKERS[place % len(MARKERS)]
        for attracts in (False, True):
            here = np.flatnonzero((period == length) & (stable == attracts))
            if not here.size:
                continue
            points = section[here]
            x = points[..., first] if plane else np.broadcast_to(here[:, None] + 1.0, points.shape[:2])
            y = points[..., second[0] if plane else first]
            options: dict[str, Any] = {"linestyle": "none", "marker": marker, "markersize": 5, "color": colour}
            options |= {} if attracts else {"markerfacecolor": "white"}
            count = f"{here.size} {'stable' if attracts else 'unstable'}"
            for number in here if plane else ():
                _path(left, dataset.isel(orbit=number), (first, *second), True, color=colour, linewidth=0.6, zorder=2)
            left.plot(x.ravel(), y.ravel(), zorder=3, label=f"period {length}: {count}", **options)
            for right in others:
                right.plot(values[here].real.ravel(), values[here].imag.ravel(), zorder=3, **options)
    left.set_xlabel(state_label(dataset, first) if plane else "number of the orbit")
    left.set_ylabel(state_label(dataset, second[0] if plane else first))
    left.margins(0.08)
    for right, beyond in zip(others, outside, strict=True):
        if beyond:
            told = f"{beyond} of {np.isfinite(values).sum()} multipliers\nlie outside of the picture"
            right.set_title(told, fontsize="small")
    handles, _ = left.get_legend_handles_labels()
    legend_outside(figure, handles[::-1], ax=ax, handlelength=1.2)
    if ax is None:
        warn(figure, [dataset])
    return figure


def unit_circle(axes: Axes, values: Complexes) -> int:
    """Draw the unit circle and set limits that contain it and nearby values.

    ``values``: multipliers that will be drawn.

    Returns: how many of them lie outside the limits.
    """
    finite = values[np.isfinite(values)]
    size = np.maximum(np.abs(finite.real), np.abs(finite.imag))
    near = size[size <= TUNING.widened_up_to]
    reach = max(TUNING.circle_up_to, 1.08 * float(near.max(initial=0.0)))
    for line in (axes.axhline, axes.axvline):
        line(0, color="0.8", linewidth=0.6, zorder=0)
    axes.add_patch(Circle((0, 0), 1, facecolor="none", edgecolor="0.35", linewidth=0.9, zorder=1))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xlabel="real part", ylabel="imaginary part")
    return int((size > reach).sum())


@picture(
    "continuation",
    "multipliers",
    "multipliers along the branches, in the unit circle and as moduli",
    needs="multiplier_real",
    parameters=1,
)
def multipliers(dataset: Dataset) -> Figure:
    """Draw the multipliers of all orbits on the branches.

    Above, the complex plane with the unit circle; the colour of a point is the parameter, and the points at which a
    multiplier crosses the circle are marked. Below, the moduli over the parameter on a logarithmic axis, a colour for
    each period; along the bottom stand the special points at which no multiplier crosses the circle.
    """
    name = swept(dataset)[0]
    values = _multipliers(dataset)
    figure = new_figure(6.4, least=4.6)
    grid = figure.add_gridspec(2, 2, height_ratios=[1.7, 1.0], width_ratios=[1.75, 1.0])
    plane = figure.add_subplot(grid[0, :] if is_narrow() else grid[0, 0])
    beside = [] if is_narrow() else [figure.add_subplot(grid[0, 1])]
    below = figure.add_subplot(grid[1, :])
    _plane(figure, plane, dataset, name, values)
    _moduli(below, dataset, name, np.abs(values))
    if not beside:
        legend_outside(figure, named_once(below), handlelength=1.8)
    for side in beside:
        side.set_axis_off()
        legend_inside(side, named_once(below), loc="upper left", handlelength=1.8)
    warn(figure, [dataset])
    return figure


def _plane(figure: Figure, axes: Axes, dataset: Dataset, name: str, values: Complexes) -> None:
    outside = unit_circle(axes, values)
    shown = np.isfinite(values) & (values != 0)
    along = dataset[name].values
    x = np.broadcast_to(along[:, None], values.shape)
    look: dict[str, Any] = {"s": 5, "cmap": sequential(), "linewidth": 0, "zorder": 2, "rasterized": True}
    if along.size:
        # also where multipliers are zero
        look |= {"vmin": along.min(), "vmax": along.max()}
    dots = axes.scatter(values.real[shown], values.imag[shown], c=x[shown], **look)
    bar = figure.colorbar(dots, ax=axes, aspect=30, pad=0.02)
    bar.set_label(wrapped(axis_label(dataset, name), 24 if is_narrow() else 36))
    bar.outline.set_linewidth(0.5)
    for kind, points in specials(dataset):
        if kind in _CROSSINGS:
            crossing = np.concatenate([_crossing(values[point], kind) for point in points])
            mark(axes, crossing.real, crossing.imag, kind, TUNING.special_mark)
    if outside:
        axes.set_title(f"{outside} of {np.isfinite(values).sum()} lie outside; their moduli are below")


def _crossing(values: Complexes, kind: str) -> Complexes:
    """The multipliers of one orbit that cross the unit circle."""
    if kind == "neimark_sacker":
        pairs = values[values.imag != 0]
        return pairs[np.argsort(np.abs(np.abs(pairs) - 1), kind="stable")[:2]]
    target = 1.0 if kind == "fold" else -1.0
    return values[[int(np.argmin(np.abs(np.nan_to_num(values, nan=np.inf) - target)))]]


def _moduli(axes: Axes, dataset: Dataset, name: str, moduli: Floats) -> None:
    x, branch = dataset[name].values, dataset["branch"].values
    categories = period_categories([dataset])
    axes.axhline(1, color="0.35", linewidth=0.9, zorder=1)
    positive = np.where(moduli > 0, moduli, np.nan)
    for number in np.unique(branch):
        points = branch == number
        category = categories[int(dataset["branch_period"].values[number])]
        axes.plot(x[points], positive[points], color=category.colour, label=category.name)
    for i in range(moduli.shape[1]):
        # at grazing there are no multipliers
        lost, known = moduli[:, i] == 0, ~np.isnan(moduli[:, i])
        if lost.any():
            where = "" if lost.sum() == known.sum() else f" at {lost.sum()} of {known.sum()} points"
            axes.plot([], [], linestyle="none", label=f"{subscript('μ', i + 1)} = 0{where}")
    axes.update_datalim(np.column_stack([x, np.ones(len(x))]))
    axes.margins(x=0.02)
    foot = blended_transform_factory(axes.transData, axes.transAxes)
    found = specials(dataset)
    for height, own in ((1.0, True), (0.05, False)):
        here = [(kind, points) for kind, points in found if (kind in _CROSSINGS) == own]
        every = x[np.concatenate([np.zeros(0, dtype=np.int64), *(points for _, points in here)])]
        widest = TUNING.special_mark if own else TUNING.foot_mark
        sizes = np.minimum(widest, room(axes, np.column_stack([every, np.zeros(len(every))])))
        more: dict[str, Any] = {} if own else {"transform": foot}
        for kind, points in here:
            mark(axes, [], [], kind, TUNING.special_mark)
            kept, sizes = sizes[: len(points)], sizes[len(points) :]
            for size in np.unique(kept)[::-1]:
                part = points[kept == size]
                mark(axes, x[part], np.full(len(part), height), kind, float(size), **more)
    finite = positive[np.isfinite(positive)]
    axes.set_yscale("log")
    axes.set_ylim(max(TUNING.smallest_modulus, 0.7 * finite.min(initial=0.5)), 1.5 * finite.max(initial=1.0))
    axes.set(xlabel=axis_label(dataset, name), ylabel="modulus")


@picture(
    "continuation",
    "cascade",
    "period doublings, their accumulation point and Feigenbaum ratios",
    needs="accumulation",
    parameters=1,
)
def cascade(dataset: Dataset) -> Figure:
    """Draw the doublings of a cascade.

    Above, the distance of each doubling from the accumulation point, on a logarithmic axis, with a line that falls by
    Feigenbaum's constant per doubling, and the error of the accumulation point, below which distances are meaningless.
    Below, the ratios of the distances between doublings.
    """
    name = swept(dataset)[0]
    values, ratios = dataset["doubling_value"].values, dataset["feigenbaum_ratio"].values
    periods = dataset["doubling_period"].values.astype(np.int64)
    limit, error = float(dataset["accumulation"]), float(dataset["accumulation_error"])
    number = np.arange(len(values))
    figure = new_figure(5.2)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.4, 1.0])

    distance = np.abs(values - limit)
    upper.semilogy(number, distance, "o", color=PALETTE[0], markersize=5, label="period doubling")
    # through the last distance that the error leaves standing: the first ones need not follow the law yet
    told = int(np.flatnonzero(distance > error)[-1]) if (distance > error).any() else 0
    fall = distance[told] * FEIGENBAUM ** (told - number)
    upper.semilogy(number, fall, color="0.6", linewidth=0.9, zorder=1, label="falls by 4.6692 a doubling")
    if error > 0:
        upper.axhspan(0, error, color="0.92", linewidth=0, zorder=0, label="error of the accumulation point")
    upper.set_ylim(0.4 * min(distance[distance > 0].min(initial=np.inf), fall[-1], error or np.inf), None)
    upper.set_ylabel("distance from the accumulation point")
    upper.set_title(f"{axis_label(dataset, name)}: accumulation at {uncertain(limit, error)}")
    legend_outside(figure, upper.get_legend_handles_labels()[0])

    lower.axhline(FEIGENBAUM, color="0.6", linewidth=0.9, zorder=1)
    note(lower, "4.6692", (1, FEIGENBAUM), (3, 0), xycoords=("axes fraction", "data"), va="center")
    lower.plot(number, ratios, "o", color=PALETTE[1], markersize=5)
    for place, ratio in zip(number, ratios, strict=True):
        if np.isfinite(ratio):
            # away from the line
            offset, va = ((0, 6), "bottom") if ratio > FEIGENBAUM else ((0, -6), "top")
            note(lower, f"{ratio:.4f}".replace("-", "−"), (place, ratio), offset, ha="center", va=va)
    lower.set_ylabel("Feigenbaum ratio")
    lower.margins(y=0.35)
    lower.set_xticks(number, [f"{period} → {2 * period}" for period in periods])
    lower.set(xlabel="period doubling", xlim=(-0.5, len(values) - 0.5))
    warn(figure, [dataset])
    return figure

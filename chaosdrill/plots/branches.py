"""Branches of periodic orbits over a parameter, and curves of special points over two, on top of diagram or chart."""

import json
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.patheffects import Normal, Stroke

from chaosdrill.plots._types import Axes, Dataset, Figure, Floats, Integers, States, Truths
from chaosdrill.plots.categories import Category, by_period
from chaosdrill.plots.contents import limits, places_of, settings, swept
from chaosdrill.plots.figures import legend_outside, new_figure, one_panel
from chaosdrill.plots.labels import axis_label, state_label
from chaosdrill.plots.markers import (
    bar,
    end_label,
    ends,
    mark,
    named_once,
    period_categories,
    room,
    soft_and_hard,
    special_name,
    specials,
    warn,
)
from chaosdrill.plots.palette import BACKGROUND, LINE_COLOURS
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.plane import Plane
from chaosdrill.plots.sections import first_that_varies
from chaosdrill.plots.tuning import TUNING

_NO_BIFURCATION = "real multipliers of product 1: no bifurcation"
_LOOKS: dict[bool, tuple[Any, str]] = {True: ("-", "stable"), False: ((0, (4, 2)), "unstable")}
"""Dashes and word of a curve, by whether it is stable."""

_DASHES = {
    "fold": "-",
    "period_doubling": (0, (5, 1.5)),
    "grazing": (0, (1.2, 1.2)),
    "neimark_sacker": (0, (6, 1.5, 1.2, 1.5)),
}


@picture(
    "continuation",
    "branches",
    "branches of orbits and their special points, over the bifurcation diagram if there is one",
    parameters=1,
    over="bifurcation-diagram",
)
def branches(*datasets: Dataset, over: Dataset | None = None, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw branches of periodic orbits over the parameter.

    The state at all points of each orbit on the section: one line per iterate, one colour per period, solid where the
    orbit is stable and dashed where it is unstable. Each kind of special point has its own shape. Bars mark ends of
    branches inside the parameter's range, and the legend explains them. The axis shows the requested range, whatever
    that of the diagram. Crowded special points are drawn smaller, and a second panel enlarges the part of the range
    with most of them. ``over``, a bifurcation diagram over that parameter, is drawn behind. ``state``: state that is
    drawn; default: the first that varies.
    """
    name = swept(datasets[0])[0]
    states = [dataset["section"].values for dataset in datasets]
    varies = first_that_varies(np.concatenate([values.reshape(-1, values.shape[-1]) for values in states]))
    index = varies if state is None else places_of(datasets[0], state, 1)[0]
    low, high = zip(*(limits(dataset)[name] for dataset in datasets), strict=True)
    edge = 0.02 * (max(high) - min(low))
    limits_of = [(min(low) - edge, max(high) + edge)]
    crowd = None if ax is not None else _crowd(datasets, name, max(high) - min(low))
    if crowd is None:
        figure, axes = one_panel(ax, 4.6)
        panels = [axes]
    else:
        figure = new_figure(8.4)
        panels = list(figure.subplots(2, 1))
        axes = panels[0]
        axes.axvspan(*crowd, color="0.93", linewidth=0, zorder=0, label="shown below")
        limits_of.append(crowd)
    categories = period_categories(datasets)
    for panel, (left, right) in zip(panels, limits_of, strict=True):
        panel.set_xlim(left, right)
        if over is not None:
            _attractors(panel, over, index)
        drawn = {stable for dataset in datasets for stable in _lines(panel, dataset, name, index, categories)}
        for category in dict.fromkeys(categories.values()):
            panel.plot([], [], color=category.colour, linewidth=1.8, label=category.name)
        for stable in sorted(drawn, reverse=True):
            dashes, text = _LOOKS[stable]
            panel.plot([], [], color="0.25", linestyle=dashes, linewidth=1.2, label=text)
        _fit(panel)
        _marks(panel, datasets, name, index)
        panel.set_ylabel(state_label(datasets[0], index))
    panels[-1].set_xlabel(axis_label(datasets[0], name))
    legend_outside(figure, named_once(axes), ax=ax, handlelength=2.0)
    if ax is None:
        warn(figure, datasets)
    behind = "" if over is None else ", over the bifurcation diagram"
    figure.set_label(f"branches of orbits and their special points{behind}")
    return figure


def _attractors(axes: Axes, diagram: Dataset, index: int) -> None:
    name = swept(diagram)[0]
    section = diagram["section"].values[..., index]
    x = np.broadcast_to(diagram[name].values[:, None, None], section.shape)
    left, right = axes.get_xlim()
    known = np.isfinite(section) & (x >= left) & (x <= right)
    # a cloud has many small points, a cycle few that have to be seen under lines
    cloud = float(np.sqrt(np.clip(2e4 / max(int(known.sum()), 1), 0.25, 2.0)))
    cycle = np.broadcast_to(diagram["period"].values[..., None] > 0, section.shape)
    options: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": BACKGROUND, "markeredgewidth": 0}
    line = float(np.clip(900 / len(x), 1.2, 2.0))
    for part, size in ((known & ~cycle, cloud), (known & cycle, max(cloud, line))):
        axes.plot(x[part], section[part], markersize=size, rasterized=True, zorder=1, **options)
    axes.plot([], [], markersize=3, label="bifurcation diagram", **options)


def _lines(axes: Axes, dataset: Dataset, name: str, index: int, categories: dict[int, Category]) -> set[bool]:
    """Draw the curves of a dataset; return whether they are stable, each answer once."""
    drawn = set()
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
            here = bool(stable[first])
            drawn.add(here)
            options: dict[str, Any] = {"linestyle": _LOOKS[here][0], "color": categories[period].colour}
            options |= {"linewidth": 1.5 * thin, "zorder": 3} if here else {"linewidth": 0.9 * thin, "zorder": 2}
            axes.plot(x[part], section[part][:, used, index], **options)
    return drawn


def _stretches(stable: Truths, special: Truths) -> Truths:
    """Return whether each stretch between neighbouring points is stable, shape (m - 1,).

    At a special point, and where one branch leaves another, round-off decides what is stored; the neighbour is used
    instead.
    """
    told: Truths = np.where(special[:-1] | (np.arange(len(stable) - 1) == 0), stable[1:], stable[:-1])
    return told


def _jumps(section: Floats) -> Integers:
    """Numbers of the stretches over which the section jumps, for example where an event reaches the section's phase."""
    if len(section) < 2 or np.isnan(section).all():
        return np.zeros(0, dtype=np.int64)
    extent = np.maximum(np.nanmax(section, axis=(0, 1)) - np.nanmin(section, axis=(0, 1)), 1e-300)
    step = np.nan_to_num(np.abs(np.diff(section, axis=0)) / extent).max(axis=(1, 2))
    padded = np.pad(step, 1)
    return np.flatnonzero(
        (step > TUNING.visible_on_branch) & (step > TUNING.jump_of_branch * np.maximum(padded[:-2], padded[2:]))
    )


def _crowd(datasets: tuple[Dataset, ...], name: str, extent: float) -> tuple[float, float] | None:
    """The shortest interval with most of the special points, if they crowd in a small part of the range."""
    found = [dataset[name].values[points] for dataset in datasets for _, points in specials(dataset)]
    x = np.sort(np.concatenate([np.zeros(0), *found]))
    most = int(np.ceil(TUNING.crowd_share * x.size))
    if x.size < TUNING.crowd:
        return None
    widths = x[most - 1 :] - x[: x.size - most + 1]
    first = int(np.argmin(widths))
    if widths[first] > TUNING.crowd_part * extent:
        return None
    edge = max(0.04 * float(widths[first]), 1e-3 * extent)
    return float(x[first]) - edge, float(x[first + most - 1]) + edge


def _fit(axes: Axes) -> None:
    """Fit the height of the axes to what lies within their width."""
    left, right = axes.get_xlim()
    within = [np.zeros(0)]
    for line in axes.get_lines():
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        within.append(y[(x >= left) & (x <= right) & np.isfinite(y)])
    values = np.concatenate(within)
    if values.size:
        edge = 0.05 * float(np.ptp(values)) or 0.05 * abs(float(values[0])) or 1.0
        axes.set_ylim(values.min() - edge, values.max() + edge)


def _marks(axes: Axes, datasets: tuple[Dataset, ...], name: str, index: int) -> None:
    reasons: dict[str, None] = {}
    kinds: list[tuple[str, bool]] = []
    places, sizes = [np.zeros((0, 2))], [np.zeros(0)]
    for dataset in datasets:
        x, section = dataset[name].values, dataset["section"].values[..., index]
        for kind, off, points in soft_and_hard(dataset):
            for here, size in _sizes(section, points):
                shown = section[here]
                known = np.isfinite(shown)
                places.append(np.column_stack([np.broadcast_to(x[here, None], shown.shape)[known], shown[known]]))
                sizes.append(np.full(len(places[-1]), TUNING.special_mark * size))
                kinds += [(kind, off)] * len(places[-1])
    every, widths = np.concatenate(places), np.concatenate(sizes)
    widths = np.minimum(widths, room(axes, every))
    for one in dict.fromkeys(kinds):
        of_kind = np.array([other == one for other in kinds], dtype=bool)
        for width in np.unique(widths[of_kind])[::-1]:
            here = of_kind & (widths == width)
            mark(axes, every[here, 0], every[here, 1], one[0], float(width), jumps=one[1])
    for dataset in datasets:
        x, section = dataset[name].values, dataset["section"].values[..., index]
        last, names = ends(dataset)
        reasons.update(dict.fromkeys(names))
        for here, size in _sizes(section, last):
            shown = section[here]
            bar(axes, np.broadcast_to(x[here, None], shown.shape), shown, TUNING.branch_bar * size)
    if reasons:
        bar(axes, [], [], TUNING.branch_bar, end_label(reasons))


def _sizes(section: Floats, points: Integers) -> list[tuple[Integers, float]]:
    """Sort points by the number of their marks, each with a factor for the size of the marks."""
    periods = np.isfinite(section[points]).sum(axis=1)
    return [(points[periods == n], _thinner(n)) for n in np.unique(periods)]


def _thinner(period: int) -> float:
    """Factor for the size of lines and marks: those of a long orbit would fill the picture."""
    return max(0.4, 1 - 0.12 * float(np.log2(max(period, 1))))


@picture(
    "continuation",
    "curves",
    "curves of special points over two parameters, over the chart of periods if there is one",
    parameters=2,
    over="parameter-chart",
)
def curves(*datasets: Dataset, over: Dataset | None = None, ax: Axes | None = None) -> Figure:
    """Draw curves of special points in the plane of two parameters.

    A colour for each kind of curve and period, and dashes by kind. Special points on a curve have their own shapes,
    parts on which nothing bifurcates are thin, and ends inside the parameters' range have a bar. Nothing is drawn
    outside a chart. The periods of ``over``, a chart over both, are drawn behind, with a panel for each seed. ``ax``
    takes a chart of one seed.
    """
    legend: Callable[..., None]
    if over is None:
        across, up = swept(datasets[0])
        figure, axes = one_panel(ax, 4.6)
        axes.set(xlabel=axis_label(datasets[0], across), ylabel=axis_label(datasets[0], up))
        axes.margins(0.03)
        panels, legend = [axes], partial(legend_outside, figure, ax=ax, handlelength=2.4)
        limits = ((-np.inf, np.inf), (-np.inf, np.inf))
    else:
        plane = Plane(over, "period", ax)
        plane.categorise(*by_period(over))
        across, up, figure, panels, legend = plane.across, plane.up, plane.figure, plane.panels, plane.legend
        limits = (panels[0].get_xlim(), panels[0].get_ylim())
    for axes in panels:
        _curves(axes, [_Curve(dataset, across, up, limits) for dataset in datasets])
        if over is not None:
            axes.set(xlim=limits[0], ylim=limits[1])
    legend(named_once(panels[0]))
    if ax is None:
        warn(figure, datasets)
    behind = "" if over is None else ", over the chart of periods"
    figure.set_label(f"curves of special points over two parameters{behind}")
    return figure


class _Curve:
    """The points of a dataset over two parameters, and which of them are within limits; the others are not named."""

    def __init__(self, dataset: Dataset, across: str, up: str, limits: tuple[tuple[float, float], ...]) -> None:
        self.dataset, self.kind = dataset, str(settings(dataset).get("follow") or "")
        self.x, self.y = dataset[across].values, dataset[up].values
        (left, right), (low, high) = limits
        self.inside = (self.x >= left) & (self.x <= right) & (self.y >= low) & (self.y <= high)

    def specials(self) -> list[tuple[str, Integers]]:
        """Kinds of special points on the curve with their numbers, except the one from which it was followed."""
        second = swept(self.dataset)[1]
        own = json.loads(str(self.dataset.attrs["parameters"]))[second]
        start = np.isclose(self.dataset[second].values, own, rtol=1e-12, atol=0.0)
        kept = (
            (kind, points[self.inside[points] & ~((kind == self.kind) & start[points])])
            for kind, points in specials(self.dataset)
        )
        return [(kind, points) for kind, points in kept if points.size]


def _curves(axes: Axes, curves: list[_Curve]) -> None:
    rim = [Stroke(linewidth=3.6, foreground="white"), Normal()]
    named: dict[str, str] = {}
    for curve in curves:
        branch = curve.dataset["branch"].values
        for number in np.unique(branch[curve.inside]):
            points = branch == number
            text = f"{special_name(curve.kind)}, period {int(curve.dataset['branch_period'].values[number])}"
            colour = named.setdefault(text, LINE_COLOURS[len(named) % len(LINE_COLOURS)])
            options: dict[str, Any] = {"color": colour, "linestyle": _DASHES.get(curve.kind, "-."), "linewidth": 1.6}
            # only such a pair leaves the unit circle along its curve
            circling = curve.kind == "neimark_sacker"
            quiet = points & circling & (curve.dataset["special_point"].values == 0)
            y = np.where(quiet, np.nan, curve.y)
            axes.plot(curve.x[points], y[points], path_effects=rim, zorder=3, label=text, **options)
            if quiet.any():
                beside = quiet | np.roll(quiet, 1) | np.roll(quiet, -1)
                y = np.where(beside, curve.y, np.nan)
                axes.plot(curve.x[points], y[points], color=colour, linewidth=0.6, zorder=2, label=_NO_BIFURCATION)
    reasons: dict[str, None] = {}
    for curve in curves:
        for kind, points in curve.specials():
            mark(axes, curve.x[points], curve.y[points], kind, TUNING.special_mark)
        for point, name in zip(*ends(curve.dataset), strict=True):
            if curve.inside[point]:
                reasons[name] = None
                bar(axes, curve.x[point], curve.y[point], TUNING.branch_bar)
    if reasons:
        bar(axes, [], [], TUNING.branch_bar, end_label(reasons))

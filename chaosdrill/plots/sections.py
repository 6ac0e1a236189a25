"""Sections: over the swept parameter with spectrum and periods, in a plane, and as a return map."""

from typing import Any

import numpy as np
from matplotlib.transforms import blended_transform_factory

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots._types import Axes, Dataset, Figure, Floats, Integers, States, Truths
from chaosdrill.plots.categories import MOTIONS, NO_RESULT, Category, by_period
from chaosdrill.plots.contents import places_of, settings, swept
from chaosdrill.plots.figures import (
    legend_above,
    legend_inside,
    legend_outside,
    make_room_for_legends,
    new_figure,
    one_panel,
    owner,
    size_of,
)
from chaosdrill.plots.labels import (
    axis_label,
    label,
    seed_names,
    shorten,
    state_label,
    strobe_words,
    subscript,
    wrapped,
)
from chaosdrill.plots.palette import BACKGROUND, PALETTE, SEED_COLOURS
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.plane import bounds, draw_cells, legend_entry
from chaosdrill.plots.tuning import TUNING

# exponents descend, so that their order distinguishes them where colours do not
_EXPONENT_COLOURS = ("#0D3B81", "#D55E00", "#009E73", "#CC79A7", "#DCA438", "#000000")
_NOT_REACHED = Category("section not reached", "#E4E4E4", "....")


@picture("bifurcation-diagram", "bifurcation-diagram", "section, exponents, progression and periods")
def bifurcation(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw a bifurcation diagram.

    From top to bottom, over the same axis: the state on the section (one colour per seed; where seeds agree, later ones
    are smaller dots on top of earlier ones), the exponents with zero marked, the progression rate if the system has
    one, and a row for each seed with its period or outcome. Points without a result from any seed are shaded. On ``ax``
    the section alone is drawn. ``state``: state of the section; default: the first that varies.
    """
    sweep = str(dataset["period"].dims[0])
    if (np.diff(dataset[sweep].values) < 0).any():
        dataset = dataset.sortby(sweep)
    states = dataset["section"].values
    index = first_that_varies(states) if state is None else places_of(dataset, state, 1)[0]
    edges = bounds(dataset[sweep].values)
    ended = [code for code, name in flag_names(dataset["outcome"]).items() if name in MOTIONS]
    # no seed has a result there
    lost = np.isin(dataset["outcome"].values, ended).sum(axis=1) == 0
    x = dataset[sweep].values
    limits = edges[[0, -1]] if len(x) == 1 else x[[0, -1]]
    has_spectrum = ax is None and "lyapunov_exponent" in dataset.variables
    has_rate = ax is None and bool(np.isfinite(dataset.get("progression_rate", np.nan)).any())
    seeds = dataset.sizes["seed"]
    row = 0.18 if seeds == 1 else 0.14 * min(seeds, TUNING.named_rows)
    heights = [2.6] + [1.7] * has_spectrum + [1.0] * has_rate + [row]
    figure = new_figure(1.4 + sum(heights), least=1.2 + TUNING.low * sum(heights)) if ax is None else owner(ax)
    panels = [ax] if ax else list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
    for panel in panels[: len(heights) - 1]:
        _shade(panel, edges, lost, NO_RESULT)
    _section(panels[0], dataset, sweep, states[..., index], edges, lost)
    (legend_above if ax is None else legend_inside)(panels[0])
    panels[0].set_ylabel(state_label(dataset, index))
    panels[-1].set(xlabel=axis_label(dataset, sweep), xlim=limits)
    if ax is not None:
        return figure
    if has_spectrum:
        _spectrum(panels[1], dataset, sweep)
    if has_rate:
        rate = dataset["progression_rate"]
        for seed, (colour, _, step) in enumerate(seed_lines(dataset)):
            _draw(panels[-2], dataset, seed, rate.values[:, seed], colour, step)
        panels[-2].set_ylabel(wrapped(label(rate), 12))
    _periods(panels[-1], dataset, sweep, edges, row)
    panels[-1].set_xlim(*limits)
    # one line each has room beside the panels
    make_room_for_legends(figure, len(panels))
    figure.align_ylabels(panels[:-1])
    shown = ["section", *["exponents"] * has_spectrum, *["progression"] * has_rate]
    figure.set_label(f"{', '.join(shown)} and periods")
    return figure


def _shade(panel: Axes, edges: Floats, mask: Truths, category: Category) -> None:
    turns = np.flatnonzero(np.diff(np.pad(mask.astype(np.int8), 1)))
    for number, (first, last) in enumerate(turns.reshape(-1, 2)):
        panel.axvspan(
            edges[first],
            edges[last],
            facecolor=category.colour,
            edgecolor="0.5",
            linewidth=0,
            hatch=category.hatch,
            zorder=0,
            label=f"{category.name}: {mask.sum()} of {mask.size} points" if number == 0 else None,
        )


def _section(panel: Axes, dataset: Dataset, sweep: str, section: Floats, edges: Floats, lost: Truths) -> None:
    period = dataset["period"].values
    x = np.broadcast_to(dataset[sweep].values[:, None], section[:, 0].shape)
    _shade(panel, edges, np.isnan(section).all(axis=(1, 2)) & ~lost, _NOT_REACHED)
    # a cloud has many small points, a cycle few that stand out
    cloud = float(np.sqrt(np.clip(4e4 / max(section.size, 1), 0.35, 2.0)))
    few = float(np.clip(120 / max(len(section), 1), 0.0, 3.0))
    for seed, (colour, name, step) in enumerate(seed_lines(dataset)):
        cycle = period[:, seed] > 0
        # of a cycle one turn is enough; it is the last one of the points that there are
        known = np.isfinite(section[:, seed])
        behind = np.cumsum(known[:, ::-1], axis=1)[:, ::-1]
        turn = known & (behind <= np.where(cycle, period[:, seed], section.shape[2])[:, None])
        for mask, size in ((cycle, max(1.2, cloud, few) + 0.9 * step), (~cycle, cloud)):
            shown = turn & mask[:, None]
            look: dict[str, Any] = {"markeredgewidth": 0, "rasterized": True}
            panel.plot(x[shown], section[:, seed][shown], "o", markersize=size, color=colour, **look)
        if name:
            panel.plot([], [], "o", markersize=3 + step, markeredgewidth=0, color=colour, label=name)


def first_that_varies(states: Floats) -> int:
    """Return the index of the first state that varies on the section; the position of a wall does not at an impact.

    The states are the last axis of ``states``; values may be missing.
    """
    for index in range(states.shape[-1]):
        if varies(states[..., index], states):
            return index
    return 0


def varies(values: Floats, states: Floats) -> bool:
    """Return whether a state has more than one value on a section, relative to all states of the section."""
    known, every = values[np.isfinite(values)], np.abs(states[np.isfinite(states)])
    if not known.size:
        return False
    # round-off around zero is measured by the other states, which may have another unit
    return bool(np.ptp(known) > TUNING.flat * max(float(np.abs(known).max()), TUNING.flat * float(every.max())))


def _spectrum(panel: Axes, dataset: Dataset, sweep: str) -> None:
    exponents = dataset["lyapunov_exponent"].values
    x = dataset[sweep].values
    foot = blended_transform_factory(panel.transData, panel.transAxes)
    panel.axhline(0, color="0.5", linewidth=0.7, zorder=1)
    for i in range(exponents.shape[2]):
        values = exponents[:, :, i]
        colour = _EXPONENT_COLOURS[i % len(_EXPONENT_COLOURS)]
        name = subscript("λ", i + 1)
        known, lost = ~np.isnan(values), np.isneginf(values)
        if known.any() and lost[known].all():
            panel.plot([], [], linestyle="none", label=f"{name} = −∞")
            continue
        for seed, (_, _, step) in enumerate(seed_lines(dataset)):
            _draw(panel, dataset, seed, np.where(lost[:, seed], np.nan, values[:, seed]), colour, step)
        panel.plot([], [], color=colour, label=name)
        if lost.any():
            there = x[lost.any(axis=1)]
            height = np.full(len(there), 0.04 + 0.06 * i)
            text = f"{name} = −∞ at {len(there)} of {len(x)} points"
            panel.plot(there, height, "v", markersize=2.5, color=colour, transform=foot, label=text)
    panel.set_ylabel(label(dataset["lyapunov_exponent"]))
    times = [dataset[name].values for name in ("return_time", "forcing_period") if name in dataset.variables]
    between = np.concatenate([np.ravel(one[np.isfinite(one)]) for one in times] or [np.zeros(0)])
    finite = exponents[np.isfinite(exponents)]
    if between.size and np.abs(finite).max(initial=0.0) * between.max() < TUNING.visible_growth:
        panel.set_ylim(-TUNING.zero_growth / between.max(), TUNING.zero_growth / between.max())
    # the shades are named above
    legend_above(panel, handles=[line for line in panel.get_lines() if str(line.get_label()).startswith("λ")])


def _periods(panel: Axes, dataset: Dataset, sweep: str, edges: Floats, height: float) -> None:
    codes, categories = by_period(dataset.transpose("seed", sweep, ...))
    names = seed_names(dataset)
    size = (size_of(height)[0] - TUNING.beside, height)
    draw_cells(panel, edges, np.arange(len(names) + 1.0), codes, categories, size, names=False)
    panel.invert_yaxis()
    panel.spines["left"].set_visible(False)
    named = 1 < len(names) <= TUNING.named_rows
    panel.set_yticks(np.arange(len(names)) + 0.5 if named else [], names if named else [])
    if len(names) > TUNING.named_rows:
        panel.set_ylabel(f"{len(names)} seeds")
    panel.tick_params(axis="y", length=0, labelsize="small")
    legend_above(panel, columns=5, handles=[legend_entry(category) for category in categories])


def seed_lines(dataset: Dataset) -> list[tuple[str, str, float]]:
    """Return colour and name of each seed, and how much wider than the last one it is drawn, from 0 to 2.

    With more seeds than can be distinguished, only the sweeps up and down have colours; the others are grey and have no
    name: the rows at the bottom distinguish them.
    """
    names = seed_names(dataset)
    if len(names) > len(SEED_COLOURS):
        swept = {"forward": (SEED_COLOURS[2], "forward", 1.0), "backward": (SEED_COLOURS[1], "backward", 0.0)}
        others = (BACKGROUND if set(names) & swept.keys() else "black", "", 0.0)
        return [swept.get(name, others) for name in names]
    if len(names) == 1:
        return [("black", "", 0.0)]
    steps = np.linspace(2.0, 0.0, len(names)).tolist()
    return list(zip(SEED_COLOURS, names, steps, strict=False))


def _draw(panel: Axes, dataset: Dataset, seed: int, values: Floats, colour: str, step: float) -> None:
    """A line where neighbours belong together, dots for what has none and for seeds that may reach other attractors."""
    x = dataset[str(dataset["period"].dims[0])].values
    dots = np.isfinite(values)
    if dataset.sizes["seed"] == 1 or seed_names(dataset)[seed] in ("forward", "backward"):
        options: dict[str, Any] = {"color": colour, "linewidth": 0.8 + step, "alpha": 1 if step == 0 else 0.5}
        breaks = _breaks(dataset, seed, values)
        panel.plot(np.insert(x, breaks, np.nan), np.insert(values, breaks, np.nan), **options)
        joined = np.pad(dots[:-1] & dots[1:], 1)
        joined[breaks] = False
        dots &= ~(joined[:-1] | joined[1:])
    if dots.any():
        size = float(np.clip(300 / len(x), 1.0, 3.0))
        panel.plot(x[dots], values[dots], "o", color=colour, markersize=size + 0.8 * step, markeredgewidth=0)


def _breaks(dataset: Dataset, seed: int, values: Floats) -> Integers:
    """Indices before which a line is broken, at jumps from one attractor to another."""
    # a selection by xarray would import dask, where that is installed
    kinds = np.stack([dataset[name].values[:, seed] for name in ("period", "outcome")], axis=1)
    changes = (np.diff(kinds, axis=0) != 0).any(axis=1)
    steps = np.abs(np.diff(values))
    known = np.where(np.isfinite(steps), steps, 0.0)
    usual = np.pad(known, 2)
    beside = np.maximum(usual[1:-3], usual[3:-1])
    # a jump may take two steps, by a run that is still on its way
    apart = np.maximum(np.minimum(usual[:-4], usual[1:-3]), np.minimum(usual[3:-1], usual[4:]))
    around = np.pad(changes, 1)
    near = changes | around[:-2] | around[2:]
    extent = float(np.ptp(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0
    jumps = (
        (known > TUNING.jump_of_section * beside)
        | (near & (known > TUNING.jump_of_section * apart))
        | (changes & (known > TUNING.leap_of_section * extent))
    )
    found: Integers = np.flatnonzero(jumps & (known > TUNING.visible_in_section * extent)) + 1
    return found


@picture("poincare-section", "poincare-section", "the section in the plane of the first two states")
def poincare(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw a section.

    The points; the title gives the section, the period found and the multipliers. A system with one state is drawn
    against the number of the iterate. ``state``: states of the plane; default: the first two.
    """
    section = dataset["section"].values
    period = int(dataset["period"]) if "period" in dataset.variables else 0
    figure, axes = one_panel(ax, 4.4)
    plane = section.shape[1] > 1
    first, *second = _plane(section) if plane and state is None else places_of(dataset, state, 2)
    x = section[:, first] if plane else np.arange(len(section))
    y = section[:, second[0]] if plane else section[:, first]
    if period:
        axes.scatter(x[-period:], y[-period:], s=34, color=PALETTE[1], edgecolor="white", linewidth=0.5)
        axes.margins(0.25)
    else:
        size = float(np.clip(6e3 / max(len(section), 1), 0.6, 9.0))
        axes.scatter(x, y, s=size, color=PALETTE[0], linewidth=0, rasterized=len(section) > TUNING.many_points)
    axes.set_xlabel(state_label(dataset, first) if plane else "iterate")
    axes.set_ylabel(state_label(dataset, second[0] if plane else first))
    axes.set_title(_title(dataset, period, len(section)))
    return figure


def _plane(section: np.ndarray) -> tuple[int, int]:
    """Return the first two states that vary on the section; on a surface one may not."""
    moves = np.array([varies(values, section) for values in section.T])
    first, second = sorted(np.argsort(~moves, kind="stable")[:2].tolist())
    return first, second


@picture("poincare-section", "return-map", "each point of the section against the one before it, with its cobweb")
@picture(
    "bifurcation-diagram",
    "return-map",
    "each point of the section against the one before it, at one value of the parameter",
    values=1,
)
def return_map(dataset: Dataset, *, ax: Axes | None = None, state: States = None) -> Figure:
    """Draw one state of each point of a section against that of the point before.

    The points with the diagonal, and the cobweb of the first 40 returns as a thin line: a transient, if the record
    begins with one. The cobweb of a detected cycle is a thick line. Each seed has a colour. ``state``: state that is
    drawn; default: the first that varies.
    """
    varied = swept(dataset)
    states = dataset["section"].values.reshape(-1, dataset.sizes["iterate"], dataset.sizes["state"])
    index = first_that_varies(states) if state is None else places_of(dataset, state, 1)[0]
    periods = np.ravel(dataset["period"].values) if "period" in dataset.variables else np.zeros(1)
    figure, axes = one_panel(ax, 5.4)
    lines = seed_lines(dataset) if varied else [(PALETTE[0], "", 0.0)]
    for values, period, (colour, name, _) in zip(states[..., index], periods.astype(int), lines, strict=True):
        last = int(np.flatnonzero(np.isfinite(values))[-1]) if np.isfinite(values).any() else 0
        axes.plot(*cobweb(values[: TUNING.cobweb_steps + 1]), color=colour, linewidth=0.5, alpha=0.6)
        if 0 < period <= last:
            axes.plot(*cobweb(values[last - period : last + 1]), color=colour, linewidth=1.5)
        size = float(np.clip(np.sqrt(6e3 / max(last, 1)), 1.0, 4.0))
        dots: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": colour, "markeredgewidth": 0}
        axes.plot(values[:-1], values[1:], markersize=size, rasterized=len(values) > TUNING.many_points, **dots)
        axes.plot([], [], markersize=4, label=name or "point", **dots)
    inside = states[..., index][np.isfinite(states[..., index])]
    if inside.size:
        extent, size = float(np.ptp(inside)), float(np.abs(inside).max())
        # what is left of a transient beyond the digits of an axis is one point
        edge = 0.05 * (extent if extent > TUNING.one_point * size else size) or 1.0
        ends = (float(inside.min()) - edge, float(inside.max()) + edge)
        axes.plot(ends, ends, color="0.5", linewidth=0.8, zorder=1, label="diagonal")
        axes.set(xlim=ends, ylim=ends)
    text = state_label(dataset, index)
    axes.ticklabel_format(useOffset=False)
    axes.locator_params(nbins=6)
    axes.set(aspect="equal", xlabel=f"{text}, at one point", ylabel=f"{text}, at the next")
    legend_outside(figure, axes.get_legend_handles_labels()[0], ax=ax)
    at = [f"{axis_label(dataset, name)} = {shorten(float(dataset[name].values[0]))}" for name in varied]
    axes.set_title(", ".join([*at, _place(dataset)]))
    return figure


def cobweb(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the line from the diagonal up or down to the next value, across to the diagonal, and so on."""
    return np.repeat(values, 2)[:-1], np.repeat(values, 2)[1:]


def _title(dataset: Dataset, period: int, iterates: int) -> str:
    where = _place(dataset)
    if not period:
        return f"{iterates} points, {where}"
    names = ("multiplier_real", "multiplier_imag") if "multiplier_real" in dataset.variables else ()
    pairs = np.transpose([np.atleast_1d(dataset[name].values) for name in names]) if names else ()
    multipliers = ", ".join(
        shorten(real) + (f" ± {shorten(imaginary)}i" if imaginary else "")
        for real, imaginary in pairs
        if np.isfinite(real) and imaginary >= 0
    )
    return f"period {period}, {where}" + (f"; multipliers {multipliers}" if multipliers else "")


def _place(dataset: Dataset) -> str:
    place = settings(dataset).get("at") or "strobe"
    return strobe_words(dataset) if place == "strobe" else f"at {place}"

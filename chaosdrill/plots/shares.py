"""Shares and measures of the basins along a parameter; the uncertain fraction of starts near a boundary."""

from typing import Any

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from chaosdrill.dataset.outcomes import flag_names
from chaosdrill.plots._types import Artist, Axes, Dataset, Figure, Floats, Line2D, Patch
from chaosdrill.plots.categories import FURTHER, Category, attractor_category
from chaosdrill.plots.contents import swept
from chaosdrill.plots.evidence import along_sweep, with_bars
from chaosdrill.plots.figures import legend_above, legend_inside, legend_outside, new_figure, one_panel
from chaosdrill.plots.labels import axis_label, label, readable, uncertain
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.plane import bounds
from chaosdrill.plots.tuning import TUNING

_NONE = Category("no attractor", "#FFFFFF", "xx")
_ENDS = {
    "jump": ("D", "jump: hysteresis"),
    "merger": ("o", "merger"),
    "split": ("P", "split"),
    "lost": ("X", "no attractor beyond"),
}


@picture(
    "basin-measures", "measures", "shares and measures of the basins along the parameter", sweeps=True,
    needs="basin_entropy",
)  # fmt: skip
def measures(dataset: Dataset) -> Figure:
    """Draw the shares, the entropies and the uncertainty exponent of the basins over a swept parameter.

    Top: the shares of the twelve largest attractors, where they exist. Middle: the basin entropy and that of the
    boundary, which is fractal beyond the line at log 2. Bottom, if it is known somewhere: the uncertainty exponent.
    Bars are two standard errors.
    """
    (name,) = swept(dataset)
    ordered = dataset.sortby(name)
    rows = 2 + bool(np.isfinite(ordered["uncertainty_exponent"]).any())
    figure = new_figure(rows * TUNING.further_panel + 0.6)
    panels = figure.subplots(rows, 1, sharex=True)

    def draw(row: int, number: int, of: str, words: str = "", part: Dataset = ordered) -> None:
        with_bars(panels[row], part[name].values, part[of], part[f"{of}_error"], number).set_label(words)

    for k, number in enumerate(ordered["attractor"].values[: TUNING.told_attractors].tolist()):
        one = ordered.isel(attractor=k)
        draw(0, k, "fraction", _told(one, number), one.where(one["attractor_outcome"] >= 0))
    draw(1, 0, "basin_entropy", "basin entropy")
    draw(1, 1, "boundary_entropy", "of the boundary")
    panels[1].axhline(np.log(2), color="0.6", linewidth=0.8, zorder=1, label="log 2")
    panels[0].set(ylim=(-0.05, 1.05), ylabel=label(dataset["fraction"]))
    panels[1].set_ylabel("entropy")
    if rows > 2:
        draw(2, 0, "uncertainty_exponent")
        panels[2].set_ylabel(label(dataset["uncertainty_exponent"]))
    legend_above(panels[0], 3)
    legend_above(panels[1])
    along_sweep(panels[-1], dataset)
    figure.align_ylabels(panels)
    return figure


@picture("basin-measures", "shares", "shares of the basins of all attractors along the parameter", sweeps=True)
@picture("attractors", "attractors", "shares of the basins of all attractors along the parameter", parameters=1)
def shares(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the share of the starts that leads to each attractor, as bands over the parameter.

    Stacked bands, the twelve largest shares in their own colours, with two standard errors of each share at its upper
    edge if there are at most 60 values. A marker shows what becomes of an attractor that ends within the sweep; on a
    band without width the attractor exists, though no start leads to it.
    """
    (name,) = swept(dataset)
    order = np.argsort(dataset[name].values, kind="stable")
    ordered = dataset.isel({name: order})
    values, numbers = ordered[name].values.astype(float), ordered["attractor"].values
    part, error = ordered["fraction"].values, ordered["fraction_error"].values
    edges = bounds(values)
    bands = [(attractor_category(k, _told(ordered.isel(attractor=k), int(numbers[k]))), part[:, k], error[:, k])
             for k in range(min(len(numbers), TUNING.told_attractors))]  # fmt: skip
    rest = part[:, TUNING.told_attractors :].sum(axis=1)
    nothing = np.full(len(values), np.nan)
    bands += [(FURTHER, rest, nothing)] if rest.any() else []
    none = ordered["fraction_none"].values
    bands += [(_NONE, none, nothing)] if none.any() else []

    figure, axes = one_panel(ax, TUNING.shares_height)
    base, middles = np.zeros(len(values)), []
    handles: list[Artist] = []
    for category, share, spread in bands:
        top = base + share
        style: dict[str, Any] = {"facecolor": category.colour, "hatch": category.hatch, "edgecolor": "0.25"}
        low, high = (np.append(one, one[-1:]) for one in (base, top))
        axes.fill_between(edges, low, high, step="post", linewidth=0.4, **style)
        handles.append(Patch(label=category.name, **style))
        if len(values) <= TUNING.error_bars:
            seen = np.isfinite(spread)
            bars = 2 * spread[seen]
            axes.errorbar(values[seen], top[seen], yerr=bars, fmt="none", ecolor="0.2", elinewidth=0.8, capsize=1.5)
        middles.append((base + top) / 2)
        base = top
    found = _mark_ends(axes, ordered, values, middles[: min(len(numbers), TUNING.told_attractors)], bands)
    for end in found:
        marker, words = _ENDS[end]
        handles.append(
            Line2D([], [], marker=marker, color="white", markeredgecolor="black", linestyle="none", label=words)
        )
    axes.set(
        xlim=(edges[0], edges[-1]), ylim=(0, 1), xlabel=axis_label(dataset, name), ylabel=label(dataset["fraction"])
    )
    legend_outside(figure, handles, ax=ax, ncols=3)
    return figure


def _told(attractor: Dataset, number: int) -> str:
    """Description of an attractor along the parameter: its periods and kinds."""
    names = flag_names(attractor["attractor_outcome"])
    periods, codes = attractor["attractor_period"].values, attractor["attractor_outcome"].values
    there = codes >= 0
    cycles = sorted(set(periods[there & (periods > 0)].tolist()))
    kinds = dict.fromkeys(readable(names.get(code, "")) for code in codes[there & (periods == 0)].tolist())
    told = [f"period {', '.join(map(str, cycles[:3]))}{', ...' if len(cycles) > 3 else ''}"] if cycles else []
    return f"{number}: {', '.join([*told, *kinds])}"


def _mark_ends(
    axes: Axes, ordered: Dataset, values: Floats, middles: list[Floats], bands: list[tuple[Category, Floats, Floats]]
) -> list[str]:
    """Mark where attractors end within the sweep; return the kinds of ends that occur."""
    found = []
    for side, place in (("below", "first_value"), ("above", "last_value")):
        ends, names = ordered[f"end_{side}"].values, flag_names(ordered[f"end_{side}"])
        for k, middle in enumerate(middles):
            kind = names.get(int(ends[k]), "")
            if kind not in _ENDS:
                continue
            found.append(kind)
            at = int(np.argmin(np.abs(values - float(ordered[place][k]))))
            look: dict[str, Any] = {"markersize": 7, "markeredgecolor": "black", "clip_on": False, "zorder": 5}
            axes.plot(values[at], middle[at], marker=_ENDS[kind][0], color=bands[k][0].colour, **look)
    return [kind for kind in _ENDS if kind in found]


@picture(
    "basin-measures", "uncertainty", "uncertain fraction of starts over the distance", sweeps=False,
    needs="uncertain_fraction",
)  # fmt: skip
def uncertain_fraction(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the fraction of starts with another attractor within a distance, and the fitted power law.

    Both axes are logarithmic; bars are two standard errors. The slope of the line is the uncertainty exponent, which
    the legend gives; the title gives the entropies.
    """
    figure, axes = one_panel(ax, 3.6)
    distance, part, error = (
        dataset[name].values for name in ("distance", "uncertain_fraction", "uncertain_fraction_error")
    )
    seen = part > 0
    power, spread = float(dataset["uncertainty_exponent"]), float(dataset["uncertainty_exponent_error"])
    low = np.minimum(2 * error[seen], 0.9 * part[seen])
    axes.errorbar(distance[seen], part[seen], yerr=[low, 2 * error[seen]], fmt="o", color=PALETTE[0], capsize=2,
                  label="uncertain, 2 standard errors")  # fmt: skip
    if np.isfinite(power):
        middle = np.exp(np.log(part[seen]).mean() - power * np.log(distance[seen]).mean())
        text = f"exponent {uncertain(power, spread)}"
        axes.plot(distance[seen], middle * distance[seen] ** power, color=PALETTE[1], label=text)
    axes.set(xscale="log", yscale="log")
    axes.set_xticks(distance[seen], [str(one) for one in distance[seen].tolist()])
    axes.xaxis.set_minor_locator(NullLocator())
    lowest, highest = axes.get_ylim()
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 4, 6) if highest < 10 * lowest else (1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set(xlabel="distance of starts (cells)", ylabel=label(dataset["uncertain_fraction"]))
    names = {"basin_entropy": "basin entropy", "boundary_entropy": "of the boundary"}
    told = [
        f"{words} {uncertain(float(dataset[name]), float(dataset[f'{name}_error']))}"
        for name, words in names.items()
        if np.isfinite(float(dataset[name]))
    ]
    axes.set_title(", ".join(told))
    legend_inside(axes, loc="best")
    return figure


@picture("basin-measures", "basin-shares", "share of the starts that leads to each attractor", sweeps=False)
def basin_shares(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the share of the starts that leads to each of the twelve largest attractors, and to none.

    One bar per attractor, with two standard errors.
    """
    figure, axes = one_panel(ax, 3.6)
    numbers = dataset["attractor"].values[: TUNING.told_attractors].tolist()
    bars = [
        (attractor_category(k, _told(dataset.isel(attractor=[k]), number)), *_share(dataset.isel(attractor=k), ""))
        for k, number in enumerate(numbers)
    ]
    if float(dataset["fraction_none"]) > 0 or not bars:
        bars.append((_NONE, *_share(dataset, "_none")))
    for place, (category, share, error) in enumerate(bars):
        axes.barh(place, share, color=category.colour, hatch=category.hatch, edgecolor="0.25", linewidth=0.4)
        axes.errorbar(share, place, xerr=2 * error, fmt="none", ecolor="0.2", elinewidth=0.8, capsize=2)
    axes.set_yticks(range(len(bars)), [category.name for category, _, _ in bars])
    axes.invert_yaxis()
    axes.set(xlim=(0, 1), xlabel=label(dataset["fraction"]))
    return figure


def _share(attractor: Dataset, of: str) -> tuple[float, float]:
    return float(attractor[f"fraction{of}"]), float(attractor[f"fraction{of}_error"])

"""Evidence of regular motion and chaos: the 0-1 test, digits of smooth averages, exponents over finite times."""

from typing import Any

import numpy as np

from chaosdrill.errors import SettingsError
from chaosdrill.plots._types import Axes, DataArray, Dataset, Figure
from chaosdrill.plots.figures import legend_above, legend_inside, legend_outside, new_figure, one_panel, stacked
from chaosdrill.plots.labels import (
    axis_label,
    exponent_text,
    label,
    shorten,
    state_label,
    subscript,
    time_unit,
    uncertain,
)
from chaosdrill.plots.markers import failures
from chaosdrill.plots.palette import DASHES, PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.plane import bounds
from chaosdrill.plots.tuning import TUNING


@picture(
    "zero-one-test", "zero-one-test", "growth K of each state, for all turning phases and their median", sweeps=False
)
def zero_one(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the growth K of the 0-1 test.

    One column per state that moves: K for every turning phase as dots, the median with two standard errors. The lines
    at 0 and 1 mark regular motion and chaos.
    """
    figure, axes = one_panel(ax, TUNING.panel_height)
    moving = np.flatnonzero(np.isfinite(dataset["k"].values)).tolist()
    _limits_of_growth(axes)
    for column, i in enumerate(moving):
        values = dataset["k_by_turn"].values[i]
        across = column + np.linspace(-0.25, 0.25, len(values))
        names = ("each turning phase", "median, 2 standard errors") if column == 0 else (None, None)
        axes.plot(across, values, "o", color=PALETTE[0], markersize=3, alpha=0.6, markeredgewidth=0, label=names[0])
        bar, middle = 2 * float(dataset["k_error"][i]), float(dataset["k"][i])
        axes.errorbar(
            [column], [middle], yerr=[bar], fmt="D", color=PALETTE[1], markersize=5, capsize=4, label=names[1]
        )
    axes.set_xticks(range(len(moving)), [state_label(dataset, i) for i in moving])
    axes.set_xlim(-0.6, max(len(moving), 1) - 0.2)
    lowest = float(np.nanmin(dataset["k_by_turn"].values, initial=0.0))
    axes.set_ylim(min(-0.25, lowest - 0.1), 1.2)
    axes.set_ylabel(label(dataset["k"]))
    told = [f"K = {uncertain(float(dataset['k'][i]), float(dataset['k_error'][i]))}" for i in moving[:3]]
    axes.set_title("; ".join([*told, *["..."] * (len(moving) > 3)]) or ("" if failures([dataset]) else "nothing moves"))
    legend_inside(axes, loc="center right")
    return figure


@picture("zero-one-test", "growth", "growth K of each state over the swept parameter", sweeps=True)
def growth(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the growth K of the 0-1 test over a swept parameter.

    K of each state that moves somewhere, of at most a dozen, with two standard errors. The lines at 0 and 1 mark
    regular motion and chaos.
    """
    figure, axes = one_panel(ax, TUNING.panel_height)
    _of_states(axes, dataset, "k", "k_error")
    _limits_of_growth(axes, beside=True)
    lowest = float(np.nanmin(dataset["k"].values, initial=0.0))
    axes.set_ylim(min(-0.25, lowest - 0.1), 1.25)
    along_sweep(axes, dataset)
    return figure


@picture("regularity", "regularity", "digits to which smooth averages agree, and the rotation number", sweeps=False)
def digits(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the digits of smooth averages.

    One bar per state that moves; the title gives the rotation number and its error.
    """
    figure, axes = one_panel(ax, TUNING.panel_height)
    moving = np.flatnonzero(np.isfinite(dataset["digits"].values)).tolist()
    heights = dataset["digits"].values[moving]
    bars = axes.bar(range(len(moving)), heights, width=0.5, color=PALETTE[0])
    axes.bar_label(bars, [f"{height:.1f}" for height in heights], padding=2)
    axes.set_xticks(range(len(moving)), [state_label(dataset, i) for i in moving])
    axes.set(xlim=(-0.8, max(len(moving), 1) - 0.2), ylim=(0, 17), ylabel=label(dataset["digits"]))
    turns, error = float(dataset["rotation_number"]), float(dataset["rotation_number_error"])
    axes.set_title(f"rotation number {uncertain(turns, error)}" if np.isfinite(turns) else "no rotation number")
    return figure


@picture("regularity", "rotation", "digits and rotation number over the swept parameter", sweeps=True)
def rotation(dataset: Dataset) -> Figure:
    """Draw the digits of smooth averages and the rotation number over a swept parameter.

    Top: the digits of each state that moves somewhere, of at most a dozen. Bottom: the rotation number. Both have bars
    of two standard errors.
    """
    figure = new_figure(2 * TUNING.further_panel + 0.6)
    above, below = figure.subplots(2, 1, sharex=True)
    _of_states(above, dataset, "digits", "digits_error")
    above.set_ylim(0, 17)
    (name,) = dataset["period"].dims
    dataset = dataset.sortby(name)
    with_bars(below, dataset[name].values, dataset["rotation_number"], dataset["rotation_number_error"], 0)
    below.set_ylabel(label(dataset["rotation_number"]))
    along_sweep(below, dataset)
    figure.align_ylabels([above, below])
    return figure


@picture("finite-time-exponents", "finite-time-exponents", "distributions of the exponents over windows", sweeps=False)
def finite_times(dataset: Dataset) -> Figure:
    """Draw the distributions of the finite exponents, of at most a dozen, over windows of each length.

    One panel per exponent: one density per window length, as steps scaled to equal height, with the mean as a line. The
    title gives the mean and the correlation time.
    """
    means = np.atleast_1d(dataset["lyapunov_exponent"].values)
    shown = np.flatnonzero(np.isfinite(means)).tolist()[: TUNING.most_panels]
    figure, panels = stacked([TUNING.further_panel] * max(len(shown), 1), 1.1, least=0.8 + 2 * TUNING.low * len(shown))
    unit, one, many = time_unit(dataset)

    def told(time: float, error: float = 0.0) -> str:
        number = uncertain(time / unit, error / unit) if error > 0 else shorten(time / unit)
        return f"{number} {one if number == '1' else many}"

    for panel, e in zip(panels, shown, strict=False):
        for w, window in enumerate(dataset["window"].values.tolist()):
            density, centre = (dataset[name].values[w, e] for name in ("histogram", "bin_centre"))
            width = centre[1] - centre[0] if len(centre) > 1 else 1.0
            edges = np.append(centre - width / 2, centre[-1] + width / 2)
            look: dict[str, Any] = {"color": PALETTE[w % len(PALETTE)], "linestyle": DASHES[w % len(DASHES)]}
            panel.stairs(density / density.max(), edges, linewidth=1.2, label=told(window), **look)
        panel.axvline(means[e], color="0.5", linewidth=0.8, zorder=1)
        first, error = (float(dataset[name][0, e, 0]) for name in ("cumulant", "cumulant_error"))
        time, scatter = (float(dataset[name][e]) for name in ("correlation_time", "correlation_time_error"))
        rest = f"correlation time {told(time, scatter)}" if np.isfinite(time) else "constant"
        panel.set_title(f"{exponent_text(int(dataset['exponent'][e]), first, error)}, {rest}")
        panel.set_ylabel("density / highest")
        panel.set_ylim(0, 1.08)
    panels[-1].set_xlabel("exponent over the window")
    legend_outside(figure, panels[0].get_legend_handles_labels()[0], ncols=3)
    if not shown:
        panels[0].set_axis_off()
    return figure


@picture("finite-time-exponents", "spread", "exponents and their spread over the swept parameter", sweeps=True)
def spread(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the exponents over a swept parameter, and how far those over windows are from them.

    Each exponent that is a number somewhere, of at most a dozen, with two standard errors; the band has one standard
    deviation of exponents over the longest window to either side.
    """
    figure, axes = one_panel(ax, TUNING.panel_height)
    (sweep,) = map(str, dataset["outcome"].dims)
    if 2 not in dataset["order"]:
        raise SettingsError("ds lacks the variances, of order 2; select them, as in ds.sel(order=[2])")
    dataset = dataset.sortby(sweep)
    means, values = dataset["lyapunov_exponent"], dataset[sweep].values
    width = np.sqrt(dataset["cumulant"].isel(window=-1).sel(order=2).values.clip(min=0))
    for number, e in enumerate(np.flatnonzero(np.isfinite(means.values).any(axis=0)).tolist()[: TUNING.most_panels]):
        band = (means.values[:, e] - width[:, e], means.values[:, e] + width[:, e])
        axes.fill_between(values, *band, color=PALETTE[number % len(PALETTE)], alpha=0.25, linewidth=0)
        name = subscript("λ", int(dataset["exponent"][e]))
        with_bars(axes, values, means[:, e], dataset["lyapunov_error"][:, e], number).set_label(name)
    axes.axhline(0.0, color="0.6", linewidth=0.8, zorder=1)
    axes.set_ylabel(label(means))
    legend_above(axes)
    along_sweep(axes, dataset)
    return figure


def _limits_of_growth(axes: Axes, *, beside: bool = False) -> None:
    """Mark the values of K for regular motion and chaos; the words stand inside the axes, or beside them."""
    where: dict[str, Any] = {"xytext": (4, 0), "va": "center"} if beside else {"xytext": (-3, 3), "ha": "right"}
    where |= {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "color": "0.35"}
    for height, name in ((0.0, "regular"), (1.0, "chaos")):
        axes.axhline(height, color="0.6", linewidth=0.8, zorder=1)
        axes.annotate(name, (1.0, height), **where)


def _of_states(axes: Axes, dataset: Dataset, name: str, error: str) -> None:
    """Draw a variable of each state that moves over the swept parameter, with two standard errors."""
    (sweep,) = dataset["period"].dims
    dataset = dataset.sortby(sweep).transpose(sweep, "state", ...)
    moving = np.flatnonzero(np.isfinite(dataset[name].values).any(axis=0)).tolist()[: TUNING.most_panels]
    for number, i in enumerate(moving):
        with_bars(axes, dataset[sweep].values, dataset[name][:, i], dataset[error][:, i], number).set_label(
            state_label(dataset, i)
        )
    axes.set_ylabel(label(dataset[name]))
    legend_above(axes)


def with_bars(axes: Axes, x: np.ndarray, values: DataArray, errors: DataArray, number: int) -> Any:
    """Draw dots with bars of two standard errors, joined by a thin line, in the colour with this number."""
    colour = PALETTE[number % len(PALETTE)]
    return axes.errorbar(
        x, values.values, yerr=2 * errors.values, fmt="o", linestyle=DASHES[number % len(DASHES)], linewidth=0.6,
        color=colour, markersize=3, markeredgewidth=0, elinewidth=0.8,
    )  # fmt: skip


def along_sweep(axes: Axes, dataset: Dataset) -> None:
    """Label the axis of the swept parameter, and limit it to the sweep."""
    (sweep,) = map(str, dataset["outcome"].dims)
    axes.set_xlabel(axis_label(dataset, sweep))
    edges = bounds(np.sort(dataset[sweep].values))
    axes.set_xlim(edges[0], edges[-1])

"""Dimensions: the growth of correlation sums with the distance, and the scaling regions."""

import numpy as np

from chaosdrill.plots._types import Axes, Dataset, Figure
from chaosdrill.plots.evidence import along_sweep, with_bars
from chaosdrill.plots.figures import legend_above, new_figure, one_panel
from chaosdrill.plots.labels import label, shorten, uncertain
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.pictures import picture
from chaosdrill.plots.tuning import TUNING


@picture(
    "dimensions",
    "dimensions",
    "correlation sums and local slopes over the distance, with the scaling region",
    sweeps=False,
)
def scaling(dataset: Dataset) -> Figure:
    """Draw the correlation sums, their local slopes and the scaling regions.

    Above each correlation sum over the distance, both on logarithmic scales, thick over the scaling region; below its
    local slopes with two standard errors, and over the scaling region a line at the dimension in a band of two standard
    errors. If nothing was counted, as on a cycle, only a title.
    """
    if not np.isfinite(dataset["local_slope"].values).any():
        figure = new_figure(TUNING.note_height)
        figure.subplots().set_axis_off()
        period = int(dataset["period"])
        figure.suptitle(f"period {period}: dimension 0" if period else "no dimension", x=0.01, ha="left")
        return figure
    figure = new_figure(0.9 + TUNING.sums_height + TUNING.slopes_height)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[TUNING.sums_height, TUNING.slopes_height])
    scale = dataset["scale"].values
    step = scale[1] / scale[0]
    for number, order in enumerate(dataset["order"].values.tolist()):
        one, colour = dataset.isel(order=number), PALETTE[number % len(PALETTE)]
        value, error = float(one["dimension"]), float(one["dimension_error"])
        sums, slope, bars = one["correlation_sum"].values, one["local_slope"].values, one["local_slope_error"].values
        name = f"order {shorten(order)}: {uncertain(value, error) if np.isfinite(value) else 'no dimension'}"
        above.plot(scale, sums, color=colour, linewidth=0.8)
        # a slope is that between two distances
        between = scale * step ** (0.5 + TUNING.slopes_aside * number)
        below.errorbar(between, slope, yerr=2 * bars, fmt="o", color=colour, markersize=3, elinewidth=0.8, label=name)
        if np.isfinite(value):
            ends = np.array([float(one["scale_low"]), float(one["scale_high"])])
            inside = (scale >= ends[0]) & (scale <= ends[1])
            above.plot(scale[inside], sums[inside], ".-", color=colour, linewidth=2, markersize=5)
            below.plot(ends, [value, value], color=colour)
            below.fill_between(ends, value - 2 * error, value + 2 * error, color=colour, alpha=0.2, linewidth=0)
    above.set(xscale="log", yscale="log")
    told = dataset["dimension"].values
    below.set_ylim(
        0, TUNING.highest_slope * np.nanmax(told if np.isfinite(told).any() else dataset["local_slope"].values)
    )
    above.set_ylabel(label(dataset["correlation_sum"]))
    below.set(ylabel="local slope", xlabel=label(dataset["scale"]))
    legend_above(above, handles=below.get_legend_handles_labels()[0])
    return figure


@picture("dimensions", "dimension", "dimension of each order over the swept parameter", sweeps=True)
def over_parameter(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the dimensions over a swept parameter.

    The dimension of each order with two standard errors; 0 where the motion is periodic, a gap where points do not
    determine it.
    """
    figure, axes = one_panel(ax, TUNING.panel_height)
    (sweep,) = map(str, dataset["outcome"].dims)
    dataset = dataset.sortby(sweep)
    values = dataset[sweep].values
    aside = TUNING.slopes_aside * np.diff(values).min(initial=np.inf) if len(values) > 1 else 0.0
    for number, order in enumerate(dataset["order"].values.tolist()):
        one = dataset.isel(order=number)
        bars = with_bars(axes, values + number * aside, one["dimension"], one["dimension_error"], number)
        bars.set_label(f"order {shorten(order)}")
    axes.set_ylim(bottom=-0.05)
    axes.set_ylabel("dimension")
    legend_above(axes)
    along_sweep(axes, dataset)
    return figure

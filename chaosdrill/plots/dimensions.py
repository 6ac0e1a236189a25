"""Dimensions: how correlation sums grow with the distance, and over which distances they do so evenly."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plots.figures import legend_inside, new_figure
from chaosdrill.plots.labels import label, shorten, uncertain
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.pictures import picture

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_SUMS, _SLOPES = 2.0, 2.8


@picture("dimensions", "dimensions", "correlation sums and their local slopes over the distance, the scaling region")
def scaling(dataset: "xr.Dataset") -> "Figure":
    """Draw the correlation sums, their local slopes and the scaling regions.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``dimensions``.

    Returns
    -------
    matplotlib.figure.Figure
        Above each correlation sum over the distance, both on logarithmic scales; below its local slopes with two
        standard errors. In the scaling region a line shows the dimension, in a band of two standard errors. Where
        nothing was counted, as on a cycle, a title alone.
    """
    if not np.isfinite(dataset["local_slope"].values).any():
        figure = new_figure(_SUMS)
        axes = figure.subplots()
        axes.set_axis_off()
        period = int(dataset["period"])
        axes.set_title(f"period {period}: dimension 0" if period else "no dimension")
        return figure
    figure = new_figure(0.7 + _SUMS + _SLOPES)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[_SUMS, _SLOPES])
    scale = dataset["scale"].values
    for number, order in enumerate(dataset["order"].values.tolist()):
        one, colour = dataset.isel(order=number), PALETTE[number % len(PALETTE)]
        value, error = float(one["dimension"]), float(one["dimension_error"])
        slope, bars = one["local_slope"].values, 2 * one["local_slope_error"].values
        name = f"order {shorten(order)}: {uncertain(value, error) if np.isfinite(value) else 'no dimension'}"
        above.plot(scale, one["correlation_sum"].values, ".-", color=colour, markersize=4)
        # a slope is that between two distances
        between = scale * np.sqrt(scale[1] / scale[0])
        below.errorbar(between, slope, yerr=bars, fmt="o", color=colour, markersize=3, capsize=2, label=name)
        ends = np.array([float(one["scale_low"]), float(one["scale_high"])])
        if np.isfinite(ends).all():
            below.plot(ends, [value, value], color=colour)
            below.fill_between(ends, value - 2 * error, value + 2 * error, color=colour, alpha=0.25, linewidth=0)
            for axes in (above, below):
                axes.axvspan(*ends, color=colour, alpha=0.06, linewidth=0)
    above.set_xscale("log")
    above.set_yscale("log")
    below.set_ylim(0, 1.3 * float(np.nanmax(dataset["local_slope"].values)))
    above.set_ylabel(label(dataset["correlation_sum"]))
    below.set_ylabel("local slope")
    below.set_xlabel(label(dataset["scale"]))
    legend_inside(below, loc="upper left")
    return figure

"""A cascade of period doublings: how fast it closes in on its accumulation point, and its Feigenbaum ratios."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.companions import swept
from chaosdrill.plot.marks import warn
from chaosdrill.plot.style import PALETTE, axis_label, new_figure, uncertain

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FEIGENBAUM = 4.669201609102990
"""Feigenbaum, J. Stat. Phys. 19, 25 (1978), doi:10.1007/BF01020332; digits from Briggs, Math. Comp. 57, 435 (1991),
doi:10.1090/S0025-5718-1991-1079009-6.
"""


def cascade(dataset: "xr.Dataset") -> "Figure":
    """Draw the doublings of a cascade.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``continuation`` in which doubled branches were followed as far as an accumulation point is told.

    Returns
    -------
    matplotlib.figure.Figure
        Above, how far the parameter of each doubling is from the accumulation point, on a logarithmic axis, with a line
        that falls by Feigenbaum's constant a doubling and the error of the accumulation point, below which the
        distances say nothing. Below, the ratios of the distances between doublings.
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
    upper.legend(loc="upper right")

    lower.axhline(FEIGENBAUM, color="0.6", linewidth=0.9, zorder=1)
    lower.annotate(
        "4.6692",
        (1, FEIGENBAUM),
        xycoords=("axes fraction", "data"),
        xytext=(3, 0),
        textcoords="offset points",
        va="center",
        fontsize=8,
    )
    lower.plot(number, ratios, "o", color=PALETTE[1], markersize=5)
    for place, ratio in zip(number, ratios, strict=True):
        if np.isfinite(ratio):
            # away from the line
            side = {"xytext": (0, 6), "va": "bottom"} if ratio > FEIGENBAUM else {"xytext": (0, -6), "va": "top"}
            lower.annotate(
                f"{ratio:.4f}".replace("-", "−"),
                (place, ratio),
                textcoords="offset points",
                ha="center",
                fontsize=7,
                **side,
            )
    lower.set_ylabel("Feigenbaum ratio")
    lower.margins(y=0.35)
    lower.set_xticks(number, [f"{period} → {2 * period}" for period in periods])
    lower.set_xlabel("period doubling")
    lower.set_xlim(-0.5, len(values) - 0.5)
    warn(figure, [dataset])
    return figure

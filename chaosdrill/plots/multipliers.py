"""Multipliers along branches of periodic orbits, and cascades of period doublings."""

from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.plots.companions import swept
from chaosdrill.plots.marks import mark, named_once, period_categories, room, specials, unit_circle, warn
from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import PALETTE, axis_label, new_figure, sequential, subscript, uncertain, wrapped

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_CROSSINGS = ("fold", "period_doubling", "neimark_sacker")
_SMALLEST = 1e-3
"""Moduli below are not shown: they tell nothing of stability."""
FEIGENBAUM = 4.669201609102990
"""Feigenbaum, J. Stat. Phys. 19, 25 (1978), doi:10.1007/BF01020332; digits from Briggs, Math. Comp. 57, 435 (1991),
doi:10.1090/S0025-5718-1991-1079009-6.
"""


@picture(
    "continuation",
    "multipliers",
    "multipliers along the branches, in the unit circle and as moduli",
    needs="multiplier_real",
    parameters=1,
)
def multipliers(dataset: "xr.Dataset") -> "Figure":
    """Draw the multipliers of all orbits on the branches.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``continuation`` over one parameter.

    Returns
    -------
    matplotlib.figure.Figure
        Above, the complex plane with the unit circle; the colour of a point is the parameter, and the points at which
        a multiplier crosses the circle are marked. Below, the moduli over the parameter on a logarithmic axis, a colour
        a period, with the special points that no multiplier crosses the circle at along the foot.
    """
    name = swept(dataset)[0]
    values = dataset["multiplier_real"].values + 1j * dataset["multiplier_imag"].values
    figure = new_figure(6.4)
    grid = figure.add_gridspec(2, 2, height_ratios=[1.7, 1.0], width_ratios=[1.75, 1.0])
    plane, side, below = (figure.add_subplot(place) for place in (grid[0, 0], grid[0, 1], grid[1, :]))
    _plane(figure, plane, dataset, name, values)
    _moduli(below, dataset, name, np.abs(values))
    side.set_axis_off()
    side.legend(handles=named_once(below), loc="upper left", handlelength=1.8)
    warn(figure, [dataset])
    return figure


def _plane(figure: "Figure", axes: "Axes", dataset: "xr.Dataset", name: str, values: "NDArray[np.complex128]") -> None:
    outside = unit_circle(axes, values)
    shown = np.isfinite(values) & (values != 0)
    x = np.broadcast_to(dataset[name].values[:, None], values.shape)
    dots = axes.scatter(
        values.real[shown],
        values.imag[shown],
        c=x[shown],
        s=5,
        cmap=sequential(),
        linewidth=0,
        zorder=2,
        rasterized=True,
    )
    bar = figure.colorbar(dots, ax=axes, aspect=30, pad=0.02)
    bar.set_label(wrapped(axis_label(dataset, name), 36))
    bar.outline.set_linewidth(0.5)
    for kind, points in specials(dataset):
        if kind in _CROSSINGS:
            crossing = np.concatenate([_crossing(values[point], kind) for point in points])
            mark(axes, crossing.real, crossing.imag, kind, 6.5)
    if outside:
        axes.set_title(f"{outside} of {np.isfinite(values).sum()} lie outside; their moduli are below")


def _crossing(values: "NDArray[np.complex128]", kind: str) -> "NDArray[np.complex128]":
    """Of the multipliers of one orbit, those that cross the unit circle."""
    if kind == "neimark_sacker":
        pairs = values[values.imag != 0]
        return pairs[np.argsort(np.abs(np.abs(pairs) - 1), kind="stable")[:2]]
    target = 1.0 if kind == "fold" else -1.0
    return values[[int(np.argmin(np.abs(np.nan_to_num(values, nan=np.inf) - target)))]]


def _moduli(axes: "Axes", dataset: "xr.Dataset", name: str, moduli: "NDArray[np.float64]") -> None:
    from matplotlib.transforms import blended_transform_factory

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
    axes.margins(x=0.02)
    foot = blended_transform_factory(axes.transData, axes.transAxes)
    found = specials(dataset)
    for height, own in ((1.0, True), (0.05, False)):
        here = [(kind, points) for kind, points in found if (kind in _CROSSINGS) == own]
        every = x[np.concatenate([np.zeros(0, dtype=np.int64), *(points for _, points in here)])]
        sizes = np.minimum(6.5 if own else 5.0, room(axes, np.column_stack([every, np.zeros(len(every))])))
        more: dict[str, Any] = {} if own else {"transform": foot}
        for kind, points in here:
            mark(axes, [], [], kind, 6.5)
            kept, sizes = sizes[: len(points)], sizes[len(points) :]
            for size in np.unique(kept)[::-1]:
                part = points[kept == size]
                mark(axes, x[part], np.full(len(part), height), kind, float(size), **more)
    finite = positive[np.isfinite(positive)]
    axes.set_yscale("log")
    axes.set_ylim(max(_SMALLEST, 0.7 * finite.min(initial=0.5)), 1.5 * finite.max(initial=1.0))
    axes.set(xlabel=axis_label(dataset, name), ylabel="modulus")


@picture(
    "continuation",
    "cascade",
    "period doublings, their accumulation point and Feigenbaum ratios",
    needs="accumulation",
    parameters=1,
)
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

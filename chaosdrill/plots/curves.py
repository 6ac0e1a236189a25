"""Curves of special points over two parameters, on top of the chart of periods if there is one."""

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.plots.charts import kind_panels
from chaosdrill.plots.companions import settings, swept
from chaosdrill.plots.marks import bar, end_label, ends, mark, named_once, special_name, specials, warn
from chaosdrill.plots.picture import picture
from chaosdrill.plots.style import LINE_COLOURS, axis_label, by_period, legend_outside, one_panel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_DASHES = {"fold": "-", "period_doubling": (0, (5, 1.5)), "grazing": (0, (1.2, 1.2))}


@picture(
    "continuation",
    "curves",
    "curves of special points over two parameters, over the chart of periods if there is one",
    parameters=2,
    over="parameter-chart",
)
def curves(*datasets: "xr.Dataset", over: "xr.Dataset | None" = None, ax: "Axes | None" = None) -> "Figure":
    """Draw curves of special points in the plane of two parameters.

    Parameters
    ----------
    *datasets : xarray.Dataset
        Of kind ``continuation``, all over the same two parameters.
    over : xarray.Dataset, optional
        Of kind ``parameter-chart`` over these, whose periods are drawn behind, with a panel for each seed.
    ax : matplotlib.axes.Axes, optional
        Where it is drawn; with a chart of one seed.

    Returns
    -------
    matplotlib.figure.Figure
        A colour for each kind of curve and period, and dashes by the kind. Points on a curve at which something else
        happens have their shape, ends inside of the parameters' range a bar. Beside a chart nothing is drawn.
    """
    if over is not None:
        kinds, looks = by_period(over)
        drawn = kind_panels(over, kinds, looks, "period", ax)
        across, up = (str(name) for name in over["period"].dims if name != "seed")
        figure, panels = drawn.figure, [axes for axes, _ in drawn.panels]
    else:
        across, up = swept(datasets[0])
        figure, axes = one_panel(ax, 4.6)
        panels = [axes]
        panels[0].set(xlabel=axis_label(datasets[0], across), ylabel=axis_label(datasets[0], up))
        panels[0].margins(0.03)
    for axes in panels:
        limits = (axes.get_xlim(), axes.get_ylim()) if over is not None else ((-np.inf, np.inf), (-np.inf, np.inf))
        _curves(axes, [_Curve(dataset, across, up, limits) for dataset in datasets])
        if over is not None:
            axes.set(xlim=limits[0], ylim=limits[1])
    handles = named_once(panels[0])
    if over is not None:
        drawn.legend(looks, handles, ax)
    else:
        legend_outside(figure, handles, ax=ax, handlelength=2.4)
    if ax is None:
        warn(figure, datasets)
    behind = "" if over is None else ", over the chart of periods"
    figure.set_label(f"curves of special points over two parameters{behind}")
    return figure


class _Curve:
    """The points of a dataset over two parameters, and which of them are within limits: the rest is not named."""

    def __init__(self, dataset: "xr.Dataset", across: str, up: str, limits: tuple[tuple[float, float], ...]) -> None:
        self.dataset, self.kind = dataset, str(settings(dataset).get("follow") or "")
        self.x, self.y = dataset[across].values, dataset[up].values
        (left, right), (low, high) = limits
        self.inside = (self.x >= left) & (self.x <= right) & (self.y >= low) & (self.y <= high)

    def specials(self) -> "list[tuple[str, NDArray[np.int64]]]":
        """Kinds of special points on the curve with their numbers, without the one that it was followed from."""
        second = swept(self.dataset)[1]
        own = json.loads(str(self.dataset.attrs["parameters"]))[second]
        start = np.isclose(self.dataset[second].values, own, rtol=1e-12, atol=0.0)
        kept = (
            (kind, points[self.inside[points] & ~((kind == self.kind) & start[points])])
            for kind, points in specials(self.dataset)
        )
        return [(kind, points) for kind, points in kept if points.size]


def _curves(axes: "Axes", curves: "list[_Curve]") -> None:
    from matplotlib.patheffects import Normal, Stroke

    rim = [Stroke(linewidth=3.6, foreground="white"), Normal()]
    named: dict[str, str] = {}
    for curve in curves:
        branch = curve.dataset["branch"].values
        for number in np.unique(branch[curve.inside]):
            points = branch == number
            text = f"{special_name(curve.kind)}, period {int(curve.dataset['branch_period'].values[number])}"
            colour = named.setdefault(text, LINE_COLOURS[len(named) % len(LINE_COLOURS)])
            look: dict[str, Any] = {"color": colour, "linestyle": _DASHES.get(curve.kind, "-."), "linewidth": 1.6}
            axes.plot(curve.x[points], curve.y[points], path_effects=rim, zorder=3, label=text, **look)
    reasons: dict[str, None] = {}
    for curve in curves:
        for kind, points in curve.specials():
            mark(axes, curve.x[points], curve.y[points], kind, 6.5)
        for point, name in zip(*ends(curve.dataset), strict=True):
            if curve.inside[point]:
                reasons[name] = None
                bar(axes, curve.x[point], curve.y[point], 11)
    if reasons:
        bar(axes, [], [], 11, end_label(reasons))

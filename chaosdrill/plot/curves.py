"""Curves of special points over two parameters, over the chart of periods where there is one."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.chart import kind_panels
from chaosdrill.plot.companions import settings, swept
from chaosdrill.plot.looks import LINE_COLOURS, motions
from chaosdrill.plot.marks import bar, end_label, ends, mark, named_once, special_name, specials, warn
from chaosdrill.plot.style import axis_label, legend_outside, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DASHES = {"fold": "-", "period_doubling": (0, (5, 1.5)), "grazing": (0, (1.2, 1.2))}


def curves(*datasets: "xr.Dataset", over: "xr.Dataset | None" = None) -> "Figure":
    """Draw curves of special points in the plane of two parameters.

    Parameters
    ----------
    *datasets : xarray.Dataset
        Of kind ``continuation``, all over the same two parameters.
    over : xarray.Dataset, optional
        Of kind ``parameter-chart`` over these, whose periods are drawn behind, with a panel for each seed.

    Returns
    -------
    matplotlib.figure.Figure
        A colour for each kind of curve and period, and dashes by the kind. Points on a curve at which something else
        happens have their shape, ends inside of the parameters' range a bar.
    """
    if over is not None:
        kinds, looks = motions(over)
        drawn = kind_panels(over, kinds, looks, [str(name) for name in over["period"].dims])
        across, up = (str(name) for name in over["period"].dims if name != "seed")
        figure, panels = drawn.figure, [axes for axes, _ in drawn.panels]
    else:
        across, up = swept(datasets[0])
        figure = new_figure(4.6)
        panels = [figure.subplots()]
        panels[0].set(xlabel=axis_label(datasets[0], across), ylabel=axis_label(datasets[0], up))
        panels[0].margins(0.03)
    for axes in panels:
        limits = axes.get_xlim(), axes.get_ylim()
        _curves(axes, datasets, across, up)
        if over is not None:
            axes.set(xlim=limits[0], ylim=limits[1])
    handles = named_once(panels[0])
    if over is not None:
        drawn.legend(looks, handles)
    else:
        legend_outside(figure, handles, handlelength=2.4)
    warn(figure, datasets)
    return figure


def _curves(axes: "Axes", datasets: "tuple[xr.Dataset, ...]", across: str, up: str) -> None:
    from matplotlib.patheffects import Normal, Stroke

    rim = [Stroke(linewidth=3.6, foreground="white"), Normal()]
    named: dict[str, str] = {}
    reasons: dict[str, None] = {}
    for dataset in datasets:
        x, y, branch = (dataset[name].values for name in (across, up, "branch"))
        kind = str(settings(dataset).get("follow") or "")
        for number in np.unique(branch):
            period = int(dataset["branch_period"].values[number])
            text = f"{special_name(kind)}, period {period}"
            colour = named.setdefault(text, LINE_COLOURS[len(named) % len(LINE_COLOURS)])
            points = branch == number
            dashes = _DASHES.get(kind, "-.")
            axes.plot(
                x[points],
                y[points],
                color=colour,
                linestyle=dashes,
                linewidth=1.6,
                path_effects=rim,
                zorder=3,
                label=text,
            )
        for special, points in specials(dataset):
            mark(axes, x[points], y[points], special, 6.5)
        last, names = ends(dataset)
        reasons.update(dict.fromkeys(names))
        bar(axes, x[last], y[last], 11)
    if reasons:
        bar(axes, [], [], 11, end_label(reasons))

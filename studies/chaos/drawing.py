"""Pictures of the study that are not of one analysis: escape rates over two parameters, effects of one per cent."""

import numpy as np
import xarray as xr
from lives import ETA, B, decays, stays
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from percent import KNOWN_AS

from chaosdrill.plots.figures import new_figure
from chaosdrill.plots.style import style


def escape_rates(over_eta: xr.Dataset, over_b: xr.Dataset) -> Figure:
    """Escape rates where chaos is a transient, and where it lasts, over either parameter."""
    with style():
        figure = new_figure(6.4)
        above, below = figure.subplots(2, 1)
        _line(above, over_eta, "eta", "frequency ratio η", f"static load b = {B}")
        _line(below, over_b, "b", "static load b", f"frequency ratio η = {ETA}")
        above.legend(loc="lower right")
    return figure


def _line(axes: Axes, line: xr.Dataset, name: str, label: str, title: str) -> None:
    x, counted, lasting = line[name].values, decays(line), stays(line)
    chaotic = lasting & (line["largest_exponent"] > 3 * line["exponent_error"]).values
    rate, error = line["rate"].values, line["error"].values
    axes.errorbar(x[counted], rate[counted], 2 * error[counted], fmt="o", ms=3, lw=0.8, label="escape rate")
    axes.set(yscale="log", xlabel=label, ylabel="escape rate per period", title=title, xlim=(x[0], x[-1]))
    floor = np.full(x.shape, 0.02)
    mark = axes.get_xaxis_transform()
    axes.plot(x[chaotic], floor[chaotic], "s", ms=3, transform=mark, label="chaos lasts")
    axes.plot(x[lasting & ~chaotic], floor[lasting & ~chaotic], "|", ms=5, transform=mark, label="a cycle lasts")


def one_per_cent(effects: dict[str, tuple[float, float, float]]) -> Figure:
    """Bars of what one per cent of each parameter does to the rate, with the amplitude kept and with the force kept."""
    names = sorted(effects, key=lambda name: abs(effects[name][0]))
    place = np.arange(len(names))
    with style():
        figure = new_figure(4.6)
        axes = figure.subplots()
        axes.barh(place + 0.2, [effects[name][0] for name in names], 0.38, label="all else kept")
        axes.barh(place - 0.2, [effects[name][2] for name in names], 0.38, label="peak force kept, by the amplitude")
        axes.axvline(0, color="0.3", lw=0.8)
        axes.set(yticks=place, yticklabels=[KNOWN_AS.get(name, name) for name in names])
        axes.set_xlabel("change of the progression rate by one per cent more, in per cent")
        axes.legend(loc="lower right")
    return figure

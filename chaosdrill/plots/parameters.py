"""Effect of one per cent more of each parameter on a periodic orbit."""

import numpy as np

from chaosdrill.dataset.elasticities import elasticities as effects
from chaosdrill.plots._types import Axes, Dataset, Figure
from chaosdrill.plots.figures import new_figure, owner
from chaosdrill.plots.labels import symbol
from chaosdrill.plots.palette import PALETTE
from chaosdrill.plots.pictures import picture


@picture(
    "periodic-orbit",
    "elasticities",
    "effect of one per cent more of each parameter on mean rates, period and largest exponent",
    needs="period_time_derivative",
)
def elasticities(dataset: Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw the effect of each parameter on an orbit.

    On the left bars of the changes of mean rates, and without forcing of the period, in per cent; on the right the
    change of the largest exponent that is not 0 by structure. The parameter with the largest effect stands on top. Of a
    search the first orbit with derivatives is shown. On ``ax`` only the changes in per cent are drawn.
    """
    note = ""
    if "orbit" in dataset.dims:
        place = int(np.isfinite(dataset["period_time_derivative"].values).all(axis=1).argmax())
        dataset, note = dataset.isel(orbit=place), f"orbit {int(dataset['orbit'][place])} of {dataset.sizes['orbit']}"
    changes = effects(dataset)
    exponent = {"lyapunov_exponent": changes.pop("lyapunov_exponent", np.zeros(dataset.sizes["parameter"]))}
    drawn = [one for one in (changes, exponent) if any(map(np.any, one.values()))] or [exponent]
    order = np.argsort(np.max(np.abs(list(drawn[0].values())), axis=0))
    names = [symbol(str(name)) for name in dataset["parameter"].values[order]]
    if ax is not None:
        _bars(ax, names, drawn[0], order, dataset)
        return owner(ax)
    figure = new_figure(1.4 + 0.28 * len(names))
    for axes, one in zip(figure.subplots(1, len(drawn), sharey=True, squeeze=False)[0], drawn, strict=True):
        _bars(axes, names, one, order, dataset)
        axes.set_xlabel("change by one per cent more" + ("" if "lyapunov_exponent" in one else ", in per cent"))
    if note:
        figure.suptitle(note, x=0.01, ha="left", fontsize="medium")
    return figure


def _bars(axes: Axes, names: list[str], changes: dict[str, np.ndarray], order: np.ndarray, dataset: Dataset) -> None:
    height = 0.8 / len(changes)
    for number, (name, change) in enumerate(changes.items()):
        places = np.arange(len(names)) + 0.4 - height * (number + 0.5)
        words = "largest exponent" if name == "lyapunov_exponent" else str(dataset[name].attrs.get("long_name", name))
        axes.barh(places, change[order], height=height, color=PALETTE[number % len(PALETTE)], label=words)
    axes.set_yticks(range(len(names)), names)
    axes.axvline(0, color="0.3", linewidth=0.8)
    axes.legend(loc="best", fontsize="small")

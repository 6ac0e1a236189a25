"""Effect of one per cent more of each parameter on a periodic orbit."""

import numpy as np

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
    changes = {
        name: _moved(dataset, name) / float(dataset[name])
        for name in map(str, dataset.data_vars)
        if not dataset[name].ndim and f"{name}_derivative" in dataset and _tells(dataset, name)
    }
    of_exponent = _moved(dataset, "lyapunov_exponent")
    moving = np.flatnonzero(np.nan_to_num(of_exponent).any(axis=1))
    exponent = of_exponent[moving[0]] / 100 if len(moving) else np.zeros(dataset.sizes["parameter"])
    order = np.argsort(np.max([*np.abs(list(changes.values())), np.abs(exponent) * (not changes)], axis=0))
    names = [symbol(str(name)) for name in dataset["parameter"].values[order]]
    if ax is not None:
        _bars(ax, names, changes or {"lyapunov_exponent": exponent}, order, dataset)
        return owner(ax)
    figure = new_figure(1.4 + 0.28 * len(names))
    both = bool(changes) and len(moving) > 0
    panels = figure.subplots(1, 2 if both else 1, sharey=True, squeeze=False)[0]
    if changes:
        _bars(panels[0], names, changes, order, dataset)
        panels[0].set_xlabel("change by one per cent more, in per cent")
    if len(moving):
        _bars(panels[-1], names, {"lyapunov_exponent": exponent}, order, dataset)
        panels[-1].set_xlabel("change by one per cent more")
    if note:
        figure.suptitle(note, x=0.01, ha="left", fontsize="medium")
    return figure


def _tells(dataset: Dataset, name: str) -> bool:
    """Whether the change of a quantity is informative: the period of a forced orbit is that of its forcing."""
    forced = "forcing_period" in dataset.variables
    return bool(float(dataset[name])) and not (name == "period_time" and forced)


def _moved(dataset: Dataset, name: str) -> np.ndarray:
    """Derivatives times the values of the parameters, 0 where they are within their errors."""
    change, error = dataset[f"{name}_derivative"].values, dataset[f"{name}_derivative_error"].values
    return np.asarray(dataset["parameter_value"].values * np.where(np.abs(change) <= error, 0.0, change))


def _bars(axes: Axes, names: list[str], changes: dict[str, np.ndarray], order: np.ndarray, dataset: Dataset) -> None:
    height = 0.8 / len(changes)
    for number, (name, change) in enumerate(changes.items()):
        places = np.arange(len(names)) + 0.4 - height * (number + 0.5)
        words = "largest exponent" if name == "lyapunov_exponent" else str(dataset[name].attrs.get("long_name", name))
        axes.barh(places, change[order], height=height, color=PALETTE[number % len(PALETTE)], label=words)
    axes.set_yticks(range(len(names)), names)
    axes.axvline(0, color="0.3", linewidth=0.8)
    axes.legend(loc="best", fontsize="small")

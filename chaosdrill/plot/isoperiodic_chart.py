"""Isoperiodic chart: the period over two parameters, and where there is none, what there is instead."""

from typing import TYPE_CHECKING

from chaosdrill.plot.chart import kind_chart
from chaosdrill.plot.looks import motions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def isoperiodic_chart(dataset: "xr.Dataset") -> "Figure":
    """Draw the periods found over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart``.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed; large regions carry their period.
    """
    kinds, looks = motions(dataset)
    return kind_chart(dataset, kinds, looks, [str(name) for name in dataset["period"].dims])

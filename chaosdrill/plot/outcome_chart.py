"""Outcome chart: how the run of every point ended, over two parameters."""

from typing import TYPE_CHECKING

from chaosdrill.plot.chart import kind_chart
from chaosdrill.plot.looks import outcomes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def outcome_chart(dataset: "xr.Dataset") -> "Figure":
    """Draw the outcomes over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart``.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed.
    """
    kinds, looks = outcomes(dataset)
    return kind_chart(dataset, kinds, looks, [str(name) for name in dataset["outcome"].dims])

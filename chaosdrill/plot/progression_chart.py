"""Progression chart: how fast the bit drills, over two parameters."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.chart import value_chart
from chaosdrill.plot.looks import sequential
from chaosdrill.plot.style import progression

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# the few points beyond this percentile, runs about to escape above all, do not set the scale
_COVERED = 99.9


def progression_chart(dataset: "xr.Dataset") -> "Figure":
    """Draw the mean progression rate over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart`` of a system that progresses.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed; in SI units where the archive has them.
    """
    from matplotlib.colors import Normalize

    rate = progression(dataset)
    finite = rate.values[np.isfinite(rate.values)]
    top = float(np.percentile(finite, _COVERED, method="higher"))
    extend = "max" if finite.max() > top else "neither"
    return value_chart(dataset, rate, Normalize(min(0.0, finite.min()), top or 1.0), sequential(), extend=extend)

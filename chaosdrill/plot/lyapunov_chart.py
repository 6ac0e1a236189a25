"""Lyapunov chart: the largest exponent over two parameters, its sign by colour."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.plot.chart import value_chart
from chaosdrill.plot.looks import MINUS_INFINITY, POSITIVE, diverging

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

# the few points beyond this percentile on either side, near superstable cycles above all, do not set the scale
_COVERED = 99.0


def lyapunov_chart(dataset: "xr.Dataset") -> "Figure":
    """Draw the largest exponent over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of kind ``parameter-chart`` with exponents.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each seed. Zero is the palest colour, and each sign has a scale of its own; minus infinity and
        points without a number stand apart.
    """
    largest = dataset["lyapunov_exponent"].isel(exponent=0)
    largest.attrs["long_name"] = f"largest {largest.attrs['long_name']}"
    norm, extend = _scale(largest.values)
    return value_chart(
        dataset, largest, norm, diverging(), [(-np.inf, MINUS_INFINITY)], extend, (largest.values > 0, POSITIVE)
    )


def _scale(values: np.ndarray) -> "tuple[Normalize, str]":
    """Norm with zero in the middle, and at which ends values lie beyond it."""
    from matplotlib.colors import TwoSlopeNorm

    finite = values[np.isfinite(values)]
    below, above = (part[part > 0] for part in (-finite, finite))
    low = float(np.percentile(below, _COVERED)) if below.size else 0.0
    high = float(np.percentile(above, _COVERED)) if above.size else 0.0
    # a sign that does not occur has the scale of the other
    low, high = low or high or 1.0, high or low or 1.0
    ends = (bool((below > low).any()), bool((above > high).any()))
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[ends]
    return TwoSlopeNorm(0.0, -low, high), extend

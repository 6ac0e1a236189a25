"""Whether small deviations from an orbit die out, told from its multipliers."""

import numpy as np


def free_multipliers(values: np.ndarray, *, forced: bool) -> np.ndarray:
    """The multipliers without the one of the flow direction, which is 1 on every orbit of a system without a period.

    Parameters
    ----------
    values : ndarray of complex, shape (..., n)
        Eigenvalues of the tangent map over one period.
    forced : bool
        Whether the system has a period; if not, the multiplier nearest to 1 is left out.

    Returns
    -------
    ndarray of complex, shape (..., n) or (..., n - 1)
    """
    if forced:
        return values
    flow = np.abs(values - 1).argmin(axis=-1)[..., np.newaxis]
    kept = np.arange(values.shape[-1]) != flow
    return values[kept].reshape(*values.shape[:-1], values.shape[-1] - 1)


def is_stable(values: np.ndarray, *, forced: bool) -> np.ndarray:
    """Whether all free multipliers lie inside of the unit circle, shape (...); parameters as for `free_multipliers`."""
    return (np.abs(free_multipliers(values, forced=forced)) < 1).all(axis=-1)

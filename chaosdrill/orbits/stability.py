"""Whether small deviations from an orbit die out, told from its multipliers."""

import numpy as np


def is_stable(multipliers: np.ndarray, *, autonomous: bool) -> np.ndarray:
    """Whether all multipliers lie inside of the unit circle, the one along the flow of an autonomous system apart.

    Parameters
    ----------
    multipliers : ndarray of complex, shape (..., n)
        Eigenvalues of the tangent map over one period.
    autonomous : bool
        Whether time does not enter the equations; then one multiplier is 1, the one nearest to it, and says nothing.

    Returns
    -------
    ndarray of bool, shape (...)
        False where a multiplier is NaN.
    """
    moduli = np.abs(multipliers)
    if autonomous and moduli.size:
        along = np.argmin(np.abs(multipliers - 1), axis=-1, keepdims=True)
        np.put_along_axis(moduli, along, np.minimum(np.take_along_axis(moduli, along, -1), 0.0), -1)
    return (moduli < 1).all(axis=-1)

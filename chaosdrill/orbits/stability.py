"""Whether small deviations from an orbit die out, told from its multipliers."""

import numpy as np


def free_multipliers(values: np.ndarray, neutral: int) -> np.ndarray:
    """The multipliers without those that are 1 on every orbit, as that of the flow direction without a period.

    Parameters
    ----------
    values : ndarray of complex, shape (..., n)
        Eigenvalues of the tangent map over one period.
    neutral : int
        How many are 1 by the structure of the system (`chaosdrill.orbits.neutral`): those nearest to 1 are left out.

    Returns
    -------
    ndarray of complex, shape (..., n - neutral)
    """
    if not neutral:
        return values
    left_out = np.argsort(np.abs(values - 1), axis=-1, kind="stable")[..., :neutral]
    kept = np.ones(values.shape, dtype=bool)
    np.put_along_axis(kept, left_out, False, axis=-1)
    return values[kept].reshape(*values.shape[:-1], values.shape[-1] - neutral)


def is_stable(values: np.ndarray, neutral: int) -> np.ndarray:
    """Whether all free multipliers lie inside of the unit circle, shape (...); parameters as for `free_multipliers`."""
    return (np.abs(free_multipliers(values, neutral)) < 1).all(axis=-1)

"""Whether points fill a smooth curve or a cloud, where the exponents are zero within their errors.

On a torus averages that fade in and out smoothly converge faster than any power of their length, in chaos like one over
its root: the averages over two halves of a record agree to many digits or to hardly any (Das, Saiki, Sander and Yorke
2017, doi:10.1088/1361-6544/aa84c2).
"""

import numpy as np

LENGTH = 2048
"""Section points by which that is told."""

SMOOTH = 1e-3
"""Difference of the two averages, in parts of the extent, below which the motion is regular."""


def is_regular(windows: np.ndarray) -> np.ndarray:
    """Whether the averages over both halves of sequences agree.

    Parameters
    ----------
    windows : ndarray, shape (P, W, n)
        Section points.

    Returns
    -------
    ndarray of bool, shape (P,)
    """
    half = windows.shape[1] // 2
    t = np.arange(1, half) / half
    weight = np.exp(-1 / (t * (1 - t)))
    weight /= weight.sum()
    early, late = (np.einsum("w,pwi->pi", weight, windows[:, k + 1 : k + half]) for k in (0, half))
    extent = np.ptp(windows, axis=1).max(axis=1)
    return (np.abs(late - early).max(axis=1) <= SMOOTH * extent) & np.isfinite(extent)

"""Means with honest error bars, dimensions, and what exponents say about an attractor."""

import numpy as np

from chaosdrill.dataset import Outcome

_FEWEST_BLOCKS = 16


def standard_error(rates: np.ndarray) -> np.ndarray:
    """Standard error of the mean of correlated blocks.

    Blocks are merged two by two, and the largest error over all lengths that leave 16 blocks is taken: with correlated
    blocks the naive error is too small (Flyvbjerg and Petersen 1989, doi:10.1063/1.457480).

    Parameters
    ----------
    rates : ndarray, shape (blocks, ...)
        Means over blocks of equal length, in order.

    Returns
    -------
    ndarray, shape (...)
        NaN with fewer than two blocks.
    """
    rates = np.asarray(rates, dtype=float)
    best = np.full(rates.shape[1:], np.nan)
    first = True
    while len(rates) >= 2 and (first or len(rates) >= _FEWEST_BLOCKS):
        best = np.fmax(best, rates.std(axis=0, ddof=1) / np.sqrt(len(rates)))
        half = len(rates) // 2
        rates = 0.5 * (rates[: 2 * half : 2] + rates[1 : 2 * half : 2])
        first = False
    return best


def kaplan_yorke(exponents: np.ndarray, states: int) -> float:
    """Kaplan-Yorke dimension of a descending spectrum (Kaplan and Yorke 1979, doi:10.1007/BFb0064319).

    An exponent -inf adds no dimension. If no partial sum is negative it is the number of states, or NaN if not all
    exponents are given.
    """
    total = 0.0
    for index, value in enumerate(exponents):
        if np.isnan(value):
            return float("nan")
        if total + value < 0:
            return float(index) if np.isinf(value) else index + total / -value
        total += value
    return float(states) if len(exponents) == states else float("nan")


def free_exponents(exponents: np.ndarray, neutral: int) -> np.ndarray:
    """Exponents that are free to have any sign, the largest first, -inf in the place of the others; shape (P, m).

    ``neutral`` of them are zero whatever the attractor: the flow direction of an autonomous system, its shifts.
    """
    size = np.where(np.isfinite(exponents), np.abs(exponents), np.inf)
    free = np.isfinite(exponents)
    rows = np.arange(len(exponents))[:, np.newaxis]
    free[rows, np.argsort(size, axis=1, kind="stable")[:, : min(neutral, exponents.shape[1])]] = False
    return -np.sort(-np.where(free, exponents, -np.inf), axis=1)


def leading(
    exponents: np.ndarray, errors: np.ndarray, neutral: int, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The largest exponent that is free to have any sign, and how far from zero it is told from zero.

    Parameters
    ----------
    exponents, errors : ndarray, shape (P, m)
        Descending spectra and their standard errors.
    neutral : int
        As in `free_exponents`.
    length : ndarray, shape (P,)
        Time over which they were averaged; an exponent within 4 / length of zero is not told from it.

    Returns
    -------
    value, margin : ndarray, shape (P,)
        The value is -inf where no finite exponent is left, NaN where there are none at all.
    """
    points, m = exponents.shape
    if not m:
        return np.full(points, np.nan), 4 / length
    value = free_exponents(exponents, neutral)[:, 0]
    bars = np.nan_to_num(errors)[np.arange(points), (exponents == value[:, np.newaxis]).argmax(axis=1)]
    return np.where(np.isnan(exponents).all(axis=1), np.nan, value), np.maximum(3 * bars, 4 / length)


def classify(exponents: np.ndarray, errors: np.ndarray, neutral: int, length: float, period: int) -> Outcome:
    """What the exponents, shape (m,), and a period found by recurrence (0: none) say together; as `leading`."""
    found, margins = leading(exponents[np.newaxis], errors[np.newaxis], neutral, np.array([length]))
    value, margin = float(found[0]), float(margins[0])
    if period and value < margin:
        return Outcome.PERIODIC
    if value > margin:
        return Outcome.CHAOTIC
    return Outcome.PERIODIC if value < -margin else Outcome.QUASIPERIODIC

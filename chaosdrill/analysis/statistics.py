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


def leading(
    exponents: np.ndarray, errors: np.ndarray, neutral: int, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The largest exponent that is free to have any sign, and how far from zero it is told from zero.

    Parameters
    ----------
    exponents, errors : ndarray, shape (P, m)
        Spectra and their standard errors.
    neutral : int
        Exponents that are zero whatever the attractor: the flow direction of an autonomous system, its shifts.
    length : ndarray, shape (P,)
        Time over which they were averaged; an exponent within 4 / length of zero is not told from it.

    Returns
    -------
    value, margin : ndarray, shape (P,)
        The value is -inf where no finite exponent is left, NaN where there are none at all.
    """
    points, m = exponents.shape
    finite = np.isfinite(exponents)
    size = np.where(finite, np.abs(exponents), np.inf)
    free = finite.copy()
    rows = np.arange(points)[:, np.newaxis]
    free[rows, np.argsort(size, axis=1, kind="stable")[:, : min(neutral, m)]] = False
    values = np.where(free, exponents, -np.inf)
    value = values.max(axis=1, initial=-np.inf)
    bars = np.nan_to_num(errors)[np.arange(points), values.argmax(axis=1)] if m else np.zeros(points)
    value = np.where(np.isnan(exponents).all(axis=1), np.nan, value) if m else np.full(points, np.nan)
    return value, np.maximum(3 * bars, 4 / length)


def classify(exponents: np.ndarray, errors: np.ndarray, neutral: int, length: float, period: int) -> Outcome:
    """What the exponents, shape (m,), and a period found by recurrence (0: none) say together; as `leading`."""
    found, margins = leading(exponents[np.newaxis], errors[np.newaxis], neutral, np.array([length]))
    value, margin = float(found[0]), float(margins[0])
    if period and value < margin:
        return Outcome.PERIODIC
    if value > margin:
        return Outcome.CHAOTIC
    return Outcome.PERIODIC if value < -margin else Outcome.QUASIPERIODIC

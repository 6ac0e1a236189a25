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


def classify(exponents: np.ndarray, errors: np.ndarray, neutral: int, length: float, period: int) -> Outcome:
    """What exponents and recurrence say together.

    Parameters
    ----------
    exponents, errors : ndarray, shape (m,)
        Descending spectrum and its standard errors.
    neutral : int
        Exponents that are zero whatever the attractor: the flow direction of an autonomous system, its shifts.
    length : float
        Time over which they were averaged; an exponent within 4 / length of zero is not told from it.
    period : int
        Period found by recurrence, 0 if none.
    """
    finite = np.isfinite(exponents)
    values, bars = exponents[finite], np.nan_to_num(errors[finite])
    order = np.argsort(np.abs(values), kind="stable")[: min(neutral, len(values))]
    values, bars = np.delete(values, order), np.delete(bars, order)
    if len(values) == 0:
        return Outcome.PERIODIC
    leading = int(np.argmax(values))
    margin = max(3 * bars[leading], 4 / length)
    if period and values[leading] < margin:
        return Outcome.PERIODIC
    if values[leading] > margin:
        return Outcome.CHAOTIC
    return Outcome.PERIODIC if values[leading] < -margin else Outcome.QUASIPERIODIC


def find_period(points: np.ndarray, most: int) -> int:
    """Smallest period of a sequence of section points, 0 if there is none up to ``most``.

    The last half of the sequence must repeat for at least two periods, every state within 1e-6 of its own size.

    Parameters
    ----------
    points : ndarray, shape (iterates, n)
    most : int
        Longest period looked for.
    """
    points = points[len(points) // 2 :]
    if len(points) < 2 or not np.isfinite(points).all():
        return 0
    size = np.abs(points).max(axis=0)
    close = 1e-6 * size + 1e-12 * size.max()
    for period in range(1, min(most, len(points) // 2) + 1):
        if (np.abs(points[period:] - points[:-period]) <= close).all():
            return period
    return 0

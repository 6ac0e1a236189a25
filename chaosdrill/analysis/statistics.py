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


def free_exponents(
    exponents: np.ndarray, neutral: np.ndarray | int, margins: np.ndarray, *, complete: bool
) -> np.ndarray:
    """Exponents that are free to have any sign, the largest first, -inf in the place of the others.

    Of those that are zero whatever the attractor only such are left out as were computed. All were if all exponents
    were, or if some are negative, for then whatever is zero lies above them. Else an exponent is left out only if it is
    not told from zero.

    Parameters
    ----------
    exponents : ndarray, shape (P, m)
        Descending spectra.
    neutral : ndarray of int, shape (P,), or int
        How many are zero whatever the attractor, see `chaosdrill.engine.structure.Structure.neutral`.
    margins : ndarray, shape (P, m)
        How far from zero each is told from zero.
    complete : bool
        Whether there are as many as states.

    Returns
    -------
    ndarray, shape (P, m)
    """
    free = np.isfinite(exponents)
    size = np.where(free, np.abs(exponents), np.inf)
    nearest = np.argsort(np.argsort(size, axis=1, kind="stable"), axis=1, kind="stable")
    among = nearest < np.reshape(neutral, (-1, 1))
    computed = complete | (exponents < -margins).any(axis=1, keepdims=True)
    free &= ~(among & (computed | (size <= margins)))
    return -np.sort(-np.where(free, exponents, -np.inf), axis=1)


def margin(errors: np.ndarray, length: np.ndarray | float) -> np.ndarray:
    """How far from zero an exponent is told from zero: three standard errors, and 4 / length at least."""
    return np.asarray(np.maximum(3 * np.nan_to_num(errors), 4 / np.asarray(length)))


def leading(
    exponents: np.ndarray, errors: np.ndarray, neutral: np.ndarray | int, length: np.ndarray, *, complete: bool
) -> tuple[np.ndarray, np.ndarray]:
    """The largest exponent that is free to have any sign, and how far from zero it is told from zero.

    Parameters
    ----------
    exponents, errors : ndarray, shape (P, m)
        Descending spectra and their standard errors.
    neutral, complete
        As in `free_exponents`.
    length : ndarray, shape (P,)
        Time over which they were averaged; an exponent within 4 / length of zero is not told from it.

    Returns
    -------
    value, margin : ndarray, shape (P,)
        The value is -inf where no finite exponent is left, NaN where an exponent is no number or there are none.
    """
    points, m = exponents.shape
    if not m:
        return np.full(points, np.nan), margin(np.zeros(points), length)
    margins = margin(errors, length[:, np.newaxis])
    value = free_exponents(exponents, neutral, margins, complete=complete)[:, 0]
    of_value = margins[np.arange(points), (exponents == value[:, np.newaxis]).argmax(axis=1)]
    sound = np.isfinite(exponents) | np.isneginf(exponents)
    return np.where(sound.all(axis=1), value, np.nan), of_value


def classify(
    exponents: np.ndarray, errors: np.ndarray, neutral: int, length: float, *, complete: bool = True
) -> Outcome:
    """What the exponents, shape (m,), say by themselves; arguments as in `leading`."""
    found, margins = leading(exponents[np.newaxis], errors[np.newaxis], neutral, np.array([length]), complete=complete)
    value, told = float(found[0]), float(margins[0])
    if np.isnan(value):
        return Outcome.NONFINITE
    if value > told:
        return Outcome.CHAOTIC
    return Outcome.PERIODIC if value < -told else Outcome.UNDECIDED

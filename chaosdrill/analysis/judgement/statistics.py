"""Means with honest error bars, dimensions, and whether exponents differ from zero."""

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.engine.tuning import RUNS

if TYPE_CHECKING:
    from chaosdrill.engine.numerics import Numerics

PAIR = 1e-6
"""Part by which two exponents of opposite signs differ at most to count as a pair."""

SURE = 3.0
"""Standard errors beyond which an exponent differs from zero."""

_FREQUENCIES = (4, 8)
"""Fewest and most frequencies from which the error of a mean is taken. Fewer make the error itself uncertain; more make
it hardly more certain, and see less of slow motion."""

_FEWEST_BLOCKS = 16
"""Blocks whose correlation is looked at, at least, and down to which they are merged; that of fewer is chance."""

_LONGEST = 0.5
"""Longest correlation time that a record is believed to show, in parts of its length."""

ONE_BLOCK = "one block has no scatter: take a longer record, or more blocks"
BEYOND = "the dimension may take more exponents than were computed: ask for more"
"""Why errors are not known."""

_NORMAL = 1.959964
_STUDENT = (12.706205, 4.302653, 3.182446, 2.776445, 2.570582, 2.446912, 2.364624, 2.306004)
"""Quantiles at 97.5 % of the normal distribution, and of Student's t with 1 to 8 degrees of freedom."""


STAYS, SINKS = 4.0, 50.0
"""Logarithms by which all tangents shrink in a record at most where the motion surely goes on, and at least where it
comes to rest: a tangent that starts across the flow shrinks to round-off, by exp(-37), before it turns into it."""


def standard_error(rates: np.ndarray) -> np.ndarray:
    """Standard error of the mean of correlated blocks: the mean plus and minus twice it covers the truth in 95 %.

    The variance of a mean over n blocks is S(0)/n, where S is their spectral density. That is averaged over the lowest
    frequencies, 0.4 n^(2/3) but 4 to 8 of them, as the squares of cosine coefficients (Lazarus et al. 2018,
    doi:10.1080/07350015.2018.1506926). These are nearly independent, so that the mean over its error follows Student's
    t; the error is enlarged by t over the normal quantile, 1.18 for 8 of them and 1.42 for 4, so that it may be used as
    that of a normal distribution.

    Where correlation lasts so long that S falls within these frequencies, their average is divided by the fall that an
    autoregression of first order would have (after Andrews and Monahan 1992, doi:10.2307/2951574). Its coefficient is
    the correlation of neighbours, corrected for its bias in short records (Marriott and Pope 1954,
    doi:10.1093/biomet/41.3-4.390), at each length of block that comes from merging by two, so that weak but slow motion
    is seen, too; the largest fall counts. In a record that is too short for its correlation the error thus grows, by up
    to 4 times.

    Measured: 95 % intervals hold the truth in 92 to 97 % if the record is six correlation times or longer, in 32 blocks
    as in 256; at three it is 90 %. See "Exponents" in docs/theory.md for chaotic and intermittent motion.

    ``rates``, shape (blocks, ...): means over blocks of equal length, in order.

    Returns, shape (...): NaN with fewer than two blocks, or where a block is NaN. With fewer than six it is that of
    independent blocks.
    """
    rates = np.asarray(rates, dtype=float)
    n = len(rates)
    if n < 2:
        return np.full(rates.shape[1:], np.nan)
    apart = rates - _total(rates) / n
    column = (-1, *(1,) * (rates.ndim - 1))
    orders = np.arange(1, min(n - 1, int(np.clip(0.4 * n ** (2 / 3), *_FREQUENCIES))) + 1)
    places = (np.arange(n) + 0.5).reshape(column)
    power = sum(_total(np.cos(np.pi * k / n * places) * apart) ** 2 for k in orders) * 2 / n / len(orders)
    student = _STUDENT[len(orders) - 1] / _NORMAL
    return np.asarray(student * np.sqrt(power / _least_fall(apart, orders.reshape(column)) / n))


def block_ends(length: int, blocks: int) -> np.ndarray:
    """Ends of at most ``blocks`` blocks of a record, from its beginning, in units of its length."""
    count = min(blocks, length)
    return np.arange(count + 1) * length // max(count, 1)


def in_blocks(values: np.ndarray, blocks: int) -> np.ndarray:
    """Means over at most ``blocks`` blocks of equal length, in order, shape (blocks, ...); a remainder is left out."""
    size = -(-len(values) // blocks)
    kept = len(values) // size * size
    return np.asarray(values[:kept].reshape(-1, size, *values.shape[1:]).mean(axis=1))


@lru_cache(maxsize=16)
def fading(length: int) -> np.ndarray:
    """Weights of an average that fades in and out smoothly, shape (length - 1,), not to be changed; their sum is 1."""
    t = np.arange(1, length) / length
    weight = np.exp(-1 / (t * (1 - t)))
    weight /= weight.sum()
    weight.flags.writeable = False
    return weight


def whole_cycles(ends: np.ndarray, cycle: int) -> np.ndarray:
    """Which ends of blocks are whole cycles before the last one; all where that leaves fewer than two blocks.

    ``ends`` and the length of a ``cycle`` are in the same units; 0: there is none.
    """
    whole = np.flatnonzero((ends[-1] - ends) % max(cycle, 1) == 0)
    return whole if len(whole) > 2 else np.arange(len(ends))


def error_of_exponents(
    rates: np.ndarray, numerics: "Numerics", steps: Any, length: Any, apart: np.ndarray | float = 0.0
) -> np.ndarray:
    """Error of exponents: that of the mean over blocks, and that of the method.

    On a cycle blocks of whole periods are alike, and what is left is the method's: each step may change the logarithm
    of a tangent's length by what the tolerance lets it, or by that part of what it grows or decays by more than e.

    ``rates``, shape (blocks, ..., m): as in `standard_error`, of lengths that no unit changes. ``steps``, ``length``,
    shape (...), or numbers: steps of the runs over all blocks, and the time that these take. ``apart``, shape (..., m),
    or a number: how far exponents are from those of these lengths, which is their error at least, since any lengths
    have the same exponents in the long run.

    Returns: shape (..., m).
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        pace = np.where(np.asarray(length) > 0.0, steps / length, np.nan)[..., np.newaxis]
        of_method = numerics.step_error * np.maximum(pace, np.abs(np.mean(rates, axis=0)))
        return np.maximum(np.hypot(standard_error(rates), of_method), apart)


def rounding_of_point(numerics: "Numerics", discrete: bool, steps: Any, units: Any, points: Any) -> Any:
    """Part of the sizes of states that the errors of a run, or of a map, may add up to from one of its points to the
    next, of so many in ``units`` with ``steps``.

    Those of steps are independent, but for those of fixed steps: a unit of a slow forcing takes hundreds.
    """
    if discrete:
        of_unit = np.full_like(steps, RUNS.rounding, dtype=float)
    elif numerics.traits.fixed_step:
        of_unit = np.full_like(steps, numerics.global_error, dtype=float)
    else:
        of_unit = numerics.step_error * np.sqrt(np.maximum(np.divide(steps, units), 1.0))
    return of_unit * units / np.maximum(points, 1)


def error_of_mean_rate(totals: np.ndarray, times: np.ndarray, numerics: "Numerics", pace: np.ndarray) -> np.ndarray:
    """Error of the mean rate of what has come to some totals by the ends of blocks: of the mean, and of the method.

    Blocks that last longer count more: what a block has beyond its time's share of the whole is an error of the mean.
    The method's is the part of the totals' way that its steps may be wrong by.

    ``totals``, shape (blocks + 1, ...): totals at the beginning of the first block and at the end of each. ``times``,
    shape (blocks + 1, ...): times there, of a shape that goes with that of the totals. ``pace``, shape (...): how far
    the totals move, up or down, per unit of time.

    Returns, shape (...): NaN with fewer than two blocks.
    """
    spans = np.diff(times, axis=0)
    if len(spans) < 2:
        return np.full(totals.shape[1:], np.nan)
    length = times[-1] - times[0]
    mean = (totals[-1] - totals[0]) / length
    of_mean = standard_error((np.diff(totals, axis=0) - mean * spans) / (length / len(spans)))
    return np.asarray(np.hypot(of_mean, numerics.global_error * pace))


def _least_fall(apart: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """Mean of the spectral density over some frequencies, in parts of that at zero, by first-order autoregressions.

    ``apart``, shape (n, ...): blocks less their mean. ``orders``, shape (K, ...): frequencies, in half-waves a record.
    """
    sums = np.concatenate([np.zeros_like(apart[:1]), np.cumsum(apart, axis=0)])
    least = np.ones(apart.shape[1:])
    size = 1
    while len(apart) // size >= _FEWEST_BLOCKS:
        count = len(apart) / size
        # all runs of this many blocks, overlapping, so that no block is left out and the order may be reversed
        merged = sums[size:] - sums[:-size]
        products = _total(merged[size:] * merged[:-size]) / (len(merged) - size)
        with np.errstate(invalid="ignore", divide="ignore"):
            neighbours = products / (_total(merged**2) / len(merged))
        neighbours = np.clip((count * neighbours + 1) / (count - 3), 0, np.exp(-1 / (_LONGEST * count)))
        flat = (1 - neighbours) ** 2
        fall = flat / (flat + 2 * neighbours * (1 - np.cos(np.pi * orders / count)))
        # blocks that are all the same have no correlation
        least = np.fmin(least, _total(fall) / len(orders))
        size *= 2
    return least


def _total(values: np.ndarray) -> np.ndarray:
    """Sum over the first axis in order, so that no bit depends on how many columns are summed at once."""
    return np.cumsum(values, axis=0)[-1]


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


def kaplan_yorke_error(
    exponents: np.ndarray, rates: np.ndarray, of_method: float, length: float, states: int
) -> tuple[float, str]:
    """Standard error of the Kaplan-Yorke dimension of a descending spectrum, from the blocks of one record.

    Exponents of one record are correlated: in a flow of constant divergence their sum has no error at all. So each
    block's rates are put into the dimension's linear form, k + (L1 + ... + Lk) / |Lk+1|, and the error is that of the
    mean of the results, by `standard_error`. Where a sum of exponents that decides k may be zero, the
    dimension has a kink there, and the larger error of the two sides is taken. At an exponent -inf the dimension is the
    whole number k on one side and the error of that side is 0.

    Measured over 400 records of 256 blocks: see tests/analysis/test_kaplan_yorke_error.py.

    ``exponents``, shape (m,): descending; -inf for those that are lost. ``rates``, shape (blocks, m): exponents over
    blocks of equal length, in the same order; what stands in the columns of lost ones is not read. ``of_method``: error
    of one exponent that the tolerance lets steps make. ``length``: time over which the exponents were averaged.

    Returns: 0 where the first exponent is surely negative. NaN where the first exponent may be zero, as there
    the dimension jumps between 0 and 1 or more, where the dimension itself is NaN, and with fewer than two blocks; and
    why it is NaN, or else empty text.
    """
    if np.isnan(kaplan_yorke(exponents, states)):
        return float("nan"), BEYOND
    if np.isinf(exponents[0]):
        return 0.0, ""
    if len(rates) < 2:
        return float("nan"), ONE_BLOCK

    def error(weights: np.ndarray) -> float:
        used = rates[:, : len(weights)]
        # a product of matrices is summed in the order of a processor
        each = np.einsum("bk,k->b", used, weights)
        return float(np.hypot(standard_error(each), of_method * np.abs(weights).sum()))

    def told(total: float, count: int) -> bool:
        return bool(abs(total) > margin(np.array(error(np.ones(count))), length))

    if not told(exponents[0], 1):
        return float("nan"), "the first exponent may be zero, where the dimension jumps"
    if exponents[0] < 0:
        return 0.0, ""
    finite = int(np.isfinite(exponents).sum())
    sums = np.cumsum(exponents[:finite])
    errors = []
    for k in range(1, finite + 1):
        # the form with k whole dimensions holds from a sum of k that is not negative to one of k + 1 that is
        sinks = k == finite or sums[k] < 0 or not told(sums[k], k + 1)
        stays = sums[k - 1] >= 0 or not told(sums[k - 1], k)
        if not (sinks and stays):
            continue
        if k == finite:
            # the next one is -inf, or there is none, or it was not computed
            errors.append(0.0 if finite < len(exponents) or finite == states else np.nan)
        else:
            size = -exponents[k]
            errors.append(error(np.append(np.full(k, 1 / size), sums[k - 1] / size**2)) if size > 0 else np.nan)
    found = float(np.max(errors))
    if not np.isnan(found):
        return found, ""
    return found, BEYOND if finite == len(exponents) < states else "a sum of exponents may have either sign"


def free_exponents(
    exponents: np.ndarray, neutral: np.ndarray | int, margins: np.ndarray, *, complete: bool
) -> np.ndarray:
    """Exponents that are free to have any sign, the largest first, -inf in the place of the others.

    Of those that are zero whatever the attractor only such are left out as were computed. All were if all exponents
    were, or if some are negative, for then whatever is zero lies above them. Else an exponent is left out only if it
    may be zero.

    ``exponents``, shape (P, m): descending spectra. ``neutral``, int, shape (P,), or int: how many are zero whatever
    the attractor, see `chaosdrill.engine.structure.Structure.neutral`. ``margins``, shape (P, m): distance from zero
    beyond which each differs from zero. ``complete``: whether there are as many as states.

    Returns: shape (P, m).
    """
    free = np.isfinite(exponents)
    # shear makes a pair of opposite signs, of which neither is a rate: the negative one would attract
    size = np.where(free, np.abs(exponents) * np.where(exponents > 0, 1 + PAIR, 1.0), np.inf)
    nearest = np.argsort(np.argsort(size, axis=1, kind="stable"), axis=1, kind="stable")
    among = nearest < np.reshape(neutral, (-1, 1))
    computed = complete | (exponents < -margins).any(axis=1, keepdims=True)
    free &= ~(among & (computed | (size <= margins)))
    return -np.sort(-np.where(free, exponents, -np.inf), axis=1)


def margin(errors: np.ndarray, length: np.ndarray | float) -> np.ndarray:
    """Distance beyond which an exponent differs from zero: `SURE` standard errors, and 4 / length at least."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.maximum(SURE * np.nan_to_num(errors, posinf=np.inf), 4 / np.asarray(length)))


def leading(
    exponents: np.ndarray, errors: np.ndarray, neutral: np.ndarray | int, length: np.ndarray, *, complete: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The largest exponent that is free to have any sign, and the distance beyond which it differs from zero.

    ``exponents``, ``errors``, shape (P, m): descending spectra and their standard errors. ``neutral``, ``complete``: as
    in `free_exponents`. ``length``, shape (P,): time over which they were averaged; an exponent within 4 / length of
    zero cannot be distinguished from it.

    Returns: ``value``, ``margin``, shape (P,): the value is -inf where no finite exponent is left, NaN where an
    exponent is not a number or there are none. ``column``, int, shape (P,): which of the exponents it is.
    """
    points, m = exponents.shape
    if not m:
        return np.full(points, np.nan), margin(np.zeros(points), length), np.zeros(points, dtype=np.int64)
    margins = margin(errors, length[:, np.newaxis])
    value = free_exponents(exponents, neutral, margins, complete=complete)[:, 0]
    column = (exponents == value[:, np.newaxis]).argmax(axis=1)
    sound = np.isfinite(exponents) | np.isneginf(exponents)
    return np.where(sound.all(axis=1), value, np.nan), margins[np.arange(points), column], column

"""Frequencies of regular motion from equally spaced samples, and whether they have a common measure.

A sequence that fades in and out smoothly has lines so narrow that their places are known to many digits (Laskar,
Froeschle and Celletti 1992, doi:10.1016/0167-2789(92)90028-L; the window is that of smooth averages). Sampling adds
whole numbers to frequencies in cycles a sample. On a cycle all are multiples of one, so that integers p and q make
p f + q g whole for any two of them; on a torus two have no such integers.
"""

from collections.abc import Callable, Iterator

import numpy as np

from chaosdrill.analysis.judgement.statistics import fading

ORDER = 1000
"""Integers up to which a common measure is looked for: a cycle of as many turns of either kind is found. There are so
many relations that the best of incommensurate frequencies lacks about 2e-7."""

HARMONICS = 8
"""Integers up to which a line is a harmonic of the strongest, or of its part, and says nothing of the others."""

LINES = 3
"""Lines of each state that are looked at, the strongest first."""

WEAK = 1e-3
"""Part of the strongest line of its state that another has at least."""

NARROW = 8
"""Bins around a line that belong to it, as its window is wide."""

SAFE = 3.0
"""Times its error by which a relation may fail. The error is that of three quarters, larger than that of the whole."""

ROUND_OFF = 1e-13
"""Error of a frequency at least: part of a turn a sample that round-off of states and times moves it by."""

PARTS, EVENLY = (8, 4), 1e-3
"""Parts of a sequence whose lines tell whether its rate changes, fewer where lines are not apart in many, and part of
the mean change from one to the next by which each differs from it at most where it does: beats of a torus that are slow
move its lines less evenly."""

PASSES = 8
"""Newton's steps to the top of a line, each of which doubles the digits."""


def incommensurate(points: np.ndarray) -> bool:
    """Whether states sampled at equal intervals have two frequencies of which no small multiples agree.

    ``points``, shape (W, n): states, each in parts of its extent.

    Returns: False also where the frequencies are not known well enough, as in chaos and on the way to an attractor.
    """
    found = [line for values in points.T for line in _lines(values)]
    if not found:
        return False
    height, frequency, error = np.array(sorted(found, reverse=True)).T
    for k in range(1, len(height)):
        if not np.isfinite(frequency[[0, k]] + error[[0, k]]).all():
            return False
        # weaker lines are combinations, of a higher order on a cycle than the two from which they are made
        if not related(frequency[0], frequency[k], error[0], error[k], HARMONICS):
            return not related(frequency[0], frequency[k], error[0], error[k], ORDER)
    return False


def frequencies(values: np.ndarray, is_likely: Callable[[float], bool]) -> Iterator[float]:
    """Frequencies of the strongest lines of a sequence that are known, in cycles a sample; of those that are likely by
    about where they are.
    """
    guesses = (guess for _, guess in _guesses(values) if _is_apart(guess, len(values)))
    tops = (_top(values, guess) for guess in guesses if is_likely(guess))
    return (top for top in tops if np.isfinite(top))


def strongest(points: np.ndarray) -> float:
    """Frequency of the strongest line of any state, shape (W, n), in cycles a sample; NaN where none is apart."""
    found = [(height, values, guess) for values in points.T for height, guess in _guesses(values)]
    for _, values, guess in sorted(found, key=lambda one: -one[0]):
        if _is_apart(guess, len(values)) and np.isfinite(top := _top(values, guess)):
            return top
    return np.nan


def quickens(values: np.ndarray) -> bool:
    """Whether the strongest line of a sequence is ever higher, or lower, from part to part, by as much each time."""
    guess = strongest(values[:, np.newaxis])
    for parts in (np.array_split(values, count) for count in PARTS):
        if np.isfinite(guess) and _is_apart(guess, len(parts[-1])):
            steps = np.diff([_top(part, guess) for part in parts])
            if (np.abs(steps - steps.mean()) <= EVENLY * np.abs(steps.mean()) - ROUND_OFF).all():
                return True
    return False


def _lines(values: np.ndarray) -> Iterator[tuple[float, float, float]]:
    """Heights, frequencies and errors of the strongest lines of a sequence, in cycles a sample."""
    most_of = len(values) * 3 // 4
    for height, guess in _guesses(values):
        tops = [np.nan]
        if _is_apart(guess, len(values)):
            # a side lobe of another line moves with the length of the window
            tops = [_top(part, guess) for part in (values, values[:most_of], values[-most_of:])]
        yield height, tops[0], max(float(np.ptp(tops)), ROUND_OFF)


def _guesses(values: np.ndarray) -> Iterator[tuple[float, float]]:
    """Heights of the strongest lines of a sequence, and about where they are."""
    size = 4 * len(values)
    power = np.abs(np.fft.rfft(_faded(values), size))
    most = power.max()
    for _ in range(LINES):
        top = int(power.argmax())
        if not power[top] > WEAK * most:
            return
        # the top of a parabola through the highest three
        before, most_here, behind = power[np.clip([top - 1, top, top + 1], 0, len(power) - 1)]
        bend = 2 * most_here - before - behind
        yield float(most_here), float(top + ((behind - before) / (2 * bend) if bend > 0 else 0.0)) / size
        power[max(0, top - 4 * NARROW) : top + 4 * NARROW + 1] = 0.0


def _is_apart(guess: float, length: int) -> bool:
    """Whether a line and its mirror image are not one."""
    return NARROW / length < guess < 0.5 - NARROW / length


def _faded(values: np.ndarray) -> np.ndarray:
    """A sequence without its mean, that fades in and out."""
    weight = fading(len(values))
    return np.asarray((values[1:] - weight @ values[1:]) * weight)


def _top(values: np.ndarray, guess: float) -> float:
    """Frequency near a guess at which the transform of a faded sequence is largest."""
    faded = _faded(values)
    at = np.arange(len(faded)) - (len(faded) - 1) / 2
    frequency = guess
    for _ in range(PASSES):
        wave = faded * np.exp(-2j * np.pi * frequency * at)
        zeroth, first, second = wave.sum(), (at * wave).sum(), (at**2 * wave).sum()
        slope = (np.conj(zeroth) * first).imag
        bend = 2 * np.pi * ((np.conj(zeroth) * second).real - abs(first) ** 2)
        if bend <= 0:
            return np.nan
        before, frequency = frequency, frequency + slope / bend
        if abs(frequency - guess) > NARROW / len(values):
            return np.nan
        if abs(frequency - before) <= ROUND_OFF:
            break
    return float(frequency)


def related(one: float, other: float, error: float, other_error: float, order: int) -> bool:
    """Whether integers up to an order make ``p one + q other`` whole within the errors."""
    within = SAFE * order * (error + other_error)
    first = np.arange(1, order + 1) * one % 1.0
    second = np.sort(np.delete(np.arange(-order, order + 1), order) * other % 1.0)
    around = np.concatenate([second[-1:] - 1.0, second, second[:1] + 1.0])
    place = np.searchsorted(around, first)
    lacks = np.minimum(around[place] - first, first - around[place - 1])
    return bool(lacks.min() <= within)

"""Whether a record is stationary, or still leaves something, or still settles.

A record is divided into parts, and two things are followed from part to part: the spread of every state, and the
distance between points a few iterates apart, which is what the motion lacks to a cycle. On an attractor both are about
the same in all parts. Away from an unstable point at rest, or from an unstable cycle, they grow from part to part, and
towards a stable one they shrink.
"""

import numpy as np

from chaosdrill.analysis.judgement.recurrence import CLOSE, ROUND_OFF, sizes

PARTS = 8
"""Parts of a record. That something grows in all of them by chance has the probability 1/8!, 1 in 40,000."""

FEWEST = 4
"""Points of a part at least."""

FACTOR = 1.5
"""Times by which it grows from the first part to the last at least."""

SMALL = 0.08
"""Part of the largest that the first three parts have at most (or the last three), where growth has come to an end
within the record. A positive exponent that differs significantly from zero needs growth by exp(4)."""

SAME = 1e-14
"""Relative distance of numbers that differ in their last digits only."""

ENDS = 3
"""Parts of these: what is over sooner says little against the rest of the record."""

LAGS = 8
"""Iterates between points that are compared, at most."""

EVEN, LIKE = 0.03, 0.5
"""Parts by which the logarithm of the pace may grow more or less in the first half of a record in which a state departs
from something unstable, and by which its growth may differ from what the exponent says of all of it; later it grows
less where the motion comes near to something else."""

LEAST_STEP = 1e-4
"""Growth of that logarithm from part to part at least: of a steady growth it is round-off."""


def stationarity(
    windows: np.ndarray, known: np.ndarray, parting: np.ndarray | bool = False, before: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Which motions still leave something, and which still settle.

    What has been as far away before, and has come back, is not leaving, and what has been as close does not settle.

    ``windows``, shape (P, W, n): states in order, at equal intervals or at a section; NaN behind the last. ``known``,
    shape (P, n): sizes that states have had on the way. ``parting``, bool, shape (P,): where nearby motions part
    evenly; what grows there is no error, however small it is. ``before``, shape (P, V, n): states before the windows,
    at the same intervals; default none.

    Returns ``leaving``, ``settling``, bool, shape (P,).
    """
    leaving, settling = np.zeros((2, len(windows)), dtype=bool)
    parting = np.broadcast_to(parting, len(windows))
    rows = np.isfinite(windows).all(axis=2).sum(axis=1)
    for count in np.unique(rows[rows >= PARTS * FEWEST]).tolist():
        here = np.flatnonzero(rows == count)
        earlier = None if before is None else before[here]
        leaving[here], settling[here] = _of_full(windows[here, :count], known[here], parting[here], earlier)
    return leaving, settling


def shows(few: np.ndarray, windows: np.ndarray, points: int) -> np.ndarray:
    """Which states move as far in the last of the parts of a record when only few of its points are looked at.

    What turns nearly a whole number of times between them seems to move slowly.

    ``few``, shape (P, K, n): states at equal intervals in the whole record of that many ``points``, ``windows``, shape
    (P, W, n), the last of these.

    Returns: bool, shape (P, n).
    """
    seen, all_ = (one[:, -(count // PARTS) :].std(axis=1) for one, count in ((few, few.shape[1]), (windows, points)))
    return np.asarray(FACTOR * seen >= all_)


def _of_full(
    points: np.ndarray, known: np.ndarray, parting: np.ndarray, before: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    size = sizes(points, known)
    rounding, close = (np.where(parting, SAME, usual)[:, np.newaxis] for usual in (ROUND_OFF, CLOSE))
    length = points.shape[1] // PARTS
    spread, lacks = _by_parts(points[:, -PARTS * length :] / size[:, np.newaxis], length)
    moves = spread.max(axis=1) > rounding * np.maximum(1, known / size)
    told = np.concatenate([spread, lacks], axis=2)
    up, down = (_grow(one) for one in (told, told[:, ::-1]))
    if before is not None and before.shape[1] >= length:
        # the last parts matter most, and all are of one length
        count = before.shape[1] // length * length
        earlier = np.concatenate(_by_parts(before[:, -count:] / size[:, np.newaxis], length), axis=2)
        up &= earlier.max(axis=1) < told.max(axis=1) / FACTOR
        down &= earlier.min(axis=1) > told.min(axis=1) * FACTOR
    states, tells = spread.shape[2], lacks.max(axis=1) > close
    leaving = (up[:, :states] & moves).any(axis=1) | (up[:, states:] & tells).any(axis=1)
    settling = (down[:, :states] | ~moves).all(axis=1) & moves.any(axis=1)
    return leaving, settling | (down[:, states:] & tells).any(axis=1)


def _by_parts(points: np.ndarray, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Spread of every state, and the largest distances between points a few iterates apart, in parts of a length.

    ``points``, shape (P, N length, n). Returns arrays of shapes (P, N, n) and (P, N, lags).
    """
    parts = points.reshape(len(points), -1, length, points.shape[2])
    lags = range(1, min(LAGS, length // 2) + 1)
    lacks = [np.abs(parts[:, :, lag:] - parts[:, :, :-lag]).max(axis=(2, 3)) for lag in lags]
    return parts.std(axis=2), np.stack(lacks, axis=2)


def departs(paths: np.ndarray, drifts: np.ndarray, growth: np.ndarray) -> np.ndarray:
    """Whether states that only grow do so at an exponential pace or faster, as from an unstable rest, not to infinity.

    Or slow down at the pace at which tangents shrink, as towards a stable rest.

    Away from a neutral rest, as in a laminar phase, the logarithm of the pace grows ever faster, since such a growth
    would be over in a finite time; that of a power of time grows ever slower, but by ever less. On the way to what lies
    beside an unstable rest it grows slower by ever more, since what is lacking to an even growth grows itself.

    ``paths``, shape (P, W, n): states at equal intervals; NaN behind the last. ``drifts``, bool, shape (P, n): which
    states only grow. ``growth``, shape (P, K): logarithms by which the pace may grow in the course of the paths: by the
    exponent of the record or of a half.

    Returns: bool, shape (P,).
    """
    found = np.zeros(len(paths), dtype=bool)
    for p in np.flatnonzero(drifts.any(axis=1)):
        path = paths[p][np.isfinite(paths[p]).all(axis=1)][:, drifts[p]]
        each = (len(path) - 1) // PARTS
        pace = np.abs(np.diff(path[-PARTS * each - 1 :: each], axis=0))
        steps = np.diff(np.log(pace), axis=0)
        early = steps[: PARTS // 2]
        mean, expected = early.mean(axis=0), growth[p][:, np.newaxis] * each / len(path)
        even = (np.abs(early - mean) <= EVEN * mean).all(axis=0) & (steps <= (1 + EVEN) * mean).all(axis=0)
        even |= (np.diff(steps, axis=0) < 0).all(axis=0) & (np.diff(steps, n=2, axis=0) < 0).all(axis=0)
        even &= mean > LEAST_STEP
        even &= (np.abs(mean - expected) <= LIKE * mean).any(axis=0)
        faster = (early > LEAST_STEP).all(axis=0)
        faster &= (np.diff(steps, axis=0) > 0).all(axis=0) | (np.diff(early, axis=0) > EVEN * mean).all(axis=0)
        # what is slowing down as tangents shrink arrives, or passes a place where all is slow
        slows = (steps.sum(axis=0) < -LEAST_STEP) & (np.abs(mean - expected) <= LIKE * np.abs(mean)).any(axis=0)
        found[p] = (even | faster | slows).any()
    return found


def _grow(values: np.ndarray) -> np.ndarray:
    """Whether values (P, PARTS, n) grow from part to part, or had to grow first."""
    steps = np.diff(values, axis=1) > 0
    throughout = steps.all(axis=1) & (values[:, -1] >= FACTOR * values[:, 0])
    first = (values[:, :ENDS] <= SMALL * values.max(axis=1, keepdims=True)).all(axis=1)
    return np.asarray(throughout | (first & steps[:, : ENDS - 1].all(axis=1)))

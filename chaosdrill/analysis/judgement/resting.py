"""Whether a motion rests, and whether it will stay there: what passes a rest slowly seems to rest for a while.

Along a heteroclinic cycle (May and Leonard 1975, doi:10.1137/0129022; Guckenheimer and Holmes 1988,
doi:10.1017/S0305004100064732) a motion comes ever closer to one unstable rest, or cycle, after the other, and stays at
each longer than before by a constant factor. While it stays, nothing moves but states that are too small to be seen.
"""

from collections.abc import Callable

import numpy as np

from chaosdrill.analysis.judgement.recurrence import CLOSE, sizes
from chaosdrill.engine.scales import SMALLEST

REST = 1e-7
"""Part of its size by which a state changes in the time in which the motion crosses its extent, at most, at rest."""

ROUNDED = 1e-11
"""Part of the size that it has had on the way by which the rounding of its rate may move it in that time."""

STEP = 1e-6
"""Part of the size of a state by which it is displaced for a difference quotient."""

LEFT = 1e-4
"""Part of the fastest rate about a rest at which nearby motions leave it at least; of difference quotients a multiple
zero is known to 1e-5."""

LAST, FEWEST, PARTS = 16, 16, 4
"""Part of a record, as one over it, and points at its end at least, in parts of which a small state grows: it has done
so since it became small, and the last stay is a large part of all."""

POWER, EVEN = 4.0, 1.5
"""Power of the time as which it grows at most where it will not be seen, as what rounding adds up, and factor by which
the logarithms of its growth from part to part differ at most: it grows evenly as long as it is small."""

SAMPLES = 3
"""Samples that a state spends on either side of its middle at least where its turns are seen: of spikes that are
shorter some fall between two samples. What turns more quickly has no length of a turn, only a mean of many."""

TURNS, LONGER, SHRINKS = 3, 0.05, 0.5
"""Turns of a motion at least, by parts of which it is seen to slow down, part by which these are longer at last than at
first at least, and part of their growth that is left in the later ones at most on the way to a cycle."""


def rests(
    states: np.ndarray, known: np.ndarray, flow: np.ndarray, unit: float, rounding: np.ndarray | float = 0.0
) -> np.ndarray:
    """Whether nothing moves any more at states, by their rates and a time of the motion; shape (P,).

    ``states``, ``flow``, the ``rounding`` errors of it, and ``known``, the sizes that states have had on the way, have
    the shape (P, n). Where a speed has come to zero, the sizes of it are those of rounding in the end.
    """
    still = REST * sizes(states[:, np.newaxis], known) + ROUNDED * known
    return np.asarray(((np.abs(flow) * unit <= still) | (np.abs(flow) <= rounding)).all(axis=1))


def is_left(
    rates: Callable[[np.ndarray], np.ndarray], state: np.ndarray, known: np.ndarray, begin: np.ndarray | None = None
) -> bool:
    """Whether a motion that seems to rest leaves again, since nearby motions do.

    One that has always been where it is, and of which nothing moves, stays on an unstable rest. Where it has come to be
    of numbers that are too small for a double, it does not.

    ``rates``: rates of the states, shape (n,), at a state. ``state``, ``known``, shape (n,): where it seems to rest,
    and sizes that states have had on the way. ``begin``, shape (n,): where it was long before.
    """
    stayed = (known <= np.abs(state)).all() and (begin is None or (begin == state).all())
    if stayed and not rates(state).any():
        return False
    size = np.maximum(known, SMALLEST)
    if begin is not None:
        size = np.maximum(size, np.abs(begin))
    steps = np.diag(STEP * size)
    matrix = np.array([(rates(state + step) - rates(state - step)) / (2 * STEP * size) for step in steps]).T
    if not np.isfinite(matrix).all():
        return False
    return bool(np.linalg.eigvals(matrix).real.max() > LEFT * np.linalg.norm(matrix, 2))


def stirs(windows: np.ndarray, known: np.ndarray, part: np.ndarray | float = 1.0) -> np.ndarray:
    """Whether a state that is too small to be seen grows evenly to the end, so that the motion will move again.

    ``windows``, shape (P, W, n): states in order, at equal intervals or at a section; NaN behind the last. ``known``,
    shape (P, n): sizes that states have had on the way. ``part``, shape (P,): part of the record that the windows are
    of: growth is compared with a power of the whole time.

    Returns: bool, shape (P,).
    """
    found, part = np.zeros(len(windows), dtype=bool), np.broadcast_to(part, len(windows))
    # a state that is small nowhere takes no further look
    some = np.flatnonzero((np.abs(windows) <= CLOSE * known[:, np.newaxis]).any(axis=(1, 2)))
    rows = np.zeros(len(windows), dtype=np.int64)
    rows[some] = np.isfinite(windows[some]).all(axis=2).sum(axis=1)
    for count in np.unique(rows[rows >= FEWEST]).tolist():
        here = np.flatnonzero(rows == count)
        each = max(FEWEST, count // LAST) // PARTS
        end = np.abs(windows[here, count - PARTS * each : count])
        small = (end <= CLOSE * known[here][:, np.newaxis]).all(axis=1) & (end > 0).all(axis=1)
        if not small.any():
            continue
        size = np.log(np.where(end > 0, end, 1.0)).reshape(len(here), PARTS, each, -1).mean(axis=2)
        grown = np.diff(size, axis=1)
        least, most = grown.min(axis=1), grown.max(axis=1)
        whole = (count / part[here])[:, np.newaxis]
        found[here] = (small & (least * whole > POWER * each) & (most <= EVEN * least)).any(axis=1)
    return found


def is_still(paths: np.ndarray) -> np.ndarray:
    """Whether nothing moves in the later half of paths, shape (P, W, n), within the tolerance; bool, shape (P,)."""
    late = paths[:, paths.shape[1] // 2 :]
    return np.asarray((np.ptp(late, axis=1) <= CLOSE * np.abs(paths).max(axis=1)).all(axis=1))


def lengthens(paths: np.ndarray) -> np.ndarray:
    """Whether turns take longer and longer, and no less so in the end, or never as long again; bool, shape (P,).

    The former is so along a heteroclinic cycle; on the way to a cycle turns lengthen by less and less. The latter is so
    where a motion has come so near to a homoclinic loop that rounding decides how long it stays at the saddle. Of a
    motion that has turned less than three times nothing is known to repeat, which is the same.

    ``paths``, shape (P, W, n): states at equal intervals of time.
    """
    middle = (paths.min(axis=1) + paths.max(axis=1)) / 2
    above = paths > middle[:, np.newaxis]
    rises = above[:, 1:] & ~above[:, :-1]
    # the state that turns least often but often enough, of those whose turns are seen if there are any
    counts = rises.sum(axis=1)
    enough, quick = counts > TURNS, counts.max(axis=1) * 2 * SAMPLES > paths.shape[1]
    seen = enough & _all_seen(above)
    counts[~np.where(seen.any(axis=1, keepdims=True), seen, enough)] = paths.shape[1]
    found = (counts == paths.shape[1]).all(axis=1)
    for p in np.flatnonzero(~found):
        state = counts[p].argmin()
        values, level, at = paths[p, :, state], middle[p, state], np.flatnonzero(rises[p, :, state])
        turns = np.diff(at + (level - values[at]) / (values[at + 1] - values[at]))
        early, between, late = (part.mean() for part in np.array_split(turns, 3))
        grows = late - early > LONGER * early and between > early
        repeats = (quick[p] and not seen[p].any()) or _repeats(turns)
        found[p] = (grows and late - between > SHRINKS * (between - early)) or not repeats
    return found


def _all_seen(above: np.ndarray) -> np.ndarray:
    """Which states are seen whenever they are on either side of their middle, shape (P, W, n); bool, shape (P, n)."""
    passed = above[:, 1:] != above[:, :-1]
    again = [(passed[:, lag:] & passed[:, :-lag]).any(axis=1) for lag in range(1, SAMPLES)]
    return np.asarray(~np.logical_or.reduce(again))


def _repeats(turns: np.ndarray) -> bool:
    """Whether the later half of the lengths of turns, in samples, comes back after some of them."""
    late = turns[len(turns) // 2 :]
    # a time between two samples is not known
    most = LONGER * late.mean() + 1.0
    return any(np.abs(late[k:] - late[:-k]).max() <= most for k in range(1, len(late) // 2 + 1)) or len(late) < TURNS

"""Which section points come back, and after how many iterates: for all points of a chunk at once."""

from dataclasses import dataclass

import numpy as np

from chaosdrill.codegen.kinds import float64, int64, void
from chaosdrill.codegen.signatures import integers, matrix, vector
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.scales import SMALLEST

CLOSE = 1e-6
"""Largest distance of two section points that count as the same, relative to the size of every state."""

ROUND_OFF = 1e-9
"""Relative distance at which points have come back as well as a run allows."""

FLOOR = 1e-6
"""Part of the size that a state has had on the way that is added to its size at the section points: below it no digit
is known. States are not compared with each other, since their units may differ."""

NEAR = 0.05
"""Distance, relative to the extent of the section points, below which a period is worth a search."""

CANDIDATES = 4

FADES = 1e-4
"""Part of a distance that is lost or won from one half of a record to the other, at least, where it does not stay."""

CLOSER = 0.5
"""Part of a distance that is left after a multiple of the iterates, below which the multiple counts on its own: after a
period doubling the points nearly come back after half of their period."""

_cubes = float64[:, :, ::1]
_table = int64[:, ::1]


@dataclass(frozen=True)
class Recurrence:
    """What the section points of P runs say."""

    period: np.ndarray  # int (P,): smallest number of iterates after which all points return, 0 without one
    residual: np.ndarray
    """(P,): largest relative distance between a point and the one a period later; infinite without a period."""
    splitting: np.ndarray
    """(P,): the same after a proper divisor of the period, the smallest over all of them: how far apart the points of a
    cycle are. Infinite for period 1."""
    near: np.ndarray
    """int (P, 4): numbers of iterates after which the points nearly come back, multiples only if they do so better; 0:
    no more."""
    rows: np.ndarray  # int (P,): section points there were


def recurrence(
    windows: np.ndarray, known: np.ndarray, most: int, depth: int | None = None, rounding: np.ndarray | float = 0.0
) -> Recurrence:
    """Compare the section points of every run with those before.

    ``windows``, shape (P, W, n + 1): section points in order, the state and a code that must be the same (the mode);
    NaN behind the last. ``known``, shape (P, n): sizes that states have had on the way, see
    `chaosdrill.engine.batch.Batch.sizes`. ``most``: longest period looked for; the points must hold two periods.
    ``depth``: how many of the last points are compared; default all. ``rounding``, shape (P,): part of these sizes that
    errors of the run may add up to from point to point, so that points that far apart count as the same.
    """
    points = len(windows)
    depth = windows.shape[1] if depth is None else depth
    period, rows = np.zeros(points, dtype=np.int64), np.zeros(points, dtype=np.int64)
    residual, splitting = np.full(points, np.inf), np.full(points, np.inf)
    near = np.zeros((points, CANDIDATES), dtype=np.int64)
    scales, gap = np.zeros((2, windows.shape[2] - 1)), np.zeros(CANDIDATES)
    floors = FLOOR * np.ascontiguousarray(known, dtype=float)
    errors = np.broadcast_to(rounding, points) / (CLOSE * FLOOR)
    found = (period, residual, splitting, near, rows)
    _compare(np.ascontiguousarray(windows), floors, errors, most, depth, scales, gap, *found)
    return Recurrence(period, residual, splitting, near, rows)


def trend(
    windows: np.ndarray, known: np.ndarray, points: np.ndarray, periods: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Whether section points a number of iterates apart come closer along the record, and whether they part.

    ``windows``, ``known``, shapes (P, W, n + 1), (P, n): as in `recurrence`. ``points``, ``periods``, int, shape (K,):
    which window, and how many iterates.

    Returns ``shrinks``, ``grows``, bool, shape (K,): where distances do not shrink, no cycle of this many iterates is
    approached; where they do not grow, none is left. Distances as small as those of a converged cycle always count as
    shrinking, since they are round-off.
    """
    late, early = np.zeros(len(points)), np.zeros(len(points))
    floors = FLOOR * np.ascontiguousarray(known, dtype=float)
    _halves(np.ascontiguousarray(windows), floors, points, periods, np.zeros(windows.shape[2] - 1), early, late)
    return (late <= CLOSE) | (late < (1 - FADES) * early), late > (1 + FADES) * early


def powers_of_two(sizes: np.ndarray) -> np.ndarray:
    """The powers of two nearest to sizes, by which no digit changes; 1 for 0."""
    found: np.ndarray = np.exp2(np.round(np.log2(np.where(sizes > 0, sizes, 1.0))))
    return found


def sizes(points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """What distances between states are relative to, for points of shape (P, rows, n); shape (P, n).

    ``known`` are sizes that the states have had on the way, as in `recurrence`.
    """
    return np.maximum(np.abs(points).max(axis=1) + FLOOR * known, SMALLEST)


def residual_at_largest(
    found: Recurrence, which: np.ndarray, windows: np.ndarray, known: np.ndarray, most: int, depth: int | None = None
) -> np.ndarray:
    """Residuals, shape (P,), of some runs in parts of the largest that states have been, from which round-off may come.

    ``found``, ``windows``, ``known``, ``most``, ``depth``: as in `recurrence`. ``which``: numbers of these runs.
    """
    residual = found.residual.copy()
    residual[which] = recurrence(windows[which], known[which] / FLOOR, most, depth).residual
    return residual


def find_period(points: np.ndarray, known: np.ndarray, most: int, rounding: float = 0.0) -> int:
    """Smallest period of a sequence of section points, 0 if no period up to ``most`` fits.

    The last half of the sequence must repeat for at least two periods, every state within 1e-6 of its own size, or
    within what the errors of the run add up to, at most 1e-6 of the size that it has had on the way.

    ``points``, shape (iterates, n). ``known``, shape (n,): these sizes. ``most``: longest period looked for.
    ``rounding``: as in `recurrence`.
    """
    points = points[len(points) // 2 :]
    if not np.isfinite(points).all():
        return 0
    window = np.zeros((1, len(points), points.shape[1] + 1))
    window[0, :, :-1] = points
    return int(recurrence(window, known[np.newaxis], most, rounding=rounding).period[0])


@inner
def _distance(points, rows, q, scale, limit):
    """Largest relative distance between points q iterates apart, or the first one found above the limit."""
    n = scale.size
    largest = 0.0
    for k in range(rows - 1, q - 1, -1):
        if points[k, n] != points[k - q, n]:
            return np.inf
        for i in range(n):
            largest = max(largest, abs(points[k, i] - points[k - q, i]) * scale[i])
        if largest > limit:
            break
    return largest


@inner
def _extent(points, rows, floor, scale):
    """Fill in one over the size of every state; returns the largest relative extent."""
    extent = 0.0
    for i in range(scale.size):
        size = 0.0
        low = points[0, i]
        high = low
        for k in range(rows):
            size = max(size, abs(points[k, i]))
            low = min(low, points[k, i])
            high = max(high, points[k, i])
        size += floor[i]
        scale[i] = 1.0 / size if size > SMALLEST else 0.0
        extent = max(extent, (high - low) * scale[i])
    return extent


@compiled(void(_cubes, matrix, integers, integers, vector, vector, vector))
def _halves(windows, floors, points, periods, scale, early, late):
    n = scale.size
    for k in range(points.size):
        window = windows[points[k]]
        rows = 0
        while rows < window.shape[0] and np.isfinite(window[rows].sum()):
            rows += 1
        q = periods[k]
        if rows <= q + 1:
            continue
        _extent(window, rows, floors[points[k]], scale)
        middle = (rows + q) // 2
        for row in range(q, rows):
            distance = 0.0
            for i in range(n):
                distance = max(distance, abs(window[row, i] - window[row - q, i]) * scale[i])
            if row < middle:
                early[k] = max(early[k], distance)
            else:
                late[k] = max(late[k], distance)


@compiled(void(_cubes, matrix, vector, int64, int64, matrix, vector, integers, vector, vector, _table, integers))
def _compare(windows, floors, errors, most, depth, scales, gap, period, residual, splitting, near, rows):
    plain, scale = scales[0], scales[1]
    for p in range(windows.shape[0]):
        count = 0
        while count < windows.shape[1] and np.isfinite(windows[p, count].sum()):
            count += 1
        rows[p] = count
        points = windows[p, max(0, count - depth) : count]
        count = points.shape[0]
        if count < 2:
            continue
        loose = max(NEAR * _extent(points, count, floors[p], plain), CLOSE)
        found = 0
        for q in range(1, min(most, count // 2) + 1):
            more = max(min(q * errors[p], 1.0 / FLOOR) - 1.0, 0.0)
            for i in range(scale.size):
                scale[i] = plain[i] / (1.0 + plain[i] * floors[p, i] * more)
            distance = _distance(points, count, q, scale, loose)
            if distance > loose:
                continue
            known = False
            for j in range(found):
                known = known or (q % near[p, j] == 0 and distance > CLOSER * gap[j])
            if found < CANDIDATES and not known:
                near[p, found] = q
                gap[found] = distance
                found += 1
            if distance <= CLOSE:
                period[p] = q
                residual[p] = distance
                break
        for d in range(1, period[p] // 2 + 1):
            if period[p] % d == 0:
                splitting[p] = min(splitting[p], _distance(points, count, d, scale, np.inf))

"""Neighbours of section points: how many there are within a distance, and how far those are that hold a part of all.

Distances are the largest over the coordinates. Both come from sorted boxes, for a limited number of points, so that the
time grows like the record.
"""

from typing import NamedTuple

import numpy as np

from chaosdrill.analysis.tuning import SCALING
from chaosdrill.codegen.kinds import int64, void
from chaosdrill.codegen.signatures import integer_matrix, integers, matrix, vector
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.lanes import exponent

SCALES = 2.0 ** np.arange(-26.0, 2.25, 0.5)
"""Distances, in standard deviations of the states; below the first one the digits of states end."""


NEAREST = np.array([1, 2, 3, 4, 6, 8, 11, 16, 23, 32])
"""Numbers of the neighbours to which distances are asked, of all points."""

_AGAIN, _THINNER = NEAREST[-4:], 4
"""Those that are asked of ever fewer points, too, and how many times fewer: parts go on evenly."""

_FURTHER = 16
"""Widths of a box up to which points are looked for in boxes; beyond, all are looked at."""

_BELOW = 1 - 2.0**-53
"""What makes a power of two less than that, and changes the exponent of no other number."""


class Counted(NamedTuple):
    """Neighbours of some points, in the order of the record."""

    places: np.ndarray  # (C,): distances, as places of `SCALES`
    counts: np.ndarray  # (R, C): within each of these
    possible: np.ndarray  # (R,): points that could be such

    def sound(self) -> np.ndarray:
        """Distances with enough pairs, but well below the extent of the attractor; (C,)."""
        counted = self.counts.sum(axis=0)
        return np.asarray((counted >= 2 * SCALING.fewest_pairs) & (counted <= SCALING.widest * self.possible.sum()))

    def near(self) -> np.ndarray:
        """Mean number of neighbours, shape (C,)."""
        return np.asarray(self.counts.mean(axis=0))

    def regular(self) -> bool:
        """Whether points keep away from each other, as on a torus: hardly any has no neighbour where some would."""
        near = self.near()
        crowded = np.flatnonzero(near >= SCALING.crowded)[:1]
        return bool(((self.counts[:, crowded] == 0).mean(axis=0) < SCALING.regular * np.exp(-near[crowded])).any())


class Shares(NamedTuple):
    """Distances within which some points have parts of all points, in the order of the record."""

    logs: np.ndarray  # (R, K): logarithms of the distances, growing with the part
    parts: np.ndarray  # (K,): mean logarithms of the parts, without bias
    neighbours: np.ndarray  # (K,): number of neighbours, among all points


def neighbours(points: np.ndarray, window: int) -> list[Counted]:
    """Neighbours within each distance of some points: among all points, and at large distances among fewer.

    ``points``, shape (N, d). ``window``: steps of time up to which two points are no pair (Theiler 1986).

    Returns: one where the points are few; else two, which share one distance.
    """
    count, columns = len(points), _columns(points)
    which, fewer = picked(count, SCALING.centres), picked(count, SCALING.fewer)
    near = _near(columns, fewer)
    last = max(int(np.searchsorted(near, SCALING.beyond * SCALING.widest * count, "right")) - 1, 0)
    if len(which) == count:
        return [_counted(columns, which, which, window, 0, last)]
    switch = min(int(np.searchsorted(near, SCALING.many)), last)
    return [
        _counted(columns, which, np.arange(count), window, 0, switch),
        _counted(columns, which, fewer, window, switch, last),
    ]


def _near(columns: np.ndarray, among: np.ndarray) -> np.ndarray:
    """About how many neighbours there are within each distance, from a few points and some others, shape (S,)."""
    count = columns.shape[1]
    few, some = columns.take(picked(count, SCALING.looked_at), axis=1), columns.take(among, axis=1)
    counts = np.zeros((few.shape[1], len(SCALES) + 1), dtype=np.int64)
    begin = np.zeros((1, len(counts)), dtype=np.int64)
    _count(few, some, begin, begin + len(among), 0, 1, counts)
    return np.asarray((counts[:, :-1].cumsum(axis=1).mean(axis=0) - 1) * count / len(among))


def _counted(columns: np.ndarray, which: np.ndarray, among: np.ndarray, window: int, first: int, last: int) -> Counted:
    """Neighbours of some points among some, within some of the distances; both are places in order."""
    centres, some = columns.take(which, axis=1), columns.take(among, axis=1)
    boxes = _Boxes(some, SCALES[last])
    rank, begin, end = boxes.about(centres, 1)
    ranked = np.zeros((len(which), max(last - first + 1, 0) + 1), dtype=np.int64)
    _count(centres.take(rank, axis=1), boxes.columns, begin, end, first, 1, ranked)
    within = np.empty_like(ranked)
    within[rank] = ranked
    # those near in time, of which a point itself is one
    begin, end = _near_in_time(among, which, window)
    _count(centres, some, begin[np.newaxis], end[np.newaxis], first, -1, within)
    within = within[:, :-1].cumsum(axis=1)
    told = np.flatnonzero(within.sum(axis=0) >= SCALING.fewest_pairs)
    return Counted(first + told, within[:, told].astype(float), len(among) - (end - begin))


def _count(
    centres: np.ndarray,
    columns: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    lowest: int,
    each: int,
    counts: np.ndarray,
) -> None:
    """Add points to the counts; see `_tally`."""
    turns, apart = np.empty((4, counts.shape[1]), dtype=np.int64), np.empty(columns.shape[1])
    _tally(centres, columns, first, last, lowest, each, counts, turns, apart)


def _near_in_time(among: np.ndarray, which: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Where those among some begin and end that are within a window about each of others; all are places in order."""
    return np.searchsorted(among, which - window), np.searchsorted(among, which + window, "right")


def shares(points: np.ndarray, window: int) -> Shares:
    """Distances within which some points have neighbours that hold growing parts of all points.

    The part within the k-th of n neighbours has the mean logarithm psi(k) - psi(n + 1) (Grassberger 1988,
    doi:10.1016/0375-9601(88)90193-4). Larger parts are found among fewer points, one drawn of each few that follow each
    other, so that no band of the attractor is left out.
    """
    from scipy.special import digamma

    count, columns = len(points), _columns(points)
    which = picked(count, SCALING.centres_of_shares)
    near = _near(columns, which)
    logs, parts, held = [], [], []
    thin, asked = 1, NEAREST
    while len(asked := asked[asked * thin <= SCALING.largest_share * count]):
        among = picked(count, -(-count // thin))
        enough = int(np.searchsorted(near, SCALING.spare * thin * asked[-1]))
        apart = _nearest(columns, which, among, window, int(asked[-1]), SCALES[min(enough, len(SCALES) - 1)])
        begin, end = _near_in_time(among, which, window)
        with np.errstate(divide="ignore"):
            logs.append(np.log(apart[:, asked - 1]))
        parts.append(digamma(asked) - digamma(len(among) + 1 - (end - begin)).mean())
        held.append(asked * thin)
        thin, asked = _THINNER * thin, _AGAIN
    if not logs:
        return Shares(np.zeros((len(which), 0)), np.zeros(0), np.zeros(0))
    return Shares(np.concatenate(logs, axis=1), np.concatenate(parts), np.concatenate(held))


def _nearest(
    columns: np.ndarray, which: np.ndarray, among: np.ndarray, window: int, most: int, reach: float
) -> np.ndarray:
    """Distances of some points to their nearest neighbours among some, in order, shape (R, most)."""
    boxes = _Boxes(columns.take(among, axis=1), reach)
    found, times, apart = np.full((len(which), most), np.inf), among[boxes.order], np.zeros(len(among))
    left = np.arange(len(which))
    for widths in (1, 4, _FURTHER, np.inf):
        if not len(left):
            break
        rank, begin, end = boxes.about(columns.take(which[left], axis=1), widths)
        at, near = which[left[rank]], np.full((len(left), most + 1), np.inf)
        near[:, most] = -np.inf
        _keep_nearest(columns.take(at, axis=1), at, boxes.columns, times, begin, end, window, near, apart)
        found[left[rank]] = near[:, most - 1 :: -1]
        left = left[found[left, -1] > widths * reach]
    return found


class _Boxes:
    """Points in rows of boxes of the second and third coordinate; in a row they are in the order of the first.

    ``columns``, shape (d, N): coordinates of the points. ``width``: of the boxes, at least.
    """

    def __init__(self, columns: np.ndarray, width: float) -> None:
        self._width, self._low = width, columns.min(axis=1)
        extent = columns.max(axis=1) - self._low
        # so much more that rounding puts no two points that are a width apart two boxes apart
        self._sizes = (1 + 1e-9) * np.maximum(width, extent / SCALING.boxes)
        self._steps = [float(extent[0]) + 3 * _FURTHER * width]
        for number in np.ceil(extent / self._sizes)[1:3].tolist():
            self._steps.append(self._steps[-1] * (number + 3 * _FURTHER))
        places = self._places(columns)
        self.order = np.argsort(places)
        self._sorted, self.columns = places[self.order], columns.take(self.order, axis=1)

    def _places(self, columns: np.ndarray) -> np.ndarray:
        """Numbers of the rows and places in them, as one number."""
        found = columns[0] - self._low[0]
        for a, step in enumerate(self._steps[:-1], 1):
            found += step * np.floor((columns[a] - self._low[a]) / self._sizes[a])
        return found

    def about(self, columns: np.ndarray, widths: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where those points are that may be within some widths of each of others.

        Returns: ``rank``, int, shape (R,): the order in which the others are looked at. ``first``, ``last``, int, shape
        (rows, R): for each row about one of them, where in ``order`` those points begin and end.
        """
        if widths > _FURTHER:
            first = np.zeros((1, columns.shape[1]), dtype=np.int64)
            return np.arange(columns.shape[1]), first, first + len(self.order)
        rows = np.zeros(1)
        for step in self._steps[:-1]:
            rows = np.add.outer(rows, step * np.arange(-widths, widths + 1)).ravel()
        places = self._places(columns)
        rank = np.argsort(places)
        at, ahead = np.add.outer(rows, places[rank]), widths * self._width + 4 * np.spacing(self._steps[-1])
        return rank, np.searchsorted(self._sorted, at - ahead), np.searchsorted(self._sorted, at + ahead, "right")


def _columns(points: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(points.T)


@inner
def _distances(centres, i, columns, first, last, apart):
    """Largest differences of coordinates."""
    for j in range(first, last):
        apart[j - first] = abs(columns[0, j] - centres[0, i])
    for a in range(1, columns.shape[0]):
        for j in range(first, last):
            apart[j - first] = max(apart[j - first], abs(columns[a, j] - centres[a, i]))


@compiled(void(matrix, matrix, integer_matrix, integer_matrix, int64, int64, integer_matrix, integer_matrix, vector))
def _tally(centres, columns, first, last, lowest, each, counts, turns, apart):
    """Add points to the counts of the smallest of `SCALES` within which they are, or of the last one, of all beyond.

    Four rows of ``turns`` count in turn: to add to a number that was just added to waits for that.
    """
    beyond = counts.shape[1] - 1
    for i in range(first.shape[1]):
        met = 0
        for row in range(first.shape[0]):
            _distances(centres, i, columns, first[row, i], last[row, i], apart[met:])
            met += last[row, i] - first[row, i]
        for j in range(met):
            # squares of `SCALES` are the powers of two from 2**-52 on
            place = exponent(apart[j] * apart[j] * _BELOW) + (53.0 - lowest)
            apart[j] = min(max(place, 0.0), beyond)
        turns[:] = 0
        for j in range(met):
            turns[j % 4, int(apart[j])] += 1
        for place in range(beyond + 1):
            counts[i, place] += each * (turns[0, place] + turns[1, place] + turns[2, place] + turns[3, place])


@compiled(void(matrix, integers, matrix, integers, integer_matrix, integer_matrix, int64, matrix, vector))
def _keep_nearest(centres, times, columns, times_of_points, first, last, window, nearest, apart):
    """Keep the smallest distances, the largest of them first, before a last one that is below all."""
    most = nearest.shape[1] - 1
    for i in range(first.shape[1]):
        for row in range(first.shape[0]):
            begin, end = first[row, i], last[row, i]
            _distances(centres, i, columns, begin, end, apart)
            for j in range(end - begin):
                if apart[j] < nearest[i, 0] and abs(times_of_points[begin + j] - times[i]) > window:
                    for k in range(most):
                        nearest[i, k] = max(min(nearest[i, k], apart[j]), nearest[i, k + 1])


def picked(count: int, most: int) -> np.ndarray:
    """At most ``most`` of ``count`` points, in order: one, drawn by a fixed seed, of each few consecutive ones.

    Evenly spaced points might all lie on one band of an attractor that is visited in turn.
    """
    step = -(-count // most)
    first = np.arange(0, count - step + 1, step)
    return np.asarray(first + np.random.default_rng(0).integers(0, step, len(first)))

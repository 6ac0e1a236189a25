"""Neighbours of section points: how many there are within a distance, and how far those are that hold a part of all.

Distances are the largest over the coordinates. Both come from a tree, for a limited number of points, so that the time
grows like the record.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from chaosdrill.analysis.tuning import SCALING

SCALES = 2.0 ** np.arange(-26.0, 2.25, 0.5)
"""Distances, in standard deviations of the states; below the first one the digits of states end."""


NEAREST = np.array([2, 3, 4, 6, 8, 11, 16, 23])
"""Numbers of the neighbours to which distances are asked, of all points; the last two also of ever fewer points."""


class Counted(NamedTuple):
    """Neighbours of some points, in the order of the record."""

    counts: np.ndarray  # (R, S): within each distance; NaN at distances at which it was not worth counting
    possible: np.ndarray  # (R,): points that could be such

    def sound(self) -> np.ndarray:
        """Distances with enough pairs, but well below the extent of the attractor; (S,)."""
        counted = self.counts.sum(axis=0)
        return np.asarray((counted >= 2 * SCALING.fewest_pairs) & (counted <= SCALING.widest * self.possible.sum()))

    def near(self) -> np.ndarray:
        """Mean number of neighbours, shape (S,)."""
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
    """Neighbours within each distance of some points: among all points, and at large distances among those alone.

    Parameters
    ----------
    points : ndarray, shape (N, d)
    window : int
        Steps of time up to which two points are no pair (Theiler 1986).

    Returns
    -------
    list of Counted
        One where the points are few; else two, which share one distance.
    """
    count, which = len(points), picked(len(points), SCALING.centres)
    tree, few = cKDTree(points, leafsize=SCALING.leaf), points[picked(count, SCALING.looked_at)]
    near = np.array([_within(tree, few, r).mean() for r in SCALES]) - 1
    # what a few points see of a sparse distance is by chance
    chosen = (near * len(which) >= SCALING.fewest_pairs) & (near <= SCALING.beyond * SCALING.widest * count)
    if len(which) == count:
        return [_counted(points, tree, which, which, window, chosen)]
    switch = np.argmax(near >= SCALING.many)
    at = np.arange(len(SCALES))
    return [
        _counted(points, tree, which, np.arange(count), window, chosen & (at <= switch)),
        _counted(points, cKDTree(points[which], leafsize=SCALING.leaf), which, which, window, chosen & (at >= switch)),
    ]


def _counted(
    points: np.ndarray, tree: cKDTree, which: np.ndarray, among: np.ndarray, window: int, chosen: np.ndarray
) -> Counted:
    """Neighbours of some points among some, of which there is a tree; both are places in order."""
    counts = np.full((len(which), len(SCALES)), np.nan)
    for place in np.flatnonzero(chosen):
        counts[:, place] = _within(tree, points[which], SCALES[place])
    # those near in time, of which a point itself is one
    first, last = np.searchsorted(among, which - window), np.searchsorted(among, which + window, "right")
    for further in range(int((last - first).max())):
        there = first + further < last
        apart = np.abs(points[which[there]] - points[among[first[there] + further]]).max(axis=1)
        counts[there] -= apart[:, np.newaxis] <= SCALES
    return Counted(counts, len(among) - (last - first))


def shares(points: np.ndarray, window: int) -> Shares:
    """Distances within which some points have neighbours that hold growing parts of all points.

    The part within the k-th of n neighbours has the mean logarithm psi(k) - psi(n + 1) (Grassberger 1988,
    doi:10.1016/0375-9601(88)90193-4). Larger parts are found among fewer points, one drawn of each few that follow each
    other, so that no band of the attractor is left out.
    """
    from scipy.special import digamma

    count = len(points)
    which = picked(count, SCALING.centres_of_shares)
    logs, parts, held = [], [], []
    thin = 1
    while thin * NEAREST[-2] <= SCALING.largest_share * count:
        among = picked(count, -(-count // thin))
        asked = NEAREST if thin == 1 else NEAREST[-2:]
        asked = asked[asked * thin <= SCALING.largest_share * count]
        spare = 2 * (window // thin + 1) + 1
        apart, place = cKDTree(points[among]).query(points[which], k=asked[-1] + spare, p=np.inf)
        apart[np.abs(among[place] - which[:, np.newaxis]) <= window] = np.inf
        apart = np.sort(apart, axis=1)[:, asked - 1]
        left = len(among) - np.searchsorted(among, which + window, "right") + np.searchsorted(among, which - window)
        with np.errstate(divide="ignore"):
            logs.append(np.log(apart))
        parts.append(digamma(asked) - digamma(left + 1).mean())
        held.append(asked * thin)
        thin *= 2
    if not logs:
        return Shares(np.zeros((len(which), 0)), np.zeros(0), np.zeros(0))
    return Shares(np.concatenate(logs, axis=1), np.concatenate(parts), np.concatenate(held))


def picked(count: int, most: int) -> np.ndarray:
    """At most ``most`` of ``count`` points, in order: one, drawn by a fixed seed, of each few consecutive ones.

    Evenly spaced points might all lie on one band of an attractor that is visited in turn.
    """
    step = -(-count // most)
    first = np.arange(0, count - step + 1, step)
    return np.asarray(first + np.random.default_rng(0).integers(0, step, len(first)))


def _within(tree: cKDTree, places: np.ndarray, distance: float) -> np.ndarray:
    return np.asarray(tree.query_ball_point(places, distance, p=np.inf, return_length=True))

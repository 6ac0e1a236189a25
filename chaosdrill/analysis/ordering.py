"""Tori by the order of their points, whatever cuts them and however many harmonics they have.

Points of a motion with one frequency beside that of the section are functions of one angle, which grows by the same
turn from point to point. In the order of that angle they run along a curve, jumps and all, and the way along it does
not depend on how many there are; in any other motion, strange nonchaotic ones included, it grows with their number. No
average has to converge, so that neither the jumps of states nor the wrinkles of a torus that is about to break hide it.
"""

import numpy as np

from chaosdrill.analysis.frequencies import frequencies
from chaosdrill.analysis.gaps import full
from chaosdrill.analysis.recurrence import CLOSE

FEWEST = 256
"""Number of points of a curve that decide: for random points the length is a third of their number."""

LONGEST = 16.0
"""Way along a curve at most, in extents of a state: a closed curve has 2, and as many more for each further fold or
jump."""

LONGER = 0.1
"""Extents by which that way may be longer than that of either half of the points. Along a spiral that grows by a part g
in the record it is about the number of points times g longer; at a departure all of the way is in the later half."""

NEARBY = np.array(sorted(np.linspace(-3.0, 3.0, 13), key=abs))
"""Around a line turns are tried so far off, in parts of one over the squared number of points: jumps move a line by
that. Of two that do as well the nearer counts."""

RESOLVED = 8.0
"""Points of that angle at least, without a gap, on a piece of the way as long as the extent: those of a cycle of many
points, which come back, are as far apart in angle as in space."""

LAST, BACK, STAYS = 16, 0.75, 0.5
"""Last points of which the nearest return is looked for, within such a part of all, and part of its distance that is
left later on at least: a cycle of any length comes back, or is approached."""

PARTS = 4
"""Parts of a turn in which a state may repeat itself, at most: the strongest line is then that of the parts."""


def ordered(points: np.ndarray) -> bool:
    """Whether points that are visited in turn lie on curves, in the order of one angle.

    Parameters
    ----------
    points : ndarray, shape (W, n)
        States at a strobe or section; those that move.
    """
    for curves in range(1, len(points) // FEWEST + 1):
        path = points[::curves]
        fills = full(path)
        if not fills.any():
            continue
        told = path[:, [fills.argmax()]]
        for turn in _turns(told[:, 0]):
            if _way(told, turn) > LONGEST * np.ptp(told):
                continue
            best = min(turn + NEARBY / len(path) ** 2, key=lambda one: float(_way(told, one)[0]))
            if all(_follows(points[k::curves], best) for k in range(curves)):
                return not _comes_back(points)
    return False


def _turns(values: np.ndarray) -> list[float]:
    """Turns of which a sequence may be a function: its strongest lines, and parts of them."""
    return [(line + k) / parts for line in frequencies(values) for parts in range(1, PARTS + 1) for k in range(parts)]


def _follows(points: np.ndarray, turn: float) -> bool:
    """Whether points run along a curve in the order of their angle, and either half of them along all of it."""
    half, extent = len(points) // 2, np.ptp(points, axis=0)
    way, early, late = (_way(part, turn) / extent for part in (points, points[:half], points[half:]))
    if not ((way <= LONGEST) & (way - np.minimum(early, late) <= LONGER)).all():
        return False
    angle = np.sort(np.arange(len(points)) * turn % 1.0)
    return bool(np.diff(angle, append=angle[0] + 1.0).max() * RESOLVED * way.max() <= 1.0)


def _comes_back(points: np.ndarray) -> bool:
    """Whether points come back where they come nearest to the last ones, or come closer from turn to turn."""
    windows = np.lib.stride_tricks.sliding_window_view(points, LAST, axis=0)
    beside = np.abs(windows[:-1] - windows[-1]).max(axis=(1, 2))[-int(BACK * len(points)) :]
    lag = len(beside) - int(beside.argmin())
    apart = (np.abs(points[lag:] - points[:-lag]) / np.ptp(points, axis=0)).max(axis=1)
    # where a jump lies between two points they are far apart
    before, after = (np.median(part) for part in np.array_split(apart, 2))
    return bool(after <= max(STAYS * before, CLOSE))


def _way(points: np.ndarray, turn: float) -> np.ndarray:
    """Way to and fro of every state along the closed curve, shape (n,)."""
    path = points[np.argsort(np.arange(len(points)) * turn % 1.0, kind="stable")]
    return np.asarray(np.abs(np.diff(path, axis=0, append=path[:1])).sum(axis=0))

"""Classify motions whose largest exponent is not told from zero: quasiperiodic, chaotic, periodic, or unbounded.

On a torus averages that fade in and out smoothly converge faster than any power of their length, in chaos like one over
its root: the averages over two halves of a record agree to many digits or to hardly any (Das, Saiki, Sander and Yorke
2017, doi:10.1088/1361-6544/aa84c2). Averages of squares go along, since what comes to rest turning about it has
constant means and a shrinking extent.
"""

from collections.abc import Callable

import numpy as np

from chaosdrill.analysis.recurrence import CLOSE, ROUND_OFF, recurrence, sizes
from chaosdrill.dataset import Outcome

LENGTH = 2048
"""Section points by which that is told."""

LEAST = 512
"""Section points without which nothing is told."""

REPEATS = 4
"""Times that a record holds a cycle by which it is known, at least."""

SMOOTH = 1e-3
"""Difference of the two averages, in parts of the extent, above which the motion is not regular."""

FASTER = 4.0
"""Times that they are closer in a part of twice the length at least, on a torus; in chaos they are 1.4 times closer."""

LIKELY = 1 / 3
"""Part of the margin, a standard error, above which an exponent is rather that of chaos unless averages converge."""

EXACT = 1e-7
"""Difference that is not asked to shrink, since the tolerance of the run may be all of it."""

PARTS = 8
"""Parts of a record in each of which a state that only grows goes on."""

ONWARD = 0.4
"""Part of its way, to and fro, by which it does so at least."""

STEADY = 0.95
"""Part of its fastest pace that it has at last: what comes to rest like a power of time, as at a bifurcation, and what
turns back in the end is slowing down."""

FAR = 0.03
"""Part of its size by which it has grown at least."""

ALONG, ACROSS = 0.1, 0.4
"""Part of the distance between neighbours that lies across the flow: at most on a closed curve, at least on a torus."""

STAYS = 0.8
"""Part of that distance that is left in the later half of a record, at least, where no cycle is approached."""

SUCCESSIVE = 32
"""One part in so many of the instants before and after one is no neighbour of it, but the same passage (Theiler 1986,
doi:10.1103/PhysRevA.34.2427)."""

REST = 1e-7
"""Part of its size by which a state changes in the time in which the motion crosses its extent, at most, at rest."""

FEWEST = 16
"""Points by which a state that only grows is told at all."""


def rests(states: np.ndarray, known: np.ndarray, flow: np.ndarray, unit: float) -> np.ndarray:
    """Whether nothing moves any more at states, by their rates and a time of the motion; shape (P,).

    ``states``, ``flow`` and ``known``, the sizes that states have had on the way, have the shape (P, n).
    """
    return np.asarray((np.abs(flow) * unit <= REST * sizes(states[:, np.newaxis], known)).all(axis=1))


def only_grows(points: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    """Which states only grow or only fall, evenly.

    Parameters
    ----------
    points : ndarray, shape (P, W, n)
        States at equal intervals; NaN behind the last.
    before : ndarray, shape (P, n), optional
        States long before, from where on growth counts; default the first points.

    Returns
    -------
    ndarray of bool, shape (P, n)
    """
    found = np.zeros((len(points), points.shape[2]), dtype=bool)
    begin = points[:, 0] if before is None else before
    rows = np.isfinite(points).all(axis=2).sum(axis=1)
    for count in np.unique(rows[rows >= FEWEST]).tolist():
        here = np.flatnonzero(rows == count)
        path, first = points[here, :count], begin[here]
        net = path[:, -1] - path[:, 0]
        steps = np.diff(path, axis=1) * np.sign(net)[:, np.newaxis]
        bounds = np.arange(PARTS + 1) * (count - 1) // PARTS
        onward, way = (
            np.add.reduceat(one, bounds[:-1], axis=1) / np.diff(bounds)[:, np.newaxis] for one in (steps, np.abs(steps))
        )
        pace = onward[:, :-1] + onward[:, 1:]
        steady = pace[:, -1] >= STEADY * pace.max(axis=1)
        far = np.sign(net) * (path[:, -1] - first) > FAR * np.maximum(np.abs(path).max(axis=1), np.abs(first))
        found[here] = (onward > ONWARD * way).all(axis=1) & steady & far
    return found


def agreement(windows: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether averages over both halves of sequences agree, and whether they agree ever better in longer parts.

    In chaos on many narrow bands averages are close as well, in parts of the whole extent; twice as many points bring
    them closer by a third, and those of a torus, unless it is slow, by orders of magnitude.

    Parameters
    ----------
    windows, known : ndarray, shapes (P, W, n), (P, n)
        Section points, and sizes that states have had on the way.

    Returns
    -------
    smooth, converging : ndarray of bool, shape (P,)
    """
    weight = _one_over_extent(windows, known)
    moves = (weight > 0).any(axis=1)
    off = (windows - windows.mean(axis=1, keepdims=True)) * weight[:, np.newaxis]
    both = np.concatenate([off, off**2], axis=2)
    quarter, half, whole = (_apart(both, windows.shape[1] // parts) for parts in (4, 2, 1))
    converging = (half <= np.maximum(quarter / FASTER, EXACT)) & (whole <= np.maximum(quarter / FASTER**2, EXACT))
    return (whole <= SMOOTH) & moves, converging & moves


def _one_over_extent(windows: np.ndarray, known: np.ndarray) -> np.ndarray:
    """What makes states comparable whatever their units, shape (P, n): 0 for those that do not move, or are unknown."""
    extent = np.ptp(windows, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(extent > CLOSE * sizes(windows, known), 1 / extent, 0.0)


def _apart(values: np.ndarray, length: int) -> np.ndarray:
    """Largest difference of the averages over both halves of parts of this length, which begin a quarter apart."""
    half, quarter = length // 2, values.shape[1] // 4
    t = np.arange(1, half) / half
    weight = np.exp(-1 / (t * (1 - t)))
    weight /= weight.sum()
    found = np.zeros(len(values))
    for start in range(0, values.shape[1] - length + 1, quarter):
        early, late = (np.einsum("w,pwi->pi", weight, values[:, k + 1 : k + half]) for k in (start, start + half))
        found = np.maximum(found, np.abs(late - early).max(axis=1))
    return found


def tell(
    windows: np.ndarray,
    known: np.ndarray,
    symmetries: np.ndarray,
    lead: np.ndarray,
    margin: np.ndarray,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
) -> np.ndarray:
    """What motions are whose largest exponent is not told from zero, by their section points alone.

    Parameters
    ----------
    windows : ndarray, shape (P, W, n + 1)
        States and modes at equal intervals of time: strobes, or, of a system without forcing, instants of any kind.
    known : ndarray, shape (P, n)
        Sizes that states have had on the way.
    symmetries : ndarray, shape (s, n)
        Orthonormal directions in which nothing ever changes: what happens along them is left out.
    lead, margin : ndarray, shape (P,)
        Largest exponents, and from where on they would be told from zero.
    flow : callable, optional
        Rates of the states, shape (n,), at a state in a mode. To be given for instants of any kind, where a cycle does
        not show by coming back.

    Returns
    -------
    ndarray of int, shape (P,)
        ``OPEN`` if a state only grows, ``PERIODIC`` for a cycle (whose exponent is zero, as that of a centre),
        ``QUASIPERIODIC`` for a torus, else ``UNDECIDED``: averages that do not agree make no chaos, since those of a
        torus that a jump cuts, as of an integrate-and-fire cell at the strobe, do not either.
    """
    paths = _aside(windows, symmetries)
    states = paths[:, :, :-1]
    found = np.full(len(windows), int(Outcome.UNDECIDED))
    open_ = only_grows(states).any(axis=1)
    found[open_] = int(Outcome.OPEN)
    cycle = ~open_ & (recurrence(paths, known, windows.shape[1] // REPEATS).period > 0)
    found[cycle] = int(Outcome.PERIODIC)
    if windows.shape[1] < LEAST:
        return found
    smooth, converging = agreement(states, known)
    for k in np.flatnonzero(~open_ & ~cycle & smooth & (converging | (lead <= LIKELY * margin))):
        found[k] = int(
            Outcome.QUASIPERIODIC if flow is None else _by_neighbours(windows[k], paths[k], known[k], flow, symmetries)
        )
    return found


def repeats_exactly(windows: np.ndarray, known: np.ndarray, symmetries: np.ndarray) -> np.ndarray:
    """Whether motions come back as exactly as a run allows, so that a positive exponent is that of an unstable cycle.

    Parameters
    ----------
    windows, known, symmetries
        As in `tell`.

    Returns
    -------
    ndarray of bool, shape (P,)
    """
    found = recurrence(_aside(windows, symmetries), known, windows.shape[1] // REPEATS)
    return (found.period > 0) & (found.residual <= ROUND_OFF)


def _aside(windows: np.ndarray, symmetries: np.ndarray) -> np.ndarray:
    """States and modes without what happens along the symmetries."""
    states = windows[:, :, :-1]
    return np.concatenate([states - (states @ symmetries.T) @ symmetries, windows[:, :, -1:]], axis=2)


def _by_neighbours(
    window: np.ndarray,
    path: np.ndarray,
    known: np.ndarray,
    flow: Callable[[np.ndarray, int], np.ndarray],
    symmetries: np.ndarray,
) -> Outcome:
    """Whether instants of a regular motion lie on a closed curve or on a torus.

    On a curve neighbours lie along the flow, on a torus beside it, as far away late in the record as early. On the way
    to a cycle they come closer.

    Parameters
    ----------
    window, path : ndarray, shape (W, n + 1)
        States and modes, and the same without what happens along the symmetries.
    known, flow, symmetries
        As in `tell`.
    """
    weight = _one_over_extent(path[np.newaxis, :, :-1], known[np.newaxis])[0]
    points = path[:, :-1] * weight
    near = len(path) // SUCCESSIVE
    part, across = np.zeros(len(path)), np.zeros(len(path))
    for k, (point, mode) in enumerate(zip(points, path[:, -1].astype(int), strict=True)):
        apart = points - point
        distance = np.linalg.norm(apart, axis=1)
        distance[path[:, -1] != mode] = np.inf
        distance[max(0, k - near) : k + near + 1] = np.inf
        nearest = int(distance.argmin())
        rate = flow(window[k, :-1], mode)
        rate = (rate - (rate @ symmetries.T) @ symmetries) * weight
        square = rate @ rate
        if CLOSE < distance[nearest] < np.inf and square > 0:
            aside = apart[nearest] - (apart[nearest] @ rate) / square * rate
            across[k] = np.linalg.norm(aside)
            part[k] = across[k] / distance[nearest]
    if np.median(part) <= ALONG:
        return Outcome.PERIODIC
    early, late = (np.median(half) for half in np.array_split(across, 2))
    torus = np.median(part) >= ACROSS and STAYS * early <= late <= early / STAYS
    return Outcome.QUASIPERIODIC if torus else Outcome.UNDECIDED

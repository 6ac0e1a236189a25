"""Evidence on motions with a largest exponent near zero: tori, long cycles, closed curves, growth.

On a torus averages that fade in and out smoothly converge faster than any power of their length, in chaos like one over
its root: the averages over two halves of a record agree to many digits or to hardly any (Das, Saiki, Sander and Yorke
2017, doi:10.1088/1361-6544/aa84c2). Averages of squares go along, since what comes to rest turning about it has
constant means and a shrinking extent.

A torus takes two more opinions. Its points are in the order of an angle, or a part of them tells the rest; and sums of
them with turning phases stay bounded (the 0-1 test: Gottwald and Melbourne 2009, doi:10.1137/080718851).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chaosdrill.analysis.judgement import ordering
from chaosdrill.analysis.judgement.frequencies import incommensurate
from chaosdrill.analysis.judgement.ordering import comes_back, ordered
from chaosdrill.analysis.judgement.predicting import predicted
from chaosdrill.analysis.judgement.recurrence import CLOSE, ROUND_OFF, recurrence, sizes
from chaosdrill.analysis.judgement.statistics import fading, in_blocks, standard_error
from chaosdrill.codegen.kinds import void
from chaosdrill.codegen.signatures import matrix, vector
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.shifts import Shifts

LENGTH, KEPT = 2048, 8192
"""Number of section points that decide, and of those that are asked where these leave open what a motion is on."""

LEAST = 512
"""Smallest number of section points for a decision."""

REPEATS = 4
"""Times that a record holds a cycle by which it is known, at least."""

SMOOTH = 1e-3
"""Difference of the two averages, in parts of the extent, above which the motion is not regular."""

FASTER = 4.0
"""Times that they are closer in a part of twice the length at least, on a torus; in chaos they are 1.4 times closer."""

REGULAR = 0.5
"""Growth K of the 0-1 test below which it calls a motion regular: it is 0 on a torus and 1 in chaos."""

TURNS = 24
"""Phases of that test, over whose answers the median is taken."""

TESTED = 1024
"""Points to which it is applied."""

BLOCKS = 256
"""Blocks of a sequence at most from which the error of a mean is taken."""

EXACT = 1e-7
"""Difference that is not asked to shrink, since the tolerance of the run may be all of it."""

PARTS = 8
"""Parts of a record in each of which a state that only grows goes on."""

ONWARD = 0.4
"""Part of its way, to and fro, by which it does so at least."""

STEADY = 0.95
"""Part of its fastest pace that it has at last: what comes to rest like a power of time, as at a bifurcation, and what
turns back in the end is slowing down."""

FAR = 0.3
"""Part of its size by which it has grown at least: less may be an arc of an angle that turns back."""

CROSSINGS, SETTLED, STILL = 8, 0.01, 5e-4
"""Times that another state passes the middle of its extent in a record at least where it goes to and fro, part of that
extent in the last quarter at most where it has settled, and extent, as a part of its size, where it hardly moves. Where
another does none of this, nor grows itself, the record is an arc of a motion that goes on otherwise, as that of a slow
angle."""

ALONG, ACROSS = 0.1, 0.4
"""Part of the distance between neighbours that lies across the flow: at most on a closed curve, at least on a torus."""

THIN = 1e-4
"""Part of the distance between neighbours by which they lie beside a curve through them at most, where nothing says
that motions come closer to it."""

NEIGHBOURS = 8
"""Nearest instants of which one lies across the flow, on a torus. Equally spaced instants are a lattice on it, in which
the nearest may lie along the flow all over the torus, and two or three pairs of others lie elsewhere."""

STAYS = 0.8
"""Part of that distance that is left in the later half of a record, at least, where no cycle is approached."""

SUCCESSIVE = 32
"""One part in this many of the instants before and after one is no neighbour but the same passage (Theiler 1986,
doi:10.1103/PhysRevA.34.2427)."""

DRIFT = 2.0
"""Times that points of a cycle are further away after all of a record than after one turn, at most. A record holds at
least `REPEATS` turns, and what drifts evenly is further away by as many less one."""

END = 32
"""Points at the end of a record that tell whether it has come to a cycle, and part of the record, as one over it."""

BEYOND = 0.9
"""Part of the size that a state has had on the way at which it arrives at least if it grows beyond all bounds."""

FEWEST = 16
"""Smallest number of points that show a growing state."""


def only_grows(
    points: np.ndarray, known: np.ndarray, before: np.ndarray | None = None, bounded: np.ndarray | bool = False
) -> np.ndarray:
    """Which states only grow or only fall, evenly, and further than they ever went.

    What grows within the sizes that it has had on the way, as a laminar phase does, or by what round-off may do, is
    bounded for all that is known.

    Parameters
    ----------
    points : ndarray, shape (P, W, n)
        States at equal intervals; NaN behind the last.
    known : ndarray, shape (P, n)
        Sizes that states have had on the way.
    before : ndarray, shape (P, n), optional
        States long before, from where on growth counts; default the first points.
    bounded : ndarray of bool, shape (n,), optional
        Which are coordinates of circles, on which nothing grows; default none.

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
        # all parts of one length, so that an even pace is even to round-off
        each = (count - 1) // PARTS
        steps, begins = steps[:, -each * PARTS :], each * np.arange(PARTS)
        onward, way = (np.add.reduceat(one, begins, axis=1) / each for one in (steps, np.abs(steps)))
        pace = onward[:, :-1] + onward[:, 1:]
        steady = pace[:, -1] >= STEADY * pace.max(axis=1)
        size = np.maximum(sizes(path, known[here]), np.abs(first))
        far = np.sign(net) * (path[:, -1] - first) > FAR * size
        beyond = np.abs(path[:, -1]) >= BEYOND * known[here]
        grows = (onward > ONWARD * way).all(axis=1) & steady & far & beyond & ~bounded
        if grows.any():
            grows &= ~_is_passage(pace)
        found[here] = grows & (grows | _is_known(path, size)).all(axis=1, keepdims=True) if grows.any() else grows
    return found


def _is_known(path: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Which states of paths, shape (P, W, n), of such sizes, go to and fro, or have settled; shape (P, n)."""
    low, high = path.min(axis=1), path.max(axis=1)
    above = path > ((low + high) / 2)[:, np.newaxis]
    crossings = (above[:, 1:] != above[:, :-1]).sum(axis=1)
    left = np.ptp(path[:, -(path.shape[1] // 4) :], axis=1)
    settled = (left <= SETTLED * (high - low)) | (high - low <= STILL * size)
    return np.asarray((crossings >= CROSSINGS) | settled)


def _is_passage(pace: np.ndarray) -> np.ndarray:
    """Whether a pace, shape (P, parts, n), is that of an arc, which turns back, or of a slow place that is passed.

    On an arc it falls by more and more, or rises by less and less; a power of time does so as well, but evens out. In a
    slow place it falls first and rises then.
    """
    first, second, third = (np.diff(pace, n, axis=1) for n in (1, 2, 3))
    arc = (second < 0).all(axis=1) & ((first[:, -1] < 0) | (third < 0).all(axis=1))
    return np.asarray(arc | ((second > 0).all(axis=1) & (first[:, 0] < 0) & (first[:, -1] > 0)))


def agreement(windows: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Whether averages over both halves of sequences agree, ever better in longer parts, and as far as a run allows.

    In chaos on many narrow bands averages are close as well, in parts of the whole extent; twice as many points bring
    them closer by a third, and those of a torus, unless it is slow, by orders of magnitude.

    ``windows``, ``known``, shapes (P, W, n), (P, n): section points, and sizes that states have had on the way.

    Returns ``smooth``, ``converging``, ``exact``, ``parting``, bool, shape (P,). The last: whether they are further
    apart in longer parts, as along a spiral.
    """
    weight = _one_over_extent(windows, known)
    moves = (weight > 0).any(axis=1)
    off = (windows - windows.mean(axis=1, keepdims=True)) * weight[:, np.newaxis]
    both = np.concatenate([off, off**2], axis=2)
    quarter, half, whole = (_apart(both, windows.shape[1] // parts) for parts in (4, 2, 1))
    converging = (half <= np.maximum(quarter / FASTER, EXACT)) & (whole <= np.maximum(quarter / FASTER**2, EXACT))
    return (whole <= SMOOTH) & moves, converging & moves, (whole <= EXACT) & moves, whole > np.maximum(half, EXACT)


def _one_over_extent(windows: np.ndarray, known: np.ndarray) -> np.ndarray:
    """What makes states comparable whatever their units, shape (P, n): 0 for those that do not move, or are unknown."""
    extent = np.ptp(windows, axis=1)
    # the reciprocal of a subnormal number is not finite
    moves = extent > np.maximum(CLOSE * np.maximum(sizes(windows, known), known), np.finfo(float).tiny)
    return np.divide(1.0, extent, out=np.zeros_like(extent), where=moves)


def _apart(values: np.ndarray, length: int) -> np.ndarray:
    """Largest difference of the averages over both halves of parts of this length, which begin a quarter apart."""
    found = np.zeros(len(values))
    for start in range(0, values.shape[1] - length + 1, values.shape[1] // 4):
        found = np.maximum(found, halves_apart(values[:, start : start + length]).max(axis=1))
    return found


def halves_apart(values: np.ndarray) -> np.ndarray:
    """How far the smooth averages over both halves of sequences, shape (P, W, n), are apart; shape (P, n)."""
    early, late = _of_halves(values)
    return np.asarray(np.abs(late - early))


def _of_halves(values: np.ndarray) -> np.ndarray:
    """Smooth averages over both halves of sequences, shape (P, W, n); shape (2, P, n)."""
    half = values.shape[1] // 2
    weight = fading(half)
    return np.stack([np.einsum("w,pwi->pi", weight, values[:, k + 1 : k + half]) for k in (0, half)])


def smooth_means(sequences: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Smooth averages of sequences, how far those over both halves are apart, and their errors.

    Where averages converge as on a torus that of the whole is closer than those of the halves, and the largest
    difference of the three is the error: where a jump cuts the torus, halves may agree by chance. Elsewhere it is
    at least that of a mean of correlated values, larger by what fading takes off the record.

    ``sequences``, ``known``, shapes (S, N), (S,): sequences that move, and sizes that they have had on the way.

    Returns ``means``, ``apart``, ``errors``, shape (S,).
    """
    columns = sequences[:, :, np.newaxis]
    weight = fading(sequences.shape[1])
    means, halves = np.einsum("sw,w->s", sequences[:, 1:], weight), _of_halves(columns)[:, :, 0]
    apart, beside = np.ptp(halves, axis=0), np.abs(halves - means).max(axis=0)
    smooth, converges, *_ = agreement(columns, known[:, np.newaxis])
    by_chance = standard_error(in_blocks(sequences.T, BLOCKS)) * np.sqrt(sequences.shape[1] * (weight**2).sum())
    return means, apart, np.where(smooth & converges, np.fmax(apart, beside), np.fmax(apart, by_chance))


@dataclass
class Regularity:
    """What longer records say of P motions; arrays of bool, shape (P,)."""

    drifts: np.ndarray  # a state only grows
    long_cycle: np.ndarray  # the points come back
    torus: np.ndarray  # averages of both halves agree, and all other opinions say that they lie on a torus
    converges: np.ndarray  # averages converge faster than any power
    agrees: np.ndarray  # averages over both halves agree as far as a run allows
    curve: np.ndarray  # instants lie on a closed curve along the flow
    line: np.ndarray  # even closely so
    ordered: np.ndarray  # in the order of an angle the points run along a curve
    cut: np.ndarray  # with several jumps, as they may for a while along pieces of an exchange of intervals
    returns: np.ndarray  # they return later than a shorter record shows, or run along a spiral


def examine(
    windows: np.ndarray,
    known: np.ndarray,
    shifts: Shifts,
    rounding: np.ndarray | float,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
    asked: np.ndarray | bool = True,
    slow: np.ndarray | bool = True,
    lasts: np.ndarray | bool = True,
) -> Regularity:
    """What motions are by their section points alone.

    Averages that do not agree make no chaos, since those of a torus that a jump cuts, as of an integrate-and-fire cell
    at the strobe, do not either; the order of its points tells it.

    Parameters
    ----------
    windows : ndarray, shape (P, W, n + 1)
        States and modes at equal intervals of time: strobes, or, of a system without forcing, instants of any kind.
    known : ndarray, shape (P, n)
        Sizes that states have had on the way.
    shifts : Shifts
        What happens along them is left out.
    rounding : float or ndarray, shape (P,)
        As in `drift`.
    flow : callable, optional
        Rates of the states, shape (n,), at a state in a mode. To be given for instants of any kind, where a cycle does
        not show by coming back, nor a torus by its gaps.
    asked, slow : ndarray of bool, shape (P,), optional
        Of which it is asked whether they are on a torus by order or prediction, which takes most of the time, and of
        which of them even if averages do not converge; default all.
    lasts : ndarray of bool, shape (P,), optional
        Of which the equations come back to what they were, so that ``flow`` tells rates at all instants; default all.
        Of others the order of instants tells a closed curve that they go round evenly.
    """
    paths, known = aside(windows, shifts), shifts.sizes(known)
    states = paths[:, :, :-1]
    drifts = np.asarray(only_grows(states, known, bounded=shifts.bounded).any(axis=1))
    cycle = np.asarray(~drifts & _comes_back(paths, known, rounding))
    smooth, converges, agrees, parting, torus, curve, line, in_order, cut, returns = np.zeros(
        (10, len(windows)), dtype=bool
    )
    if windows.shape[1] >= LEAST:
        smooth, converges, agrees, parting = agreement(states, known)
    weight = _one_over_extent(states, known)
    asked, lasts, told = np.broadcast_to(asked, len(windows)), np.broadcast_to(lasts, len(windows)), slow | converges
    for k in np.flatnonzero(~drifts & ~cycle & (True if flow is not None else asked)):
        moving = states[k][:, weight[k] > 0] * weight[k, weight[k] > 0]
        if flow is None:
            in_order[k], winds_up, cut[k] = ordered(moving)
            # what is in order does not come back
            returns[k] = winds_up or (not in_order[k] and moving.size > 0 and comes_back(moving, 0.0))
        elif not lasts[k]:
            curve[k], returns[k], _ = ordered(moving)
        elif smooth[k] and not parting[k]:
            curve[k], line[k], torus[k] = _by_neighbours(windows[k], paths[k], known[k], flow, shifts)
            # instants of a short laminar phase may look like those of a torus
            torus[k] &= agrees[k]
        many = moving.size and len(moving) >= ordering.FEWEST
        none = returns[k] or curve[k] or torus[k]
        if asked[k] and told[k] and many and not none and _is_regular(moving):
            # on a torus that settles averages part for a while, but its points are in order
            torus[k] = smooth[k] if in_order[k] else predicted(moving, strobed=flow is None)
    return Regularity(drifts, cycle, torus, converges, agrees, curve, line, in_order, cut, returns)


def goes_on(
    windows: np.ndarray, known: np.ndarray, others: np.ndarray, steps: np.ndarray, shifts: Shifts
) -> np.ndarray:
    """Whether other states of motions lie on the curves along which their section points run; bool, shape (P,).

    ``windows``, ``known``, ``shifts``: as in `examine`; of points that are in order. ``others``, ``steps``, shapes (P,
    K, n), (K,): as in `chaosdrill.analysis.judgement.ordering.goes_on`.
    """
    states, others = shifts.quotient(windows[:, :, :-1]), shifts.quotient(others)
    moves = _one_over_extent(states, shifts.sizes(known)) > 0
    each = zip(states, others, moves, strict=True)
    return np.array([ordering.goes_on(path[:, of], other[:, of], steps) for path, other, of in each], dtype=bool)


def closes(paths: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether points, shape (P, W, n + 1), come back to round-off again and again; bool, shape (P,)."""
    found = recurrence(paths, known, paths.shape[1] // REPEATS)
    return np.asarray((found.period > 0) & (found.residual <= ROUND_OFF))


def closes_for_good(paths: np.ndarray, known: np.ndarray, rounding: np.ndarray | float) -> np.ndarray:
    """Whether they do so, and stay."""
    found = recurrence(paths, known, paths.shape[1] // REPEATS, rounding=rounding)
    return stays(paths, known, np.where(found.residual <= ROUND_OFF, found.period, 0), rounding)


def stays(paths: np.ndarray, known: np.ndarray, periods: np.ndarray, rounding: np.ndarray | float) -> np.ndarray:
    """Whether what comes back after a period, if any, does not move on, as in a channel, or comes ever closer."""
    moves_on, closer, _ = drift(paths, known, periods, rounding)
    return np.asarray((periods > 0) & (~moves_on | closer))


def stays_late(paths: np.ndarray, known: np.ndarray, periods: np.ndarray, rounding: np.ndarray) -> np.ndarray:
    """The same of the later half of the points, or of the last turns by which a drift is seen, if these take longer.

    ``paths``, shape (P, W, n + 1): NaN behind the last.
    """
    found, rows = np.zeros(len(paths), dtype=bool), np.isfinite(paths).all(axis=2).sum(axis=1)
    for count, cycle in np.unique(np.stack([rows, periods])[:, periods > 0], axis=1).T.tolist():
        here = np.flatnonzero((rows == count) & (periods == cycle))
        begin = max(0, min(count // 2, count - REPEATS * cycle - 1))
        found[here] = stays(paths[here, begin:count], known[here], periods[here], rounding[here])
    return found


def drift(
    paths: np.ndarray, known: np.ndarray, periods: np.ndarray, rounding: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whether points that come back move on each time, or come ever closer, or come back to round-off.

    What moves on is further away after all turns than after one. Round-off may come from the largest that states have
    been.

    ``paths``, ``known``, shapes (P, W, n + 1), (P, n): as in `recurrence`, without NaN. ``periods``, int, shape (P,):
    after how many iterates they come back. ``rounding``, shape (P,): part of their sizes that errors of the run may add
    up to from point to point.

    Returns ``moves_on``, ``closer``, ``rounded``, bool, shape (P,): ``closer`` is False, too, for those that
    come back to round-off and do not move on.
    """
    scale, rounding = sizes(paths[:, :, :-1], known), np.broadcast_to(rounding, len(paths))
    moves_on, closer, rounded = np.zeros((3, len(paths)), dtype=bool)
    for cycle in np.unique(periods[periods > 0]).tolist():
        here = np.flatnonzero(periods == cycle)
        points, size = np.ascontiguousarray(np.moveaxis(paths[here, :, :-1], 1, 2)), scale[here]
        far = max((points.shape[2] - 1) // cycle - 1, 1) * cycle
        once = points[:, :, cycle:] - points[:, :, :-cycle]
        np.abs(once, out=once)
        lacks = np.abs(points[:, :, -cycle:] - points[:, :, -cycle - far : -far])
        largest, most = np.maximum(1.0, known[here] / size), once.max(axis=2) / size
        adds_up = points.shape[2] * rounding[here, np.newaxis] * largest
        within = np.clip(DRIFT * most, adds_up, CLOSE * largest)
        moves_on[here] = (lacks.max(axis=2) / size > within).any(axis=1)
        rounded[here] = (most <= ROUND_OFF * largest).all(axis=1)
        asked = moves_on[here] | ~rounded[here]
        if once.shape[2] < 2:
            continue
        steps = (once[asked] / size[asked, :, np.newaxis]).max(axis=1)
        # of as many points of each phase, since points of a cycle are not equally far off
        half = max(steps.shape[1] // (2 * cycle), 1) * cycle
        falls = steps[:, -half:].mean(axis=1) < STAYS * steps[:, :half].mean(axis=1)
        early, late = np.array_split(steps, 2, axis=1)
        falls &= np.median(late, axis=1) < STAYS * np.median(early, axis=1)
        closer[here[asked]] = falls
    return moves_on, closer, rounded


def turn(paths: np.ndarray, known: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """By how much the way from a point to the one a period later changes in a period, in parts of it; shape (P,).

    That is how far the multiplier of what moves is from 1. The least of all points counts; 0 where there are too few.

    ``paths``, ``known``, ``periods``: as in `drift`.
    """
    # a state may be next to zero at all of the points
    found, scale = np.zeros(len(paths)), np.maximum(sizes(paths[:, :, :-1], known), known)
    for cycle in np.unique(periods[periods > 0]).tolist():
        here = np.flatnonzero((periods == cycle) & (paths.shape[1] > 2 * cycle))
        points = paths[here, :, :-1] / scale[here, np.newaxis]
        ways = points[:, cycle:] - points[:, :-cycle]
        changes, before = (np.abs(one).max(axis=2) for one in (ways[:, cycle:] - ways[:, :-cycle], ways[:, :-cycle]))
        # points that do not move at all have no way
        shares = np.divide(changes, before, out=np.full_like(changes, np.inf), where=before > 0)
        # NaN behind the last point
        found[here] = np.fmin.reduce(shares, axis=1, initial=np.inf)
    return found


def stopped(paths: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether the end of a record, shape (P, W, n + 1), comes back to round-off again and again; bool, shape (P,).

    A motion that is chaotic for a while and then falls to a cycle does so.
    """
    return closes(paths[:, -max(END, paths.shape[1] // END) :], known)


def _comes_back(paths: np.ndarray, known: np.ndarray, rounding: np.ndarray | float) -> np.ndarray:
    """Whether points come back after some iterates, and after all multiples no further away than after one.

    What drifts, as in the channel that a cycle leaves behind at a fold, is further away after each. Either they come
    back to round-off, or ever closer: the points of an adding machine are always as far away as its finest part.
    """
    found = recurrence(paths, known, paths.shape[1] // REPEATS, rounding=rounding)
    moves_on, closer, rounded = drift(paths, known, found.period, rounding)
    return np.asarray((found.period > 0) & ~moves_on & (rounded | closer))


def _is_regular(points: np.ndarray) -> bool:
    """Whether the 0-1 test calls points, shape (W, n), regular."""
    return bool(zero_one((points[-TESTED:] - points[-TESTED:].mean(axis=0)).T).max() < REGULAR)


def zero_one(values: np.ndarray) -> np.ndarray:
    """Growth K of the 0-1 test of sequences, shape (..., N): 0 for regular motion, 1 for chaos; shape (...)."""
    return median(zero_one_by_turn(values))


def median(growth: np.ndarray) -> np.ndarray:
    """Median of K over the turning phases, the last axis; 0 where nothing moves."""
    known = np.where(np.isfinite(growth).any(axis=-1, keepdims=True), growth, 0.0)
    # that of numbers that may be none takes ten times as long
    return np.asarray((np.nanmedian if np.isnan(known).any() else np.median)(known, axis=-1))


def turns() -> np.ndarray:
    """Turning phases of the 0-1 test, between pi/5 and 4 pi/5, spread evenly; shape (TURNS,)."""
    return np.asarray(np.pi / 5 + 3 * np.pi / 5 * ((np.arange(TURNS) * (np.sqrt(5) - 1) / 2) % 1))


def zero_one_by_turn(values: np.ndarray) -> np.ndarray:
    """Growth K of the 0-1 test for each of the turning phases; NaN where nothing moves.

    A sequence turns by a phase at every step, and the correlation of its mean square displacement with time is taken,
    less the part that only oscillates (Gottwald and Melbourne 2009, doi:10.1137/080718851). Displacements over n steps
    begin at all points but the last tenth. Over all that begin anywhere, the first and last of them cut off by the ends
    of the sequence, their squares are a sum over correlations, the same for all phases; those that are cut off at the
    beginning, and those that begin in the last tenth, are subtracted.

    ``values``, shape (..., N): sequences.

    Returns: shape (..., TURNS).
    """
    count = values.shape[-1]
    steps = np.arange(1, count // 10 + 1)
    kept = count - len(steps)
    off = (values - values.mean(axis=-1, keepdims=True))[..., 1:]
    # a power of two, whose transform is fast
    size = 2 ** (count - 1).bit_length()
    pairs = np.fft.irfft(np.fft.rfft(off, size) * np.conj(np.fft.rfft(off[..., :kept], size)), size)[..., : len(steps)]
    pairs[..., 1:] *= 2
    squares = np.zeros((*values.shape[:-1], TURNS, len(steps)))
    for place in np.ndindex(values.shape[:-1]):
        _squares(off[place], pairs[place], turns(), squares[place])
    # the mean is taken out of the values, and with it the part that only oscillates, but for what is left of it
    grown = squares - squares.mean(axis=-1, keepdims=True)
    later = steps - steps.mean()
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((grown * later).sum(axis=-1) / np.sqrt((grown**2).sum(axis=-1) * (later**2).sum()))


@compiled(void(vector, vector, vector, matrix))
def _squares(off, pairs, angles, squares):
    """Fill in sums of squared displacements over 1, 2, ... steps by each angle."""
    most = squares.shape[1]
    kept = off.size + 1 - most
    for t in range(angles.size):
        by_real, by_imaginary = math.cos(angles[t]), math.sin(angles[t])
        real, imaginary = 1.0, 0.0
        slope = total = cut = 0.0
        first_real = first_imaginary = last_real = last_imaginary = 0.0
        for k in range(most):
            slope += pairs[k] * real
            total += slope
            squares[t, k] = total - cut
            if k + 1 < most:
                first_real += off[k] * real
                first_imaginary += off[k] * imaginary
                last_real += off[kept + k] * real
                last_imaginary += off[kept + k] * imaginary
            cut += first_real**2 + first_imaginary**2 - last_real**2 - last_imaginary**2
            real, imaginary = (real * by_real - imaginary * by_imaginary, real * by_imaginary + imaginary * by_real)


def aside(windows: np.ndarray, shifts: Shifts) -> np.ndarray:
    """States and modes in the quotient by shifts, shape (P, W, n + 1)."""
    return np.concatenate([shifts.quotient(windows[:, :, :-1]), windows[:, :, -1:]], axis=2) if shifts else windows


def _by_neighbours(
    window: np.ndarray,
    path: np.ndarray,
    known: np.ndarray,
    flow: Callable[[np.ndarray, int], np.ndarray],
    shifts: Shifts,
) -> tuple[bool, bool, bool]:
    """Whether instants of a regular motion lie on a closed curve, whether even closely so, and whether on a torus.

    On a curve all near neighbours lie along the flow, on a torus some beside it, as far away late in the record as
    early. On the way to a cycle they come closer. Where a cycle goes round more often than instants can resolve, its
    neighbours lie beside it as well, and the frequencies tell. A torus may be thin: on a curve neighbours lie beside
    the flow as it bends, but for a small part.

    ``window``, ``path``, shapes (W, n + 1), (W, m + 1): states and modes, and the same in the quotient by shifts.
    ``known``, shape (m,): sizes that coordinates of the quotient have had. ``flow``, ``shifts``: as in `examine`.
    """
    weight = _one_over_extent(path[np.newaxis, :, :-1], known[np.newaxis])[0]
    points = path[:, :-1] * weight
    near = len(path) // SUCCESSIVE
    part, across = np.zeros((2, len(path)))
    off_flow, along_flow, away = (np.zeros((len(path), NEIGHBOURS, size)) for size in (points.shape[1], 1, 1))
    rates = np.stack([shifts.rates(state[:-1], flow(state[:-1], int(state[-1]))) for state in window])
    paces = np.abs(rates) / np.maximum(np.ptp(path[:, :-1], axis=0), sizes(path[np.newaxis, :, :-1], known)[0])
    if (weight == 0).any() and paces[:, weight == 0].max() > CLOSE * paces[:, weight > 0].max():
        # instants a whole number of turns apart are strobes
        in_order, winds_up, _ = ordered(points[:, weight > 0])
        return False, False, in_order and not winds_up
    for k, (point, mode) in enumerate(zip(points, path[:, -1].astype(int), strict=True)):
        apart = points - point
        distance = np.linalg.norm(apart, axis=1)
        distance[path[:, -1] != mode] = np.inf
        distance[max(0, k - near) : k + near + 1] = np.inf
        nearest = np.argpartition(distance, NEIGHBOURS)[:NEIGHBOURS]
        rate = rates[k] * weight
        square = rate @ rate
        nearest = nearest[(distance[nearest] > CLOSE) & (distance[nearest] < np.inf)]
        if len(nearest) and square > 0:
            along = apart[nearest] @ rate / square
            beside = apart[nearest] - np.outer(along, rate)
            off = np.linalg.norm(beside, axis=1)
            across[k] = off.mean()
            part[k] = (off / distance[nearest]).max()
            off_flow[k, : len(nearest)], along_flow[k, : len(nearest), 0] = beside, along
            away[k, : len(nearest), 0] = distance[nearest]
    early, late = (np.median(half) for half in np.array_split(across, 2))
    apart_for_good = bool(np.median(part) >= ACROSS and STAYS * early <= late <= early / STAYS)
    torus = apart_for_good and incommensurate(points[:, weight > 0])
    line = bool(np.median(_unbent(off_flow, along_flow[..., 0], away[..., 0])) <= THIN)
    return bool(np.median(part) <= ALONG), line, torus


def _unbent(beside: np.ndarray, along: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Part of their distance by which neighbours lie beside a curve that bends, at most; shape (W,).

    Of what lies beside the flow, shape (W, K, n), squares and cubes of the way along it, shape (W, K), are taken off by
    least squares; at a distance of zero there is no neighbour.
    """
    scale = np.abs(along).max(axis=1, keepdims=True)
    way = np.divide(along, scale, out=np.zeros_like(along), where=scale > 0)
    square, cube = way**2, way**3
    # orthogonal columns; what differs from the first by round-off alone is no other one
    other = cube - square * _share(cube[..., np.newaxis], square)
    other[(other**2).sum(axis=1) <= ROUND_OFF**2 * (cube**2).sum(axis=1)] = 0.0
    for column in (square, other):
        beside = beside - column[..., np.newaxis] * _share(beside, column)[:, np.newaxis]
    off = np.linalg.norm(beside, axis=2)
    return np.asarray(np.divide(off, distance, out=np.zeros_like(off), where=distance > 0).max(axis=1))


def _share(values: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Least squares of values, shape (W, K, n), by one column, shape (W, K); shape (W, n)."""
    products, squares = np.einsum("wk,wki->wi", column, values), (column**2).sum(axis=1)[:, np.newaxis]
    return np.divide(products, squares, out=np.zeros_like(products), where=squares > 0)

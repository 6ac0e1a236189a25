"""Tori by the order of their points, whatever cuts them and however many harmonics they have.

Points of a motion with one frequency beside that of the section are functions of one angle, which grows by the same
turn from point to point. In the order of that angle they run along a curve, jumps and all, and the way along it does
not depend on how many there are; in any other motion, strange nonchaotic ones included, it grows with their number. No
average has to converge, so that neither the jumps of states nor the wrinkles of a torus that is about to break hide it.
"""

from collections.abc import Iterator

import numpy as np

from chaosdrill.analysis.judgement.frequencies import frequencies, quickens
from chaosdrill.analysis.judgement.gaps import full
from chaosdrill.analysis.judgement.recurrence import CLOSE, ROUND_OFF
from chaosdrill.analysis.judgement.stationarity import SAME

FEWEST = 256
"""Number of points of a curve that decide: for random points the length is a third of their number."""

LONGEST = 16.0
"""Way along a curve at most, in extents of a state: a closed curve has 2, and as many more for each further fold or
jump."""

LONGER = 0.1
"""Extents by which that way may be longer than that of either half of the points, and by twice of which those of halves
may be longer than those of quarters on average, since a jump cuts off twice as much there. Along a spiral that grows by
a part g in the record it is about the number of points times g longer; at a departure all of the way is in the later
half. The graph of a strange nonchaotic attractor has dips of all widths, about as many of each. That one doubling finds
none is not rare, but another does then."""

NEARBY = np.array(sorted(np.linspace(-8.0, 8.0, 33), key=abs))
"""Around a line turns are tried so far off, in parts of one over the squared number of points: jumps move a line by
that. Of two that do as well the nearer counts."""

RESOLVED = 16.0
"""Points of that angle at least, without a gap, on a piece of the way as long as the extent: those of a cycle of many
points, which come back, are as far apart in angle as in space."""

JUMP, APART, RARE = 0.1, 8.0, 300
"""Part of the extent that neighbours on a curve are apart at a jump, at least, times that they are further apart than
those on one side of it, which a curve that is steep for a while is not, and points that each jump but one takes at
least. A rotation, cut once, has one. An exchange of more intervals follows an angle until it comes to one that is
shorter than one over the number of points, and jumps at the ends of the others: so many points do with so few jumps as
often as by chance one is so short. Where no tangent moves, as in exchanges, at most one jump makes a torus."""

LAST, BACK, STAYS = 16, 0.75, 0.5
"""Last points of which the nearest return is looked for, within such a part of all, and part of its distance that is
left later on at least: a cycle of any length comes back, or is approached. In what is before that part only a return
that is close counts, since so few points do not tell an approach."""

MOVES, EXPLAINED = 1e-7, 0.98
"""Part of the extent by which a curve moves in the record at least, and part of what points of one half lack to the
curve of the other that an even motion explains. Of a curve that is rough, or thinly covered, it explains little."""

NODES, ALIKE = 8, 2.0
"""Neighbours by angle through which the curve between them is drawn, and how much faster or slower it may seem to move
where they are twice as far apart: what it lacks for their distance is hundreds of times more then."""

ASKED = 256
"""Points that tell how far the curve through others lies beside them, at most, spread evenly along it."""

FAR, PASSES, FINER = 3.0, 4, 1e-3
"""Times the median by which a point at a jump is missed, steps in which the turn is refined, and part of what is missed
that a step is worth at least. What is left of it is fitted with the motion."""

WAVES = 2
"""Waves along a curve of which its motion consists, as of a circle that shrinks, or moves on as it is."""

WINDS, DRIFTS, FALLEN = 5, 0.9, 0.05
"""Degree of the polynomial of time by which an angle drifts beside its even pace, and part of what points lack to the
curve through the others that the drift explains at least where there is one (measured: 0.93 and more of chirps; where
an angle advances evenly 0.86 at most, of less than `MOVES`, and 0.1 as a rule). Part of it that is left in the later
half of a record at most where a torus is approached; of a rate that falls like a root of time 0.16 is."""

LEFT, SLOWER = 0.02, 0.9
"""Part of the extent by which a curve that moves ever slower may move on, and part of its pace in the first half of the
record that it has in the second at most: it settles on a torus then. A spiral goes on to its centre, a third of the
extent away and more."""

BESIDE, MOST, DOUBT = 2, 0.9, 32
"""Points on either side between which another state of a motion lies, part of all other states that do at least, and
how far the turn that brings them there may be off, in parts of one over the squared number of points: near a fraction
points are in one order at many turns."""

SEVERAL = 2
"""Other states that points repeat at least. Within the points of a record an angle comes back to round-off once in
a million times."""

PARTS = 4
"""Parts of a turn in which a state may repeat itself, at most: the strongest line is then that of the parts."""

SHIFTS, OF = np.array([(k, parts) for parts in range(1, PARTS + 1) for k in range(parts)]).T
"""Whole turns that are added to a line, and into how many parts the sum is cut."""


def ordered(points: np.ndarray) -> tuple[bool, bool, bool]:
    """Whether points that are visited in turn lie on curves, in the order of one angle, or on a spiral, and with cuts.

    Those of an angle whose rate changes evenly do not stay either.

    ``points``, shape (W, n): states at a strobe or section; those that move.

    Returns ``on_curves`` that stay where they are and are no cycle, ``on_a_spiral``: on curves that move evenly, and
    ``cut``: on curves with several jumps.
    """
    curves, turn, parts, cuts = _likeliest(points)
    if not curves:
        return False, False, False
    moves = any(_moves_on(points[k::curves], turn, WAVES * parts) for k in range(curves))
    # by the extent of one curve, which may be small beside the way from one to the next
    path = points[::curves]
    # in a few turns along one of several no rate is known, that from one to the next is
    moves |= any(quickens(told) for each in {1, curves} for told in points[::each, full(points[::each])].T)
    moves |= any(_drifts(points[k::curves], turn) for k in range(curves))
    back = comes_back(path[:, full(path)])
    back |= curves > 1 and _returns(points, len(points), 0.0, ROUND_OFF, _extents(points, curves))
    return not moves and not back, moves, cuts > 1


def goes_on(points: np.ndarray, others: np.ndarray, steps: np.ndarray) -> bool:
    """Whether other states of a motion lie on the curves along which points run, at the angles of their times.

    They do not where the points repeat them, as on a cycle that is longer than the points.

    ``points``, shape (W, n): as in `ordered`. ``others``, shape (K, n): states before or behind them. ``steps``, int,
    shape (K,): how many points behind the first of them, negative before it.
    """
    curves, turn, *_ = _likeliest(points)
    if not curves or _repeat(points, others, steps, _extents(points, curves)):
        return False
    paths = [points[k::curves] for k in range(curves)]
    asked = [(others[steps % curves == k], (steps[steps % curves == k] - k) // curves) for k in range(curves)]
    count, most = len(paths[0]), max(int(np.abs(later).max(initial=1)) for _, later in asked)
    off = np.arange(DOUBT * most // count + 1) / (count * most)
    for one in turn + np.column_stack([off, -off]).ravel()[1:]:
        lie = [_beside(path, one, *of) for path, of in zip(paths, asked, strict=True)]
        if np.concatenate(lie).mean() >= MOST:
            return True
    return False


def _extents(points: np.ndarray, curves: int) -> np.ndarray:
    """Extents, by which round-off counts, of the curve on which each point lies; shape (W, n).

    A curve may be small beside the way to the next one. Digits of its points are those of their sizes.
    """
    of_curves = np.array([np.ptp(points[k::curves], axis=0) for k in range(curves)])
    least = SAME / ROUND_OFF * np.abs(points).max(axis=0)
    return np.maximum(of_curves, least)[np.arange(len(points)) % curves]


def _extent(points: np.ndarray) -> np.ndarray:
    """Extent of every state along one curve, shape (n,); of one that rests there, as a flag does, infinite."""
    extent = np.ptp(points, axis=0)
    return np.where(extent > SAME * np.abs(points).max(axis=0), extent, np.inf)


def _repeat(points: np.ndarray, others: np.ndarray, steps: np.ndarray, extents: np.ndarray) -> bool:
    """Whether points are the same as other states, several of them, all after multiples of one number of steps.

    ``extents``, shape (W, n): in parts of which they are.
    """
    nearest = np.array([(np.abs(points - other) / extents).max(axis=1).argmin() for other in others])
    same = (np.abs(points[nearest] - others) <= ROUND_OFF * extents[nearest]).all(axis=1)
    lags = (nearest - steps)[same]
    return len(lags) >= SEVERAL and bool((lags % lags.min() == 0).all())


def _beside(points: np.ndarray, turn: float, others: np.ndarray, later: np.ndarray) -> np.ndarray:
    """Which other states, shape (K, n), ``later`` by that many points, lie between the points beside them by angle."""
    angle, extent = _angles(len(points), turn), _extent(points)
    order = np.argsort(angle, kind="stable")
    place = np.searchsorted(angle[order], later * turn - np.floor(later * turn))
    near = points[order[(place[:, np.newaxis] + np.arange(-BESIDE, BESIDE)) % len(points)]]
    lacks = np.maximum(near.min(axis=1) - others, others - near.max(axis=1))
    return np.asarray((lacks <= LEFT * extent).all(axis=1))


def _likeliest(points: np.ndarray) -> tuple[int, float, int, int]:
    """The first order of points without several jumps, with their number, or else the first one; 0 curves if none is.

    Beside a fraction, points of several curves seem to be on fewer that are cut.
    """
    found = (0, 0.0, 0, 0)
    for curves, turn, parts in _orders(points):
        cuts = _cuts([points[k::curves] for k in range(curves)], turn)
        if cuts <= 1 or not found[0]:
            found = curves, turn, parts, cuts
        if cuts <= 1:
            break
    return found


def _orders(points: np.ndarray) -> Iterator[tuple[int, float, int]]:
    """On how many curves points lie in the order of an angle, its turn from one on a curve to the next, and its parts,
    the fewest curves first.
    """
    tried: list[tuple[int, float]] = []
    for curves in range(1, len(points) // FEWEST + 1):
        path = points[::curves]
        fills = full(path)
        if not fills.any():
            continue
        path, told = path / _extent(path), int(fills.argmax())
        paths = [points[k::curves] for k in range(curves)]
        here: list[float] = []
        for turn, parts in _turns(path, told):
            nearby = NEARBY.max() / len(path) ** 2
            if _known(turn, 1, here, nearby):
                continue
            # an angle that has been tried, also on fewer curves, is known better from these
            bases = [base * (curves // k) for k, base in tried if curves % k == 0]
            known = _known(turn, 1, bases, nearby) or _known(turn, parts, bases, nearby)
            for one in known[:2] or _nearest(path, told, turn, fills):
                here.append(one)
                if not known:
                    tried.append((curves, one))
                if _follow(paths, one):
                    yield curves, one, parts
                    break


def _known(turn: float, parts: int, bases: list[float], nearby: float) -> list[float]:
    """Turns near one that are such parts of others, either way round."""
    shifted = [base + round(parts * turn - base) for one in bases for base in (one, -one)]
    return [base / parts for base in shifted if abs(base / parts - turn) <= nearby]


def _turns(path: np.ndarray, told: int) -> Iterator[tuple[float, int]]:
    """Turns in whose order the way along points is short, and which parts they are of one of a state's strongest lines.

    No turn nearby closes a gap that is wider, nor shortens a way by more.
    """
    few = path[: FEWEST // 2, [told]]

    def is_likely(guess: float) -> bool:
        # the way along some of the points is no longer, but a guess is not the line
        return bool((_way(few, (guess + SHIFTS) / OF) <= 2 * LONGEST).any())

    for line in frequencies(path[:, told], is_likely):
        turns = (line + SHIFTS) / OF
        short = _way(few, turns)[:, 0] <= LONGEST
        for turn, parts in zip(turns[short].tolist(), OF[short].tolist(), strict=True):
            ways, gap = _way(path, turn), _gap(len(path), turn) - 2 * NEARBY.max() / len(path)
            if ways[told] <= LONGEST / max(gap * RESOLVED * LONGEST, 1.0) and ways.max() <= NEARBY.max() * LONGEST:
                yield turn, parts


def _nearest(path: np.ndarray, told: int, turn: float, fills: np.ndarray) -> Iterator[float]:
    """The turn near one in whose order the way is shortest, and what it is refined to."""
    nearby = turn + NEARBY / len(path) ** 2
    best = float(nearby[_way(path[:, [told]], nearby).argmin()])
    yield best
    # jumps move the shortest way, but not what is between them
    yield _refined(path[:, fills], best, *_halves(path))[0]


def _follow(paths: list[np.ndarray], turn: float) -> bool:
    """Whether points run along curves in the order of their angle, with few jumps."""
    if not all(_follows(path, turn) for path in paths):
        return False
    return (_cuts(paths, turn) - 1) * RARE <= sum(map(len, paths))


def _cuts(paths: list[np.ndarray], turn: float) -> int:
    """Number of jumps of the curves along which points run, which are one if they lie in the same place."""
    jumps = [_jumps(path, turn) for path in paths]
    ends = np.array([[path.min(axis=0), path.max(axis=0)] for path in paths])
    extent = ends[:, 1].max(axis=0) - ends[:, 0].min(axis=0)
    return max(jumps) if (np.ptp(ends, axis=0) <= LEFT * extent).all() else sum(jumps)


def _jumps(points: np.ndarray, turn: float) -> int:
    """Number of jumps of the closed curve along which points run."""
    steps = _steps(points, turn)
    beside = np.minimum(np.roll(steps, 1, axis=0), np.roll(steps, -1, axis=0))
    return int(((steps > JUMP * _extent(points)) & (steps > APART * beside)).any(axis=1).sum())


def _follows(points: np.ndarray, turn: float) -> bool:
    """Whether points run along a curve in the order of their angle, and any part of them along all of it."""
    extent = _extent(points)

    def ways(parts: int) -> np.ndarray:
        return np.array([_way(part, turn) / extent for part in np.array_split(points, parts)])

    (way,), halves = ways(1), ways(2)
    if not ((way <= LONGEST) & (way - halves.min(axis=0) <= LONGER)).all():
        return False
    if not ((halves.mean(axis=0) - ways(4).mean(axis=0)) / 2 <= LONGER).all():
        return False
    return bool(_gap(len(points), turn) * RESOLVED * way.max() <= 1.0)


def comes_back(points: np.ndarray, stays: float = STAYS) -> bool:
    """Whether points come back where they come nearest to the last ones, or come closer from turn to turn.

    The latter, if no more than such a part of their distance ``stays``. So few points as are looked for show neither.
    """
    if len(points) <= LAST:
        return False
    nearby = int(BACK * len(points))
    return _returns(points, nearby, stays, CLOSE) or _returns(points, len(points), 0.0, CLOSE)


def _returns(points: np.ndarray, most: int, stays: float, close: float, extents: np.ndarray | None = None) -> bool:
    """The same for the nearest return after ``most`` points or fewer, to a part ``close`` of the extent.

    ``extents``, shape (W, n): of the curve of each point; default that of all points.
    """
    windows = np.lib.stride_tricks.sliding_window_view(points, LAST, axis=0)
    earlier = windows[:-1][-most:]
    # no window is nearer than its last point, so that few have to be looked at
    least = np.abs(earlier[:, :, -1] - points[-1]).max(axis=1)
    near = np.flatnonzero(least <= np.abs(earlier[least.argmin()] - windows[-1]).max())
    lag = len(earlier) - int(near[np.abs(earlier[near] - windows[-1]).max(axis=(1, 2)).argmin()])
    extent = np.ptp(points, axis=0) if extents is None else extents[lag:]
    apart = (np.abs(points[lag:] - points[:-lag]) / extent).max(axis=1)
    # where a jump lies between two points they are far apart
    before, after = (np.median(part) for part in np.array_split(apart, 2))
    return bool(after <= max(stays * before, close))


def _moves_on(points: np.ndarray, turn: float, waves: int) -> bool:
    """Whether the curve along which points run moves evenly, as along a spiral, and will not have settled soon."""
    points = points / _extent(points)
    middle, quarter, halves = len(points) // 2, len(points) // 4, _halves(points)
    turn, missed = _refined(points, turn, *halves)
    # less than of a curve that moves enough
    if missed <= MOVES / 4:
        return False
    pace, explained = _pace(points, turn, waves, *halves)
    by_halves = explained > EXPLAINED and pace / ALIKE <= _pace(points, turn, waves, *halves, 2)[0] <= ALIKE * pace
    first, of_first = _pace(points, turn, waves, slice(quarter), slice(quarter, middle))
    if not by_halves and of_first <= EXPLAINED:
        return False
    last, of_last = _pace(points, turn, waves, slice(middle, middle + quarter), slice(middle + quarter, None))
    by_quarters = min(of_first, of_last) > EXPLAINED and first / ALIKE <= last <= ALIKE * first
    if not ((by_halves or by_quarters) and (pace if by_halves else last) * len(points) > MOVES):
        return False
    # quarters of fewer points do not tell a pace so well
    settles = quarter >= FEWEST and last <= SLOWER * first
    return not (settles and last * middle / np.log(first / last) <= LEFT)


def _drifts(points: np.ndarray, turn: float) -> bool:
    """Whether the angle in whose order points run along a curve does not advance evenly, as that of a slow chirp.

    That of a torus that is approached falls into its even pace so fast that hardly any of its drift is in the later
    half of the record.
    """
    size, explained = _drift(points, turn)
    if size <= MOVES or explained <= DRIFTS:
        return False
    first, second = (_drift(points[half], turn)[0] for half in _halves(points))
    return second > FALLEN * first


def _drift(points: np.ndarray, turn: float) -> tuple[float, float]:
    """What the drift of an angle makes of points on the curve through others, in their extents, and which part of the
    squares of what they miss that explains."""
    points, every = points / _extent(points), (slice(None, None, 2), slice(1, None, 2))
    turn, _ = _refined(points, turn, *every)
    winds = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, len(points)), WINDS)[:, 1:]
    misses, slope, later, _ = _missed(points, turn, *every, times=winds)
    lacks, columns = misses.ravel(), (slope[:, :, np.newaxis] * later[:, np.newaxis]).reshape(misses.size, WINDS)
    even, drifting = _rest(columns[:, :1], lacks)[1], _rest(columns, lacks)[1]
    return (float(np.sqrt((even - drifting) / len(lacks))), 1 - drifting / even) if even > drifting else (0.0, 0.0)


def _halves(points: np.ndarray) -> tuple[slice, slice]:
    """The earlier and the later half of some points."""
    return slice(len(points) // 2), slice(len(points) // 2, None)


def _refined(points: np.ndarray, turn: float, some: slice, others: slice) -> tuple[float, float]:
    """The turn with which points lie on the curve through others, and by how much they miss it all the same."""
    missed = 0.0
    for _ in range(PASSES):
        misses, slope, later, _ = _missed(points, turn, some, others)
        along = slope * later
        missed = float(np.median(np.abs(misses).max(axis=1))) if len(misses) else 0.0
        # in a few turns of nearly whole numbers angles tell times, and what is drawn through neighbours is hardly later
        missed *= len(points) / 2 / max(float(np.median(np.abs(later))), 1.0) if len(later) else 1.0
        square = float((along**2).sum())
        if missed <= MOVES / 4 or not square > 0:
            break
        step = float((along * misses).sum()) / square
        turn += step
        if step**2 * square <= FINER**2 * float((misses**2).sum()):
            break
    return turn, missed


def _pace(
    points: np.ndarray, turn: float, waves: int, some: slice, others: slice, thin: int = 1
) -> tuple[float, float]:
    """How fast the curve along which points run moves between some of them and others, and what part that explains.

    Returns ``pace``, in extents a point, and ``explained``, part of the squares of what is missed; of the state that
    shows it best.
    """
    misses, slopes, later, angle = _missed(points, turn, some, others, thin)
    phases = 2 * np.pi * np.outer(angle, np.arange(waves + 1))
    moves = np.concatenate([np.cos(phases), np.sin(phases[:, 1:])], axis=1)
    best = (0.0, 0.0)
    for missed, slope in zip(misses.T, slopes.T, strict=True):
        columns = np.column_stack([slope, moves]) * later
        total = _rest(columns[:, :1], missed)[1]
        found, rest = _rest(columns, missed)
        if total > 0 and 1 - rest / total > best[1]:
            best = float(np.sqrt(((moves @ found[1:]) ** 2).mean())), float(1 - rest / total)
    return best


def _missed(
    points: np.ndarray, turn: float, some: slice, others: slice, thin: int = 1, times: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """By how much polynomials through other points, the neighbours of some points by angle, miss these.

    The others are at other times, so that they miss by what the curve has moved meanwhile, and, if the turn is not
    known, along the curve. Of the others every ``thin`` one by angle is taken; what lies at a jump is left out.

    ``times``, shape (W, m): functions of the time; default the number of the point.

    Returns ``misses``, what is missed, ``slope``, what a turn of the angle makes of it, shapes (K, n); ``later``, how
    much more these functions are of the others, shape (K, m), and ``angle``, shape (K,).
    """
    angle, number = _angles(len(points), turn), np.arange(len(points))
    times = number[:, np.newaxis] if times is None else times
    order, most = np.argsort(angle[others], kind="stable")[::thin], NODES // 2
    asked = number[some][np.argsort(angle[some], kind="stable")]
    asked = asked[:: max(1, len(asked) // ASKED)]
    sought = angle[asked]
    a, x, t = (one[others][order] for one in (angle, points, times))
    a = np.concatenate([a[-most:] - 1, a, a[:most] + 1])
    x, t = (np.concatenate([one[-most:], one, one[:most]]) for one in (x, t))
    place = np.clip(np.searchsorted(a, sought), most, len(a) - most)
    near, itself = place[:, np.newaxis] + np.arange(-most, most), np.arange(NODES)
    apart = a[near][:, :, np.newaxis] - a[near][:, np.newaxis]
    apart[:, itself, itself] = 1.0
    ratios = (sought[:, np.newaxis] - a[near])[:, np.newaxis] / np.where(apart == 0, np.nan, apart)
    ratios[:, itself, itself] = 1.0
    weight = ratios.prod(axis=2)
    misses = np.einsum("wk,wki->wi", weight, x[near]) - points[asked]
    later = np.einsum("wk,wkm->wm", weight, t[near]) - times[asked]
    slope = (x[place] - x[place - 1]) / (a[place] - a[place - 1])[:, np.newaxis]
    size = np.abs(misses).max(axis=1)
    known = size <= FAR * np.nanmedian(size) if np.isfinite(size).any() else np.zeros(len(size), dtype=bool)
    return misses[known], slope[known], later[known], sought[known]


def _rest(columns: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, float]:
    """Least squares, and the squares that are left."""
    found = np.linalg.lstsq(columns, values, rcond=None)[0]
    return found, float(((values - columns @ found) ** 2).sum())


def _way(points: np.ndarray, turn: np.ndarray | float) -> np.ndarray:
    """Way to and fro of every state along the closed curve, shape (..., n), as turns have."""
    return np.asarray(_steps(points, turn).sum(axis=-2))


def _steps(points: np.ndarray, turn: np.ndarray | float) -> np.ndarray:
    """How far neighbours along it are apart, shape (..., W, n)."""
    path = points[np.argsort(_angles(len(points), turn), kind="stable")]
    back = path[..., :1, :] - path[..., -1:, :]
    return np.asarray(np.abs(np.concatenate([path[..., 1:, :] - path[..., :-1, :], back], axis=-2)))


def _gap(count: int, turn: np.ndarray | float) -> np.ndarray:
    """The widest gap between angles of points, in parts of a turn, shape (...)."""
    angle = np.sort(_angles(count, turn))
    return np.asarray(np.diff(angle, append=angle[..., :1] + 1.0).max(axis=-1))


def _angles(count: int, turn: np.ndarray | float) -> np.ndarray:
    """Angles of points in parts of a turn, shape (..., count); a remainder takes longer."""
    turned = np.multiply.outer(turn, np.arange(count))
    return np.asarray(turned - np.floor(turned))

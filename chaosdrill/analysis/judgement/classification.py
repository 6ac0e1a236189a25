"""Evidence from records, for spectra as for points of grids; `words` beside it makes words of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from chaosdrill.analysis.judgement.recurrence import CLOSE, ROUND_OFF, Recurrence, recurrence, residual_at_largest
from chaosdrill.analysis.judgement.resting import is_still, lengthens, stirs
from chaosdrill.analysis.judgement.stationarity import SAME, departs, shows, stationarity
from chaosdrill.analysis.judgement.statistics import SINKS, STAYS, block_ends, leading
from chaosdrill.analysis.judgement.tori import (
    END,
    LENGTH,
    REPEATS,
    Regularity,
    aside,
    closes,
    closes_for_good,
    examine,
    goes_on,
    only_grows,
    stays,
    stopped,
    turn,
)
from chaosdrill.analysis.judgement.words import FOLDS, Evidence, Selectable, pauses, steady, words
from chaosdrill.analysis.tuning import PLAN
from chaosdrill.dataset import Outcome
from chaosdrill.engine.shifts import Shifts, shifts_of
from chaosdrill.engine.structure import Structure
from chaosdrill.model import HybridSystem

SPLIT = 1e-5
"""Least relative distance between the points of a cycle at which it differs from one of half its period."""

DECAY = 1e-4
"""A transient whose points nearly come back after twice the period of its cycle loses more than this part of its
amplitude meanwhile, at the required distance from the doubling."""

HYPERBOLIC = 1e-5
"""Logarithm of a multiplier, averaged over whole cycles, below which a cycle is attracting."""

NEUTRAL = 1e-6
"""Logarithm of a multiplier, or of the change of an area in a record, that counts as zero."""

BENDS = 1e-3
"""Distance to a cycle, in parts of that between its points and of what its multiplier lacks to 1, at which it is surely
there: beyond a fold the multiplier would be 1 before (Kantorovich's condition, for curvatures of the map up to 500)."""

TURNS = 0.1
"""Part by which the way of a point changes in a period, at least, where it does not go one way, as in a channel."""

USUAL = 64
"""Longest period that is looked for at the end of a record, unless another one is asked for."""

NO_GROWTH = 8.0
"""Logarithm by which the tangent along the flow grows or shrinks in a record at most: on an attractor it is that of the
speed at the end over that at the beginning."""

ZERO = 0.1
"""Part of the largest growth or decay of a tangent up to which that along the flow may be uncertain in the record."""

APART = 0.5
"""Part of the growth or decay that decides which that along the flow has at most."""

PAIRED = 0.1
"""Part of an exponent by which another one differs from its opposite at most where one tangent shrinks as another
grows: shear looks even for a while."""

QUARTER = 0.25
"""Part of a record at whose end chaos is asked to go on as well."""

ENDS = (4, 8, 16, 32)
"""Parts at the end of a record, as one over them, in which it is seen whether it has come to a cycle."""

LOOKS = 16
"""Instants at which it is seen whether a motion goes further than its extent until the next, so that its turns are not
seen."""

OPEN_ANSWERS = (Outcome.TRANSIENT, Outcome.UNDECIDED)
"""Words that leave open what a motion is on."""


def undrawn(system: HybridSystem, states: np.ndarray) -> np.ndarray:
    """States, and what stands behind them in a row, with zeros for those that noise is made of: they say nothing."""
    if not system.noise:
        return states
    states = states.copy()
    states[..., system.free : len(system.state_names)] = 0.0
    return states


@dataclass(frozen=True)
class Averages(Selectable):
    """Exponents of P records, in descending order."""

    exponents: np.ndarray  # (P, m)
    errors: np.ndarray  # (P, m): their standard errors
    late: np.ndarray  # (P, m): growth rates over the later half of the record
    course: np.ndarray  # (P, B + 1, m): logarithms of growth at the beginning and at the ends of blocks of one length
    length: np.ndarray  # (P,): time of the record
    rounding: np.ndarray  # (P,): part of the sizes of states that errors of the run may add up to from point to point
    neutral: np.ndarray  # int (P,): how many are zero whatever the attractor
    complete: bool  # whether there are as many as states


def _paired(exponents: np.ndarray, lead: np.ndarray) -> np.ndarray:
    """Whether another exponent is minus the leading one, as in shear; shape (P,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(exponents + lead[:, np.newaxis]) <= PAIRED * np.abs(lead)[:, np.newaxis]).any(axis=1))


@dataclass(frozen=True)
class Records(Selectable):
    """P records of one system, by their exponents and their last states."""

    system: HybridSystem
    structure: Structure
    shifts: Shifts
    averages: Averages
    windows: np.ndarray  # (P, W, n + 1): states and modes, NaN behind the last
    known: np.ndarray  # (P, n): sizes that states have had on the way
    part: np.ndarray | float = 1.0  # (P,): part of the record that the windows are of


def evidence_of(records: Records, ended: np.ndarray, before: np.ndarray | None = None) -> Evidence:
    """What exponents and states of records say; whether the points come back, and how, is for the caller to add.

    ``ended``, int, shape (P,): what ended the runs, or ``OK``. ``before``, shape (P, n): states long before the record.
    """
    system, structure, shifts, averages = records.system, records.structure, records.shifts, records.averages
    windows, known, part = records.windows, records.known, records.part
    exponents, length = averages.exponents, averages.length
    points, n = len(exponents), system.free
    lead, margin, column = leading(exponents, averages.errors, averages.neutral, length, complete=averages.complete)
    # what grows or moves where only a condition or a step sees it has no tangent that tells
    unseen = structure.symmetries > len(shifts.lines)
    if unseen and exponents.shape[1]:
        nearest = np.abs(exponents).argmin(axis=1)
        column = np.where(lead < 0, nearest, column)
        lead = np.where(lead < 0, exponents[np.arange(points), nearest], lead)
    one_of = (np.arange(points), column)
    late = averages.late[one_of] if exponents.shape[1] else np.zeros(points)
    known_so_far = {"ended": ended, "lead": lead, "margin": margin, "length": length, "late": late}
    found = Evidence.of(points, rounding=averages.rounding, **known_so_far)
    if exponents.shape[1]:
        course = averages.course[one_of[0], :, column]
        quarter = max(1, round(QUARTER * (course.shape[1] - 1)))
        with np.errstate(invalid="ignore"):
            found.quarter = course[:, -1] - course[:, -1 - quarter]
            found.pauses = pauses(course)
            found.steady = steady(course) & ~_paired(exponents, lead)
            # lengths of tangents that turn come and go, also where nothing grows
            area = course + averages.course[one_of[0], :, np.minimum(column + 1, exponents.shape[1] - 1)]
            found.even = (found.steady & (lead > 0)) | (steady(area) & (area[:, -1] > area[:, 0]))
            shrinks = averages.course[:, quarter] - averages.course[:, 0] < -2 * FOLDS
        found.drawn_in = shrinks.any(axis=1) & ~found.steady
    found.noisy[:] = system.draws
    found.lasts[:] = system.forced or system.autonomous
    if averages.complete and exponents.shape[1] and not system.forced and structure.autonomous:
        _add_flow(found, records)
    with np.errstate(invalid="ignore"):
        if averages.complete and contracts(system):
            found.torus_possible = ~(exponents.sum(axis=1) * length < -NEUTRAL)
    # no flow of two states without events is chaotic, nor a forced one of one state
    found.chaos_possible[:] = not _smooth(system) or n > (2 if system.autonomous else 1)
    found.stirs = (ended == Outcome.OK) & stirs(shifts.quotient(windows[:, :, :-1]), shifts.sizes(known), part)
    untold = unseen | (averages.neutral >= exponents.shape[1])
    open_ = np.flatnonzero((ended == Outcome.OK) & (untold | ~found.negative | ~found.lasts))
    states, known = aside(windows[open_], shifts)[:, :, :-1], shifts.sizes(known[open_])
    found.leaving[open_], found.settling[open_] = stationarity(states, known, found.even[open_])
    drifts = only_grows(states, known, None if before is None else shifts.quotient(before[open_]), shifts.bounded)
    found.drifts[open_] = drifts.any(axis=1)
    whole, later = lead[open_], found.late[open_]
    rates = np.stack([whole, later, 2 * whole - later], axis=1)
    found.departs[open_] = departs(states, drifts, rates * (length * part)[open_, np.newaxis])
    return found


def _add_flow(found: Evidence, records: Records) -> None:
    """Add whether there is a zero exponent for the flow of a system without forcing, or all tangents shrink."""
    system, structure, averages = records.system, records.structure, records.averages
    exponents, length = averages.exponents, averages.length
    with np.errstate(invalid="ignore"):
        # a tangent that starts across the flow shrinks before it turns into it
        growth, late = exponents * length[:, np.newaxis], averages.late * length[:, np.newaxis]
        found.sinks = growth[:, 0] < -SINKS
        found.shrinks = (growth[:, 0] < -STAYS) & (late.max(axis=1) < -STAYS)
        by_chance = 3 * averages.errors * length[:, np.newaxis]
        # an error as large as what it is of makes nothing zero
        most = np.maximum(NO_GROWTH, np.minimum(by_chance, ZERO * np.abs(growth).max(axis=1, keepdims=True)))
        zero = np.minimum(np.abs(growth), np.abs(late)) <= most
        # the exponent that decides is not the one along the flow, nor one of a pair with it
        decides = (np.abs(found.lead) > found.margin)[:, np.newaxis] * (found.lead * length)[:, np.newaxis]
        zero &= (growth * np.sign(decides) <= APART * np.abs(decides)) | (decides == 0)
        # what rests but for a shift has no other one
        found.flows = zero.sum(axis=1) >= np.minimum(averages.neutral, max(structure.symmetries, 1))
        # on a line nothing comes back, on a circle it does
        line = system.free == 1 and not structure.symmetries and not len(records.shifts.turns)
        found.flows &= not line or not _smooth(system)


def evidence_of_records(
    records: Records,
    coarse: np.ndarray,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
    passages: np.ndarray | None = None,
) -> Evidence:
    """All that whole records say by themselves, which reached their ends and are not continued.

    Parameters
    ----------
    records : Records
        Their last states, all of a length. Of a map the last `LENGTH` tell, and all where these leave a record open.
    coarse : ndarray, shape (P, B + 1, n)
        States at the beginning of the records and at the ends of their blocks.
    flow : callable, optional
        Rates of the states, as in `examine`, where there is no map.
    passages : ndarray, shape (P, E, n + 1), optional
        States and modes after the events of a transition, as in `add_passages`, of a system free of time.
    """
    system, shifts, averages, known = records.system, records.shifts, records.averages, records.known
    ended = np.full(len(known), int(Outcome.OK))
    whole, coarse = undrawn(system, records.windows), undrawn(system, coarse)
    points = round(whole.shape[1] / records.part)
    windows = whole[:, -LENGTH:] if flow is None else whole
    part = min(1.0, windows.shape[1] / points)
    late = replace(records, windows=windows, part=part)
    e = evidence_of(late, ended, coarse[:, 0])
    if system.draws:
        return e
    if flow is None:
        paths, size = aside(windows, shifts), shifts.sizes(known)
        found = recurrence(paths, size, USUAL, 2 * USUAL, e.rounding)
        cycles = (found.period > 0) & (points % np.maximum(found.period, 1) == 0)
        add_returns(e, found, found.period * averages.length / points, cycles, paths, size)
        add_ends(e, averages, paths, size, part)
        moving = np.flatnonzero(e.leaving | e.settling)
        states = aside(whole[moving], shifts)[:, :, :-1]
        rows, sizes = windows.shape[1], shifts.sizes(known[moving])
        e.leaving[moving], e.settling[moving] = stationarity(
            states[:, -rows:], sizes, e.even[moving], states[:, :-rows]
        )
    add_record(e, whole, known, coarse, shifts, points, flow)
    if passages is not None:
        # along an unstable cycle that round-off does not leave, tangents grow as in chaos
        open_ = np.flatnonzero(np.isin(words(e), (*OPEN_ANSWERS, Outcome.CHAOTIC)))
        add_passages(e, open_, undrawn(system, passages[open_]), known[open_], shifts)
    if flow is not None:
        add_turns(e, late, lambda _, *at: flow(*at))
    add_later(e, late, flow)
    if flow is not None:
        add_turns(e, late, lambda _, *at: flow(*at))
    return e


def add_record(
    e: Evidence,
    windows: np.ndarray,
    known: np.ndarray,
    coarse: np.ndarray,
    shifts: Shifts,
    points: int,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
) -> None:
    """Add what whole records of equal length say by themselves, as in `evidence_of_records`."""
    lengths = [min(LENGTH, windows.shape[1]) if flow is None else windows.shape[1], windows.shape[1]]
    paths, sizes, most = aside(windows[:, -lengths[0] :], shifts), shifts.sizes(known), lengths[0] // REPEATS
    found = recurrence(paths, sizes, most, rounding=e.rounding)
    e.recurs |= found.period > 0
    residual = residual_at_largest(found, np.flatnonzero((found.period > 0) & e.unmoved), paths, sizes, most)
    period = np.where(closes_exactly(e, residual, found.period), found.period, 0)
    e.exact |= stays(paths, sizes, period, e.rounding)
    if lengths[0] < points:
        few = shifts.quotient(coarse)
        few = few * shows(few, shifts.quotient(windows[:, :, :-1]), points)[:, np.newaxis]
        earlier = stationarity(few, shifts.sizes(known))
        e.leaving, e.settling = e.leaving | earlier[0], e.settling | earlier[1]
    drifts, open_ = e.drifts.copy(), np.flatnonzero(~e.positive & ~(e.negative & e.lasts))
    for count in sorted(set(lengths)):
        _add_regularity_of(e, open_, windows[open_, -count:], known[open_], coarse[open_], shifts, points, flow)
        # the whole record tells more of growth than its last points
        e.drifts |= drifts
        open_ = open_[words(e)[open_] == Outcome.UNDECIDED]


def _add_regularity_of(
    e: Evidence,
    which: np.ndarray,
    windows: np.ndarray,
    known: np.ndarray,
    coarse: np.ndarray,
    shifts: Shifts,
    points: int,
    flow: Callable[[np.ndarray, int], np.ndarray] | None,
) -> None:
    """Add what the last points of some records say, see `examine`, and whether the earlier ones agree."""
    asked = e.may_be_torus[which], e.settled[which], e.lasts[which]
    _add_seen(e, which, examine(windows, known, shifts, e.rounding[which], flow, *asked))
    count = windows.shape[1]
    if count < points and flow is None:
        here = np.flatnonzero(e.ordered[which])
        ends = block_ends(points, coarse.shape[1] - 1)
        steps = ends - ends[-1] + count - 1
        # what the record begins with may still be on its way
        early = np.flatnonzero((steps < 0) & (ends > 0))
        goes = goes_on(windows[here], known[here], coarse[here][:, early], steps[early], shifts)
        of = which[here]
        e.ordered[of], e.torus[of] = goes, goes & e.torus[of]


def closes_exactly(e: Evidence, residual: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Whether points come back as exactly as a run allows, by their distances from where they were a period before.

    At steps of a map those of chaos on narrow bands nearly do so, and those beside an unstable cycle: there they come
    back to the last digits, or as exactly as a period of the run allows.
    """
    return residual <= np.where(e.even & e.bounded, np.maximum(SAME, e.rounding * period), ROUND_OFF)


def is_own_period(found: Recurrence) -> np.ndarray:
    """Whether points come back, and so closely that they do not settle on a cycle with a part of the period."""
    return (found.period > 0) & (found.splitting > SPLIT) & (found.residual <= DECAY * found.splitting)


def is_no_channel(
    found: Recurrence, multiplier: np.ndarray, paths: np.ndarray, known: np.ndarray, periods: np.ndarray
) -> np.ndarray:
    """Whether what comes back with these logarithms of multipliers is a cycle, not what one leaves behind at a fold.

    There points come back as nearly, and nearby motions come closer for a while. But they move one way: what comes
    closer from side to side, as beyond a doubling, or turning, is far from a fold however slowly it does so.

    ``multiplier``, shape (P,). ``paths``, ``known``, shapes (P, W, n + 1), (P, n): points that come closer, and sizes,
    as in `recurrence`. ``periods``, int, shape (P,): after how many of the points they come back.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        lacks, bound = -np.expm1(multiplier), BENDS * np.minimum(found.splitting, 1.0)
        closes = (lacks > 0) & (found.residual <= bound * lacks**2)
    open_ = np.flatnonzero((lacks > 0) & ~closes & (found.residual <= bound) & (periods > 0))
    turns = np.minimum(turn(paths[open_], known[open_], periods[open_]), 1.0)
    closes[open_] = (turns > TURNS) & (found.residual[open_] <= bound[open_] * turns**2)
    return np.asarray(closes)


def add_returns(
    e: Evidence, found: Recurrence, lasts: np.ndarray, whole: np.ndarray, paths: np.ndarray, known: np.ndarray
) -> np.ndarray:
    """Add whether the last points come back, and whether nearby motions come closer meanwhile.

    ``found``: periods of the points. ``lasts``, shape (P,): times that these take. ``whole``, bool, shape (P,): whether
    exponents are averages over whole cycles. ``paths``, ``known``, shapes (P, W, n + 1), (P, n): the points and sizes
    that ``found`` is of.

    Returns, bool, shape (P,): whether distances from a whole cycle neither grow nor shrink.
    """
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        multiplier = e.lead * lasts
        distance = found.residual / -np.expm1(np.minimum(multiplier, -1e-300))
        e.recurs = is_own_period(found)
        attracting = np.where(whole, multiplier < -HYPERBOLIC, e.negative)
        e.attracts = e.recurs & attracting & (distance <= CLOSE) & (found.splitting > 10 * distance)
        e.attracts &= is_no_channel(found, multiplier, paths, known, np.where(e.attracts, found.period, 0))
    return np.asarray(whole & (np.abs(multiplier) <= NEUTRAL))


def add_ends(e: Evidence, averages: Averages, paths: np.ndarray, known: np.ndarray, part: np.ndarray | float) -> None:
    """Add whether points of the map come back to round-off in the end, and whether on a cycle to which all come closer.

    ``paths`` and ``known`` are those of the quotient by shifts, and ``part`` is as in `evidence_of`.
    """
    # of what is known to be on a cycle nothing else is asked
    asked = np.flatnonzero(~e.attracts)
    e.stopped[asked] = stopped(paths[asked], known[asked])
    blocks, rows = averages.course.shape[1] - 1, paths.shape[1]
    part = np.broadcast_to(part, len(paths))
    for size in ENDS:
        count = max(END, rows // size)
        left = np.flatnonzero(e.stopped & ~e.arrives)
        if not len(left) or count > rows:
            break
        # of whole blocks
        share = np.maximum(1, np.floor(part[left] * count / rows * blocks)).astype(int)
        with np.errstate(invalid="ignore"):
            grown = averages.course[left, -1] - averages.course[left, blocks - share]
        left = left[grown.max(axis=1, initial=-np.inf) < -2 * FOLDS]
        e.arrives[left] = closes_for_good(paths[left, -count:], known[left], e.rounding[left])


def add_turns(e: Evidence, records: Records, rates: Callable[[int, np.ndarray, int], np.ndarray]) -> None:
    """Add whether turns of motions at instants of any kind lengthen, where nothing but that speaks against a cycle.

    What does not move has no turns. It is on a cycle with the forcing, or along a line, or else passes slowly, unless
    its rates tell that it turns between instants; so may what seems to turn slowly. ``rates``: those of a record, by
    its number, at a state in a mode.
    """
    windows, shifts = records.windows, records.shifts
    asked = np.flatnonzero(words(e) == Outcome.PERIODIC)
    asked = asked[np.isfinite(windows[asked]).all(axis=(1, 2))]
    if len(asked):
        paths = shifts.quotient(windows[asked, :, :-1])
        still, found = is_still(paths), lengthens(paths)
        found[still] = not (records.system.forced or len(shifts.lines))
        interval = (records.averages.length * records.part)[asked] / windows.shape[1]
        for k in np.flatnonzero(found):
            # instants all along the record, the last one too
            rows = windows[asked[k], :: -max(1, windows.shape[1] // LOOKS)]
            flow = [shifts.rates(row[:-1], rates(int(asked[k]), row[:-1].copy(), int(row[-1]))) for row in rows]
            moved, size = interval[k] * np.abs(flow), np.abs(paths[k]).max(axis=0)
            if still[k]:
                found[k] = (moved[0] <= CLOSE * size).all()
            else:
                extent = np.ptp(paths[k], axis=0)
                found[k] = (np.median(moved, axis=0) <= extent)[extent > CLOSE * size].all()
        e.lengthens[asked] |= found


def add_passages(e: Evidence, which: np.ndarray, passages: np.ndarray, known: np.ndarray, shifts: Shifts) -> None:
    """Add what the states and modes after the events of a transition say of some motions, shape (P, E, n + 1).

    Where events move states, instants of a torus or a cycle have no smooth averages and lie on no closed curve; its
    points at the events of one transition come back, from the middle of the record on if it had to settle, or follow an
    angle.
    """
    early, passages = passages[:, :-LENGTH, :-1], passages[:, -LENGTH:]
    paths, sizes = aside(passages, shifts), shifts.sizes(known)
    e.exact[which] |= closes(paths, sizes) | closes(paths[:, paths.shape[1] // 2 :], sizes)
    # one that is drawn in follows it from then on, where all of it is known
    complete, may_turn = paths.shape[1] < LENGTH, ~e.exact[which] & ~e.positive[which]
    for begin, some in ((0, may_turn), (paths.shape[1] // 4, complete & e.drawn_in[which])):
        left = np.flatnonzero(some & may_turn & ~e.ordered[which])
        of = which[left]
        asked = e.may_be_torus[of], e.settled[of]
        seen = examine(passages[left, begin:], known[left], shifts, e.rounding[of], None, *asked)
        may_turn[left] &= ~seen.returns
        # walls with corners cut the tori of billiards, whose tangents do not move; a part alone may be of an exchange
        whole = (begin == 0) | ~(seen.cut & e.unmoved[of])
        e.ordered[of], e.torus[of] = e.ordered[of] | (seen.ordered & whole), e.torus[of] | (seen.torus & whole)
        e.converges[of] |= seen.converges
    # earlier ones of a torus lie on its curve as well
    if count := early.shape[1]:
        in_order, steps = np.flatnonzero(e.ordered[which]), np.arange(count // 8, count, max(1, count // PLAN.blocks))
        others, of = early[in_order][:, steps], which[in_order]
        goes = goes_on(passages[in_order], known[in_order], others, steps - count, shifts)
        e.ordered[of], e.torus[of] = goes, goes & e.torus[of]


def add_later(e: Evidence, records: Records, flow: Callable[[np.ndarray, int], np.ndarray] | None = None) -> None:
    """Add what motions that are open so far have reached by the later half of these last points of their record.

    Or of a torus, if others than the tangent that tells shrink, by the end of the first quarter. Instants of any kind,
    of which the ``flow`` tells the rates, come back to a cycle only by chance; they lie on a closed curve there.
    """
    windows, known, shifts, part = records.windows, records.known, records.shifts, records.part
    half = windows.shape[1] // 2
    # a part of an exchange of intervals seems a torus, more rarely the longer it is; tangents do not tell the two apart
    for begin, some in ((half, e.moved_before), (half // 2, (part == 1.0) & e.drawn_in & ~e.moved_before)):
        which = np.flatnonzero(np.isin(words(e), OPEN_ANSWERS) & (some | (begin == half)))
        paths, sizes = aside(windows[which, begin:], shifts), shifts.sizes(known[which])
        if flow is None:
            e.cycle_reached[which] |= closes_for_good(paths, sizes, e.rounding[which])
        of = which[~e.cycle_reached[which] & ~np.any(stationarity(paths[:, :, :-1], sizes), axis=0)]
        asked = e.may_have_reached_torus[of] & some[of], False, e.lasts[of]
        seen = examine(windows[of, begin:], known[of], shifts, e.rounding[of], flow, *asked)
        seems = seen.ordered & ~(seen.cut & e.unmoved[of]) | seen.torus & seen.converges
        e.torus_reached[of] = some[of] & seems
        e.cycle_reached[of] |= (seen.line | seen.curve & (e.late[of] < 0) & ~e.unmoved[of]) & seen.converges


def _smooth(system: HybridSystem) -> bool:
    """Whether nothing but the flow moves the states."""
    return len(system.modes) == 1 and all(t.marks_only() for t in system.transitions)


def contracts(system: HybridSystem) -> bool:
    """Whether the flow of a forced system of two states shrinks or stretches all areas alike.

    A closed curve that it maps to itself encloses an area that it maps to itself, so that there is no torus where it
    shrinks them; one that goes round with an angle, or from mode to mode as with hysteresis, encloses none.
    """
    if not system.forced or system.autonomous or len(system.state_names) != 2:
        return False
    if len(shifts_of(system, but_of=()).turns):
        return False
    if "contracts" not in system.shared:
        free = {*system.states, system.time}
        rates = [sum(field[x].diff(x) for x in system.states).expand() for field in system.modes.values()]
        even = rates[0].free_symbols.isdisjoint(free) and all(rate == rates[0] for rate in rates)
        system.shared["contracts"] = even and _keeps_areas(system)
    return bool(system.shared["contracts"])


def _keeps_areas(system: HybridSystem) -> bool:
    """Whether events change no area, and the states, or the time, tell the mode.

    A surface is then crossed both ways, at a speed that is the same on both sides.
    """
    from chaosdrill.model.crossings import same_surface

    if any(t.reset or t.condition is not None for t in system.transitions):
        return False
    states = set(system.states)
    ways = [(mode, t) for t in system.transitions for mode in t.source if mode != t.target]
    for mode, t in ways:
        if not t.guard.free_symbols & states:
            continue
        there, here = system.modes[t.target], system.modes[mode]
        jump = sum(t.guard.diff(x) * (there[x] - here[x]) for x in system.states).expand()
        back = [other.guard for before, other in ways if before == t.target and other.target == mode]
        if not any(same_surface((guard, t.guard)) for guard in back):
            return False
        if jump != 0 and not same_surface((jump, t.guard)):
            return False
    return True


def add_regularity(
    e: Evidence,
    which: np.ndarray,
    windows: np.ndarray,
    known: np.ndarray,
    shifts: Shifts,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
) -> None:
    """Add what longer records of some points say, see `examine`."""
    _add_seen(e, which, examine(windows, known, shifts, e.rounding[which], flow, lasts=e.lasts[which]))
    e.leaving[which], e.settling[which] = stationarity(aside(windows, shifts)[:, :, :-1], shifts.sizes(known))


def _add_seen(e: Evidence, which: np.ndarray, seen: Regularity) -> None:
    """Add what was found of some points."""
    e.drifts[which], e.long_cycle[which] = seen.drifts, seen.long_cycle
    # pieces of an exchange of intervals, in which tangents do not move, follow one angle for a while
    whole = ~(seen.cut & e.unmoved[which])
    e.torus[which], e.ordered[which], e.returns[which] = seen.torus & whole, seen.ordered & whole, seen.returns
    e.converges[which], e.agrees[which] = seen.converges, seen.agrees
    e.curve[which], e.line[which] = seen.curve, seen.line


def add_rests(e: Evidence, rest: np.ndarray, unmoved: np.ndarray, left: Callable[[int], bool]) -> None:
    """Add what it says of motions that no event has moved whether they rest, and whether a rest is left again.

    ``rest``, ``unmoved``, bool, shape (P,). ``left``: whether the rest of a point, by its number, is left; see
    `chaosdrill.analysis.judgement.resting.is_left`.
    """
    e.sinks &= rest | ~unmoved
    for k in np.flatnonzero(rest & unmoved).tolist():
        e.stirs[k] |= left(k)

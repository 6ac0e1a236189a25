"""Evidence from records, and what points of a grid are on by it.

Neither exponents nor recurrence decide alone. Before a period doubling a slow transient alternates about the cycle, so
that its points come back after two periods to any tolerance that is wider than its slow decay; near any bifurcation the
exponent of a short run has no sign; in chaos a laminar stretch repeats for a while. What is not beyond doubt is left
undecided here. The word itself is given by `chaosdrill.analysis.words`, for spectra as for points.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.analysis.recurrence import CLOSE, FLOOR, ROUND_OFF, Recurrence, recurrence
from chaosdrill.analysis.resting import is_left, lengthens, rests, stirs
from chaosdrill.analysis.stationarity import departs, stationarity
from chaosdrill.analysis.statistics import SINKS, STAYS, error_of_exponents, leading
from chaosdrill.analysis.tori import LEAST, REPEATS, Regularity, aside, closes, examine, only_grows, stopped
from chaosdrill.analysis.words import Evidence, words
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.shifts import Shifts
from chaosdrill.engine.structure import Structure
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.plan import Plan

SPLIT = 1e-5
"""Least relative distance between the points of a cycle at which it differs from one of half its period."""

DECAY = 1e-4
"""A transient whose points nearly come back after twice the period of its cycle loses more than this part of its
amplitude meanwhile, at the required distance from the doubling."""

NEUTRAL = 1e-6
"""Logarithm of a multiplier that counts as zero, and of an area that shrinks in a record."""

HYPERBOLIC = 1e-5
"""Logarithm of a multiplier, averaged over whole cycles, below which a cycle is attracting."""


NO_GROWTH = 8.0
"""Logarithm by which the tangent along the flow grows or shrinks in a record at most: on an attractor it is that of the
speed at the end over that at the beginning."""

ZERO = 0.1
"""Part of the largest growth or decay of a tangent up to which that along the flow may be uncertain in the record."""

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
class Averages:
    """Exponents of P records, in descending order."""

    exponents: np.ndarray  # (P, m)
    errors: np.ndarray  # (P, m): their standard errors
    late: np.ndarray  # (P, m): growth rates over the later half of the record
    length: np.ndarray  # (P,): time of the record
    neutral: np.ndarray  # int (P,): how many are zero whatever the attractor
    complete: bool  # whether there are as many as states


def evidence_of(
    system: HybridSystem,
    structure: Structure,
    shifts: Shifts,
    averages: Averages,
    windows: np.ndarray,
    known: np.ndarray,
    ended: np.ndarray,
    before: np.ndarray | None = None,
    part: np.ndarray | float = 1.0,
) -> Evidence:
    """What exponents and states of records say; whether the points come back, and how, is for the caller to add.

    Parameters
    ----------
    windows : ndarray, shape (P, W, n + 1)
        States and modes of the record; NaN behind the last.
    known : ndarray, shape (P, n)
        Sizes that states have had on the way.
    ended : ndarray of int, shape (P,)
        What ended the runs, or ``OK``.
    before : ndarray, shape (P, n), optional
        States long before the record.
    part : float or ndarray, shape (P,)
        Part of the record that the windows are of.
    """
    exponents, length = averages.exponents, averages.length
    points, n = len(exponents), system.free
    lead, margin, column = leading(exponents, averages.errors, averages.neutral, length, complete=averages.complete)
    one_of = (np.arange(points), column)
    late = averages.late[one_of] if exponents.shape[1] else np.zeros(points)
    found = Evidence.of(points, ended=ended, lead=lead, margin=margin, length=length, late=late)
    found.noisy[:] = system.draws
    unforced = not system.forced and structure.autonomous
    with np.errstate(invalid="ignore"):
        if unforced and averages.complete and exponents.shape[1]:
            # a tangent that starts across the flow shrinks before it turns into it
            growth, late = exponents * length[:, np.newaxis], averages.late * length[:, np.newaxis]
            found.sinks = growth[:, 0] < -SINKS
            found.shrinks = (growth[:, 0] < -STAYS) & (late.max(axis=1) < -STAYS)
            by_chance = 3 * averages.errors * length[:, np.newaxis]
            # an error as large as what it is of makes nothing zero
            most = np.maximum(NO_GROWTH, np.minimum(by_chance, ZERO * np.abs(growth).max(axis=1, keepdims=True)))
            zero = np.minimum(np.abs(growth), np.abs(late)) <= most
            # what rests but for a shift has no other one
            found.flows = zero.sum(axis=1) >= np.minimum(averages.neutral, max(structure.symmetries, 1))
            # on a line nothing comes back
            found.flows &= n > 1 or structure.symmetries > 0 or not _smooth(system)
        if averages.complete and contracts(system):
            found.torus_possible = ~(exponents.sum(axis=1) * length < -NEUTRAL)
    found.chaos_possible = np.full(points, _chaos_possible(system, n))
    found.stirs = (ended == Outcome.OK) & stirs(shifts.quotient(windows[:, :, :-1]), shifts.sizes(known))
    # what grows where only a condition or a step sees it has no tangent that tells
    unseen = structure.symmetries > len(shifts.lines)
    open_ = np.flatnonzero((ended == Outcome.OK) & (unseen | ~(found.lead < -found.margin)))
    states, known = aside(windows[open_], shifts)[:, :, :-1], shifts.sizes(known[open_])
    found.leaving[open_], found.settling[open_] = stationarity(states, known)
    begin = None if before is None else shifts.quotient(before[open_])
    drifts = only_grows(states, known, begin, shifts.bounded)
    found.drifts[open_] = drifts.any(axis=1)
    whole, later = lead[open_], found.late[open_]
    rates = np.stack([whole, later, 2 * whole - later], axis=1)
    found.departs[open_] = departs(states, drifts, rates * (length * part)[open_, np.newaxis])
    return found


def evidence_of_records(
    system: HybridSystem,
    structure: Structure,
    shifts: Shifts,
    averages: Averages,
    windows: np.ndarray,
    known: np.ndarray,
    coarse: np.ndarray,
    part: float,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
    passages: np.ndarray | None = None,
) -> Evidence:
    """All that whole records say by themselves, which reached their ends and are not continued.

    Parameters
    ----------
    windows, known
        As in `evidence_of`; the last states, all of a length, which are this ``part`` of the records.
    coarse : ndarray, shape (P, B + 1, n)
        States at the beginning of the records and at the ends of their blocks.
    flow : callable, optional
        Rates of the states, as in `examine`, where there is no map.
    passages : ndarray, shape (P, E, n + 1), optional
        States and modes after the events of a transition, as in `add_passages`, of a system free of time.
    """
    ended = np.full(len(windows), int(Outcome.OK))
    windows, coarse = undrawn(system, windows), undrawn(system, coarse)
    e = evidence_of(system, structure, shifts, averages, windows, known, ended, coarse[:, 0], part)
    leaving, settling = e.leaving, e.settling
    if part < 1.0:
        earlier = stationarity(shifts.quotient(coarse), shifts.sizes(known))
        e.leaving, e.settling = leaving | earlier[0], settling | earlier[1]
    if system.draws:
        return e
    found = recurrence(aside(windows, shifts), shifts.sizes(known), windows.shape[1] // REPEATS)
    e.recurs = found.period > 0
    e.exact = e.recurs & (found.residual <= ROUND_OFF)
    e.stopped = stopped(aside(windows, shifts), shifts.sizes(known))
    unclear = np.flatnonzero(~e.positive & ~e.negative)
    drifts = e.drifts.copy()
    _add_seen(e, unclear, examine(windows[unclear], known[unclear], shifts, flow), flow is None)
    # the whole record tells more of growth than its last points
    e.drifts |= drifts
    e.leaving[unclear], e.settling[unclear] = leaving[unclear], settling[unclear]
    if passages is not None:
        # along an unstable cycle that round-off does not leave, tangents grow as in chaos
        open_ = np.flatnonzero(np.isin(words(e), (*OPEN_ANSWERS, Outcome.CHAOTIC)))
        add_passages(e, open_, undrawn(system, passages[open_]), known[open_], shifts)
    if flow is not None:
        _add_turns(e, windows, shifts)
    open_ = np.flatnonzero(_is_open(e))
    _add_later(e, open_, windows[open_, windows.shape[1] // 2 :], known[open_], shifts, flow)
    if flow is not None:
        _add_turns(e, windows, shifts)
    return e


def _is_open(e: Evidence) -> np.ndarray:
    return np.isin(words(e), OPEN_ANSWERS)


def _add_turns(e: Evidence, windows: np.ndarray, shifts: Shifts, seen: np.ndarray | bool = True) -> None:
    """Add whether turns of motions at instants of any kind lengthen, where nothing but that speaks against a cycle."""
    asked = np.flatnonzero((words(e) == Outcome.PERIODIC) & seen)
    asked = asked[np.isfinite(windows[asked]).all(axis=(1, 2))]
    if len(asked):
        e.lengthens[asked] |= lengthens(shifts.quotient(windows[asked, :, :-1]))


def add_passages(e: Evidence, which: np.ndarray, passages: np.ndarray, known: np.ndarray, shifts: Shifts) -> None:
    """Add what the states and modes after the events of a transition say of some motions, shape (P, E, n + 1).

    Where events move states, instants of a torus or a cycle have no smooth averages and lie on no closed curve; its
    points at the events of one transition come back, from the middle of the record on if it had to settle, or follow an
    angle.
    """
    paths, sizes = aside(passages, shifts), shifts.sizes(known)
    e.exact[which] |= closes(paths, sizes) | closes(paths[:, paths.shape[1] // 2 :], sizes)
    left = np.flatnonzero(~e.exact[which] & ~e.positive[which])
    e.ordered[which[left]] |= examine(passages[left], known[left], shifts).ordered


def _add_later(
    e: Evidence,
    which: np.ndarray,
    later: np.ndarray,
    known: np.ndarray,
    shifts: Shifts,
    flow: Callable[[np.ndarray, int], np.ndarray] | None,
) -> None:
    """Add what some motions have reached by the later half of their record.

    Instants of any kind, of which the ``flow`` tells the rates, come back to a cycle only by chance; they lie on a
    closed curve there.
    """
    paths, sizes = aside(later, shifts), shifts.sizes(known)
    if flow is None:
        found = recurrence(paths, sizes, later.shape[1] // REPEATS)
        e.cycle_reached[which] = (found.period > 0) & (found.residual <= ROUND_OFF)
    leaving, settling = stationarity(paths[:, :, :-1], sizes)
    stays = np.flatnonzero(~e.cycle_reached[which] & ~leaving & ~settling)
    seen = examine(later[stays], known[stays], shifts, flow)
    e.torus_reached[which[stays]] = seen.ordered | seen.torus & seen.converges & ((flow is None) | seen.agrees)
    falls = e.late[which[stays]] < 0
    e.cycle_reached[which[stays]] |= (seen.line | seen.curve & falls & ~e.unmoved[which[stays]]) & seen.converges


def _chaos_possible(system: HybridSystem, n: int) -> bool:
    """Whether a motion can be chaotic: no flow of two states without events is, nor a forced one of one state."""
    return not _smooth(system) or n > (2 if system.autonomous else 1)


def _smooth(system: HybridSystem) -> bool:
    """Whether nothing but the flow moves the states."""
    return len(system.modes) == 1 and all(t.marks_only() for t in system.transitions)


def contracts(system: HybridSystem) -> bool:
    """Whether the flow of a forced system of two states shrinks or stretches all areas alike.

    A closed curve that it maps to itself encloses an area that it maps to itself, so that there is no torus where it
    shrinks them.
    """
    if "contracts" not in system.shared:
        system.shared["contracts"] = _contracts(system)
    return bool(system.shared["contracts"])


def _contracts(system: HybridSystem) -> bool:
    if system.autonomous or len(system.state_names) != 2 or any(t.reset for t in system.transitions):
        return False
    free = {*system.states, system.time}
    rates = [sum(field[x].diff(x) for x in system.states) for field in system.modes.values()]
    return all(not (rate.free_symbols & free) for rate in rates)


@dataclass
class Verdict:
    """What P points are on."""

    outcome: np.ndarray
    """int (P,): their outcome without further steps; an exponent near zero alone does not make a torus."""
    period: np.ndarray  # int (P,)
    decided: np.ndarray  # bool (P,): whether that is beyond doubt
    exponents: np.ndarray  # (P, m): descending spectra
    errors: np.ndarray  # (P, m): their standard errors
    lead: np.ndarray  # (P,): largest exponent that is free to have any sign
    margin: np.ndarray  # (P,): beyond which it differs from zero
    evidence: Evidence
    cycle: np.ndarray  # int (P,): length of the cycle that the record repeats, in units of lengths; 0: unknown, or none
    moves: np.ndarray  # bool (P,): whether nothing says that the motion dies out

    def at(self, which: np.ndarray) -> "Verdict":
        """The verdict on some of the points."""
        parts = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "evidence"}
        return Verdict(evidence=self.evidence.at(which), **{name: values[which] for name, values in parts.items()})


def judge(plan: "Plan", batch: Batch, which: np.ndarray, ends: np.ndarray, before: np.ndarray | None = None) -> Verdict:
    """Judge some points of a batch by the averages over blocks with these ends, and by the section.

    ``before`` are the states of all points before the record, to tell by what only grows.
    """
    paths, size = aside(batch.window[which], plan.shifts), plan.shifts.sizes(batch.sizes[which])
    found = recurrence(paths, size, plan.max_period, 2 * plan.max_period)
    noisy = plan.system.draws
    if not plan.maps or noisy:
        # at the ends of parts of a duration, or where the system itself never repeats, a return tells no period
        found = replace(found, period=np.zeros_like(found.period))
    times = batch.times[which]
    if plan.section is not None and plan.system.forced and not plan.system.autonomous:
        found = replace(found, period=_in_phase(plan, batch, which, found.period, ends))
    cycle, certain, lasts = _cycle_length(plan, batch, which, found.period, ends)
    whole = certain & (_first_whole(ends, cycle) >= 0)
    begin = np.where(whole, _first_whole(ends, cycle), 0)
    averages = _averages(plan, batch, which, begin)
    exponents, errors = averages.exponents, averages.errors
    windows, known = undrawn(plan.system, batch.window[which]), batch.sizes[which]
    early = None if before is None else undrawn(plan.system, before[which])
    points = batch.counts[which][:, sorted(plan.section)].sum(axis=1) if plan.section is not None else ends[-1]
    part = np.minimum(1.0, windows.shape[1] / np.maximum(points, 1))
    e = evidence_of(
        plan.system, plan.structure, plan.shifts, averages, windows, known, batch.outcome[which], early, part
    )
    e.measured[:] = plan.exponents > 0
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        multiplier = e.lead * lasts
        distance = found.residual / -np.expm1(np.minimum(multiplier, -1e-300))
        split = (found.splitting > SPLIT) & (found.residual <= DECAY * found.splitting)
        e.recurs = (found.period > 0) & split
        neutral = whole & (np.abs(multiplier) <= NEUTRAL)
        e.exact = e.recurs & (_residual(plan, paths, size, found, e.recurs & neutral) <= ROUND_OFF)
        attracting = np.where(whole, multiplier < -HYPERBOLIC, e.negative)
        e.attracts = attracting & (distance <= CLOSE) & (found.splitting > 10 * distance)
        centre = e.recurs & neutral & (found.residual <= ROUND_OFF)
    e.winds = _winds(plan, batch, which) & ~e.recurs & ~e.noisy
    e.rests, moves = _at_rest(plan, batch, which, e, before)
    e.ended = np.where(e.rests, int(Outcome.OK), e.ended)
    if not plan.max_extension and plan.maps and plan.section is None and not noisy:
        _look_closer(plan, e, windows, known)
    if not plan.maps and not plan.system.forced and not noisy:
        # turns between two instants are not seen
        _add_turns(e, windows, plan.shifts, batch.length[which] <= windows.shape[1] * plan.where.unit)
    outcome = words(e)
    if batch.counts_returns:
        grazed = np.array([plan.where.grazed(of_one) for of_one in times], dtype=bool)
        outcome[grazed & (batch.outcome[which] == Outcome.OK)] = int(Outcome.NO_RETURN)
        exponents[grazed], errors[grazed] = np.nan, np.nan
    periodic = outcome == Outcome.PERIODIC
    decided = (periodic & ((e.recurs & e.attracts) | centre)) | ((outcome == Outcome.CHAOTIC) & ~e.recurs)
    decided |= ((outcome == Outcome.QUASIPERIODIC) & e.winds) | (outcome == Outcome.CONTRACTING)
    if not plan.maps:
        decided |= periodic & e.negative
    ended = ~np.isin(outcome, MEASURED)
    decided = (decided & moves) | (outcome == Outcome.EQUILIBRIUM) & e.rests | ended | ~e.measured
    repeats = periodic & e.recurs & ((e.lead < e.margin) | e.exact | ~e.measured)
    period = np.where(repeats, found.period, 0)
    return Verdict(
        outcome=outcome,
        period=period,
        decided=decided,
        exponents=exponents,
        errors=errors,
        lead=e.lead,
        margin=e.margin,
        evidence=e,
        cycle=np.where(certain & (period > 0), cycle, 0),
        moves=moves,
    )


def _residual(plan: "Plan", windows: np.ndarray, known: np.ndarray, found: Recurrence, whole: np.ndarray) -> np.ndarray:
    """Residuals, of some points relative to the sizes that the states have had, from which round-off may come."""
    residual = found.residual.copy()
    rows = np.flatnonzero(whole)
    if len(rows):
        residual[rows] = recurrence(windows[rows], known[rows] / FLOOR, plan.max_period, 2 * plan.max_period).residual
    return residual


def _averages(plan: "Plan", batch: Batch, which: np.ndarray, begin: np.ndarray) -> Averages:
    """Exponents from the beginning of a block to the end, with errors from all blocks, point by point."""
    sums, times, length = batch.sums[which], batch.times[which], batch.length[which]
    with np.errstate(invalid="ignore", divide="ignore"):
        exponents = _means(sums, begin, times)
        late = _means(sums, np.full(len(which), (times.shape[1] - 1) // 2), times)
        spans = np.diff(times, axis=1)
        rates = np.diff(sums, axis=1) / spans[..., np.newaxis]
        if batch.counts_returns:
            # blocks that last longer count more
            apart = rates - (sums[:, -1] / length[:, np.newaxis])[:, np.newaxis]
            rates = apart * (spans / spans.mean(axis=1, keepdims=True))[..., np.newaxis]
        rates = np.where(np.isfinite(rates), rates, np.nan).transpose(1, 0, 2)
        errors = error_of_exponents(rates, plan.numerics, batch.steps[which], length)
    order = np.argsort(-exponents, axis=1, kind="stable")
    exponents, errors, late = (np.take_along_axis(one, order, 1) for one in (exponents, errors, late))
    neutral = np.full(len(which), plan.structure.most_neutral)
    if plan.structure.autonomous and plan.structure.symmetries:
        neutral = plan.structure.neutral(batch.flow(which))
    return Averages(exponents, errors, late, length, neutral, plan.computed == plan.system.free)


def _look_closer(plan: "Plan", e: Evidence, windows: np.ndarray, known: np.ndarray) -> None:
    """Look for tori and long cycles in sufficiently long records whose exponent is indistinguishable from zero."""
    rows = np.isfinite(windows[:, :, 0]).sum(axis=1)
    unclear = np.flatnonzero(~e.positive & ~e.negative & ~e.recurs & (rows >= LEAST) & (rows == windows.shape[1]))
    if len(unclear):
        add_regularity(e, unclear, windows[unclear], known[unclear], plan.shifts)


def add_regularity(
    e: Evidence,
    which: np.ndarray,
    windows: np.ndarray,
    known: np.ndarray,
    shifts: Shifts,
    flow: Callable[[np.ndarray, int], np.ndarray] | None = None,
) -> None:
    """Add what longer records of some points say, see `examine`."""
    _add_seen(e, which, examine(windows, known, shifts, flow), flow is None)
    e.leaving[which], e.settling[which] = stationarity(aside(windows, shifts)[:, :, :-1], shifts.sizes(known))


def _add_seen(e: Evidence, which: np.ndarray, seen: Regularity, strobed: bool) -> None:
    """Add what was found of some points, at strobes or at instants of any kind."""
    e.drifts[which], e.long_cycle[which] = seen.drifts, seen.long_cycle
    e.torus[which], e.converges[which], e.agrees[which] = seen.torus, seen.converges, seen.agrees
    e.curve[which], e.line[which], e.ordered[which], e.returns[which] = (
        seen.curve,
        seen.line,
        seen.ordered,
        seen.returns,
    )
    if not strobed:
        # instants of a short laminar phase may look like those of a torus
        e.torus[which] &= seen.agrees | e.unmoved[which]


def _winds(plan: "Plan", batch: Batch, which: np.ndarray) -> np.ndarray:
    """Whether nothing but phases moves, point by point."""
    if not (plan.structure.autonomous and plan.structure.symmetries):
        return np.zeros(len(which), dtype=bool)
    return plan.structure.winds(batch.flow(which))


def _at_rest(
    plan: "Plan", batch: Batch, which: np.ndarray, e: Evidence, before: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Which points of a system without forcing are at rest, and which go on moving for all that is known.

    A motion that neither rests nor ends has a zero exponent, that of the flow (Haken 1983,
    doi:10.1016/0375-9601(83)90209-8).
    """
    if plan.system.forced or not plan.structure.autonomous:
        return np.zeros(len(which), dtype=bool), np.ones(len(which), dtype=bool)
    went = np.isin(batch.outcome[which], (Outcome.OK, Outcome.NO_RETURN))
    with np.errstate(invalid="ignore"):
        rest = went & rests(batch.x[which], batch.sizes[which], batch.flow(which), plan.where.unit)
    moving = [i for i, t in enumerate(plan.system.transitions) if not t.marks_only()]
    unmoved = batch.counts[which][:, moving].sum(axis=1) == 0

    def left(k: int) -> bool:
        p = int(which[k])
        at = partial(batch.rates, p, mode=int(batch.mode[p]))
        return is_left(at, batch.x[p], batch.sizes[p], None if before is None else before[p])

    add_rests(e, rest, unmoved, left)
    rest &= ~e.stirs
    return rest, ~(rest | e.sinks | e.shrinks) | e.stirs


def add_rests(e: Evidence, rest: np.ndarray, unmoved: np.ndarray, left: Callable[[int], bool]) -> None:
    """Add what it says of motions that no event has moved whether they rest, and whether a rest is left again.

    Parameters
    ----------
    rest, unmoved : ndarray of bool, shape (P,)
    left : callable
        Whether the rest of a point, by its number, is left; see `chaosdrill.analysis.resting.is_left`.
    """
    e.sinks &= rest | ~unmoved
    for k in np.flatnonzero(rest & unmoved).tolist():
        e.stirs[k] |= left(k)


def _cycle_length(
    plan: "Plan", batch: Batch, which: np.ndarray, period: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Length of a cycle with a number of iterates, in units of lengths, whether it is certain, and its duration."""
    each = batch.length[which] / ends[-1]
    if plan.section is None or batch.counts_returns:
        return period, period > 0, period * each
    crossings = np.maximum(batch.counts[which][:, sorted(plan.section)].sum(axis=1), 1)
    length = int(ends[-1]) * period / crossings
    if not plan.system.forced:
        return np.zeros_like(period), np.zeros(len(which), dtype=bool), length * each
    cycle = np.rint(length).astype(int)
    # a crossing more or less in the record moves the estimate by this much
    certain = (cycle > 0) & (np.abs(length - cycle) <= (length + 1) / crossings)
    return cycle, certain, cycle * each


def _in_phase(plan: "Plan", batch: Batch, which: np.ndarray, period: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The least multiples of periods that take whole forcing periods, 0 where none does.

    What comes back to a section at another phase of the forcing goes on otherwise.
    """
    answer = np.zeros_like(period)
    for p in np.flatnonzero(period).tolist():
        times = batch.times[which[p]] / batch.period[which[p]]
        points = int(batch.counts[which[p], sorted(plan.section or ())].sum())
        for multiple in range(period[p], plan.max_period + 1, period[p]):
            begin = int(_first_whole(ends, np.array([multiple]))[0]) if batch.counts_returns else 0
            # the number of points in a record of whole forcing periods
            of = int(ends[-1] - ends[begin]) if batch.counts_returns else points
            turns = (times[-1] - times[begin]) * multiple / max(of, 1)
            # where no part of a record is whole nothing can be said against it
            if abs(turns - np.rint(turns)) <= CLOSE if begin >= 0 else multiple == period[p]:
                answer[p] = multiple
                break
    return answer if batch.counts_returns else np.where(answer > 0, answer, period)


def _first_whole(ends: np.ndarray, cycle: np.ndarray) -> np.ndarray:
    """The first block from which the record consists of whole cycles of a length; -1 without one."""
    fits = (ends[-1] - ends[:-1]) % np.maximum(cycle, 1)[:, np.newaxis] == 0
    return np.where(fits.any(axis=1) & (cycle > 0), fits.argmax(axis=1), -1)


def _means(sums: np.ndarray, begin: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Mean growth rates from the beginning of a block to the end, -inf where rank was lost; shape (P, m)."""
    last, rows = sums[:, -1], np.arange(len(sums))
    growth = last - sums[rows, begin]
    time = times[:, -1] - times[rows, begin]
    return np.where(np.isneginf(last), -np.inf, growth / time[:, np.newaxis])

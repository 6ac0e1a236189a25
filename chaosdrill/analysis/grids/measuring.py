"""Points are measured until the kind of their motion is decided.

A point that is undecided after its record is not final. First the cycle that it seems to approach is sought
(`chaosdrill.analysis.grids.cycles`). Without one the run continues, and its record doubles each time, up to
``max_extension`` times the length asked for. Only undecided points pay for that.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from chaosdrill.analysis.grids.cycles import Begun, Cycles, at_points, continued, escapes, linearised, search, stands
from chaosdrill.analysis.grids.judging import Verdict, averages_of, errors_of, judge, last_rows
from chaosdrill.analysis.grids.matching import moments
from chaosdrill.analysis.grids.plan import Plan
from chaosdrill.analysis.judgement.classification import (
    OPEN_ANSWERS,
    Records,
    add_passages,
    add_regularity,
    evidence_of_records,
    undrawn,
)
from chaosdrill.analysis.judgement.recurrence import CLOSE, sizes
from chaosdrill.analysis.judgement.statistics import block_ends, error_of_mean_rate, whole_cycles
from chaosdrill.analysis.judgement.tori import LENGTH
from chaosdrill.analysis.judgement.words import DIGITS, Evidence, words
from chaosdrill.analysis.tuning import CYCLES, PLAN
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.dataset.schema import names_of_errors
from chaosdrill.engine.batch import Batch, alike
from chaosdrill.engine.run import rate_names

Arrays = dict[str, np.ndarray]

SIDE = np.array([1.0, 0.7, -0.8, 0.6, -0.9])
"""Direction in which a followed state is displaced from what is unstable: one that no system knows of."""


def point_columns(plan: Plan) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Dtype and shape of everything that is known of one point."""
    n = len(plan.system.state_names)
    return {
        "section": ("f8", (plan.rows, n)),
        "period": ("i2", ()),
        "outcome": ("i1", ()),
        "lyapunov_exponent": ("f8", (plan.exponents,)),
        "lyapunov_error": ("f8", (plan.exponents,)),
        **dict.fromkeys(mean_names(plan), ("f8", ())),
        "moments": ("f8", (4, len(plan.shifts.bounded))),
        "state": ("f8", (n,)),
        "lead": ("f8", ()),
        "ended_by": ("i2", (2,)),
    }


def measure(
    plan: Plan,
    parameters: Mapping[str, np.ndarray],
    starts: np.ndarray,
    modes: np.ndarray,
    before: Batch | None = None,
    beside: np.ndarray | None = None,
) -> tuple[Arrays, Batch]:
    """Everything that is known of some points, and their runs.

    ``parameters``, shape (P,). ``starts``, ``modes``, shapes (P, n) and (P,). ``before``: runs whose attractors are
    followed; then all points must share compiled functions. ``beside``, shape (n,): how far beside these the runs
    begin, in parts of the sizes of the states.

    Returns: ``arrays``: as `point_columns` declares them, NaN (and period 0) where a point has no result. ``batch``:
    the runs of the last group of points that share compiled functions.
    """
    points = len(starts)
    arrays = {name: np.zeros((points, *shape), dtype) for name, (dtype, shape) in point_columns(plan).items()}
    for group in alike(plan.system, parameters, points):
        here = {name: np.asarray(values)[group] for name, values in parameters.items()}
        batch = plan.batch(here, starts[group], modes[group])
        if before is not None:
            batch.continue_from(before)
            batch.x[:] += 0.0 if beside is None else beside * batch.sizes
        _settle(_Group(plan, here, batch, arrays, group))
    return arrays, batch


@dataclass
class _Group:
    """Points that share compiled functions, while they are measured: their runs, and where their results go."""

    plan: Plan
    parameters: Mapping[str, np.ndarray]  # (P,)
    batch: Batch  # a run for each
    arrays: Arrays  # results of all points there are, as `point_columns` declares them
    places: np.ndarray  # int (P,): where in these, point by point

    @property
    def outcomes(self) -> np.ndarray:
        """Outcomes so far, shape (P,)."""
        return self.arrays["outcome"][self.places]

    def tell(self, which: np.ndarray, outcomes: np.ndarray | Outcome) -> None:
        """Give some points another outcome."""
        self.arrays["outcome"][self.places[which]] = outcomes

    def write(self, which: np.ndarray, verdict: Verdict, cycles: Cycles | None = None) -> None:
        """Keep the results of some points, whose verdict this is; of runs over the ``cycles`` that were found there."""
        places = self.places[which]
        of = (self.batch, which) if cycles is None else (cycles.batch, cycles.places)
        for name, values in _results(self.plan, *of, verdict).items():
            self.arrays[name][places] = values

    def write_cycles(self, which: np.ndarray, cycles: Cycles) -> np.ndarray:
        """Keep the results of some points that are on cycles; return those of ``which`` that are left."""
        self.write(cycles.which, cycles.verdict.at(cycles.places), cycles)
        return np.setdiff1d(which, cycles.which)

    def average_over_cycles(self, which: np.ndarray, cycle: np.ndarray, record: int) -> None:
        """Mean rates over one cycle more, where the record of a cycle is no whole number of them.

        The ``cycle`` of each and the length of the ``record`` (0 for one that begins beside the section) are in units
        of lengths. A cycle that does not come back keeps the means over its record.
        """
        plan, batch = self.plan, self.batch
        rows = np.flatnonzero((cycle > 0) & ((record == 0) | (record % np.maximum(cycle, 1) != 0)))
        if not len(rows):
            return
        chosen, cycle = which[rows], cycle[rows]
        runs = plan.bare(self.parameters, batch.x, batch.mode)
        runs.stand(batch.standing(np.arange(len(batch.x))))
        for length in np.unique(cycle).tolist():
            runs.proceed(chosen[cycle == length], 0, np.array([0, length]))
        shifts, window = plan.shifts, np.nan_to_num(last_rows(batch.window[chosen], plan.judged)[:, :, :-1])
        size = sizes(shifts.quotient(window), shifts.sizes(batch.sizes[chosen]))
        back = (runs.outcome[chosen] == Outcome.OK) & (runs.mode[chosen] == batch.mode[chosen])
        away = np.abs(shifts.quotient(runs.x[chosen]) - shifts.quotient(batch.x[chosen]))
        back &= (away <= CLOSE * size).all(axis=1)
        rates = event_rates(plan, runs, chosen)
        for name in rates.keys() - {"closest_grazing"}:
            self.arrays[name][self.places[chosen[back]]] = rates[name][back]


@dataclass
class _Known:
    """What the records of the points of a group have shown so far."""

    evidence: Evidence
    grows: np.ndarray  # bool (P,): whether the last one only grew
    leaves: np.ndarray  # bool (P,): whether it still left something
    moves: np.ndarray  # bool (P,): whether nothing says that the motion dies out


def _settle(group: _Group) -> None:
    """Run a group until every point is decided or has been extended as far as it may be."""
    plan = group.plan
    tells = plan.exponents > 0 and not plan.system.draws
    changes = tells and not (plan.system.autonomous or plan.system.forced)
    # a longer record of equations that change is one of other motions
    extended = plan.max_extension > 0 and not changes
    timed = tells and plan.where.counts == "time"
    begun = stands(group.batch, group.parameters) if changes or (timed and not extended) else None
    known, left = _first(group)
    if not extended:
        if begun is not None:
            _look_at_instants(group, begun, known.evidence, left)
        return
    left = _extend(group, known, left)
    if plan.system.draws:
        return
    if plan.maps and known.moves[left].any():
        left = np.union1d(_displace(group, left[known.moves[left]]), left[~known.moves[left]])
    if plan.exponents:
        _tell_apart(group, known.evidence, left)


def _first(group: _Group) -> tuple[_Known, np.ndarray]:
    """What the record that was asked for shows, and the points that it does not decide."""
    plan, batch, every = group.plan, group.batch, np.arange(len(group.places))
    ends, before = plan.ends, batch.x.copy()
    batch.run(plan.transient, ends)
    verdict = judge(plan, batch, every, ends, before)
    group.write(every, verdict)
    beside = plan.where.counts == "section" and plan.transient == 0
    group.average_over_cycles(every, verdict.cycle, 0 if beside else int(ends[-1]))
    e = verdict.evidence
    return _Known(e, verdict.outcome == Outcome.OPEN, e.leaving.copy(), verdict.moves.copy()), every[~verdict.decided]


def _look_at_instants(group: _Group, begun: Begun, evidence: Evidence, left: np.ndarray) -> None:
    """Tell points by as many instants of their record as spectra look at, where their section says too little."""
    plan, batch = group.plan, group.batch
    open_ = left[np.isin(group.outcomes[left], OPEN_ANSWERS)]
    if plan.where.counts == "time":
        each = [(plan.at_instants(), open_)]
    else:
        since = batch.elapsed - batch.length
        each = [(plan.at_instants_of(float(since[p]), float(batch.length[p])), np.array([p])) for p in open_]
    for fine, here in each:
        which = np.arange(len(here))
        runs = begun.at(here, begun.states[here]).instants(fine)
        runs.run(fine.transient, np.array([0]))
        first = runs.x[:, np.newaxis].copy()
        runs.proceed(which, 0, np.array([0, fine.periods]))
        sums = batch.sums_by_size(here)
        averages = averages_of(plan, batch, here, sums, fine.periods, errors_of(plan, batch, here, sums))
        seen_last = runs.window[:, -LENGTH:], runs.sizes, LENGTH / fine.periods
        records = Records(plan.system, plan.structure, plan.shifts, averages, *seen_last)
        for p in which[runs.outcome == Outcome.OK].tolist():
            one, at = np.array([p]), here[[p]]
            seen = evidence_of_records(records.at(one), first[one], partial(runs.rates, p))
            before = evidence.at(at)
            # whether it rests is known from the run with tangents
            seen.ended, seen.rests, seen.sinks, seen.winds = before.ended, before.rests, before.sinks, before.winds
            seen.stirs, seen.lengthens = seen.stirs | before.stirs, seen.lengthens | before.lengthens
            evidence.put(at, seen)
    group.tell(open_, words(evidence.at(open_)))


def _extend(group: _Group, known: _Known, left: np.ndarray) -> np.ndarray:
    """Look for the cycles of the points that are left, else go on, time and again; return those still left then."""
    plan, batch, times = group.plan, group.batch, 2
    while len(left):
        if not plan.system.draws:
            for cycles in search(plan, batch, left[known.moves[left]], group.parameters):
                left = group.write_cycles(left, cycles)
        if times > plan.max_extension or not len(left):
            break
        ends, before = block_ends(plan.periods * times, PLAN.blocks), batch.x.copy()
        batch.proceed(left, 0, ends)
        verdict = judge(plan, batch, left, ends, before)
        grows, leaves = verdict.outcome == Outcome.OPEN, verdict.evidence.leaving.copy()
        _goes_on_leaving(verdict, known.leaves[left])
        # what only grew, and then grows on or cannot be followed any further, is known
        lost = known.evidence.at(left).drifts & ~np.isin(verdict.outcome, MEASURED)
        group.tell(left[lost], Outcome.OPEN)
        certain = (known.grows[left] & grows) | lost
        rows = np.flatnonzero(~certain)
        group.write(left[rows], verdict.at(rows))
        group.average_over_cycles(left[rows], verdict.cycle[rows], ends[-1])
        known.evidence.put(left, verdict.evidence)
        known.grows[left], known.leaves[left], known.moves[left] = grows, leaves, verdict.moves
        left, times = left[~verdict.decided & ~certain], 2 * times
    return left


def _goes_on_leaving(verdict: Verdict, leaves: np.ndarray) -> None:
    """Take chaos back where the record before still ``leaves`` something, bool (P,), and all growth may be from there.

    The points that are kept of a longer record may begin after that.
    """
    e = verdict.evidence
    doubt = leaves & (verdict.outcome == Outcome.CHAOTIC) & (e.late * e.length / 2 <= DIGITS)
    e.leaving |= doubt
    verdict.outcome[doubt], verdict.decided[doubt] = words(e.at(doubt)), False


def _displace(group: _Group, which: np.ndarray) -> np.ndarray:
    """Run the points that leave an unstable cycle from further away; return those that stay undecided."""
    plan = group.plan
    leaving, runs = escapes(plan, group.batch, which, group.parameters)
    if not len(leaving):
        return which
    away = _Group(plan, at_points(group.parameters, leaving), runs, group.arrays, group.places[leaving])
    runs.run(plan.transient, plan.ends)
    verdict = judge(plan, runs, np.arange(len(leaving)), plan.ends)
    rows = np.flatnonzero(verdict.decided & (runs.outcome == Outcome.OK))
    away.write(rows, verdict.at(rows))
    away.average_over_cycles(rows, verdict.cycle[rows], plan.ends[-1])
    left = np.setdiff1d(np.arange(len(leaving)), rows)
    for cycles in search(plan, runs, np.flatnonzero(~verdict.decided & verdict.moves), away.parameters):
        left = away.write_cycles(left, cycles)
    return np.union1d(np.setdiff1d(which, leaving), leaving[left])


def _tell_apart(group: _Group, evidence: Evidence, left: np.ndarray) -> None:
    """Tell points of which exponents and returns say too little by points of the map, by instants or by events."""
    plan, batch, parameters = group.plan, group.batch, group.parameters
    unclear = left[~evidence.at(left).positive & ~evidence.at(left).negative]
    unclear = unclear[np.isin(group.outcomes[unclear], (Outcome.OPEN, Outcome.UNDECIDED, Outcome.TRANSIENT))]
    if not plan.maps:
        # along a cycle tangents grow evenly, and in no chaos but that of constant slopes
        evenly = group.arrays["lyapunov_error"][group.places, 0] * batch.length <= PLAN.evenly
        even = np.flatnonzero((group.outcomes == Outcome.CHAOTIC) & evenly)
        if len(even):
            begun, seen = continued(plan, batch, even, at_points(parameters, even)), evidence.at(even)
            _tell_by_passages(plan, begun, batch.counts[even], np.arange(len(even)), seen)
            group.tell(even, words(seen))
    if len(unclear) and (plan.maps or plan.structure.autonomous):
        found, followed = _tell(plan, parameters, batch, unclear, evidence.at(unclear))
        group.tell(unclear, np.where(followed, found, group.outcomes[unclear]))


def may_be_left(plan: Plan, parameters: Mapping[str, np.ndarray], found: Arrays, batch: Batch, point: int = 0) -> bool:
    """Whether a point that was measured stands on something unstable, which the slightest noise would leave."""
    if plan.system.draws:
        return False
    outcome = int(found["outcome"][point])
    waits = outcome == Outcome.NO_RETURN and plan.structure.autonomous and not plan.system.forced
    if outcome == Outcome.EQUILIBRIUM or waits:
        here = plan.system.with_parameters(**{name: float(values[point]) for name, values in parameters.items()})
        state = batch.x[point] if waits else found["state"][point]
        growth = float(linearised(here, state, int(batch.mode[point])).real.max())
    else:
        growth = float(found["lead"][point])
    unit = batch.period[point] if plan.where.counts != "section" else plan.where.unit
    return outcome not in (Outcome.CHAOTIC, Outcome.OPEN) and growth * unit > PLAN.grows


def beside_unstable(states: int) -> np.ndarray:
    """How far beside what may be unstable a followed state begins, in parts of the sizes of the states, shape (n,)."""
    return CYCLES.displaced * SIDE[np.arange(states) % len(SIDE)]


def _tell(
    plan: Plan, parameters: Mapping[str, np.ndarray], batch: Batch, which: np.ndarray, evidence: Evidence
) -> tuple[np.ndarray, np.ndarray]:
    """Outcomes of points whose exponent cannot be distinguished from zero, by points of the map, and whether these were
    reached.

    Without a map, instants decide, and the events that move their states most often.
    """
    here = at_points(parameters, which)
    begun = continued(plan, batch, which, here)
    runs = begun.mapped(plan, LENGTH)
    runs.run(0, np.array([0, LENGTH]))
    reached = np.flatnonzero(runs.outcome == Outcome.OK)
    if plan.maps:
        add_regularity(evidence, reached, runs.window[reached], runs.sizes[reached], plan.shifts)
    else:
        for p in reached:
            one = np.array([p])
            add_regularity(evidence, one, runs.window[one], runs.sizes[one], plan.shifts, partial(runs.rates, int(p)))
        _tell_by_passages(plan, begun, batch.counts[which], reached, evidence)
    return words(evidence), runs.outcome == Outcome.OK


def _tell_by_passages(plan: Plan, begun: Begun, counts: np.ndarray, which: np.ndarray, evidence: Evidence) -> None:
    """Add what the events say of some points that are undecided, by the transition that each has taken most often."""
    changing = [i for i, t in enumerate(plan.system.transitions) if not t.marks_only()]
    which = which[np.isin(words(evidence)[which], (*OPEN_ANSWERS, Outcome.CHAOTIC))]
    most = np.array(changing)[counts[which][:, changing].argmax(axis=1)] if changing else np.zeros(0)
    for transition in np.unique(most[counts[which, most] > 0] if changing else most).tolist():
        chosen = which[most == transition]
        here = begun.at(chosen, begun.states[chosen])
        runs = here.let(plan.passages(here.parameters, here.states, here.modes, transition))
        runs.run(0, np.array([0, LENGTH]))
        rows = np.flatnonzero(runs.outcome == Outcome.OK)
        add_passages(evidence, chosen[rows], runs.window[rows], runs.sizes[rows], plan.shifts)


def _results(plan: Plan, batch: Batch, which: np.ndarray, verdict: Verdict) -> Arrays:
    """The results of some runs of a batch, whose verdict this is."""
    n, ended, window = len(plan.system.state_names), ~np.isin(verdict.outcome, MEASURED), batch.window[which]
    seen = undrawn(plan.system, last_rows(window, plan.judged))
    of_motion, states = moments(seen, batch.sizes[which], verdict.period, plan.shifts)
    for row in np.flatnonzero(verdict.outcome == Outcome.EQUILIBRIUM):
        states[row], of_motion[row, :3] = batch.rest(int(which[row])), 0.0
        of_motion[row, 0] = plan.shifts.quotient(states[row])
    means = event_rates(plan, batch, which) | rate_errors(plan, batch, which, verdict.cycle)
    return {
        "section": last_rows(window[:, :, :n], plan.rows),
        "period": verdict.period,
        "outcome": verdict.outcome,
        "lyapunov_exponent": verdict.exponents[:, : plan.exponents],
        "lyapunov_error": np.maximum(verdict.errors, verdict.apart)[:, : plan.exponents],
        **{name: np.where(ended, np.nan, values) for name, values in means.items()},
        "moments": of_motion,
        "state": states,
        "lead": verdict.evidence.lead,
        "ended_by": batch.ended_by[which],
    }


def event_rates(plan: Plan, batch: Batch, which: np.ndarray) -> Arrays:
    """Mean rates of some points of a batch, as `chaosdrill.engine.run.event_rates` of a run."""
    transitions = plan.system.transitions
    changing = [i for i, t in enumerate(transitions) if not t.marks_only()]
    counts, length = batch.counts[which], batch.length[which]
    unit = batch.period[which] if plan.system.forced else 1.0
    chosen = (changing, *([i for i in changing if transitions[i].kind == kind] for kind in ("impact", "slip")))
    with np.errstate(invalid="ignore", divide="ignore"):
        values = [counts[:, kinds].sum(axis=1) / (length / unit) for kinds in chosen]
        values += list(batch.integrals[which, -1].T / length)
    values.append(batch.grazing[which][:, changing].min(axis=1, initial=np.inf))
    found = dict(zip(rate_names(plan.system), values, strict=True))
    if plan.section is not None:
        points = counts[:, sorted(plan.section)].sum(axis=1)
        found["return_time"] = np.where(points > 0, length / np.maximum(points, 1), np.nan)
    return found


def rate_errors(plan: Plan, batch: Batch, which: np.ndarray, cycle: np.ndarray) -> Arrays:
    """Standard errors of the mean rates of quadratures of some points of a batch.

    ``cycle`` is the length of the cycle in units of lengths, 0 without one; on a cycle the blocks are whole cycles, if
    there are any.
    """
    found = np.full((len(which), len(plan.system.quadratures)), np.nan)
    for length in np.unique(cycle).tolist():
        here = np.flatnonzero(cycle == length)
        blocks = whole_cycles(batch.ends, length)
        totals, times = (values[which[here]][:, blocks].swapaxes(0, 1) for values in (batch.integrals, batch.times))
        with np.errstate(invalid="ignore", divide="ignore"):
            pace = batch.moved[which[here]] / batch.length[which[here], np.newaxis]
            found[here] = error_of_mean_rate(totals, times[..., np.newaxis], plan.numerics, pace)
    return dict(zip(names_of_errors(plan.system.quadratures), found.T, strict=True))


def mean_names(plan: Plan) -> tuple[str, ...]:
    """Names of the means that are known of every point, and of their errors."""
    errors = names_of_errors(plan.system.quadratures)
    return (*rate_names(plan.system), *errors, *(("return_time",) if plan.section is not None else ()))

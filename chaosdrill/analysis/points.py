"""Points of a grid: each is a run of its own, measured until it is decided what it is on.

A point that is undecided after its record is not believed. First the cycle to which it seems to lead is looked for
(`chaosdrill.analysis.cycles`); if there is none it goes on, over records twice as long every time, up to
``max_extension`` times the length asked for. Only undecided points pay for that.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from chaosdrill.analysis.classification import OPEN_ANSWERS, Verdict, add_passages, add_regularity, judge, undrawn
from chaosdrill.analysis.cycles import Begun, at_points, continued, escapes, linearised, search
from chaosdrill.analysis.matching import KNOWN_BY, count_attractors, moments, number_attractors
from chaosdrill.analysis.plan import BLOCKS, Plan
from chaosdrill.analysis.recurrence import CLOSE, sizes
from chaosdrill.analysis.statistics import block_ends, error_of_mean_rate, whole_cycles
from chaosdrill.analysis.tori import LENGTH
from chaosdrill.analysis.visits import LENGTH as VISITED
from chaosdrill.analysis.visits import merge
from chaosdrill.analysis.words import Evidence, words
from chaosdrill.dataset import Outcome, count_outcomes
from chaosdrill.dataset.outcomes import MEASURED
from chaosdrill.dataset.schema import names_of_errors
from chaosdrill.engine.batch import Batch, alike
from chaosdrill.engine.run import rate_names

Arrays = dict[str, np.ndarray]

AT_ONCE = 4096
"""Points whose runs are held in memory together, at most."""

DISPLACED = 0.02
"""Distance to which a followed state is displaced from an unstable rest or cycle, in parts of the states' sizes."""

SIDE = np.array([1.0, 0.7, -0.8, 0.6, -0.9])
"""Direction in which it is: one that no system knows of."""

GROWS = 1e-6
"""Logarithm by which a distance grows in a unit of the lengths from where on it is unstable."""

EVENLY = 4.0
"""Error of the logarithm of growth in a whole record up to which tangents grow evenly, for all that its ends tell: that
of chaos grows like the root of its length."""

MOST_HELD = 2**26
"""Bytes of their section points, at most."""


@dataclass(frozen=True)
class Axis:
    """Values of a swept parameter, or of a state from which the runs start."""

    name: str
    values: np.ndarray
    of_start: bool = False


class Task(ABC):
    """What tasks of points have in common; a unit is a part of them that is computed together."""

    @property
    @abstractmethod
    def units(self) -> int:
        """How many there are."""

    @property
    @abstractmethod
    def points_per_unit(self) -> int:
        """Points of each."""

    @property
    def total(self) -> int:
        """Points in all."""
        return self.units * self.points_per_unit

    def counts(self, arrays: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Points by outcome."""
        return count_outcomes(arrays["outcome"])


@dataclass(frozen=True)
class PointTask(Task):
    """All points of a grid, each with every seed; a unit is a point with its seeds."""

    plan: Plan  # how a point is measured
    axes: tuple[Axis, ...]  # the grid; the last axis runs fastest
    starts: np.ndarray  # (S, n): initial states of the seeds
    modes: np.ndarray  # int (S,): their initial modes
    keeps: tuple[str, ...]  # arrays that are kept of every point
    counts_attractors: bool = False  # whether the different attractors among the seeds of a point are counted

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def units(self) -> int:
        """Points of the grid."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def points_per_unit(self) -> int:
        """Seeds."""
        return len(self.starts)

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one unit of each array."""
        declared = point_columns(self.plan)
        kept = {name: (dtype, (self.points_per_unit, *shape)) for name, (dtype, shape) in declared.items()}
        columns = {name: kept[name] for name in self.keeps}
        return columns | ({"attractor_count": ("i2", ())} if self.counts_attractors else {})

    def run(self, first: int, count: int) -> Arrays:
        """Results of some points of the grid with all their seeds."""
        held = 8 * self.plan.window * (len(self.plan.system.state_names) + 1)
        step = max(1, min(AT_ONCE, MOST_HELD // held) // self.points_per_unit)
        parts = [self._run(begin, min(step, first + count - begin)) for begin in range(first, first + count, step)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def begin(self, units: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
        """Parameters, initial states and modes of some points of the grid, with every seed."""
        seeds, names = len(self.starts), self.plan.system.state_names
        places = np.unravel_index(np.repeat(units, seeds), self.shape)
        starts, modes = np.tile(self.starts, (len(units), 1)), np.tile(self.modes, len(units))
        parameters: dict[str, np.ndarray] = {}
        for axis, index in zip(self.axes, places, strict=True):
            if axis.of_start:
                starts[:, names.index(axis.name)] = axis.values[index]
            else:
                parameters[axis.name] = axis.values[index]
        return parameters, starts, modes

    def _run(self, first: int, count: int) -> Arrays:
        seeds = len(self.starts)
        found, _ = measure(self.plan, *self.begin(np.arange(first, first + count)))
        found = {name: values.reshape(count, seeds, *values.shape[1:]) for name, values in found.items()}
        kept = {name: found[name] for name in self.keeps}
        if self.counts_attractors:
            counts = count_attractors(found)
            for unit in np.flatnonzero(counts > 1).tolist():
                counts[unit] = self._told_apart(first + unit, {name: found[name][unit] for name in KNOWN_BY})
            kept["attractor_count"] = counts.astype("i2")
        return kept

    def _told_apart(self, unit: int, seeds: Arrays) -> int:
        """Attractors among the seeds of a point of the grid that seem to be on several."""
        numbers, leaders = number_attractors(seeds)
        parameters, starts, modes = self.begin(np.array([unit]))

        def begin(which: np.ndarray) -> Batch:
            here = {name: values[leaders[which]] for name, values in parameters.items()}
            return self.plan.mapped(here, starts[leaders[which]], modes[leaders[which]], VISITED)

        return len(merge(self.plan, seeds, numbers, leaders, begin)[1])

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.plan.fingerprint() | {
            "grid": {axis.name: axis.values.tolist() for axis in self.axes},
            "seeds": self.starts.tolist(),
            "modes": self.modes.tolist(),
            "keeps": list(self.keeps),
        }


@dataclass(frozen=True)
class StartTask(PointTask):
    """Runs from many initial states, without a grid; a unit is one of them."""

    @property
    def units(self) -> int:
        """Initial states."""
        return len(self.starts)

    @property
    def points_per_unit(self) -> int:
        """One."""
        return 1

    def begin(self, units: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
        """No parameters, and the initial states and modes of some of the runs."""
        return {}, self.starts[units], self.modes[units]

    def _run(self, first: int, count: int) -> Arrays:
        found, _ = measure(self.plan, *self.begin(np.arange(first, first + count)))
        return {name: found[name][:, np.newaxis] for name in self.keeps}


@dataclass(frozen=True)
class LineTask(Task):
    """Lines of points, forward or backward along a parameter; a unit is a whole line.

    Where a run ends early, as one that escapes, the next point starts from the line's own initial state.
    """

    plan: Plan  # how a point is measured
    axis: Axis  # the swept parameter
    directions: tuple[str, ...]  # ``"forward"`` or ``"backward"``, for each line
    start: np.ndarray  # (n,): initial state of all lines
    mode: int  # their initial mode
    keeps: tuple[str, ...]  # arrays that are kept of every point

    @property
    def units(self) -> int:
        """Lines."""
        return len(self.directions)

    @property
    def points_per_unit(self) -> int:
        """Points of a line."""
        return len(self.axis.values)

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one line of each array, in the order of the values."""
        declared = point_columns(self.plan)
        return {name: (declared[name][0], (self.points_per_unit, *declared[name][1])) for name in self.keeps}

    def run(self, first: int, count: int) -> Arrays:
        """Results of some lines."""
        lines = [self._line(direction) for direction in self.directions[first : first + count]]
        return {name: np.stack([line[name] for line in lines]) for name in self.keeps}

    def _line(self, direction: str) -> Arrays:
        points = self.points_per_unit
        kept = {name: np.zeros(shape, dtype) for name, (dtype, shape) in self.columns().items()}
        before: Batch | None = None
        for index in range(points) if direction == "forward" else range(points - 1, -1, -1):
            parameters = {self.axis.name: self.axis.values[[index]]}
            start = (self.start[np.newaxis], np.array([self.mode]))
            found, batch = measure(self.plan, parameters, *start, before)
            if before is not None and may_be_left(self.plan, parameters, found, batch):
                found, batch = self._beside(parameters, start, before, found, batch)
            before = batch
            for name in self.keeps:
                kept[name][index] = found[name][0]
        return kept

    def _beside(
        self, parameters: Mapping[str, np.ndarray], start: tuple[np.ndarray, np.ndarray], *last: Any
    ) -> tuple[Arrays, Batch]:
        """The same point from beside the state that was followed, unless that run comes to an early end."""
        before, found, batch = last
        side = DISPLACED * SIDE[np.arange(len(self.start)) % len(SIDE)]
        other, beside = measure(self.plan, parameters, *start, before, side)
        return (other, beside) if np.isin(other["outcome"], MEASURED).all() else (found, batch)

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.plan.fingerprint() | {
            "line": {self.axis.name: self.axis.values.tolist()},
            "directions": list(self.directions),
            "start": self.start.tolist(),
            "mode": self.mode,
            "keeps": list(self.keeps),
        }


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
        "moments": ("f4", (4, len(plan.shifts.bounded))),
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

    Parameters
    ----------
    parameters : mapping of str to ndarray, shape (P,)
    starts, modes : ndarray, shapes (P, n) and (P,)
    before : Batch, optional
        Runs whose attractors are followed; then all points must share compiled functions.
    beside : ndarray, shape (n,), optional
        How far beside these the runs begin, in parts of the sizes of the states.

    Returns
    -------
    arrays : dict of str to ndarray
        As `point_columns` declares them, NaN (and period 0) where a point has no result.
    batch : Batch
        The runs of the last group of points that share compiled functions.
    """
    points = len(starts)
    arrays = {name: np.zeros((points, *shape), dtype) for name, (dtype, shape) in point_columns(plan).items()}
    for group in alike(plan.system, parameters, points):
        here = {name: np.asarray(values)[group] for name, values in parameters.items()}
        batch = plan.batch(here, starts[group], modes[group])
        if before is not None:
            batch.continue_from(before)
            batch.x[:] += 0.0 if beside is None else beside * batch.sizes
        _settle(plan, here, batch, arrays, group)
    return arrays, batch


def _settle(plan: Plan, parameters: Mapping[str, np.ndarray], batch: Batch, arrays: Arrays, places: np.ndarray) -> None:
    """Run a batch until every point is decided or has been extended as far as it may be."""
    ends, before = plan.ends, batch.x.copy()
    batch.run(plan.transient, ends)
    which = np.arange(len(places))
    verdict = judge(plan, batch, which, ends, before)
    _write(plan, batch, which, verdict, which, arrays, places)
    beside = plan.where.counts == "section" and plan.transient == 0
    whole = 0 if beside else int(ends[-1])
    _average_over_cycles(plan, parameters, batch, which, verdict.cycle, whole, arrays, places)
    evidence, open_, moves = verdict.evidence, verdict.outcome == Outcome.OPEN, verdict.moves.copy()
    which, times = which[~verdict.decided], 2
    repeats = not plan.system.draws
    while len(which) and plan.max_extension:
        for cycles in search(plan, batch, which[moves[which]], parameters) if repeats else ():
            _write(plan, cycles.batch, cycles.places, cycles.verdict, cycles.places, arrays, places[cycles.which])
            which = np.setdiff1d(which, cycles.which)
        if times > plan.max_extension or not len(which):
            break
        ends, before = block_ends(plan.periods * times, BLOCKS), batch.x.copy()
        batch.proceed(which, 0, ends)
        verdict = judge(plan, batch, which, ends, before)
        grows = verdict.outcome == Outcome.OPEN
        # what only grew, and then grows on or cannot be followed any further, is known
        lost = evidence.at(which).drifts & ~np.isin(verdict.outcome, MEASURED)
        arrays["outcome"][places[which[lost]]] = int(Outcome.OPEN)
        known = (open_[which] & grows) | lost
        rows = np.flatnonzero(~known)
        _write(plan, batch, which[rows], verdict, rows, arrays, places[which[rows]])
        of_cycles = (which[rows], verdict.cycle[rows], ends[-1], arrays, places[which[rows]])
        _average_over_cycles(plan, parameters, batch, *of_cycles)
        evidence.put(which, verdict.evidence)
        open_[which], moves[which] = grows, verdict.moves
        which, times = which[~verdict.decided & ~known], 2 * times
    if moves[which].any() and plan.max_extension and plan.maps and repeats:
        left = _displace(plan, parameters, batch, which[moves[which]], arrays, places)
        which = np.union1d(left, which[~moves[which]])
    unclear = which[~evidence.at(which).positive & ~evidence.at(which).negative]
    unclear = unclear[np.isin(arrays["outcome"][places[unclear]], (Outcome.OPEN, Outcome.UNDECIDED, Outcome.TRANSIENT))]
    if plan.max_extension and plan.exponents and not plan.maps and repeats:
        even = np.flatnonzero((arrays["outcome"][places] == Outcome.CHAOTIC) & _grows_evenly(batch, arrays, places))
        evidence.put(even, _passed(plan, parameters, batch, even, evidence.at(even)))
        arrays["outcome"][places[even]] = words(evidence.at(even))
    told = (plan.maps or plan.structure.autonomous) and repeats
    if plan.max_extension and plan.exponents and told and len(unclear):
        found, followed = _tell(plan, parameters, batch, unclear, evidence.at(unclear))
        arrays["outcome"][places[unclear]] = np.where(followed, found, arrays["outcome"][places[unclear]])


def may_be_left(plan: Plan, parameters: Mapping[str, np.ndarray], found: Arrays, batch: Batch, point: int = 0) -> bool:
    """Whether a point that was measured stands on something unstable, which the slightest noise would leave."""
    if plan.system.draws:
        return False
    outcome = int(found["outcome"][point])
    if outcome == Outcome.EQUILIBRIUM:
        here = plan.system.with_parameters(**{name: float(values[point]) for name, values in parameters.items()})
        growth = float(linearised(here, found["state"][point], int(batch.mode[point])).real.max())
    else:
        growth = float(found["lead"][point])
    unit = batch.period[point] if plan.where.counts != "section" else plan.where.unit
    return outcome not in (Outcome.CHAOTIC, Outcome.OPEN) and growth * unit > GROWS


def _average_over_cycles(
    plan: Plan,
    parameters: Mapping[str, np.ndarray],
    batch: Batch,
    which: np.ndarray,
    cycle: np.ndarray,
    record: int,
    arrays: Arrays,
    places: np.ndarray,
) -> None:
    """Mean rates over one cycle more, where the record of a cycle is no whole number of them.

    ``cycle`` and the length of the ``record`` (0 for one that begins beside the section) are in units of lengths;
    ``cycle`` and ``places`` are those of the points ``which``. A cycle that does not come back keeps the means over its
    record.
    """
    rows = np.flatnonzero((cycle > 0) & ((record == 0) | (record % np.maximum(cycle, 1) != 0)))
    if not len(rows):
        return
    chosen, cycle = which[rows], cycle[rows]
    runs = plan.bare(parameters, batch.x, batch.mode)
    runs.stand(batch.standing(np.arange(len(batch.x))))
    for length in np.unique(cycle).tolist():
        runs.proceed(chosen[cycle == length], 0, np.array([0, length]))
    shifts, window = plan.shifts, np.nan_to_num(batch.window[chosen][:, :, :-1])
    size = sizes(shifts.quotient(window), shifts.sizes(batch.sizes[chosen]))
    back = (runs.outcome[chosen] == Outcome.OK) & (runs.mode[chosen] == batch.mode[chosen])
    away = np.abs(shifts.quotient(runs.x[chosen]) - shifts.quotient(batch.x[chosen]))
    back &= (away <= CLOSE * size).all(axis=1)
    rates = event_rates(plan, runs, chosen)
    for name in rates.keys() - {"closest_grazing"}:
        arrays[name][places[rows[back]]] = rates[name][back]


def _displace(
    plan: Plan,
    parameters: Mapping[str, np.ndarray],
    batch: Batch,
    which: np.ndarray,
    arrays: Arrays,
    places: np.ndarray,
) -> np.ndarray:
    """Run the points that leave an unstable cycle from further away; return those that stay undecided."""
    leaving, runs = escapes(plan, batch, which, parameters)
    if not len(leaving):
        return which
    here = at_points(parameters, leaving)
    runs.run(plan.transient, plan.ends)
    verdict = judge(plan, runs, np.arange(len(leaving)), plan.ends)
    decided = verdict.decided & (runs.outcome == Outcome.OK)
    rows = np.flatnonzero(decided)
    _write(plan, runs, rows, verdict, rows, arrays, places[leaving[rows]])
    _average_over_cycles(plan, here, runs, rows, verdict.cycle[rows], plan.ends[-1], arrays, places[leaving[rows]])
    which = np.setdiff1d(which, leaving[rows])
    for cycles in search(plan, runs, np.flatnonzero(~verdict.decided & verdict.moves), here):
        solved = leaving[cycles.which]
        _write(plan, cycles.batch, cycles.places, cycles.verdict, cycles.places, arrays, places[solved])
        which = np.setdiff1d(which, solved)
    return which


def _tell(
    plan: Plan, parameters: Mapping[str, np.ndarray], batch: Batch, which: np.ndarray, evidence: Evidence
) -> tuple[np.ndarray, np.ndarray]:
    """Outcomes of points whose exponent is not told from zero, by points of the map, and whether these were reached.

    Where there is no map they are told by instants, and by the events that move their states most often.
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


def _grows_evenly(batch: Batch, arrays: Arrays, places: np.ndarray) -> np.ndarray:
    """Points whose tangents grow as evenly as along a cycle, which no chaos does but that of constant slopes."""
    return np.asarray(arrays["lyapunov_error"][places, 0] * batch.length <= EVENLY)


def _passed(
    plan: Plan, parameters: Mapping[str, np.ndarray], batch: Batch, which: np.ndarray, evidence: Evidence
) -> Evidence:
    """Evidence of some points with what their events say of them."""
    if len(which):
        begun = continued(plan, batch, which, at_points(parameters, which))
        _tell_by_passages(plan, begun, batch.counts[which], np.arange(len(which)), evidence)
    return evidence


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


def _write(
    plan: Plan,
    batch: Batch,
    which: np.ndarray,
    verdict: Verdict,
    rows: np.ndarray,
    arrays: Arrays,
    places: np.ndarray,
) -> None:
    """Keep the results of some points of a batch, at their places."""
    n = len(plan.system.state_names)
    ended = ~np.isin(verdict.outcome[rows], MEASURED)
    window = batch.window[which]
    period = verdict.period[rows]
    arrays["section"][places] = _last_rows(window[:, :, :n], plan.rows)
    arrays["period"][places] = period
    arrays["outcome"][places] = verdict.outcome[rows]
    arrays["lead"][places] = verdict.lead[rows]
    arrays["ended_by"][places] = batch.ended_by[which]
    arrays["lyapunov_exponent"][places] = verdict.exponents[rows][:, : plan.exponents]
    arrays["lyapunov_error"][places] = verdict.errors[rows][:, : plan.exponents]
    means = event_rates(plan, batch, which) | rate_errors(plan, batch, which, verdict.cycle[rows])
    for name, values in means.items():
        arrays[name][places] = np.where(ended, np.nan, values)
    arrays["moments"][places], arrays["state"][places] = moments(
        undrawn(plan.system, window), batch.sizes[which], period, plan.shifts
    )
    for row in np.flatnonzero(verdict.outcome[rows] == Outcome.EQUILIBRIUM):
        state = batch.rest(int(which[row]))
        arrays["state"][places[row]], arrays["moments"][places[row], :3] = state, 0.0
        arrays["moments"][places[row], 0] = plan.shifts.quotient(state)


def _last_rows(windows: np.ndarray, count: int) -> np.ndarray:
    """The last points of every window, NaN behind them where there were fewer."""
    rows = np.isfinite(windows[:, :, 0]).sum(axis=1)
    index = np.maximum(rows - count, 0)[:, np.newaxis] + np.arange(count)
    taken = np.take_along_axis(windows, np.minimum(index, windows.shape[1] - 1)[:, :, np.newaxis], axis=1)
    taken[index >= rows[:, np.newaxis]] = np.nan
    return taken


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

    On a cycle of so many units of lengths, 0: of none, they are those over blocks that are whole cycles, if there are.
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

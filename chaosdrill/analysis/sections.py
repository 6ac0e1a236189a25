"""Sections: where points of a motion are taken, what lengths count, and what such points say of one run.

A section is the strobe of a forcing, an event by the name or kind of its transition, or a surface: a comparison, met
where it becomes true. It travels as the text ``at`` through arguments, scenes and provenance, and as one record,
`Section`, through the analyses. The state on it is the one before the event.
"""

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Span
from chaosdrill.analysis.recording import Record, record, record_returns, time_of_motion
from chaosdrill.analysis.recurrence import CLOSE, find_period, sizes
from chaosdrill.analysis.statistics import block_ends, error_of_mean_rate, whole_cycles
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.schema import names_of_errors
from chaosdrill.engine import layout
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, event_rates, rate_names
from chaosdrill.engine.shifts import shifts_of
from chaosdrill.engine.structure import examine
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job
    from chaosdrill.orbits.marks import Marks

RETURN = 1000
"""Longest time between two points of a section, unless another one is given: in forcing periods, else in times in
which the motion from the initial state crosses its own extent. Slow phases of bursting and stick-slip motions are
shorter, and a run that never returns does not take long."""

_ROUNDING = 4e-16
"""Part of a time by which round-off may put it beyond the ends of the run."""


SOONER = 3.0
"""Times the distance after a period within which a state is back after a part of it that counts."""

BLOCKS = 256
"""Parts of a record at most, from which the errors of its mean rates are taken."""

SAMPLES = 200
"""Default number of samples of a trajectory: in a period or return, or in a whole duration."""

AT_ONCE = 1e-9
"""Part of the unit of time within which a second point of a surface comes from grazing it, not from a return."""

LOOKED_AT = 256
"""Points of a section among which the nearest return is looked for."""


@dataclass(frozen=True)
class Section:
    """Where points are taken."""

    system: HybridSystem  # the system; where a surface is the section, with a transition in every mode that marks it
    transitions: frozenset[int] | None  # the events before which the points are taken; None for the strobe
    own: int  # transitions that the system has without those
    counts: str  # {"strobe", "section", "time"}: what lengths count: strobes, points of the section, or time
    unit: float
    """Forcing period; without forcing the time in which the motion from the initial state crosses its own extent."""
    longest: float  # longest time between two points

    def at_parameters(self, system: HybridSystem, given: Any, numerics: Numerics) -> "Section":
        """The same section, looked for by the same settings, of the system at other parameters."""
        unit, longest = _times(system, self.counts, given, numerics)
        return replace(self, system=self.system.with_parameters(system.parameters), unit=unit, longest=longest)

    def grazed(self, times: np.ndarray) -> bool:
        """Whether points of a surface at these times follow each other at once: where the motion only touches it.

        Round-off then makes any number of points of one, which tell no period.
        """
        marked = self.transitions is not None and min(self.transitions, default=0) >= self.own
        return marked and bool((np.diff(times) <= AT_ONCE * self.unit).any())


def find_section(system: HybridSystem, given: Any, numerics: Numerics, *, timed: bool = False) -> Section:
    """The section that the settings ``at``, ``max_return``, ``periods`` and ``duration`` of an analysis name.

    The ``unit`` is 1 where nothing asks for it: no point of a section is waited for, and it is not ``timed``.
    """
    counts = given.counts(system)
    marked, chosen = system, None
    if given.at not in (None, "strobe"):
        named = frozenset(i for i, t in enumerate(system.transitions) if given.at in (t.name, t.kind))
        marked, chosen = system, named
        if not named:
            from chaosdrill.model.surface import surface

            marked, chosen = surface(system, given.at)
    return Section(marked, chosen, len(system.transitions), counts, *_times(system, counts, given, numerics, timed))


def _times(
    system: HybridSystem, counts: str, given: Any, numerics: Numerics, timed: bool = False
) -> tuple[float, float]:
    """Unit of time of a section, and the longest time between two points."""
    period = system.forcing_period()
    unit = period or (given.max_return or 0.0) / RETURN or 1.0
    if (counts == "section" or timed) and not (period or given.max_return):
        unit = time_of_motion(system, numerics)
    return unit, given.max_return or RETURN * unit


def measured_span(section: Section, given: Any, numerics: Numerics, units: int) -> Span:
    """Time from the start that a number of section points takes; for a forced system in whole periods.

    A record begins and ends half a return after a point, so that it holds the requested number.
    """
    assert section.transitions is not None
    run = Run(section.system, section.unit, numerics)
    before, count = int(given.transient), int(given.periods)
    found = record_returns(run, section.transitions, before + count + 1, section.longest)
    if found.outcome != Outcome.OK or section.grazed(found.times):
        return Span(1.0, units, 0, False, int(found.outcome) or int(Outcome.NO_RETURN))
    after = (found.times[1:] + found.times[:-1]) / 2
    begin = float(after[before - 1]) if before else 0.0
    length = float(after[before + count - 1]) - begin
    if not section.system.forced:
        return Span(length / units, units, begin, False)
    return Span(section.unit, math.ceil(length / section.unit), math.ceil(begin / section.unit), True)


def settled_at(section: Section, run: Run, points: int) -> Outcome:
    """Continue over a number of section points, which are discarded."""
    assert section.transitions is not None
    found = record_returns(run, section.transitions, points, section.longest)
    run.forget()
    return found.outcome


@dataclass(frozen=True)
class OrbitStart:
    """From where an orbit is looked for, as `chaosdrill.orbits.find.find_orbit` takes it."""

    system: HybridSystem
    period: int
    start: str | float
    transient: float
    marks: "Marks | None" = None  # the section whose points the period counts, if one was named


def orbit_start(system: HybridSystem, given: Any, numerics: Numerics) -> OrbitStart:
    """Where the search for an orbit begins by its settings.

    Where a section is named: in the middle of the first long way between events from a point of it on, so that it is
    beside all of them, and the round has the time that the ``period`` returns from there take. On an attractor it is
    the point after the transient to which so many returns lead back most nearly; else the first point, or the middle of
    the way to it, if that is long.
    """
    # a section alone needs no orbits, nor what they import
    from chaosdrill.orbits.marks import Marks
    from chaosdrill.orbits.problem import Problem

    if given.counts(system) != "section":
        lead_in = int(given.transient) if system.forced else given.transient
        return OrbitStart(system, given.period, given.start, lead_in)
    where, period = find_section(system, given, numerics), int(given.period)
    assert where.transitions is not None
    run = Run(where.system, where.unit, numerics)
    attracted = given.start == "attractor"
    lead_in = max(int(given.transient), 1) if attracted else 0
    found = record_returns(run, where.transitions, lead_in, where.longest)
    ahead = Run(where.system, where.unit, numerics)
    ahead.continue_from(run)
    passed = found
    if found.outcome == Outcome.OK:
        count = (LOOKED_AT if attracted else 1) + period
        passed = record_returns(ahead, where.transitions, count, where.longest, every=True)
        found = passed.of(where.transitions)
    states, times = found.states_after(), found.times
    if len(times) <= period:
        # what the motion does instead is told by the search
        return OrbitStart(system, 1, "attractor", 0)
    problem = Problem(system, (), numerics)
    problem.set_unit(where.unit)
    spread = np.maximum(np.ptp(states, axis=0), CLOSE * np.maximum(np.abs(states).max(axis=0), problem.sizes))
    last = len(states) - period

    def away(steps: int) -> np.ndarray:
        return np.asarray((np.abs(states[steps : steps + last] - states[:last]) / spread).max(axis=1))

    # what is back sooner leads to an orbit of a shorter period
    sooner = np.array([away(q) for q in range(1, period) if period % q == 0]).min(axis=0, initial=np.inf)
    nearest = int(np.lexsort((away(period), sooner < SOONER * away(period)))[0])
    record_returns(run, where.transitions, nearest + 1, where.longest)
    first, last_time = times[nearest], times[nearest + period]
    instants = passed.times[(passed.times >= first) & (passed.times <= last_time)]
    # a way that is wide enough: the later it is, the farther the round leads beyond the return that was seen
    ways = np.diff(instants)
    if not attracted and first >= ways.max() / 4:
        # the start itself is on a way, and deviations from an orbit grow from there on
        beside = Run(where.system, float(first) / 2, numerics)
    else:
        wide = int(np.flatnonzero(ways >= ways.max() / 2)[0])
        beside = Run(where.system, float((instants[wide] + instants[wide + 1]) / 2 - first), numerics)
        beside.continue_from(run)
    beside.advance(1)
    state = dict(zip(system.state_names, beside.x.tolist(), strict=True))
    marks = Marks(where.system.limited({}), where.transitions)
    return OrbitStart(system.with_initial(**state, mode=beside.mode), 1, float(last_time - first), 0, marks)


@dataclass(frozen=True)
class Path:
    """A motion over time."""

    outcome: Outcome
    times: np.ndarray  # (T,): at equal intervals, from the start of the record
    rows: np.ndarray  # (T, n + q + 1): states, quadratures and mode there
    events: Record  # all events but those that only mark a surface that was named for the purpose
    tangents: np.ndarray | None  # (m, n): those that were followed over the record, at its end, if any were
    message: str  # what ended the run and where, as `Run.stopped` tells


def samples_of(system: HybridSystem, given: Any) -> int:
    """Samples of a trajectory in every unit of its length; a map has one an iterate."""
    return int(given.samples or (1 if system.discrete else SAMPLES))


def traced(where: Section, given: Any, job: "Job") -> Path:
    """A motion over its length, with a number of samples in every unit of it; see `trajectory`."""
    system, samples = where.system, samples_of(where.system, given)
    if where.counts == "section":
        return _traced_to_points(where, given, job)
    plan = given.span(system, job.numerics)
    run = Run(system, plan.unit, job.numerics, samples=samples if given.times is None else 1)
    outcome = plan.settle(run)
    start, here = run.elapsed, _present(run)
    beside = None if given.tangents is None else _beside(run, given.tangents, job.numerics)
    wanted = None if given.times is None else given.times if outcome == Outcome.OK else []
    since = None if wanted is None else _since(start, plan, wanted)
    count = plan.count if outcome == Outcome.OK else 0
    found = record(run, count, events=True, times=since, report=job.report(plan.count))
    rows = np.vstack([here, found.samples]) if wanted is None else found.samples
    even = start + np.arange(len(rows)) * (plan.unit / samples)
    times = even if wanted is None else np.array(wanted[: len(rows)], dtype=float)
    outcome = found.outcome if outcome == Outcome.OK else outcome
    tangents = (
        None if beside is None else _followed(beside, plan.length if since is None else float(since[-1]), outcome)
    )
    return Path(outcome, times, rows, found.of(set(range(where.own))), tangents, run.stopped(outcome))


def _beside(run: Run, tangents: np.ndarray, numerics: Numerics) -> Run:
    """A run that goes on from where another one stands, with tangents, whose steps thus are not cut."""
    beside = Run(run.system, run.period, numerics, tangents=tangents, orthonormalise=False)
    beside.continue_from(run)
    # of a forced system the clock begins anew at every strobe
    beside.begin_at(origin=float(run.standing["time"]) if run.system.forced else run.elapsed)
    return beside


def _followed(beside: Run, length: float, outcome: Outcome) -> np.ndarray:
    """The tangents of a run a time later, NaN where it or the record ended early."""
    if outcome == Outcome.OK:
        whole, rest = divmod(Fraction(length), Fraction(beside.period))
        if abs(rest - Fraction(beside.period)) <= _ROUNDING * length:
            whole, rest = whole + 1, Fraction(0)
        if whole:
            outcome, _ = beside.advance(int(whole))
        if rest > _ROUNDING * length and outcome == Outcome.OK:
            beside.change_period(float(rest))
            outcome, _ = beside.advance(1)
    return beside.vectors.copy() if outcome == Outcome.OK else np.full(beside.vectors.shape, np.nan)


def _since(start: float, plan: Span, times: list[float]) -> np.ndarray:
    """Times since the start of the record, within it.

    Raises
    ------
    SettingsError
        A time before or behind the record.
    """
    end = start + plan.length
    slack = _ROUNDING * max(abs(start), abs(end))
    for time in (*times[:1], *times[-1:]):
        if not start - slack <= time <= end + slack:
            raise SettingsError(
                f"times holds {time!r}; times count from the start of the run, and the record, after the transient, "
                f"goes from {start:.6g} to {end:.6g}"
            )
    since = np.array([float(Fraction(time) - Fraction(start)) for time in times])
    return np.clip(since, 0.0, plan.length)


def _traced_to_points(where: Section, given: Any, job: "Job") -> Path:
    """The same up to the last of a number of section points: once for its events, and once more for its samples."""
    system, count = where.system, int(given.periods)
    assert where.transitions is not None
    run = Run(system, where.unit, job.numerics)
    outcome = settled_at(where, run, int(given.transient))
    start, here = run.elapsed, _present(run)
    again, rows = Run(system, where.unit, job.numerics), [here]
    again.continue_from(run)
    if system.forced:
        again.begin_at(origin=float(run.standing["time"]))
    beside = None if given.tangents is None else _beside(run, given.tangents, job.numerics)
    left = count if outcome == Outcome.OK else 0
    found = record_returns(run, where.transitions, left, where.longest, every=True, report=job.report(count))
    outcome = found.outcome if outcome == Outcome.OK else outcome
    parts, length = count * (given.samples or SAMPLES), run.elapsed - start
    if length > 0:
        again.change_period(length)
        again.settings["samples"] = parts
        rows.append(record(again, 1, events=False, slices=1).samples)
    table = np.vstack(rows)
    tangents = None if beside is None else _followed(beside, length, outcome)
    times = start + np.arange(len(table)) * (length / parts)
    return Path(outcome, times, table, found.of(set(range(where.own))), tangents, run.stopped(outcome))


def _present(run: Run) -> np.ndarray:
    """State, quadratures that begin, and mode where a run stands."""
    return np.concatenate([run.x, np.zeros(len(run.system.quadratures)), [run.standing["mode"]]])


@dataclass(frozen=True)
class Taken:
    """The section points of a run, and where it stands behind them."""

    where: Section
    run: Run
    outcome: Outcome
    points: np.ndarray  # (N, n), or (N, n + q) at strobes: states, and there quadratures
    modes: np.ndarray  # (N,)
    times: np.ndarray  # (N,)
    period: int  # smallest number of points after which all come back; 0: none up to the longest that is looked for
    blocks: "_Blocks"

    @property
    def states(self) -> np.ndarray:
        """States on the section, shape (N, n)."""
        return self.points[:, : len(self.run.x)]


def phases_of(where: Section, periods: np.ndarray) -> np.ndarray:
    """Phases of the forcing at times in periods, shape (N, 2), as points of a circle; (N, 0) where none is.

    At events of a forced system they are one: what comes back at another phase goes on otherwise.
    """
    if where.transitions is None or not where.system.forced or where.system.autonomous:
        return np.zeros((len(periods), 0))
    angle = 2 * np.pi * (periods % 1)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def section_points(where: Section, given: Any, max_period: int, job: "Job") -> Taken:
    """States at every strobe, or before every event of a section, by the settings of an analysis."""
    system = where.system
    first, outcome, run, found, blocks = _recorded(where, given, job)
    if where.transitions is None:
        points, modes = found.samples[:, :-1], found.samples[:, -1]
        times = (first + 1 + np.arange(len(points))) * run.period
    else:
        crossings = found.of(where.transitions)
        points, modes, times = crossings.states_before(), crossings.events[:, layout.EVENT_MODE], crossings.times
    if outcome == Outcome.OK and where.grazed(times):
        outcome = Outcome.NO_RETURN
    phases = phases_of(where, times / run.period)
    shifts = shifts_of(system, but_of=())
    compared = np.column_stack([shifts.quotient(points[:, : len(system.state_names)]), phases])
    known = np.append(shifts.sizes(run.sizes), np.ones(phases.shape[1]))
    repeats = outcome == Outcome.OK and not system.draws
    period = find_period(compared, known, max_period) if repeats else 0
    return Taken(where, run, outcome, points, modes, times, period, blocks)


def section(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """States at every strobe, or before every event of a section; see `poincare_section`."""
    numerics, n = job.numerics, len(system.state_names)
    taken = section_points(find_section(system, given, numerics), given, given.max_period, job)
    where, run, outcome, period, blocks = taken.where, taken.run, taken.outcome, taken.period, taken.blocks
    points, modes, times = taken.points, taken.modes, taken.times
    multipliers = np.full(system.free, complex(np.nan, np.nan))
    repeats = system.forced or system.autonomous
    if period and repeats and where.counts != "time":
        multipliers = cycle_multipliers(where, run, period, numerics)
    rates = event_rates(run) if outcome == Outcome.OK else dict.fromkeys(rate_names(system), np.nan)
    returns = np.diff(times)[-period:] if period else np.diff(times)
    if period:
        length = period * run.period if where.transitions is None else float(times[-1] - times[-1 - period])
        rates |= cycle_rates(where, run, points[-period:, :n], length, numerics)
    errors = np.full(len(system.quadratures), np.nan)
    if outcome == Outcome.OK:
        chosen = whole_cycles(blocks.points, period)
        errors = error_of_mean_rate(blocks.totals[chosen], blocks.times[chosen, np.newaxis], numerics, blocks.pace)
    rates |= dict(zip(names_of_errors(system.quadratures), errors, strict=True))
    variables = {
        "section": (("iterate", "state"), points[:, :n]),
        "mode": ("iterate", modes.astype(np.int8)),
        "period": ((), np.int32(period)),
        "return_time": ((), returns.mean() if len(returns) and outcome == Outcome.OK else np.nan),
        "multiplier_real": ("multiplier", multipliers.real),
        "multiplier_imag": ("multiplier", multipliers.imag),
        "outcome": ((), np.int8(Outcome.PERIODIC if period else outcome)),
        **{name: ((), value) for name, value in rates.items()},
    }
    if where.transitions is None:
        variables |= {name: ("iterate", points[:, n + i]) for i, name in enumerate(system.quadratures)}
    if system.forced:
        variables["forcing_period"] = ((), where.unit)
    coords = {
        "iterate": np.arange(len(points), dtype=np.int32),
        "time": ("iterate", times),
        "state": list(system.state_names),
        "multiplier": np.arange(1, system.free + 1, dtype=np.int32),
    }
    return dataset(variables | coords, coords)


@dataclass(frozen=True)
class _Blocks:
    """Quadratures, shape (B + 1, q), and times since a record began, when it had so many points of the section; and how
    far quadratures move per unit of time, up or down, shape (q,)."""

    points: np.ndarray
    times: np.ndarray
    totals: np.ndarray
    pace: np.ndarray


def _recorded(where: Section, given: Any, job: "Job") -> tuple[int, Outcome, Run, Record, _Blocks]:
    """Strobes before the record, how it went, the run at its end, the record, and blocks of it."""
    n, q = len(where.system.state_names), len(where.system.quadratures)
    if where.counts == "section":
        run = Run(where.system, where.unit, job.numerics)
        outcome = settled_at(where, run, int(given.transient))
        first = run.strobes
        found, blocks = _recorded_returns(where, run, int(given.periods) if outcome == Outcome.OK else 0, job)
    else:
        plan = given.span(where.system, job.numerics)
        run = Run(where.system, plan.unit, job.numerics)
        outcome = plan.settle(run)
        first, count = run.strobes, plan.count if outcome == Outcome.OK else 0
        found = record(run, count, events=where.transitions is not None, report=job.report(plan.count))
        ends = block_ends(len(found.samples), BLOCKS)
        totals = np.vstack([np.zeros((1, q)), found.samples[:, n : n + q]])[ends]
        times = ends * plan.unit
        blocks = _Blocks(ends, times, totals, run.moved / (times[-1] or plan.unit))
    return first, found.outcome if outcome == Outcome.OK else outcome, run, found, blocks


def _recorded_returns(where: Section, run: Run, count: int, job: "Job") -> tuple[Record, _Blocks]:
    """Continue over a number of section points, block by block."""
    assert where.transitions is not None
    ends, report = block_ends(count, BLOCKS), job.report(count)
    start, times, totals = run.elapsed, [0.0], [run.integrals()]
    parts = [record_returns(run, where.transitions, 0, where.longest)]
    for before, ahead in zip(ends.tolist(), np.diff(ends).tolist(), strict=False):
        onward = None if report is None else lambda points, before=before: report(before + points)
        parts.append(record_returns(run, where.transitions, ahead, where.longest, report=onward))
        times.append(run.elapsed - start)
        totals.append(run.integrals())
        if parts[-1].outcome != Outcome.OK:
            break
    events, at_times = (np.concatenate(rows) for rows in ([one.events for one in parts], [one.times for one in parts]))
    found = Record(parts[-1].outcome, parts[-1].samples, events, at_times)
    pace = run.moved / (times[-1] or where.unit)
    return found, _Blocks(ends[: len(times)], np.array(times), np.array(totals), pace)


def cycle_rates(where: Section, run: Run, points: np.ndarray, length: float, numerics: Numerics) -> dict[str, float]:
    """Mean rates over one cycle from where a run stands; none if it does not come back.

    Parameters
    ----------
    points : ndarray, shape (period, n)
        Points of the section on the cycle.
    length : float
        Duration of the cycle, of a forced system a number of its periods but for round-off.
    """
    system, period = run.system, len(points)
    shifts = shifts_of(system, but_of=())
    size = sizes(shifts.quotient(points)[np.newaxis], shifts.sizes(run.sizes))[0]
    periods = max(1, round(length / run.period))
    # a rate that names time has no mean over a cycle that begins at another time
    clocked = any(system.time in e.free_symbols for rates in system.quadratures.values() for e in rates.values())
    forced = not system.autonomous or clocked or abs(length - periods * run.period) <= CLOSE * run.period
    at_events = where.counts == "section"
    cycle = Run(system, run.period if forced or at_events else length, numerics)
    cycle.continue_from(run)
    if at_events:
        outcome = _once_more(where, run, cycle, period)
    else:
        outcome, _ = cycle.advance(periods if forced else 1)
    away = np.abs(shifts.quotient(cycle.x) - shifts.quotient(run.x))
    if outcome != Outcome.OK or cycle.mode != run.mode or (away > CLOSE * size).any():
        return {}
    part = run.period / cycle.period if system.forced else 1.0
    rates = event_rates(cycle)
    rates = {name: value * (part if name.endswith("_per_period") else 1.0) for name, value in rates.items()}
    return {name: value for name, value in rates.items() if name != "closest_grazing"}


def _once_more(where: Section, run: Run, cycle: Run, period: int) -> Outcome:
    """Run on over a cycle from the event of the section at which another run stands."""
    assert where.transitions is not None
    if where.system.forced:
        cycle.begin_at(origin=float(run.standing["time"]))
    return record_returns(cycle, where.transitions, period, where.longest).outcome


def cycle_multipliers(where: Section, run: Run, period: int, numerics: Numerics) -> np.ndarray:
    """Eigenvalues of the tangent map over a cycle with a number of points, by descending modulus."""
    system, n = where.system, len(where.system.state_names)
    deficient = examine(system).deficient
    whole_map = Run(system, run.period, numerics, tangents=np.eye(n), orthonormalise=False)
    ranked = Run(system, run.period, numerics, tangents=np.eye(n), deficient=deficient)
    for one in (whole_map, ranked):
        one.continue_from(run)
        outcome = one.advance(period)[0] if where.transitions is None else _once_more(where, run, one, period)
        if outcome != Outcome.OK:
            return np.full(n, complex(np.nan, np.nan))
    values = np.linalg.eigvals(whole_map.vectors.T).astype(complex)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    values[ranked.live :] = 0
    return values

"""What the points of a section say of one run: their period, mean rates with errors, and the cycle's multipliers."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.judgement.recurrence import CLOSE, find_period, sizes
from chaosdrill.analysis.judgement.statistics import block_ends, error_of_mean_rate, rounding_of_point, whole_cycles
from chaosdrill.analysis.judgement.tori import stays_late
from chaosdrill.analysis.recording import Record, record, record_returns
from chaosdrill.analysis.sections import Section, find_section, settled_at
from chaosdrill.analysis.tuning import SECTIONS
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.schema import names_of_errors
from chaosdrill.engine import layout
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run, event_rates, rate_names
from chaosdrill.engine.shifts import shifts_of
from chaosdrill.engine.structure import examine
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job


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
    units = max(blocks.points[-1], 1)
    rounding = float(rounding_of_point(job.numerics, system.discrete, run.steps, units, len(points)))
    period = find_period(compared, known, max_period, rounding) if repeats else 0
    if period:
        window = np.column_stack([compared, modes])[np.newaxis]
        period *= int(stays_late(window, known[np.newaxis], np.array([period]), np.array([rounding]))[0])
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
    message = run.stopped(outcome)
    return dataset(variables | coords, coords, {"message": message} if message else None)


@dataclass(frozen=True)
class _Blocks:
    """Quadratures, shape (B + 1, q), and times since a record began, at given numbers of section points; and how far
    quadratures move per unit of time, up or down, shape (q,)."""

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
        ends = block_ends(len(found.samples), SECTIONS.blocks)
        totals = np.vstack([np.zeros((1, q)), found.samples[:, n : n + q]])[ends]
        times = ends * plan.unit
        blocks = _Blocks(ends, times, totals, run.moved / (times[-1] or plan.unit))
    return first, found.outcome if outcome == Outcome.OK else outcome, run, found, blocks


def _recorded_returns(where: Section, run: Run, count: int, job: "Job") -> tuple[Record, _Blocks]:
    """Continue over a number of section points, block by block."""
    assert where.transitions is not None
    ends, report = block_ends(count, SECTIONS.blocks), job.report(count)
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

    ``points``, shape (period, n): points of the section on the cycle. ``length``: duration of the cycle, of a forced
    system a number of its periods but for round-off.
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
        cycle.begin_at(float(run.standing["time"]))
    return record_returns(cycle, where.transitions, period, where.longest).outcome


def cycle_multipliers(where: Section, run: Run, period: int, numerics: Numerics) -> np.ndarray:
    """Eigenvalues of the tangent map over a cycle with a number of points, by descending modulus."""
    system, n = where.system, where.system.free
    columns, deficient = np.eye(n, len(system.state_names)), examine(system).deficient
    whole_map = Run(system, run.period, numerics, tangents=columns, orthonormalise=False)
    ranked = Run(system, run.period, numerics, tangents=columns, deficient=deficient)
    for one in (whole_map, ranked):
        one.continue_from(run)
        outcome = one.advance(period)[0] if where.transitions is None else _once_more(where, run, one, period)
        if outcome != Outcome.OK:
            return np.full(n, complex(np.nan, np.nan))
    values = np.linalg.eigvals(whole_map.vectors[:, :n].T).astype(complex)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    values[ranked.live :] = 0
    return values

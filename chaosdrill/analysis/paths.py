"""A motion over time: its samples, or the states at given times, with its events and tangents."""

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.recording import Record, record, record_returns
from chaosdrill.analysis.sections import Section, settled_at
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.tuning import SECTIONS
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job


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
    return int(given.samples or (1 if system.discrete else SECTIONS.samples))


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
    if wanted and given.ends_at_times():
        found = found.until(float(wanted[-1]), whole=len(found.samples) == len(wanted))
    rows = np.vstack([here, found.samples]) if wanted is None else found.samples
    even = start + np.arange(len(rows)) * (plan.unit / samples)
    times = even if wanted is None else np.array(wanted[: len(rows)], dtype=float)
    outcome = found.outcome if outcome == Outcome.OK else outcome
    told = run.stopped(outcome)
    tangents, outcome, own = _followed(beside, plan.length if since is None else float(since[-1]), outcome)
    return Path(outcome, times, rows, found.of(set(range(where.own))), tangents, told or own)


def _beside(run: Run, tangents: np.ndarray, numerics: Numerics) -> Run:
    """A run that goes on from where another one stands, with tangents, whose steps thus are not cut."""
    beside = Run(run.system, run.period, numerics, tangents=tangents, orthonormalise=False)
    beside.continue_from(run)
    # the clock of a forced system restarts at every strobe
    beside.begin_at(float(run.standing["time"]) if run.system.forced else run.elapsed)
    return beside


def _followed(beside: Run | None, length: float, outcome: Outcome) -> tuple[np.ndarray | None, Outcome, str]:
    """The tangents of a run a time later, NaN where it or the record ended early; the outcome of both, and what ended
    the run with tangents alone."""
    if beside is None:
        return None, outcome, ""
    told = ""
    if outcome == Outcome.OK:
        whole, rest = divmod(Fraction(length), Fraction(beside.period))
        if abs(rest - Fraction(beside.period)) <= SECTIONS.rounding * length:
            whole, rest = whole + 1, Fraction(0)
        if whole:
            outcome, _ = beside.advance(int(whole))
        if rest > SECTIONS.rounding * length and outcome == Outcome.OK:
            beside.change_period(float(rest))
            outcome, _ = beside.advance(1)
        told = beside.stopped(outcome)
        if outcome == Outcome.STEP_UNDERFLOW or (not told and not np.isfinite(beside.vectors).all()):
            lost = f"the tangents are lost at time {beside.elapsed:.10g}; another method may follow them"
            told = f"{lost}; {told}" if told else lost
    tangents = beside.vectors.copy() if outcome == Outcome.OK else np.full(beside.vectors.shape, np.nan)
    return tangents, outcome, told


def _since(start: float, plan: Span, times: list[float]) -> np.ndarray:
    """Times since the start of the record, within it; raises `SettingsError` for a time before or behind the record."""
    end = start + plan.length
    slack = SECTIONS.rounding * max(abs(start), abs(end))
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
        again.begin_at(float(run.standing["time"]))
    beside = None if given.tangents is None else _beside(run, given.tangents, job.numerics)
    left = count if outcome == Outcome.OK else 0
    found = record_returns(run, where.transitions, left, where.longest, every=True, report=job.report(count))
    outcome = found.outcome if outcome == Outcome.OK else outcome
    parts, length = count * (given.samples or SECTIONS.samples), run.elapsed - start
    if length > 0:
        again.change_period(length)
        again.settings["samples"] = parts
        rows.append(record(again, 1, events=False, slices=1).samples)
    table = np.vstack(rows)
    told = run.stopped(outcome)
    tangents, outcome, own = _followed(beside, length, outcome)
    times = start + np.arange(len(table)) * (length / parts)
    return Path(outcome, times, table, found.of(set(range(where.own))), tangents, told or own)


def _present(run: Run) -> np.ndarray:
    """State, quadratures that begin, and mode where a run stands."""
    return np.concatenate([run.x, np.zeros(len(run.system.quadratures)), [run.standing["mode"]]])

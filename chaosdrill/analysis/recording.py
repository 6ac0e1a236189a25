"""Record part of a run: its samples and its events, whatever their number."""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

import numpy as np

from chaosdrill.analysis.judgement.resting import is_left, rests
from chaosdrill.analysis.spans import check_record
from chaosdrill.analysis.tuning import SECTIONS
from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Record:
    """The recorded part of a run."""

    outcome: Outcome  # ``Outcome.OK``, or what ended the run before its time
    samples: np.ndarray  # (samples, n + q + 1): states, quadratures and mode
    events: np.ndarray
    """(events, 6 + 2 n): columns of the engine's event buffer, the states before and after from column 6 on."""
    times: np.ndarray  # (events,): time of each event since the start of the run

    @property
    def transitions(self) -> np.ndarray:
        """Transition of each event, int of shape (events,)."""
        return self.events[:, at.EVENT_KIND].astype(np.int64)

    def states_before(self) -> np.ndarray:
        """States before the events, shape (events, n)."""
        n = (self.events.shape[1] - at.EVENT_COLUMNS) // 2
        return self.events[:, at.EVENT_COLUMNS : at.EVENT_COLUMNS + n]

    def states_after(self) -> np.ndarray:
        """States after the events, shape (events, n)."""
        n = (self.events.shape[1] - at.EVENT_COLUMNS) // 2
        return self.events[:, at.EVENT_COLUMNS + n :]

    def modes_after(self, system: HybridSystem) -> np.ndarray:
        """Modes after the events, int of shape (events,)."""
        into = [-1 if t.marks_only() else system.mode_names.index(t.target) for t in system.transitions]
        led = np.array(into, dtype=np.int64)[self.transitions]
        return np.where(led < 0, self.events[:, at.EVENT_MODE].astype(np.int64), led)

    def of(self, transitions: Collection[int]) -> "Record":
        """The same record with the events of some transitions only."""
        kept = np.isin(self.events[:, at.EVENT_KIND], list(transitions))
        return Record(self.outcome, self.samples, self.events[kept], self.times[kept])

    def until(self, end: float, *, whole: bool) -> "Record":
        """The same record up to a time; what ended the run later does not count if all samples are there, ``whole``."""
        kept = self.times <= end + SECTIONS.rounding * abs(end)
        return Record(Outcome.OK if whole else self.outcome, self.samples, self.events[kept], self.times[kept])


def record(
    run: Run,
    periods: int,
    *,
    events: bool,
    times: np.ndarray | None = None,
    report: Callable[[int], None] | None = None,
    slices: int = SECTIONS.slices,
) -> Record:
    """Run on for a number of periods and keep all samples, or the states at some times, and all events if asked to.

    ``run``: it is continued. ``periods``: to go on for. ``events``: whether events are kept. ``times``: ascending times
    since the present strobe at which states are kept in place of samples. ``report``: called with the periods done,
    between the slices. ``slices``: parts between which an interruption is heard.
    """
    n, per_period = len(run.system.state_names), run.samples
    length = (periods + 1) * per_period + 2 if times is None else len(times)
    shape = (length, n + len(run.system.quadratures) + 1)
    check_record(*shape, "periods or samples")
    rows = np.zeros(shape)
    if times is not None:
        rows[:, :2] = _instants(times, run, periods)
    buffer = np.zeros((SECTIONS.event_rows if events else 0, at.EVENT_COLUMNS + 2 * n))
    start, first = run.elapsed, run.strobes
    found = [buffer[:0]]
    filled, outcome = 0, Outcome.OK
    # a run that has ended before has no periods to go on for, and must not be asked to
    for part in np.array_split(np.arange(periods), max(1, min(periods, slices))) if periods else ():
        target, full = len(part), True
        while full and outcome == Outcome.OK:
            outcome, full = run.advance(target, rows[filled:], buffer, instants=times is not None)
            target = 0
            samples, taken = run.filled()
            filled += samples
            found.append(buffer[:taken].copy())
        if report:
            report(run.strobes - first)
    table = np.concatenate(found)
    times = start + (table[:, at.EVENT_STROBES] - first) * run.period + table[:, at.EVENT_TIME]
    return Record(outcome, rows[:filled], table, times)


def _instants(times: np.ndarray, run: Run, periods: int) -> np.ndarray:
    """Times since the present strobe as numbers of strobes and what is left after these, exactly; shape (times, 2)."""
    unit = Fraction(run.period)
    found = np.zeros((len(times), 2))
    for row, time in zip(found, times.tolist(), strict=True):
        number, rest = divmod(Fraction(time), unit)
        # round-off may put the end of the record behind its last strobe
        row[:] = (run.strobes + number, float(rest)) if number < periods else (run.strobes + periods, 0.0)
    return found


def record_returns(
    run: Run,
    chosen: Collection[int],
    count: int,
    longest: float,
    *,
    every: bool = False,
    report: Callable[[int], None] | None = None,
) -> Record:
    """Run on to the ``count``-th event of the ``chosen`` transitions, directly after it, and keep these; no samples.

    ``run``: it is continued. ``longest``: a run that meets none in a whole multiple of this time, counted from its
    start, ends with ``Outcome.NO_RETURN``, or ``Outcome.EQUILIBRIUM`` if nothing moves any more; no step depends on
    where a record begins or ends. ``every``: whether all events are kept, not only those. ``report``: called with the
    events of the chosen transitions so far.
    """
    n, cell = len(run.system.state_names), max(1, math.ceil(longest / run.period))
    check_record(count, at.EVENT_COLUMNS + 2 * n, "periods")
    buffer = np.zeros((SECTIONS.event_rows, at.EVENT_COLUMNS + 2 * n))
    begin = run.elapsed - run.strobes * run.period - float(run.standing["time"])
    found, left, outcome, met = [buffer[:0]], count, Outcome.OK, -1
    if run.strobes % cell or run.standing["time"] > 0:
        met = run.strobes
    while left and outcome == Outcome.OK:
        target = (run.strobes // cell + 1) * cell
        outcome, full = run.advance(target - run.strobes, None, buffer[: min(left, SECTIONS.event_rows)])
        rows = buffer[: run.filled()[1]].copy()
        ours = np.isin(rows[:, at.EVENT_KIND], list(chosen))
        found.append(rows if every else rows[ours])
        left -= int(ours.sum())
        met = int(rows[ours, at.EVENT_STROBES].max(initial=met))
        if outcome == Outcome.OK and not full and met < target - cell:
            still = run.system.autonomous and rests(run.x[np.newaxis], run.sizes, flow_of(run), run.period)[0]
            still = still and not is_left(partial(flow_of, run), run.x, run.sizes)
            outcome = Outcome.EQUILIBRIUM if still else Outcome.NO_RETURN
        if report:
            report(count - left)
    table = np.concatenate(found)
    times = begin + table[:, at.EVENT_STROBES] * run.period + table[:, at.EVENT_TIME]
    return Record(outcome, np.zeros((0, n + len(run.system.quadratures) + 1)), table, times)


def flow_of(run: Run, state: np.ndarray | None = None, mode: int | None = None) -> np.ndarray:
    """Rates of the states where a run stands, or at another state and in another mode; shape (n,)."""
    system = run.system
    rates = np.zeros(len(run.x) + len(system.quadratures))
    place = run.x if state is None else np.ascontiguousarray(state)
    present = int(run.standing["mode"]) if mode is None else mode
    kernels_of(system).functions.field(present, float(run.standing["time"]), run.c, place, rates)
    return rates[: len(run.x)]


def time_of_motion(system: HybridSystem, numerics: Numerics) -> float:
    """Time in which the motion from the initial state crosses its own extent."""
    from chaosdrill.orbits.place import Place, characteristic_time

    few = min(numerics.max_events or SECTIONS.few_events, SECTIONS.few_events)
    return characteristic_time(Place(system), replace(numerics, max_events=few))

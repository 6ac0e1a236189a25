"""Where a run begins, and how fast it then moves."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.scales import SMALLEST
from chaosdrill.engine.setup import bounds_of
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Place:
    """A state on a motion, from which it can be continued."""

    system: "HybridSystem"  # with the state and the mode there as its initial ones
    phase: float = 0.0  # time in the forcing period
    came: Run | None = None
    """A run that has come there, whose guard signs are taken over. Without one the motion begins there."""

    def run(self, period: float, numerics: Numerics, **options: object) -> Run:
        """A run that continues from there; arguments as for `Run`."""
        run = Run(self.system, period, numerics, **options)  # type: ignore[arg-type]
        if self.came is not None:
            state = run.x.copy()
            run.continue_from(self.came)
            run.x[:] = state
        if self.system.forced:
            run.begin_at(self.phase)
        return run


def started(system: "HybridSystem", state: np.ndarray, mode: str) -> "HybridSystem":
    """The system with a different initial state."""
    return system.with_initial(**dict(zip(system.state_names, state.tolist(), strict=True)), mode=mode)


def reached(run: Run, numerics: Numerics) -> Place:
    """The place that a run has reached, at a strobe; the run may continue."""
    system = started(run.system, run.x, run.mode)
    here = Run(system, run.period, numerics)
    here.continue_from(run)
    return Place(system, 0.0, here)


def characteristic_time(place: Place, numerics: Numerics) -> float:
    """Time in which the motion from a place crosses its own extent, 1 if it does not move.

    A turn of a sinusoidal motion takes about nine of these units.
    """
    unit = _first_unit(place, numerics)
    for _ in range(TUNING.characteristic_rounds):
        better, steps = _crossing(place, numerics, unit)
        if not 1e-12 < better < 1e12 or (better > unit and steps > TUNING.characteristic_steps):
            return unit
        good = 1 / TUNING.characteristic_ratio <= better / unit <= TUNING.characteristic_ratio
        unit = better
        if good:
            break
    return unit


def _first_unit(place: Place, numerics: Numerics) -> float:
    """1, or the largest power of ten below it in which the motion stays within the allowed number of steps.

    The search goes upward: in a unit far from its own, a motion may take any number of steps.
    """
    if numerics.traits.fixed_step:
        return 1.0
    units: list[float] = (10.0 ** np.arange(-12, 1)).tolist()
    for unit in units[:-1]:
        run = place.run(unit, numerics)
        run.advance(1)
        if 10 * run.steps > TUNING.characteristic_steps:
            return unit
    return units[-1]


def _crossing(place: Place, numerics: Numerics, unit: float) -> tuple[float, int]:
    """The longest ratio of extent to mean rate among the states, from samples at this distance; and the steps taken.

    States that move one way only are ignored if there are others. For a motion that escapes, or has left for good
    without an end, the mean time between its events tells how fast it was before.
    """
    system = place.system
    d = len(system.state_names)
    run = place.run(unit, numerics, samples=TUNING.characteristic_samples)
    samples = np.zeros(
        ((TUNING.characteristic_units + 2) * TUNING.characteristic_samples, d + len(system.quadratures) + 1)
    )
    outcome, _ = run.advance(TUNING.characteristic_units, samples)
    between = _between_events(place, numerics, unit) if outcome == Outcome.ESCAPED else None
    if between:
        return between, run.steps
    rows = samples[: run.filled()[0]]
    if len(rows) < 2:
        return 0.0, run.steps
    rates = np.zeros((len(rows), d + len(system.quadratures)))
    times = np.arange(1, len(rows) + 1) * unit / TUNING.characteristic_samples
    for row, time, rate in zip(rows, times, rates, strict=True):
        kernels_of(system).functions.field(int(row[-1]), time, run.c, row[:d].copy(), rate)
    extent = np.ptp(rows[:, :d], axis=0)
    largest = np.maximum(np.abs(rates[:, :d]).max(axis=0), SMALLEST)
    mean = largest * np.sqrt(((rates[:, :d] / largest) ** 2).mean(axis=0))
    moving = (mean > 0) & (extent > 0)
    ways = extent[moving] / mean[moving]
    if run.steps <= len(rows):
        # samples show all motion; rates without motion are round-off along a stiff direction
        seen = np.ptp(times) * extent[moving] / np.abs(np.diff(rows[:, :d], axis=0)).sum(axis=0)[moving]
        ways = np.where(seen > np.maximum(unit, TUNING.characteristic_ratio * ways), seen, ways)
    returning = ways < TUNING.characteristic_units * unit / 2
    if not returning.any():
        between = _between_events(place, numerics, unit)
        if between:
            return between, run.steps
    return float((ways[returning] if returning.any() else ways).max(initial=0.0)), run.steps


def _between_events(place: Place, numerics: Numerics, unit: float) -> float | None:
    """Mean time between the events with an effect of these units; None if there are less than two."""
    events = within_bounds(place.system, *events_of(place.run(unit, numerics), TUNING.characteristic_units))
    times = events[:, layout.EVENT_STROBES] * unit + events[:, layout.EVENT_TIME]
    return float(np.diff(times).mean()) if len(times) > 1 else None


def events_until_escape(place: Place, numerics: Numerics, unit: float) -> np.ndarray:
    """Events with an effect, shape (E, columns), of a motion that escapes within these units; none if it stays."""
    outcome, events = events_of(place.run(unit, numerics), TUNING.characteristic_units)
    return within_bounds(place.system, outcome, events) if outcome == Outcome.ESCAPED else events[:0]


def drifts_until_guard(run: Run, drift: np.ndarray) -> float:
    """How often the state of a run moves on by ``drift``, shape (d,), until it meets a guard; infinite if it does not.

    Guards that a drift leaves as they are, as that of a foot that moves on with the body, do not count.
    """
    kernels, mode = kernels_of(run.system), run.system.mode_names.index(run.mode)
    gradient, nearest = np.zeros(len(drift) + 1), np.inf
    for j, event in enumerate(kernels.layout.events[mode]):
        if all(run.system.transitions[k].marks_only() for k in event.outcomes):
            continue
        value = kernels.functions.guard(mode, j, run.elapsed, run.c, run.x, gradient)
        moves = gradient[:-1] * drift
        way = moves.sum()
        if value * way < 0 <= event.direction * way and abs(way) > TUNING.drifts * np.abs(moves).sum():
            nearest = min(nearest, -value / way)
    return nearest


def is_slow(place: Place, numerics: Numerics, time: float) -> bool:
    """Whether a motion, followed for this time in few steps, meets events in its second half, or drifts towards one."""
    if numerics.traits.fixed_step:
        # its steps grow with the time
        return False
    run = place.run(time / 4, numerics)
    states, met = [run.x.copy()], []
    for _ in range(4):
        outcome, events = events_of(run, 1)
        if outcome != Outcome.OK or run.steps > TUNING.slow_steps:
            return False
        states.append(run.x.copy())
        met.append(len(events))
    before, last = np.diff(states, axis=0)[-2:]
    even = np.abs(last - before) <= TUNING.drifts * np.abs(last)
    return sum(met[2:]) > 0 or np.isfinite(drifts_until_guard(run, np.where(even, last, 0.0)))


def within_bounds(system: "HybridSystem", outcome: Outcome, events: np.ndarray) -> np.ndarray:
    """The events of a run, without the last if its reset left the bounds, or gave NaN, and so ended the run.

    After others a state may be beyond a bound by rounding, as at a wall there.
    """
    low, high = bounds_of(system)
    last = events[-1:, layout.EVENT_COLUMNS + len(system.state_names) :]
    ended = outcome in (Outcome.ESCAPED, Outcome.NONFINITE) and not ((low <= last) & (last <= high)).all()
    return events[:-1] if ended else events


def events_of(run: Run, periods: int, samples: np.ndarray | None = None) -> tuple[Outcome, np.ndarray]:
    """Events with an effect, over ``periods`` periods."""
    d = len(run.x)
    buffer = np.zeros((TUNING.most_events, layout.EVENT_COLUMNS + 2 * d))
    outcome, full = run.advance(periods, samples, buffer)
    if full:
        return Outcome.EVENT_LIMIT, buffer[:0]
    rows = buffer[: run.filled()[1]]
    changing = np.array([not t.marks_only() for t in run.system.transitions], dtype=bool)
    return outcome, rows[changing[rows[:, layout.EVENT_KIND].astype(int)]] if len(rows) else rows

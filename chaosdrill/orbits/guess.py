"""Initial guesses for orbits, read from ordinary simulations."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine import shooting as at
from chaosdrill.engine.run import Run
from chaosdrill.engine.setup import values_of_constrained
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.place import (
    Place,
    characteristic_time,
    events_of,
    is_slow,
    reached,
    started,
    within_bounds,
)
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.problem import Problem


def standpoint(problem: "Problem", orbit: Orbit) -> tuple[int, float, np.ndarray]:
    """Middle of the longest segment: its number, the time since the start of the orbit, the state.

    No event is near there, so that a run from there meets all of them.
    """
    longest = int(orbit.durations.argmax())
    step = (problem.unit or 1.0) / problem.numerics.steps_a_period
    clock = orbit.phase if problem.forced else 0.0
    middle = float(orbit.durations[:longest].sum() + orbit.durations[longest] / 2)
    # fixed steps fall where those of the orbit fell
    on_grid = round((clock + middle) / step) * step - clock
    if abs(on_grid - middle) < orbit.durations[longest] / 2:
        middle = on_grid
    return longest, middle, problem.at([orbit], np.array([[middle]]))[0][0, 0]


def place_on(problem: "Problem", orbit: Orbit, segment: int, time: float, state: np.ndarray) -> Place:
    """A place within a segment of an orbit.

    The signs of the guards come from a run from the event at which the segment began. States that the mode constrains
    get the values that it gives them, so that round-off does not decide on which side of a guard they lie.

    ``segment``, ``time``, ``state``: number of the segment, time since the start of the orbit, state of shape (d,).
    """
    values = dict(zip(problem.free, orbit.starts[0, problem.states :].tolist(), strict=True))
    system = problem.plain.with_parameters(**values)
    mode = system.mode_names[orbit.segments[segment, at.SEGMENT_MODE]]
    forcing = system.forcing_period()
    before = float(orbit.durations[:segment].sum())
    phase, began = orbit.phase + time, orbit.phase + before
    if forcing:
        phase, began = phase % forcing, began % forcing
    state, start = (
        _pinned(system, int(orbit.segments[segment, at.SEGMENT_MODE]), there, when)
        for there, when in ((state, phase), (orbit.starts[segment, : problem.states], began))
    )
    came = None
    taken = int(orbit.segments[segment - 1, at.SEGMENT_OUTCOME])
    if taken >= 0 and time > before:
        run = Place(started(system, start, mode), began).run(time - before, problem.numerics)
        run.fix_step(step_of(problem, forcing))
        run.just_took(taken)
        came = run if run.advance(1)[0] == Outcome.OK and run.mode == mode else None
    return Place(started(system, state, mode), phase, came)


def _pinned(system: "HybridSystem", mode: int, state: np.ndarray, time: float) -> np.ndarray:
    """A state with the constrained components of a mode at their values."""
    held = state.copy()
    for i, value in values_of_constrained(system, {}, mode, time).items():
        held[i] = value
    return held


def step_of(problem: "Problem", forcing: float | None) -> float:
    """Step of a fixed-step method, the same wherever a run of a system begins."""
    return (forcing or problem.unit or 1.0) / problem.numerics.steps_a_period


def run_from(
    problem: "Problem",
    orbit: Orbit,
    segment: int,
    time: float,
    state: np.ndarray,
    parts: int = 1,
    **options: object,
) -> Run:
    """A run of the ordinary engine that begins on an orbit.

    ``segment``, ``time``, ``state``: where, as for `place_on`. ``parts``: the period of the run is that of the forcing,
    or the whole orbit without forcing; with ``parts``, that fraction of the whole orbit. ``options``: passed on to
    `Run`.
    """
    place = place_on(problem, orbit, segment, time, state)
    forcing = place.system.forcing_period()
    period = float(orbit.durations.sum()) / parts if parts > 1 or not forcing else forcing
    run = place.run(period, problem.numerics, **options)
    run.fix_step(step_of(problem, forcing))
    return run


def unit_of(problem: "Problem", place: Place) -> float:
    """Forcing period, or the characteristic time of the first motion."""
    if problem.unit is None:
        problem.set_unit(characteristic_time(place, problem.numerics))
    assert problem.unit is not None
    return problem.unit


def settled(problem: "Problem", transient: float) -> tuple[Outcome, Run]:
    """The run from the system's initial state over a transient, up to phase 0, and its outcome.

    The transient counts forcing periods, or time without forcing.
    """
    parts = int(np.ceil(transient)) if problem.forced else TUNING.transient_parts
    run = Run(problem.plain, problem.period or max(transient, 1e-300) / TUNING.transient_parts, problem.numerics)
    return run.advance(parts)[0] if transient else Outcome.OK, run


InitialGuess = Callable[[], tuple[Outcome, Orbit | None]]
"""Reads a guess of an orbit: returns ``Outcome.OK`` or the reason why the run ended, and the guess if there is one."""


def initial_guess(problem: "Problem", place: Place, periods: int) -> InitialGuess:
    """A function that simulates the path from a place over a number of periods; without forcing, until it returns."""
    values = np.array([problem.plain.parameters[name] for name in problem.free])
    if problem.forced:
        return partial(guess_of_forced, problem, place, periods, values)
    return partial(guess_of_return, problem, place, values)


def guess_of_forced(problem: "Problem", place: Place, periods: int, values: np.ndarray) -> tuple[Outcome, Orbit | None]:
    """The path from a place over ``periods`` forcing periods, as a guess for an orbit.

    ``values``, shape (q,): free parameters, as they are in the system of the place.

    Returns the outcome, ``Outcome.OK`` or the reason why the run ended early, and the orbit, if there is one.
    """
    period = place.system.forcing_period()
    assert period is not None
    run = place.run(period, problem.numerics)
    state, mode = run.x.copy(), run.mode
    outcome, events = events_of(run, periods)
    if outcome != Outcome.OK:
        return outcome, None
    return outcome, _round(problem, events, place.phase, state, mode, periods, values, period, run.x - state)


def _round(
    problem: "Problem",
    events: np.ndarray,
    phase: float,
    state: np.ndarray,
    mode: str,
    periods: int,
    values: np.ndarray,
    period: float,
    moved: np.ndarray,
) -> Orbit | None:
    """The path from a state and phase over ``periods`` periods, with its events; the state changes by ``moved``."""
    if not len(events):
        if phase > 0:
            rest = np.array([period - phase])
            segment = np.array([[problem.system.mode_names.index(mode), at.SHARE, -1]], dtype=np.int64)
            ahead = Orbit(segment, 1, np.concatenate([state, values])[np.newaxis], phase, rest)
            state = problem.at([ahead], rest[np.newaxis])[0][0, 0]
        return eventless(problem, state, mode, periods, values, period)
    times = events[:, layout.EVENT_STROBES] * period + events[:, layout.EVENT_TIME]
    durations = np.diff(times, prepend=times[-1] - periods * period)
    orbit = orbit_of_events(problem, events, durations, periods, values, float((phase + times[-1]) % period), moved)
    return orbit if _connected(problem, orbit) else None


def returns(problem: "Problem", run: Run, periods: int) -> list[InitialGuess]:
    """Functions that simulate the closest returns of a run after ``periods`` periods, the closest first.

    Without forcing: spread out along the run.
    """
    place = reached(run, problem.numerics)
    run = place.run(unit_of(problem, place), problem.numerics)
    if not problem.forced:
        places = [place]
        while len(places) < TUNING.places and run.advance(1)[0] == Outcome.OK:
            places.append(reached(run, problem.numerics))
        return [initial_guess(problem, one, periods) for one in places]
    record = strobed(run, TUNING.returns_recorded + periods)
    states = record.states
    if len(states) <= periods:
        return [lambda: (record.outcome, None)]
    spread = np.maximum(problem.shifts.extent(states), _unmoved(problem, states))
    last = len(states) - periods

    def away(steps: int) -> np.ndarray:
        moved = problem.shifts.across(states[steps : steps + last] - states[:last])
        return np.asarray((np.abs(moved) / spread).max(axis=1))

    whole, parts = away(periods), [q for q in range(1, periods) if periods % q == 0]
    # an earlier return leads to an orbit of a shorter period
    sooner = np.min([away(q) for q in parts], axis=0) < TUNING.sooner * whole if parts else np.zeros(last, dtype=bool)
    return [partial(record.guess, problem, j, periods) for j in np.lexsort((whole, sooner))[: TUNING.places].tolist()]


def _unmoved(problem: "Problem", states: np.ndarray) -> np.ndarray:
    """Extents of states, shape (d,), below which they rest but for rounding."""
    return np.asarray(TUNING.at_rest * np.maximum(np.abs(states).max(axis=0), problem.sizes))


@dataclass(frozen=True)
class Strobed:
    """A motion as its strobes show it, m of them."""

    outcome: Outcome  # why it ended early; otherwise ``Outcome.OK``
    states: np.ndarray  # (m, d): its start first
    modes: np.ndarray  # int (m,)
    sequences: np.ndarray
    """int (m,): number of the sequence of events from the strobe before; 0 for the first state."""
    rows: np.ndarray  # (E, columns): events that change something, as the engine records them

    def guess(self, problem: "Problem", j: int, periods: int) -> tuple[Outcome, Orbit | None]:
        """The path over some periods from strobe j, as a guess of an orbit."""
        assert problem.period is not None
        since = self.rows[:, layout.EVENT_STROBES] - j
        events = self.rows[(since >= 0) & (since < periods)].copy()
        events[:, layout.EVENT_STROBES] -= j
        values = np.array([problem.plain.parameters[name] for name in problem.free])
        mode = problem.plain.mode_names[self.modes[j]]
        state, moved = self.states[j], self.states[j + periods] - self.states[j]
        return Outcome.OK, _round(problem, events, 0.0, state, mode, periods, values, problem.period, moved)


def strobed(run: Run, length: int) -> Strobed:
    """The strobes of a run, at most ``length`` after its start."""
    d = len(run.x)
    samples = np.zeros((length + 3, d + len(run.system.quadratures) + 1))
    buffer = np.zeros((TUNING.most_events, layout.EVENT_COLUMNS + 2 * d))
    start, mode = run.x.copy(), run.system.mode_names.index(run.mode)
    taken, rows, target, full, outcome = 0, [], length, True, Outcome.OK
    while full:
        outcome, full = run.advance(target, samples[taken:], buffer)
        target = 0
        new, events = run.filled()
        taken += new
        rows.append(buffer[:events].copy())
    table = np.concatenate(rows)
    changing = np.array([not t.marks_only() for t in run.system.transitions], dtype=bool)
    kinds = table[:, layout.EVENT_KIND].astype(np.int64)
    table = table[changing[kinds]] if len(kinds) else table
    kinds = table[:, layout.EVENT_KIND].astype(np.int64)
    ends = np.searchsorted(table[:, layout.EVENT_STROBES].astype(np.int64), np.arange(taken + 1))
    sequences = [hash(tuple(kinds[a:b].tolist())) for a, b in pairwise(ends)]
    return Strobed(
        outcome,
        np.vstack([start, samples[:taken, :d]]),
        np.concatenate([[mode], samples[:taken, -1]]).astype(np.int64),
        np.array([0, *sequences], dtype=np.int64),
        table,
    )


def guess_of_return(problem: "Problem", place: Place, values: np.ndarray) -> tuple[Outcome, Orbit | None]:
    """The path from a place until it returns, as a guess for an orbit of an autonomous system."""
    first = unit = unit_of(problem, place)
    last = TUNING.return_units[-1]
    for units in TUNING.return_units:
        outcome, guess = guess_of_autonomous(problem, place, units * unit, values, near=units < last)
        if outcome == Outcome.EQUILIBRIUM:
            return Outcome.OK, None
        if guess is not None or outcome != Outcome.OK:
            break
    while guess is None and outcome == Outcome.OK and is_slow(place, problem.numerics, last * unit):
        unit *= TUNING.slower_unit
        problem.set_unit(unit)
        outcome, guess = guess_of_autonomous(problem, place, last * unit, values)
    if guess is None:
        problem.set_unit(first)
    return outcome, guess


def guess_of_autonomous(
    problem: "Problem",
    place: Place,
    duration: float,
    values: np.ndarray,
    expected: float | None = None,
    *,
    near: bool = False,
) -> tuple[Outcome, Orbit | None]:
    """The path from a place until it returns within a duration, as a guess for an orbit.

    It returns after the expected time if there is one, otherwise at the first return that is about as close as any
    other; without events a longer duration may show a closer one, unless it is ``near``. A motion that ends early, for
    instance by escaping, may have returned before. One that is ``near`` and did not return before it came to rest has
    the outcome ``Outcome.EQUILIBRIUM``, as a longer duration shows no more of it.
    """
    system = place.system
    unit = unit_of(problem, place)
    run = place.run(unit, problem.numerics, samples=TUNING.return_samples)
    state, mode = run.x.copy(), run.mode
    whole = int(np.ceil(duration / unit))
    samples = np.zeros(((whole + 2) * TUNING.return_samples, len(state) + len(system.quadratures) + 1))
    outcome, events = events_of(run, whole, samples)
    d, ended, shifts = len(state), outcome != Outcome.OK, problem.shifts
    path = np.vstack([state, samples[: run.filled()[0], :d]])
    if ended:
        events = within_bounds(system, outcome, events)
        if expected is not None and run.elapsed < expected:
            return outcome, None
    there = 0 if expected is None else min(round(expected / unit * TUNING.return_samples), len(path) - 1)
    moved = path[there] - state
    least = _unmoved(problem, path)
    if near and not ended:
        end = TUNING.return_units[0]
        since = events[:, layout.EVENT_STROBES] >= whole - end
        if not since.any() and (np.ptp(path[-end * TUNING.return_samples :], axis=0) <= least).all():
            outcome = Outcome.EQUILIBRIUM
    if len(events):
        orbit = _back_at_event(problem, events, unit, values, expected, moved)
        return (outcome, None) if orbit is None else (Outcome.OK, orbit)
    segments = np.array([[problem.system.mode_names.index(mode), at.PLANE, -1]], dtype=np.int64)
    starts = np.concatenate([state, values])[np.newaxis]
    resting = shifts.still(path)
    extent = np.ptp(resting, axis=0)
    if (extent <= least).all():
        return outcome, None
    if expected is not None:
        return Outcome.OK, Orbit(segments, 1, starts, 0.0, np.array([expected]), drift_in(problem, moved))
    if ended:
        # up to there: a motion that escapes is farther away than any return
        extent = np.maximum.accumulate(resting) - np.minimum.accumulate(resting)
    away = shifts.across(path - state)
    if len(shifts.turns) and not ended:
        extent = np.ptp(away, axis=0)
    back = _first_return(np.abs(away) / np.maximum(extent, least), near or ended)
    if back is None:
        return outcome, None
    lasting = np.array([back * unit / TUNING.return_samples])
    guess = Orbit(segments, 1, starts, 0.0, lasting, drift_in(problem, path[back] - state))
    return Outcome.OK, _to_plane(problem, guess, unit / TUNING.return_samples)


def _back_at_event(
    problem: "Problem", events: np.ndarray, unit: float, values: np.ndarray, expected: float | None, moved: np.ndarray
) -> Orbit | None:
    """The path from the first event to where it comes back, or all that precedes the expected time, in which the state
    has moved as given."""
    begun, times = None, events[:, layout.EVENT_STROBES] * unit + events[:, layout.EVENT_TIME]
    if expected is None:
        states, kinds = events[:, layout.EVENT_COLUMNS + problem.states :], events[:, layout.EVENT_KIND]
        last = _shortest_return(problem.shifts.across(states - states[0]), states, kinds, problem.sizes)
        if last is None:
            return None
        durations, events = np.diff(times)[:last], events[1 : last + 1]
        begun, moved = states[0], states[last] - states[0]
    else:
        times = times[times < expected]
        events, durations = events[: len(times)], np.diff(times, prepend=times[-1:] - expected)
    if not len(events):
        return None
    orbit = orbit_of_events(problem, events, durations, 1, values, 0.0, moved, begun)
    return orbit if _connected(problem, orbit) else None


def _to_plane(problem: "Problem", guess: Orbit, most: float) -> Orbit:
    """A smooth path that ends on the plane across the flow at its start, if it does so within a time ``most``.

    Newton's method leaves a motion that returns exactly where it is, also where it is one of a family.
    """
    state, sizes, one = guess.starts[0, : problem.states], problem.sizes, guess
    flow = problem.flow_at(guess) / sizes
    for _ in range(TUNING.to_plane):
        moved = problem.shifts.across(problem.at([one], one.durations[np.newaxis])[0][0, 0] - state) / sizes
        one = replace(one, durations=one.durations - flow @ moved / (flow @ flow))
        if not abs(one.durations[0] - guess.durations[0]) <= most:
            return guess
    return one


def own_path(
    problem: "Problem", orbit: Orbit, values: np.ndarray | None = None, expected: float | None = None
) -> tuple[Outcome, Orbit | None]:
    """The motion of the system from the middle of an orbit's longest segment, as a guess for an orbit.

    ``values`` are the free parameters, if not those of the orbit; ``expected`` is as for `guess_of_autonomous`.
    """
    segment, time, state = standpoint(problem, orbit)
    values = orbit.starts[0, problem.states :] if values is None else values
    place = place_on(problem, orbit.with_values(values, problem.states), segment, time, state)
    if problem.forced:
        return guess_of_forced(problem, place, orbit.periods, values)
    return guess_of_autonomous(problem, place, 2 * float(orbit.durations.sum()), values, expected)


def _first_return(away: np.ndarray, near: bool) -> int | None:
    """Index of the first local minimum of the distance that is comparable to the smallest one.

    ``away``, shape (T, d): distances from the first state, as fractions of the extent of each state. ``near``: whether
    a return must be as close as a state that has not left yet.

    None if the motion does not leave, or does not return.
    """
    distance = away.max(axis=1)
    left = np.flatnonzero(distance > TUNING.left)
    if not len(left):
        return None
    inner = (
        left[0] + np.flatnonzero((np.diff(distance[left[0] :])[:-1] <= 0) & (np.diff(distance[left[0] :])[1:] >= 0)) + 1
    )
    if near:
        inner = inner[distance[inner] <= TUNING.left]
    if not len(inner):
        return None
    return int(inner[distance[inner] <= max(2 * distance[inner].min(), TUNING.back)][0])


def drift_in(problem: "Problem", moved: np.ndarray) -> np.ndarray | None:
    """The shift contained in the change of a state; None without one."""
    drift = problem.shifts.part(moved) if problem.shifts else np.zeros(0)
    return drift if drift.any() else None


def _shortest_return(away: np.ndarray, states: np.ndarray, kinds: np.ndarray, sizes: np.ndarray) -> int | None:
    """Number of events after which the first one recurs most closely; None if its kind never recurs.

    ``away`` is the difference of each state from the first, without shifts; ``sizes`` are the sizes of the states.
    """
    same = np.flatnonzero(kinds[1:] == kinds[0]) + 1
    if not len(same):
        return None
    spread = np.maximum(np.ptp(away, axis=0), 1e-12 * np.maximum(np.abs(states).max(axis=0), sizes))
    away = (np.abs(away[same]) / spread).max(axis=1)
    good = same[away <= max(2 * away.min(), TUNING.back)]
    return int(good[0])


def orbit_of_events(
    problem: "Problem",
    events: np.ndarray,
    durations: np.ndarray,
    periods: int,
    values: np.ndarray,
    phase: float,
    moved: np.ndarray,
    begun: np.ndarray | None = None,
) -> Orbit:
    """The round that ends with the last of the events; the state changes in it by ``moved``, shape (d,).

    It begins in the state ``begun``, as the first duration did; if it is not known, where the last event led.
    """
    d = problem.states
    guards = kernels_of(problem.system).layout.events
    segments = np.zeros((len(events), 3), dtype=np.int64)
    for segment, row in zip(segments, events, strict=True):
        mode, kind = int(row[layout.EVENT_MODE]), int(row[layout.EVENT_KIND])
        segment[:] = mode, next(j for j, e in enumerate(guards[mode]) if kind in e.outcomes), kind
    after = np.roll(events[:, layout.EVENT_COLUMNS + d : layout.EVENT_COLUMNS + 2 * d], 1, axis=0)
    starts = np.column_stack([after, np.tile(values, (len(events), 1))])
    orbit = Orbit(segments, periods, starts, phase, durations, drift_in(problem, moved))
    if begun is not None:
        starts[0, :d] = begun
    elif orbit.drift is not None:
        # it begins where the last event led, a drift further
        starts[1:] += orbit.moved_on()
    return orbit


def _connected(problem: "Problem", orbit: Orbit) -> bool:
    """Whether every event leads into the mode of the next segment; on an open path the last one need not."""
    targets = [problem.plain.transitions[k].target for k in orbit.segments[:, at.SEGMENT_OUTCOME]]
    modes = [problem.system.mode_names[m] for m in np.roll(orbit.segments[:, at.SEGMENT_MODE], -1)]
    return targets == modes


def eventless(
    problem: "Problem", state: np.ndarray, mode: str, periods: int, values: np.ndarray, period: float
) -> Orbit:
    segments = np.tile([problem.system.mode_names.index(mode), at.SHARE, -1], (periods, 1)).astype(np.int64)
    whole = np.full(periods, period)
    one = Orbit(segments[:1], 1, np.concatenate([state, values])[np.newaxis], 0.0, whole[:1])
    long = Orbit(one.segments, 1, one.starts, 0.0, np.array([periods * period]))
    path = problem.at([long], np.arange(periods + 1)[np.newaxis] * period)[0][0]
    starts = np.column_stack([path[:-1], np.tile(values, (periods, 1))])
    return Orbit(segments, periods, starts, 0.0, whole, drift_in(problem, path[-1] - path[0]))


def with_values(problem: "Problem", values: np.ndarray) -> "HybridSystem":
    """The plain system at values of the free parameters."""
    return problem.plain.with_parameters(**dict(zip(problem.free, values.tolist(), strict=True)))

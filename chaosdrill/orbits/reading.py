"""Guesses of orbits, read off runs of the ordinary engine."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.engine import layout
from chaosdrill.engine.run import Run
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.pace import unit_of
from chaosdrill.orbits.place import Place, place_on, reached, standpoint

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family

MOST_EVENTS = 4096
"""Events of one orbit; more are chatter that is not completed."""


def settled(family: "Family", transient: float) -> tuple[Outcome, Run]:
    """The run from the system's initial state over a transient, to a phase 0, and how it went.

    The transient is in forcing periods, or a time where there are none.
    """
    parts = int(np.ceil(transient)) if family.forced else PARTS
    run = Run(family.plain, family.period or max(transient, 1e-300) / PARTS, family.numerics)
    return run.advance(parts)[0] if transient else Outcome.OK, run


Reading = Callable[[], tuple[Outcome, Orbit | None]]
"""What reads a guess of an orbit: ``Outcome.OK`` or what ended the run, and the guess if there is one."""


def reading_from(family: "Family", place: Place, periods: int) -> Reading:
    """What reads the path from a place over so many forcing periods; without forcing, until it is back."""
    values = np.array([family.plain.parameters[name] for name in family.free])
    if family.forced:
        return partial(guess_of_forced, family, place, periods, values)
    return partial(guess_of_return, family, place, values)


def guess_of_forced(family: "Family", place: Place, periods: int, values: np.ndarray) -> tuple[Outcome, Orbit | None]:
    """The path from a place over so many forcing periods, as a guess of an orbit.

    Parameters
    ----------
    family : Family
    place : Place
    periods : int
    values : ndarray, shape (q,)
        Free parameters, as they are in the system of the place.

    Returns
    -------
    outcome : Outcome
        ``Outcome.OK``, or what ended the run before.
    orbit : Orbit or None
    """
    period = place.system.forcing_period()
    assert period is not None
    run = place.run(period, family.numerics)
    state, mode = run.x.copy(), run.mode
    outcome, events = _events(run, periods)
    if outcome != Outcome.OK:
        return outcome, None
    return outcome, _round(family, events, place.phase, state, mode, periods, values, period)


def _round(
    family: "Family",
    events: np.ndarray,
    phase: float,
    state: np.ndarray,
    mode: str,
    periods: int,
    values: np.ndarray,
    period: float,
) -> Orbit | None:
    """The path from a state at a phase on, over so many periods, with the events in them."""
    if not len(events):
        if phase > 0:
            rest = np.array([period - phase])
            arc = np.array([[family.system.mode_names.index(mode), at.SHARE, -1]], dtype=np.int64)
            ahead = Orbit(arc, 1, np.concatenate([state, values])[np.newaxis], phase, rest)
            state = family.at([ahead], rest[np.newaxis])[0][0, 0]
        return eventless(family, state, mode, periods, values, period)
    times = events[:, layout.EVENT_STROBES] * period + events[:, layout.EVENT_TIME]
    durations = np.diff(times, prepend=times[-1] - periods * period)
    orbit = orbit_of_events(family, events, durations, periods, values, float((phase + times[-1]) % period))
    return orbit if _connected(family, orbit) else None


def returns(family: "Family", run: Run, periods: int) -> list[Reading]:
    """What reads the motion of a run where it comes back most nearly after so many periods, the nearest first.

    Of systems without a period: at some distances along it.
    """
    place = reached(run, family.numerics)
    run = place.run(unit_of(family, place), family.numerics)
    if not family.forced:
        places = [place]
        while len(places) < PLACES and run.advance(1)[0] == Outcome.OK:
            places.append(reached(run, family.numerics))
        return [reading_from(family, one, periods) for one in places]
    record = strobed(run, RECORD + periods)
    states = record.states
    if len(states) <= periods:
        return [lambda: (record.outcome, None)]
    spread = np.maximum(np.ptp(states, axis=0), 1e-9 * np.maximum(np.abs(states).max(axis=0), 1.0))
    last = len(states) - periods

    def away(steps: int) -> np.ndarray:
        return np.asarray((np.abs(states[steps : steps + last] - states[:last]) / spread).max(axis=1))

    whole, parts = away(periods), [q for q in range(1, periods) if periods % q == 0]
    # what is back sooner leads to an orbit of a shorter period
    sooner = np.min([away(q) for q in parts], axis=0) < SOONER * whole if parts else np.zeros(last, dtype=bool)
    return [partial(record.guess, family, j, periods) for j in np.lexsort((whole, sooner))[:PLACES].tolist()]


@dataclass(frozen=True)
class Strobed:
    """A motion as its strobes show it, m of them.

    Attributes
    ----------
    outcome : Outcome
        What ended it before its time, else ``Outcome.OK``.
    states : ndarray, shape (m, d)
        Its start first.
    modes : ndarray of int, shape (m,)
    sequences : ndarray of int, shape (m,)
        A number that stands for the sequence of events from the strobe before; 0 for the first state.
    rows : ndarray, shape (E, columns)
        Events that change something, as the engine records them.
    """

    outcome: Outcome
    states: np.ndarray
    modes: np.ndarray
    sequences: np.ndarray
    rows: np.ndarray

    def guess(self, family: "Family", j: int, periods: int) -> tuple[Outcome, Orbit | None]:
        """The path from strobe j on over so many periods, as a guess of an orbit."""
        assert family.period is not None
        since = self.rows[:, layout.EVENT_STROBES] - j
        events = self.rows[(since >= 0) & (since < periods)].copy()
        events[:, layout.EVENT_STROBES] -= j
        values = np.array([family.plain.parameters[name] for name in family.free])
        mode = family.plain.mode_names[self.modes[j]]
        return Outcome.OK, _round(family, events, 0.0, self.states[j], mode, periods, values, family.period)


def strobed(run: Run, length: int) -> Strobed:
    """What the strobes of a run show, at most so many beside its start."""
    d = len(run.x)
    samples = np.zeros((length + 3, d + len(run.system.quadratures) + 1))
    buffer = np.zeros((MOST_EVENTS, layout.EVENT_COLUMNS + 2 * d))
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


def guess_of_return(family: "Family", place: Place, values: np.ndarray) -> tuple[Outcome, Orbit | None]:
    """The path from a place until it is back, as a guess of an orbit of a system without a period."""
    unit, outcome, guess = unit_of(family, place), Outcome.OK, None
    units = SHORTEST_RETURN
    while guess is None and outcome == Outcome.OK and units <= LONGEST_RETURN:
        outcome, guess = guess_of_autonomous(family, place, units * unit, values)
        units *= 8
    return outcome, guess


def guess_of_autonomous(
    family: "Family", place: Place, duration: float, values: np.ndarray, expected: float | None = None
) -> tuple[Outcome, Orbit | None]:
    """The path from a place until it is back, within a duration, as a guess of an orbit.

    It is taken to be back after the time that is expected, or else at the first return that is as near as any.
    """
    system = place.system
    unit = unit_of(family, place)
    run = place.run(unit, family.numerics, samples=SAMPLES)
    state, mode = run.x.copy(), run.mode
    whole = int(np.ceil(duration / unit))
    samples = np.zeros(((whole + 2) * SAMPLES, len(state) + len(system.quadratures) + 1))
    outcome, events = _events(run, whole, samples)
    if outcome != Outcome.OK:
        return outcome, None
    d = len(state)
    if len(events):
        times = events[:, layout.EVENT_STROBES] * unit + events[:, layout.EVENT_TIME]
        if expected is None:
            last = _shortest_return(events[:, layout.EVENT_COLUMNS + d :], events[:, layout.EVENT_KIND])
            if last is None:
                return outcome, None
            durations, events = np.diff(times)[:last], events[1 : last + 1]
        else:
            times = times[times < expected]
            events, durations = events[: len(times)], np.diff(times, prepend=times[-1:] - expected)
        if not len(events):
            return outcome, None
        orbit = orbit_of_events(family, events, durations, 1, values, 0.0)
        return outcome, orbit if _connected(family, orbit) else None
    path = np.vstack([state, samples[: run.filled()[0], :d]])
    away = np.abs(path - state).max(axis=1)
    size = np.abs(path - path.mean(axis=0)).max()
    if size <= 1e-9 * max(1.0, np.abs(path).max()):
        return outcome, None
    left = np.flatnonzero(away > 0.2 * size)
    if not len(left):
        return outcome, None
    back = left[0] + _first_dip(away[left[0] :])
    arcs = np.array([[family.system.mode_names.index(mode), at.PLANE, -1]], dtype=np.int64)
    starts = np.concatenate([state, values])[np.newaxis]
    return outcome, Orbit(arcs, 1, starts, 0.0, np.array([back * unit / SAMPLES]))


def own_path(
    family: "Family", orbit: Orbit, values: np.ndarray | None = None, expected: float | None = None
) -> tuple[Outcome, Orbit | None]:
    """What the system itself does from the middle of an orbit's longest arc on, as a guess of an orbit.

    ``values`` are the free parameters, if not those of the orbit; ``expected`` is as for `guess_of_autonomous`.
    """
    arc, time, state = standpoint(family, orbit)
    values = orbit.starts[0, family.states :] if values is None else values
    place = place_on(family, orbit.with_values(values, family.states), arc, time, state)
    if family.forced:
        return guess_of_forced(family, place, orbit.periods, values)
    return guess_of_autonomous(family, place, 2 * float(orbit.durations.sum()), values, expected)


RECORD = 256
"""Periods over which the nearest returns are looked for."""

SOONER = 3.0
"""Times the distance after a period within which a state is back after a part of it that counts."""

PLACES = 8
"""Places from which an orbit near an attractor is looked for."""

SHORTEST_RETURN, LONGEST_RETURN = 32, 2048
"""Units of the motion's pace within which a system without a period is to return: the first tried, and the last."""

PARTS = 64
"""Parts of a transient given as a time."""

SAMPLES = 64
"""Samples a unit, where a path without events is searched for its return."""

NEAR = 0.05
"""Part of the spread of the states within which a state counts as back."""


def _first_dip(away: np.ndarray) -> int:
    """Index of the first local minimum that is not much larger than the smallest value."""
    inner = np.flatnonzero((away[1:-1] <= away[:-2]) & (away[1:-1] <= away[2:])) + 1
    if not len(inner):
        return int(away.argmin())
    good = inner[away[inner] <= max(2 * away[inner].min(), NEAR * away.max())]
    return int(good[0])


def _shortest_return(states: np.ndarray, kinds: np.ndarray) -> int | None:
    """Number of events after which the first one comes again, as nearly as it does; None if its kind never does."""
    same = np.flatnonzero(kinds[1:] == kinds[0]) + 1
    if not len(same):
        return None
    spread = np.maximum(np.ptp(states, axis=0), 1e-12)
    away = (np.abs(states[same] - states[0]) / spread).max(axis=1)
    good = same[away <= max(2 * away.min(), NEAR)]
    return int(good[0])


def _events(run: Run, periods: int, samples: np.ndarray | None = None) -> tuple[Outcome, np.ndarray]:
    """Events that change something, over so many periods."""
    d = len(run.x)
    buffer = np.zeros((MOST_EVENTS, layout.EVENT_COLUMNS + 2 * d))
    outcome, full = run.advance(periods, samples, buffer)
    if full:
        return Outcome.EVENT_LIMIT, buffer[:0]
    rows = buffer[: run.filled()[1]]
    changing = np.array([not t.marks_only() for t in run.system.transitions], dtype=bool)
    return outcome, rows[changing[rows[:, layout.EVENT_KIND].astype(int)]] if len(rows) else rows


def orbit_of_events(
    family: "Family", events: np.ndarray, durations: np.ndarray, periods: int, values: np.ndarray, phase: float
) -> Orbit:
    d = family.states
    guards = family.system.kernels.events
    arcs = np.zeros((len(events), 3), dtype=np.int64)
    for arc, row in zip(arcs, events, strict=True):
        mode, kind = int(row[layout.EVENT_MODE]), int(row[layout.EVENT_KIND])
        arc[:] = mode, next(j for j, e in enumerate(guards[mode]) if kind in e.outcomes), kind
    after = np.roll(events[:, layout.EVENT_COLUMNS + d : layout.EVENT_COLUMNS + 2 * d], 1, axis=0)
    starts = np.column_stack([after, np.tile(values, (len(events), 1))])
    return Orbit(arcs, periods, starts, phase, durations)


def _connected(family: "Family", orbit: Orbit) -> bool:
    """Whether every event leads into the mode of the next arc; the last one may not, on a path that is no cycle."""
    targets = [family.plain.transitions[k].target for k in orbit.arcs[:, at.ARC_OUTCOME]]
    modes = [family.system.mode_names[m] for m in np.roll(orbit.arcs[:, at.ARC_MODE], -1)]
    return targets == modes


def eventless(family: "Family", state: np.ndarray, mode: str, periods: int, values: np.ndarray, period: float) -> Orbit:
    arcs = np.tile([family.system.mode_names.index(mode), at.SHARE, -1], (periods, 1)).astype(np.int64)
    whole = np.full(periods, period)
    one = Orbit(arcs[:1], 1, np.concatenate([state, values])[np.newaxis], 0.0, whole[:1])
    long = Orbit(one.arcs, 1, one.starts, 0.0, np.array([periods * period]))
    path = family.at([long], np.arange(periods)[np.newaxis] * period)[0][0]
    return Orbit(arcs, periods, np.column_stack([path, np.tile(values, (periods, 1))]), 0.0, whole)


def with_values(family: "Family", values: np.ndarray) -> "HybridSystem":
    """The plain system at values of the free parameters."""
    return family.plain.with_parameters(**dict(zip(family.free, values.tolist(), strict=True)))

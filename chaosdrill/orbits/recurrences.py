"""Where motions nearly come back: guesses of orbits, the nearest returns first."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, zip_longest
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.engine import layout
from chaosdrill.engine.setup import pins
from chaosdrill.orbits.find import orbit_read, solved
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.pace import unit_of
from chaosdrill.orbits.place import Place, started
from chaosdrill.orbits.reading import Strobed, orbit_of_events, strobed

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family, Lap

RECORD = 3000
"""Strobes, events or maxima recorded from each start."""

SCATTERED = 500
"""Random starts beside the given ones."""

SHORT = 8
"""Record of a random start, in units of the longest period that is looked for."""

WIDER = 0.5
"""Part of the extent of the recorded states by which the box of random starts reaches beyond them on every side."""

A_TURN = 128
"""Samples from one maximum of a smooth motion to the next."""

AN_EVENT = 16
"""Units of the motion's pace in which an event is waited for."""

Solution = tuple[Orbit, "Lap", np.ndarray]


@dataclass(frozen=True)
class Return:
    """A motion that nearly comes back.

    Attributes
    ----------
    away : float
        Largest distance of a state from where it began, relative to the extent of the motion.
    place : ndarray, shape (d,)
        Where it began.
    attempt : callable
        Looks for the orbit: returns orbit, lap and residuals, or raises NoOrbitError.
    """

    away: float
    place: np.ndarray
    attempt: Callable[[], Solution]


@dataclass(frozen=True)
class Record:
    """States that a motion passes, of one kind each.

    Attributes
    ----------
    states : ndarray, shape (m, d)
    kinds : ndarray of int, shape (m,)
        Only states of the same kind are compared: modes, or kinds of events.
    sequences : ndarray of int, shape (m,)
        Which events led there from the state before, as a number that stands for their sequence.
    times : ndarray, shape (m,)
    rows : ndarray, shape (m, columns)
        Events as the engine records them, where there are any.
    """

    states: np.ndarray
    kinds: np.ndarray
    sequences: np.ndarray
    times: np.ndarray
    rows: np.ndarray


class Recurrences:
    """Returns of motions from given states and from random ones around them.

    Parameters
    ----------
    family : Family
    longest : int
        Largest period that is asked for.
    starts, modes : ndarray, shapes (S, d) and (S,)
        Given states, at phase 0.
    """

    def __init__(self, family: "Family", longest: int, starts: np.ndarray, modes: np.ndarray) -> None:
        self.family, self.longest = family, longest
        names = family.plain.mode_names
        self.turning = -1
        systems = [started(family.plain, x, names[m]) for x, m in zip(starts, modes, strict=True)]
        self.unit = unit_of(family, Place(systems[0]))
        self.eventful = any(not t.marks_only() for t in family.plain.transitions)
        if not family.forced and not self.eventful:
            self.unit, self.turning = _turn(family, systems, self.unit)
        self.records = [self._record(system, RECORD) for system in systems]
        known = np.vstack([record.states for record in self.records])
        self.extent = np.maximum(np.ptp(known, axis=0), 1e-9 * np.maximum(np.abs(known).max(axis=0, initial=0), 1.0))
        for system in self._scattered(known):
            self.records.append(self._record(system, SHORT * longest))

    def nearest(self, period: int) -> Iterator[Return]:
        """Returns after a period (in periods of the forcing, occurrences of an event, maxima).

        Those by different sequences of events lead to different orbits: of every sequence the nearest one comes first,
        then of every one the next.
        """
        found: dict[tuple[int, ...], list[tuple[float, int, int, int]]] = {}
        for number, record in enumerate(self.records):
            for steps in self._steps(period):
                last = len(record.states) - steps
                if last <= 0:
                    continue
                same = record.kinds[steps:] == record.kinds[:last]
                if not self.family.forced and self.eventful:
                    same &= _busiest(record.kinds, steps) == period
                away = (np.abs(record.states[steps:] - record.states[:last]) / self.extent).max(axis=1)
                for j in np.flatnonzero(same).tolist():
                    sequence = _least_turn(record.sequences[j + 1 : j + steps + 1].tolist())
                    found.setdefault(sequence, []).append((float(away[j]), number, j, steps))
        for group in found.values():
            group.sort()
        rounds = zip_longest(*found.values())
        for away_, number, j, steps in chain.from_iterable(sorted(filter(None, turn)) for turn in rounds):
            place = self.records[number].states[j]
            yield Return(away_, place, partial(self._attempt, self.records[number], j, steps, period))

    def _steps(self, period: int) -> range:
        if self.family.forced or not self.eventful:
            return range(period, period + 1)
        return range(period, period * len(self.family.plain.transitions) + 1)

    def _attempt(self, record: Record, j: int, steps: int, period: int) -> Solution:
        family = self.family
        if family.forced:
            strobes = Strobed(Outcome.OK, record.states, record.kinds, record.sequences, record.rows)
            return orbit_read(family, partial(strobes.guess, family, j, period), period)
        durations = np.diff(record.times[j : j + steps + 1])
        if self.eventful:
            guess = orbit_of_events(family, record.rows[j + 1 : j + steps + 1], durations, 1, np.zeros(0), 0.0)
        else:
            arcs = np.array([[record.kinds[j], at.PLANE, -1]], dtype=np.int64)
            guess = Orbit(arcs, 1, record.states[j : j + 1], 0.0, durations.sum(keepdims=True))
        return solved(family, guess)

    def _scattered(self, known: np.ndarray) -> "Iterator[HybridSystem]":
        """Systems that start at random in the enlarged box of the known states, where their mode leaves freedom."""
        table = pins(self.family.plain)
        rng = np.random.default_rng(20260106)
        modes = np.concatenate([self._modes(record) for record in self.records])
        for _ in range(SCATTERED if len(known) else 0):
            chosen = int(rng.integers(len(known)))
            low, high = known.min(axis=0), known.max(axis=0)
            drawn = rng.uniform(low - WIDER * (high - low), high + WIDER * (high - low))
            state = np.where(table[modes[chosen]] == 1, known[chosen], drawn)
            yield started(self.family.plain, state, self.family.plain.mode_names[modes[chosen]])

    def _modes(self, record: Record) -> np.ndarray:
        """Modes in which the recorded states are."""
        if self.family.forced or not self.eventful:
            return record.kinds
        targets = [self.family.plain.mode_names.index(t.target) for t in self.family.plain.transitions]
        return np.array(targets, dtype=np.int64)[record.kinds]

    def _record(self, system: "HybridSystem", length: int) -> Record:
        if self.family.forced:
            return _strobes(self.family, system, length)
        if self.eventful:
            return _events(self.family, system, length, self.unit)
        return _maxima(self.family, system, length, self.unit, self.turning)


def _busiest(kinds: np.ndarray, steps: int) -> np.ndarray:
    """How often the most frequent kind comes among so many events after each one."""
    counts = np.cumsum(kinds[:, np.newaxis] == np.unique(kinds), axis=0)
    return np.asarray((counts[steps:] - counts[:-steps]).max(axis=1))


def _least_turn(sequence: list[int]) -> tuple[int, ...]:
    """The first in order of all cyclic shifts, the same for all of them."""
    return min(tuple(sequence[i:] + sequence[:i]) for i in range(len(sequence)))


def _strobes(family: "Family", system: "HybridSystem", length: int) -> Record:
    """States at phase 0."""
    assert family.period is not None
    seen = strobed(Place(system).run(family.period, family.numerics), length)
    return Record(seen.states, seen.modes, seen.sequences, np.arange(len(seen.states)) * family.period, seen.rows)


def _events(family: "Family", system: "HybridSystem", length: int, unit: float) -> Record:
    """States after events."""
    d = family.states
    run = Place(system).run(unit, family.numerics)
    buffer = np.zeros((length, layout.EVENT_COLUMNS + 2 * d))
    run.advance(AN_EVENT * length, events=buffer)
    rows = buffer[: run.filled()[1]]
    kinds = rows[:, layout.EVENT_KIND].astype(np.int64)
    changing = np.array([not t.marks_only() for t in system.transitions], dtype=bool)[kinds]
    rows, kinds = rows[changing], kinds[changing]
    times = rows[:, layout.EVENT_STROBES] * unit + rows[:, layout.EVENT_TIME]
    return Record(rows[:, layout.EVENT_COLUMNS + d :], kinds, kinds, times, rows)


def _path(family: "Family", system: "HybridSystem", unit: float, units: int) -> np.ndarray:
    """Samples of a smooth motion."""
    run = Place(system).run(unit, family.numerics, samples=A_TURN)
    samples = np.zeros(((units + 2) * A_TURN, family.states + len(system.quadratures) + 1))
    run.advance(units, samples)
    return samples[: run.filled()[0], : family.states]


def _peaks(values: np.ndarray) -> np.ndarray:
    """Indices of the local maxima."""
    return np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1


def _turn(family: "Family", systems: "list[HybridSystem]", unit: float) -> tuple[float, int]:
    """Time of a turn of a smooth motion, and the state whose maxima come most regularly."""
    state = 0
    for _ in range(8):
        paths = [_path(family, system, unit, 32) for system in systems]
        path = max(paths, key=len)
        gaps = [np.diff(_peaks(column[len(column) // 4 :])) for column in path.T]
        spread = [float(g.std() / g.mean()) if len(g) > 4 else np.inf for g in gaps]
        state = int(np.argmin(spread))
        if not np.isfinite(spread[state]):
            return unit, 0
        gap = float(gaps[state].mean())
        if A_TURN / 4 < gap < 4 * A_TURN:
            return unit * gap / A_TURN, state
        unit *= max(gap / A_TURN, 1 / 16)
    return unit, state


def _maxima(family: "Family", system: "HybridSystem", length: int, unit: float, state: int) -> Record:
    """States where one of them is largest, by the parabola through three samples."""
    path = _path(family, system, unit, length)
    mode = system.mode_names.index(system.initial["mode"])
    top = _peaks(path[:, state]) if len(path) > 2 else np.zeros(0, dtype=np.int64)
    left, middle, right = path[top - 1], path[top], path[top + 1]
    slope, bend = (right - left) / 2, right - 2 * middle + left
    shift = np.clip(-slope[:, state] / bend[:, state], -1, 1)[:, np.newaxis]
    states = middle + shift * slope + shift**2 / 2 * bend
    times = (top + 1 + shift[:, 0]) * unit / A_TURN
    kinds = np.full(len(top), mode)
    return Record(states, kinds, kinds, times, np.zeros((len(top), 0)))

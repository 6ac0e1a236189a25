"""All orbits up to a period, stable or not, from close returns of motions."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, zip_longest

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine import shooting as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.setup import constrained_states
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.derivatives import derived_of
from chaosdrill.orbits.find import NoOrbitError, least_period, orbit_read, solved
from chaosdrill.orbits.guess import Strobed, drift_in, orbit_of_events, strobed, unit_of
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.pieces import Pieces
from chaosdrill.orbits.place import Place, started, within_bounds
from chaosdrill.orbits.problem import Problem, Shot, admissible
from chaosdrill.orbits.results import FoundOrbit
from chaosdrill.orbits.tuning import TUNING
from chaosdrill.orbits.verification import describe

Solution = tuple[Orbit, Shot, np.ndarray]


@dataclass(frozen=True)
class Return:
    """A motion that nearly comes back."""

    away: float  # largest distance of a state from where it began, relative to the extent of the motion
    place: np.ndarray  # (d,): where it began
    attempt: Callable[[], Solution]  # looks for the orbit: returns orbit, shot and residuals, or raises NoOrbitError


@dataclass(frozen=True)
class Record:
    """States that a motion passes, of one kind each."""

    states: np.ndarray  # (m, d)
    kinds: np.ndarray  # int (m,): modes, or kinds of events; only states of the same kind are compared
    sequences: np.ndarray
    """int (m,): number of the sequence of events that led there from the state before."""
    times: np.ndarray  # (m,)
    rows: np.ndarray  # (m, columns): events as the engine records them, where there are any


class CloseReturns:
    """Returns of motions from given states and from random ones around them.

    ``longest``: largest period to look for. ``starts``, ``modes``, shapes (S, d) and (S,): starts at phase 0.
    """

    def __init__(self, problem: Problem, longest: int, starts: np.ndarray, modes: np.ndarray) -> None:
        self.problem, self.longest = problem, longest
        names = problem.plain.mode_names
        self.turning = -1
        systems = [started(problem.plain, x, names[m]) for x, m in zip(starts, modes, strict=True)]
        self.unit = unit_of(problem, Place(systems[0]))
        self.eventful = any(not t.marks_only() for t in problem.plain.transitions)
        if not problem.forced and not self.eventful:
            self.unit, self.turning = _turn(problem, systems, self.unit)
        self.records = [self._record(system, TUNING.record) for system in systems]
        known = self._measured()
        # if every motion escapes, the given ones are not on an attractor and show little of where orbits are
        stays = problem.forced or not self.eventful or any(len(r.states) == TUNING.record for r in self.records)
        self.escaping = not stays
        short = TUNING.short_record * longest
        if stays:
            span = np.ptp(known, axis=0) if len(known) else np.zeros(problem.states)
            self.records += [self._record(system, short) for system in self._scattered(known, span, span)]
        else:
            for _ in range(TUNING.open_rounds):
                # the set that motions leave may extend as far as they do, or as far as the origin, or between
                least = np.maximum(self.extent, problem.shifts.extent(np.vstack([known, starts])))
                most = np.maximum(least, np.abs(known).max(axis=0, initial=0))
                self.records += [self._record(system, short) for system in self._scattered(known, least, most)]
                known = self._measured()
            self.records += [self._record(system, short) for system in self._beside_lasting()]
            known = self._measured()
            problem.sizes = np.maximum(np.abs(known).max(axis=0, initial=0), 1e-9 * problem.sizes)
        self.orbits: list[FoundOrbit] = []
        """Orbits found from these returns so far: longer orbits follow shorter ones a part of the way."""
        self._rounds: list[Record] = []

    def _measured(self) -> np.ndarray:
        """All recorded states, whose extent is that of the motion."""
        known = np.vstack([record.states for record in self.records])
        spread = self.problem.shifts.extent(known) if len(known) else 0.0
        self.extent = np.maximum(spread, 1e-9 * np.maximum(np.abs(known).max(axis=0, initial=0), self.problem.sizes))
        return known

    def nearest(self, period: int) -> Iterator[Return]:
        """Returns after a period (counted in forcing periods, occurrences of an event, or maxima).

        Different sequences of events lead to different orbits: first comes the nearest return of each sequence,
        then the second nearest of each.
        """
        groups: dict[tuple[int, ...], int] = {}
        tables = [np.zeros((5, 0))]
        for number, record in enumerate(self.records):
            for steps in self._steps(period):
                last = len(record.states) - steps
                if last <= 0:
                    continue
                same = record.kinds[steps:] == record.kinds[:last]
                if not self.problem.forced and self.eventful:
                    same &= _busiest(record.kinds, steps) == period
                begun = np.flatnonzero(same)
                moved = self.problem.shifts.across(record.states[begun + steps] - record.states[begun])
                away = (np.abs(moved) / self.extent).max(axis=1)
                which = _groups_of(sliding_window_view(record.sequences[1:], steps)[begun], groups)
                tables.append(np.array(np.broadcast_arrays(which, away, number, begun, steps)))
        which, away, numbers, begun, steps = np.concatenate(tables, axis=1)
        order = np.lexsort((away, which))
        turn = np.zeros(len(which))
        turn[order] = np.arange(len(which)) - np.searchsorted(which[order], which[order])
        for i in np.lexsort((away, turn)).tolist():
            record, j, length = self.records[int(numbers[i])], int(begun[i]), int(steps[i])
            yield Return(float(away[i]), record.states[j], partial(self._attempt, record, j, length, period))

    def pieced(self, period: int) -> Iterator[Return]:
        """Rounds joined from pieces of several motions.

        Where motions escape few of them return, but each covers a part of the way.
        """
        if not (self.problem.forced or self.eventful):
            return
        for orbit in self.orbits[len(self._rounds) :]:
            system = started(self.problem.plain, orbit.states[0], self.problem.plain.mode_names[orbit.mode])
            length = orbit.period if self.problem.forced else len(orbit.event_times) + 1
            self._rounds.append(self._record(system, length))
        records = [*self._rounds, *self.records]
        lists = [r.states for r in records], [r.kinds for r in records], [r.sequences for r in records]
        pieces = Pieces(*lists, self.extent, len(self._rounds))
        turns = [pieces.rounds(steps, steps if self.problem.forced else period) for steps in self._steps(period)]
        for turn in zip_longest(*turns, fillvalue=[]):
            for gap, chosen in chain(*turn):
                record = self._joined([(records[p.record], p.index) for p in chosen])
                yield Return(gap, record.states[0], partial(self._attempt, record, 0, len(chosen), period))

    def _joined(self, parts: list[tuple[Record, int]]) -> Record:
        """Pieces of motions as the record of one; each keeps its own start, wherever the one before it ended."""
        d = self.problem.states
        around = [*parts, parts[0]]
        states = np.array([r.states[j] for r, j in around])
        times = np.cumsum([0.0, *(r.times[j + 1] - r.times[j] for r, j in parts)])
        if self.problem.forced:
            rows = [r.rows[r.rows[:, layout.EVENT_STROBES] == j].copy() for r, j in parts]
            for i, some in enumerate(rows):
                some[:, layout.EVENT_STROBES] = i
            table = np.concatenate(rows)
        else:
            table = np.array([parts[0][0].rows[parts[0][1]], *(r.rows[j + 1] for r, j in parts)])
            table[1:, layout.EVENT_COLUMNS + d : layout.EVENT_COLUMNS + 2 * d] = states[1:]
        kinds = np.array([r.kinds[j] for r, j in around])
        sequences = np.array([0, *(r.sequences[j + 1] for r, j in parts)])
        return Record(states, kinds, sequences, times, table)

    def _steps(self, period: int) -> range:
        if self.problem.forced or not self.eventful:
            return range(period, period + 1)
        return range(period, period * len(self.problem.plain.transitions) + 1)

    def _attempt(self, record: Record, j: int, steps: int, period: int) -> Solution:
        problem = self.problem
        if problem.forced:
            strobes = Strobed(Outcome.OK, record.states, record.kinds, record.sequences, record.rows)
            return orbit_read(problem, partial(strobes.guess, problem, j, period), period)
        durations, moved = np.diff(record.times[j : j + steps + 1]), record.states[j + steps] - record.states[j]
        if self.eventful:
            rows = record.rows[j + 1 : j + steps + 1]
            guess = orbit_of_events(problem, rows, durations, 1, np.zeros(0), 0.0, moved)
        else:
            segments = np.array([[record.kinds[j], at.PLANE, -1]], dtype=np.int64)
            drift = drift_in(problem, moved)
            guess = Orbit(segments, 1, record.states[j : j + 1], 0.0, durations.sum(keepdims=True), drift)
        return solved(problem, guess)

    def _scattered(self, known: np.ndarray, span: np.ndarray, most: np.ndarray) -> Iterator[HybridSystem]:
        """Systems that start at random in the enlarged box of the known states, where their mode leaves freedom.

        The box extends beyond them by a part of a length between ``span`` and ``most``, shapes (d,), of any order.
        """
        table = constrained_states(self.problem.plain)
        rng = np.random.default_rng(20260106)
        modes = np.concatenate([self._modes(record) for record in self.records])
        if not len(known):
            return
        low, high = known.min(axis=0), known.max(axis=0)
        for _ in range(TUNING.random_starts):
            chosen = int(rng.integers(len(known)))
            with np.errstate(divide="ignore", invalid="ignore"):
                beyond = TUNING.wider * np.where(most > span, span * (most / span) ** rng.uniform(), span)
            drawn = rng.uniform(low - beyond, high + beyond)
            state = np.where(table[modes[chosen]] == 1, known[chosen], drawn)
            yield started(self.problem.plain, state, self.problem.plain.mode_names[modes[chosen]])

    def _beside_lasting(self) -> Iterator[HybridSystem]:
        """Systems that start beside recorded states whose motion lasted, at distances of several orders of magnitude.

        Almost all others escape at once (Sweet, Nusse and Yorke 2001, doi:10.1103/PhysRevLett.86.2261).
        """
        table = constrained_states(self.problem.plain)
        rng = np.random.default_rng(20260107)
        pairs = [
            (record, j, mode) for record in self.records for j, mode in enumerate(self._modes(record)[:-1].tolist())
        ]
        for _ in range(TUNING.random_starts if pairs else 0):
            record, j, mode = pairs[int(rng.integers(len(pairs)))]
            away = self.extent * 10.0 ** rng.uniform(*TUNING.beside_lasting)
            drawn = record.states[j] + away * rng.normal(size=len(away))
            state = np.where(table[mode] == 1, record.states[j], drawn)
            yield started(self.problem.plain, state, self.problem.plain.mode_names[mode])

    def _modes(self, record: Record) -> np.ndarray:
        """Modes in which the recorded states are."""
        if self.problem.forced or not self.eventful:
            return record.kinds
        targets = [self.problem.plain.mode_names.index(t.target) for t in self.problem.plain.transitions]
        return np.array(targets, dtype=np.int64)[record.kinds]

    def _record(self, system: HybridSystem, length: int) -> Record:
        if self.problem.forced:
            return _strobes(self.problem, system, length)
        if self.eventful:
            return _events(self.problem, system, length, self.unit)
        return _maxima(self.problem, system, length, self.unit, self.turning)


def _busiest(kinds: np.ndarray, steps: int) -> np.ndarray:
    """How often the most frequent kind occurs among the given number of events after each event."""
    counts = np.cumsum(kinds[:, np.newaxis] == np.unique(kinds), axis=0)
    return np.asarray((counts[steps:] - counts[:-steps]).max(axis=1))


def _groups_of(sequences: np.ndarray, groups: dict[tuple[int, ...], int]) -> np.ndarray:
    """Number of each sequence, a row, shape (k, steps), the same for all its cyclic shifts; new ones are added."""
    met, which = np.unique(sequences, axis=0, return_inverse=True)
    least = [_least_turn(row) for row in met.tolist()]
    return np.array([groups.setdefault(word, len(groups)) for word in least], dtype=np.int64)[which.ravel()]


def _least_turn(sequence: list[int]) -> tuple[int, ...]:
    """The cyclic shift that comes first in order, the same for all shifts of a sequence."""
    return min(tuple(sequence[i:] + sequence[:i]) for i in range(len(sequence)))


def _strobes(problem: Problem, system: HybridSystem, length: int) -> Record:
    """States at phase 0."""
    assert problem.period is not None
    seen = strobed(Place(system).run(problem.period, problem.numerics), length)
    return Record(seen.states, seen.modes, seen.sequences, np.arange(len(seen.states)) * problem.period, seen.rows)


def _events(problem: Problem, system: HybridSystem, length: int, unit: float) -> Record:
    """States after events."""
    d = problem.states
    run = Place(system).run(unit, problem.numerics)
    buffer = np.zeros((length, layout.EVENT_COLUMNS + 2 * d))
    outcome, _ = run.advance(TUNING.event_units * length, events=buffer)
    rows = within_bounds(system, outcome, buffer[: run.filled()[1]])
    kinds = rows[:, layout.EVENT_KIND].astype(np.int64)
    changing = np.array([not t.marks_only() for t in system.transitions], dtype=bool)[kinds]
    rows, kinds = rows[changing], kinds[changing]
    times = rows[:, layout.EVENT_STROBES] * unit + rows[:, layout.EVENT_TIME]
    return Record(rows[:, layout.EVENT_COLUMNS + d :], kinds, kinds, times, rows)


def _path(problem: Problem, system: HybridSystem, unit: float, units: int) -> np.ndarray:
    """Samples of a smooth motion."""
    run = Place(system).run(unit, problem.numerics, samples=TUNING.turn_samples)
    samples = np.zeros(((units + 2) * TUNING.turn_samples, problem.states + len(system.quadratures) + 1))
    run.advance(units, samples)
    return samples[: run.filled()[0], : problem.states]


def _peaks(values: np.ndarray) -> np.ndarray:
    """Indices of the local maxima."""
    return np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1


def _turn(problem: Problem, systems: list[HybridSystem], unit: float) -> tuple[float, int]:
    """Time of one turn of a smooth motion, and the state with the most regular maxima."""
    state = 0
    for _ in range(8):
        paths = [_path(problem, system, unit, 32) for system in systems]
        path = max(paths, key=len)
        gaps = [np.diff(_peaks(column[len(column) // 4 :])) for column in path.T]
        spread = [float(g.std() / g.mean()) if len(g) > 4 else np.inf for g in gaps]
        state = int(np.argmin(spread))
        if not np.isfinite(spread[state]):
            return unit, 0
        gap = float(gaps[state].mean())
        if TUNING.turn_samples / 4 < gap < 4 * TUNING.turn_samples:
            return unit * gap / TUNING.turn_samples, state
        unit *= max(gap / TUNING.turn_samples, 1 / 16)
    return unit, state


def _maxima(problem: Problem, system: HybridSystem, length: int, unit: float, state: int) -> Record:
    """States at the maxima of one of them, by the parabola through three samples."""
    path = _path(problem, system, unit, length)
    mode = system.initial_mode
    top = _peaks(path[:, state]) if len(path) > 2 else np.zeros(0, dtype=np.int64)
    left, middle, right = path[top - 1], path[top], path[top + 1]
    slope, bend = (right - left) / 2, right - 2 * middle + left
    shift = np.clip(-slope[:, state] / bend[:, state], -1, 1)[:, np.newaxis]
    states = middle + shift * slope + shift**2 / 2 * bend
    times = (top + 1 + shift[:, 0]) * unit / TUNING.turn_samples
    kinds = np.full(len(top), mode)
    return Record(states, kinds, kinds, times, np.zeros((len(top), 0)))


def search(
    system: HybridSystem,
    max_period: int,
    starts: np.ndarray,
    modes: np.ndarray,
    numerics: Numerics,
    progress: Callable[[int, int, dict[str, int] | None], None] | None = None,
    derive: Sequence[str] = (),
) -> list[FoundOrbit]:
    """All orbits up to a period that are found from close returns of motions.

    Motions are recorded from the given states (by default the system's own) and from random ones in a box around them;
    Newton's method starts from their returns, the closest first, until many in a row give no new orbit (Auerbach et
    al. 1987, doi:10.1103/PhysRevLett.58.2387). There is no proof that all orbits are found.

    ``max_period``: longest period in forcing periods. Without forcing: the largest number of times that the most
    frequent event of an orbit occurs in one round; without events, the largest number of maxima of the state with the
    most regular maxima. ``starts``, ``modes``, shapes (S, d) and (S,): states at phase 0, and their modes.
    ``progress``: called with the periods done, their number, and the orbits so far. ``derive``: parameters with respect
    to which the properties of the orbits are differentiated.

    Returns them by period (without forcing by duration), the more stable ones first.
    """
    problem = Problem(system, (), numerics)
    if not len(starts):
        starts = np.array([system.initial_values])
        modes = np.array([system.initial_mode])
    close_returns = CloseReturns(problem, max_period, starts, modes)
    known = Listed(problem, close_returns.extent)
    close_returns.orbits = known.found
    for period in range(1, max_period + 1):
        _all_of(period, close_returns, known)
        if progress:
            progress(period, max_period, {Outcome.PERIODIC.meaning: len(known.found)})
    if derive:
        known.derive(derive)
    return sorted(known.found, key=lambda o: (o.period if problem.forced else o.duration, abs(o.multipliers[0])))


def _all_of(period: int, close_returns: CloseReturns, known: "Listed") -> None:
    """Try the returns after a period, last those that probably lead to a known orbit.

    If there are too few of them, or all motions escape, so that returns favour the orbits that are left slowly, rounds
    are joined from pieces, as long as new orbits are found.
    """
    put_off: list[tuple[float, Return]] = []

    def fresh() -> Iterator[Return]:
        for candidate in close_returns.nearest(period):
            apart = known.distance(candidate.place) / max(candidate.away, 1e-300)
            if apart > TUNING.taken:
                yield candidate
            else:
                put_off.append((apart, candidate))

    few = _try(fresh(), known)
    few &= _try((candidate for _, candidate in sorted(put_off, key=lambda pair: -pair[0])), known)
    before = -1
    while (few or close_returns.escaping) and len(known.found) > before:
        before = len(known.found)
        _try(close_returns.pieced(period), known)


def _try(candidates: Iterable[Return], known: "Listed") -> bool:
    """Look for the orbits near returns until many in a row give nothing new; return whether the returns ran out."""
    last = 0
    for attempt, candidate in enumerate(candidates, 1):
        if known.add(candidate):
            last = attempt
        if attempt - last > max(TUNING.attempts, TUNING.attempts_beyond * last):
            return False
    return True


class Listed:
    """Orbits found so far, each listed once.

    ``extent``, shape (d,): extent of the motion in every state.
    """

    def __init__(self, problem: Problem, extent: np.ndarray) -> None:
        self.problem, self.extent = problem, extent
        self.found: list[FoundOrbit] = []
        self._orbits: list[Orbit] = []
        self._refused: list[Orbit] = []
        self._points = np.zeros((0, len(extent)))
        self._paths: dict[int, np.ndarray] = {}

    def distance(self, place: np.ndarray) -> float:
        """Distance of the nearest point of a known orbit, relative to the extent."""
        away = np.abs(self.problem.shifts.across(self._points - place))
        return float((away / self.extent).max(axis=1).min(initial=np.inf))

    def add(self, candidate: Return) -> bool:
        """Look for the orbit near a return; return whether it is new."""
        try:
            orbit, shot, residuals = candidate.attempt()
        except NoOrbitError:
            return False
        if not admissible(orbit, shot):
            return False
        least, _ = least_period(self.problem, orbit)
        if any(self._same(least, old) for old in (*self._orbits, *self._refused)):
            return False
        if least is not orbit:
            code, least, shot, residuals = self.problem.newton(least)
            if code:
                return False
        found = describe(self.problem, least, shot, residuals)
        if found.outcome != Outcome.PERIODIC:
            self._refused.append(least)
            return False
        self._orbits.append(least)
        self.found.append(found)
        self._points = np.vstack([self._points, found.states if self.problem.forced else least.starts])
        return True

    def derive(self, names: Sequence[str]) -> None:
        """Differentiate the properties of all orbits with respect to these parameters."""
        pairs = zip(self.found, self._orbits, strict=True)
        derived = derived_of(self.problem, names, [(orbit, one.multipliers, one.rank) for one, orbit in pairs])
        self.found = [replace(one, derived=own) for one, own in zip(self.found, derived, strict=True)]

    def _same(self, a: Orbit, b: Orbit) -> bool:
        """Whether two orbits are the same closed path: both take the same time, and one passes the other's start."""
        if len(a) != len(b) or a.periods != b.periods:
            return False
        if abs(a.durations.sum() - b.durations.sum()) > TUNING.same_orbit * a.durations.sum():
            return False
        if a.eventless:
            return self._on_path(a, b)
        across = self.problem.shifts.across
        away = (np.abs(across(b.starts - a.starts[0])) / self.extent).max(axis=1)
        period = self.problem.period
        if period:
            late = (b.phase + np.cumsum(b.durations) - b.durations - a.phase) / period
            away = np.maximum(away, np.abs(late - np.round(late)))
        return bool(((away <= TUNING.same_orbit) & (b.segments == a.segments[0]).all(axis=1)).any())

    def _on_path(self, a: Orbit, b: Orbit) -> bool:
        """Whether an orbit without events passes the start of another one, as near as it is sampled."""
        across = self.problem.shifts.across
        if self.problem.forced:
            away = np.abs(across(self.problem.strobes([b])[0][0] - a.starts[0])) / self.extent
            return bool(away.max(axis=1).min() <= TUNING.same_orbit)
        if id(b) not in self._paths:
            instants = np.linspace(0, float(b.durations.sum()), TUNING.path_samples, endpoint=False)
            self._paths[id(b)] = self.problem.at([b], instants[np.newaxis])[0][0]
        total = float(b.durations.sum())
        away = np.linalg.norm(across(self._paths[id(b)] - a.starts[0]) / self.extent, axis=1)
        time, width = int(away.argmin()) * total / TUNING.path_samples, total / TUNING.path_samples
        for _ in range(TUNING.path_closer):
            # the path may turn sharply between two samples
            instants = np.sort(np.linspace(time - width, time + width, 65) % total)
            near = self.problem.at([b], instants[np.newaxis])[0][0]
            away = np.linalg.norm(across(near - a.starts[0]) / self.extent, axis=1)
            time, width = float(instants[away.argmin()]), width / 32
        return bool(away.min() <= TUNING.path_distance)

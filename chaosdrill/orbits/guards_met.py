"""Guards along an orbit: where it nearly touches one, how fast it meets others, and what is taken where it does."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kinds import int64, void
from chaosdrill.codegen.signatures import event_places, matrix, vector
from chaosdrill.engine import shooting as at
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.records import functions_type
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.problem import LostError, Problem, Shot
from chaosdrill.orbits.tuning import TUNING


@dataclass(frozen=True)
class Touch:
    """A guard that is nearly reached within a segment."""

    segment: int  # number of the segment
    guard: int  # number of the guard in its mode
    side: int  # sign by which the guard's value is multiplied, so that it is negative before the guard is met

    def greatest(self, problem: Problem, orbit: Orbit, instant: float) -> tuple[float, float]:
        """Largest value of the guard in the segment near an instant, and its time.

        ``instant``: time since the start of the orbit.

        Raises `LostError` if there is no maximum nearby: it has left the segment.
        """
        total = float(orbit.durations.sum())
        now, gap = instant, TUNING.touch_probe * total
        rate = self._look(problem, orbit, now)[1]
        for _ in range(TUNING.touch_steps):
            before, now = now, now + gap
            rate_before, rate = rate, self._look(problem, orbit, now)[1]
            curvature = (rate - rate_before) / (now - before)
            if not curvature < 0:
                break
            gap = -rate / curvature
            if abs(gap) <= TUNING.touch_settled * total:
                return self._look(problem, orbit, now + gap)[0], now + gap
        raise LostError("the guard has no greatest value in the segment any more")

    def _look(self, problem: Problem, orbit: Orbit, instant: float) -> tuple[float, float]:
        """Value and rate of the guard."""
        begin = float(orbit.durations[: self.segment].sum())
        total = float(orbit.durations.sum())
        if not orbit.eventless and not begin < instant < begin + orbit.durations[self.segment]:
            raise LostError("the greatest value has left the segment")
        state = problem.at([orbit], np.array([[instant % total if orbit.eventless else instant]]))[0][0]
        values, rates = _guard(problem, orbit, self.segment, self.guard, np.array([instant]), state)
        return self.side * float(values[0]), self.side * float(rates[0])


def touches(problem: Problem, orbit: Orbit) -> Iterator[tuple[float, Touch, float]]:
    """Greatest values of guards within segments: (value as a part of the guard's variation there, which, when)."""
    transitions = problem.plain.transitions
    begin = 0.0
    for i, (mode, _, _) in enumerate(orbit.segments.tolist()):
        instants = begin + orbit.durations[i] * (np.arange(TUNING.guard_samples) + 0.5) / TUNING.guard_samples
        states = problem.at([orbit], instants[np.newaxis])[0][0]
        for j, event in enumerate(kernels_of(problem.system).layout.events[mode]):
            if all(transitions[k].marks_only() for k in event.outcomes):
                continue
            values, _ = _guard(problem, orbit, i, j, instants, states)
            side = event.direction or -int(np.sign(values[TUNING.guard_samples // 2]))
            heights = side * values
            # orbits without events have segments that end nowhere in particular
            padded = np.pad(heights, 1, mode="wrap") if orbit.eventless else np.pad(heights, 1, constant_values=np.inf)
            tops = (heights >= padded[:-2]) & (heights >= padded[2:])
            # between two instants a top rises by less than it lies above its neighbours
            risen = 2 * heights - padded[:-2] - padded[2:] + TUNING.far_touch * np.ptp(values)
            tops &= np.abs(heights) <= risen
            for k in np.flatnonzero(tops).tolist():
                touch = Touch(i, j, side)
                try:
                    value, instant = touch.greatest(problem, orbit, float(instants[k]))
                except LostError:
                    continue
                yield abs(value) / max(float(np.ptp(values)), 1e-300), touch, instant
        begin += float(orbit.durations[i])


def nearest_touch(problem: Problem, orbit: Orbit) -> tuple[Touch, float] | None:
    """The guard that an orbit touches at a border, and the time; None if it touches none."""
    found = min(touches(problem, orbit), key=lambda one: one[0], default=None)
    return found[1:] if found is not None and found[0] <= TUNING.touching else None


def slowness(problem: Problem, orbit: Orbit, shot: Shot) -> np.ndarray:
    """Speed at the event that ends each segment, as a part of how fast its guard changes; infinite without one."""
    begin = 0.0
    parts = np.full(len(orbit), np.inf)
    for i, (_, end, _) in enumerate(orbit.segments.tolist()):
        if end >= 0:
            instants = begin + orbit.durations[i] * (np.arange(TUNING.guard_samples) + 0.5) / TUNING.guard_samples
            _, rates = _guard(problem, orbit, i, end, instants, problem.at([orbit], instants[np.newaxis])[0][0])
            parts[i] = shot.speeds[i] / max(float(np.abs(rates).max()), 1e-300)
        begin += float(orbit.durations[i])
    return parts


def slowest_event(problem: Problem, orbit: Orbit, shot: Shot) -> int | None:
    """Index of the event with zero normal speed; or None."""
    parts = slowness(problem, orbit, shot)
    slowest = int(parts.argmin())
    return slowest if parts[slowest] <= TUNING.touching else None


def taken(problem: Problem, orbit: Orbit, segment: int, guard: int, after: float) -> tuple[int, np.ndarray]:
    """Transition that would be taken if a guard were met on a segment, -1 for none, and the state after it, shape (d,).

    ``after``: time since the start of the segment.
    """
    system = problem.system
    n, instant = len(system.state_names), float(orbit.durations[:segment].sum()) + after
    x = np.zeros(n)
    x[: problem.states] = problem.at([orbit], np.array([[instant]]))[0][0, 0]
    x[problem.states :] = orbit.starts[0, problem.states :]
    places = event_places(n)
    room = np.zeros(places.size)
    constants = kernels_of(system).constants(system.parameters)
    mode = int(orbit.segments[segment, at.SEGMENT_MODE])
    event_map = kernels_of(system).functions.event_map
    came = int(event_map(mode, guard, orbit.phase + instant, constants, x, 0, np.ones(n), 0.0, room))
    return came, room[places.image : places.image + problem.states].copy()


def _guard(
    problem: Problem, orbit: Orbit, segment: int, guard: int, instants: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values and rates of a guard in states (K, d) at times since the start of an orbit."""
    system, count = problem.system, len(instants)
    kernels = kernels_of(system)
    n, d = len(system.state_names), problem.states
    x = np.empty((count, n))
    x[:, :d], x[:, d:] = states, orbit.starts[0, d:]
    values, gradients, rates = np.zeros(count), np.zeros((count, n + 1)), np.zeros((count, n + len(system.quadratures)))
    mode = int(orbit.segments[segment, at.SEGMENT_MODE])
    times, constants = orbit.phase + instants, kernels.constants(system.parameters)
    _guard_along(kernels.functions, mode, guard, times, constants, x, values, gradients, rates)
    return values, np.einsum("ij,ij->i", gradients[:, :n], rates[:, :n]) + gradients[:, n]


@compiled(void(functions_type, int64, int64, vector, vector, matrix, vector, matrix, matrix))
def _guard_along(functions, mode, guard, times, c, states, values, gradients, rates):
    """Values and gradients of a guard and rates of the states, one row a state."""
    for k in range(times.size):
        values[k] = functions.guard(mode, guard, times[k], c, states[k], gradients[k])
        functions.field(mode, times[k], c, states[k], rates[k])

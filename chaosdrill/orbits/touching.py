"""Guards that an orbit comes near to within an arc: their greatest values, and when."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine import lap as at
from chaosdrill.orbits.special import LostError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit

LOOKS = 512
"""Instants of an arc at which guards are looked at."""

CLOSE = 1e-6
"""Greatest value of a guard, and speed at an event, that count as zero at a border: parts of what they are before."""

PROBE = 1e-5
"""First difference of two instants, as a part of the orbit, in the search for the greatest value."""

SETTLED = 1e-9
"""Change of the instant, as a part of the orbit, at which the value is exact: it changes with the square."""

TURNS = 20
"""Steps of the secant method, at most."""


@dataclass(frozen=True)
class Touch:
    """A guard that is nearly met within an arc.

    Attributes
    ----------
    arc, guard : int
        Number of the arc, and of the guard in its mode.
    side : int
        Sign by which the guard's value is multiplied, so that it is negative before the guard is met.
    """

    arc: int
    guard: int
    side: int

    def greatest(self, family: "Family", orbit: "Orbit", instant: float) -> tuple[float, float]:
        """Greatest value within the arc next to an instant, and when it is reached.

        Parameters
        ----------
        family : Family
        orbit : Orbit
        instant : float
            Time since the start of the orbit.

        Raises
        ------
        LostError
            There is no greatest value near: it has left the arc.
        """
        total = float(orbit.durations.sum())
        now, gap = instant, PROBE * total
        rate = self._look(family, orbit, now)[1]
        for _ in range(TURNS):
            before, now = now, now + gap
            rate_before, rate = rate, self._look(family, orbit, now)[1]
            curvature = (rate - rate_before) / (now - before)
            if not curvature < 0:
                break
            gap = -rate / curvature
            if abs(gap) <= SETTLED * total:
                return self._look(family, orbit, now + gap)[0], now + gap
        raise LostError("the guard has no greatest value in the arc any more")

    def _look(self, family: "Family", orbit: "Orbit", instant: float) -> tuple[float, float]:
        """Value and rate of the guard."""
        begin = float(orbit.durations[: self.arc].sum())
        total = float(orbit.durations.sum())
        if not orbit.eventless and not begin < instant < begin + orbit.durations[self.arc]:
            raise LostError("the greatest value has left the arc")
        state = family.at([orbit], np.array([[instant % total if orbit.eventless else instant]]))[0][0]
        values, rates = _guard(family, orbit, self.arc, self.guard, np.array([instant]), state)
        return self.side * float(values[0]), self.side * float(rates[0])


def touches(family: "Family", orbit: "Orbit") -> "Iterator[tuple[float, Touch, float]]":
    """Greatest values of guards within arcs: (value as a part of the guard's variation there, which, when)."""
    transitions = family.plain.transitions
    begin = 0.0
    for i, (mode, _, _) in enumerate(orbit.arcs.tolist()):
        instants = begin + orbit.durations[i] * (np.arange(LOOKS) + 0.5) / LOOKS
        states = family.at([orbit], instants[np.newaxis])[0][0]
        for j, event in enumerate(family.system.kernels.events[mode]):
            if all(transitions[k].marks_only() for k in event.outcomes):
                continue
            values, _ = _guard(family, orbit, i, j, instants, states)
            side = event.direction or -int(np.sign(values[LOOKS // 2]))
            heights = side * values
            # of orbits without events the ends of arcs are no ends
            padded = np.pad(heights, 1, mode="wrap") if orbit.eventless else np.pad(heights, 1, constant_values=np.inf)
            tops = (heights >= padded[:-2]) & (heights >= padded[2:])
            for k in np.flatnonzero(tops).tolist():
                touch = Touch(i, j, side)
                try:
                    value, instant = touch.greatest(family, orbit, float(instants[k]))
                except LostError:
                    continue
                yield abs(value) / max(float(np.ptp(values)), 1e-300), touch, instant
        begin += float(orbit.durations[i])


def nearest_touch(family: "Family", orbit: "Orbit") -> tuple[Touch, float] | None:
    """The guard that an orbit at a border touches, and when; None if there is none."""
    found = min(touches(family, orbit), key=lambda one: one[0], default=None)
    return found[1:] if found is not None and found[0] <= CLOSE else None


def slowness(family: "Family", orbit: "Orbit", lap: "Lap") -> np.ndarray:
    """Speed at the event that ends each arc, as a part of how fast its guard changes before; infinite without one."""
    begin = 0.0
    parts = np.full(len(orbit), np.inf)
    for i, (_, end, _) in enumerate(orbit.arcs.tolist()):
        if end >= 0:
            instants = begin + orbit.durations[i] * (np.arange(LOOKS) + 0.5) / LOOKS
            _, rates = _guard(family, orbit, i, end, instants, family.at([orbit], instants[np.newaxis])[0][0])
            parts[i] = lap.speeds[i] / max(float(np.abs(rates).max()), 1e-300)
        begin += float(orbit.durations[i])
    return parts


def slowest_event(family: "Family", orbit: "Orbit", lap: "Lap") -> int | None:
    """Number of the event that comes with no speed; None if there is none."""
    parts = slowness(family, orbit, lap)
    slowest = int(parts.argmin())
    return slowest if parts[slowest] <= CLOSE else None


def taken(family: "Family", orbit: "Orbit", arc: int, guard: int, after: float) -> int:
    """Transition that would be taken if a guard were met on an arc, a time after its start; -1 for none."""
    system = family.system
    n, instant = len(system.states), float(orbit.durations[:arc].sum()) + after
    x = np.zeros(n)
    x[: family.states] = family.at([orbit], np.array([[instant]]))[0][0, 0]
    x[family.states :] = orbit.starts[0, family.states :]
    room = np.zeros(event_places(n).size)
    constants = system.kernels.constants(system.parameters)
    mode = int(orbit.arcs[arc, at.ARC_MODE])
    transit = system.kernels.functions[7]
    return int(transit(mode, guard, orbit.phase + instant, constants, x, 0, np.ones(n), 0.0, room))


def _guard(
    family: "Family", orbit: "Orbit", arc: int, guard: int, instants: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values and rates of a guard in states (K, d) at times since the start of an orbit."""
    system = family.system
    field, evaluate = system.kernels.functions[3], system.kernels.functions[5]
    constants = system.kernels.constants(system.parameters)
    n, d = len(system.states), family.states
    mode = int(orbit.arcs[arc, at.ARC_MODE])
    values, slopes = np.zeros(len(instants)), np.zeros(len(instants))
    x, rates, gradient = np.zeros(n), np.zeros(n + len(system.quadratures)), np.zeros(n + 1)
    x[d:] = orbit.starts[0, d:]
    for k, (instant, state) in enumerate(zip(instants, states, strict=True)):
        x[:d] = state
        time = orbit.phase + float(instant)
        values[k] = evaluate(mode, guard, time, constants, x, gradient)
        field(mode, time, constants, x, rates)
        slopes[k] = gradient[:n] @ rates[:n] + gradient[n]
    return values, slopes

"""Cubic coefficients of the normal forms at a period doubling and at a Neimark-Sacker point, of any kind of orbit.

They need second and third derivatives of the return map along the critical directions. The map is that from an event,
or from a plane across the flow, to the same the next time, with the time of the forcing among its variables; near an
orbit it is as smooth as the flow is, events included. Shooting gives its first derivative to round-off, also at starts
beside the orbit; what that is on a small disc of the critical plane tells the higher ones.

Kuznetsov 2004, Elements of Applied Bifurcation Theory, section 5.4, doi:10.1007/978-1-4757-3978-7.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.engine import shooting as at
from chaosdrill.engine.layout import DONE
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.settings import SETTINGS

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot

RINGS = (1.0, 0.5)
"""Distances, in radii, at which the derivative is looked at."""
ANGLES = 8
"""Angles on a ring: harmonics that alias to those asked for are of the seventh order and beyond."""


@dataclass(frozen=True)
class ReturnMap:
    """The map from the start of an orbit to its next return, in units of the sizes of its variables.

    Raises
    ------
    LostError
        Where the start is held on a surface, or orbits come in families: there it is no map of all its variables.
    """

    problem: "Problem"
    orbit: "Orbit"

    def __post_init__(self) -> None:
        problem, neutral = self.problem, self.problem.neutral
        held = kernels_of(problem.plain).held[self.orbit.segments[0, at.SEGMENT_MODE]] > 0
        if held or neutral.count > int(neutral.flow and not problem.forced):
            raise LostError("the return map is not one of all states")

    @property
    def timed(self) -> bool:
        """Whether the time in the period at which it starts is a variable, the last one."""
        return self.problem.forced and not self.orbit.eventless

    @cached_property
    def weights(self) -> np.ndarray:
        """Inverse sizes of the reduced unknowns, as from `Problem.weights`."""
        return self.problem.weights(self.orbit)

    @cached_property
    def units(self) -> np.ndarray:
        """Sizes of the variables, shape (m,)."""
        return np.asarray(1 / self.weights[: self.problem.states + self.timed])

    def derivative(self, change: np.ndarray) -> np.ndarray:
        """Derivative of the map at a start beside the orbit's own, shapes (m,) and (m, m).

        Raises
        ------
        LostError
        """
        problem, d, count, m = self.problem, self.problem.states, len(self.orbit), len(self.units)
        moved = change * self.units
        starts = self.orbit.starts.copy()
        starts[0, :d] += moved[:d]
        phase = self.orbit.phase + (float(moved[d]) if self.timed else 0.0)
        orbit = replace(self.orbit, starts=starts, phase=phase)
        times = slice(d + 1, d + 1 + count)
        for _ in range(SETTINGS.newton_steps):
            shot = problem.shoot(orbit, False, self.orbit)
            if shot.outcome != DONE or not np.isfinite(shot.equations).all():
                break
            rows, ends = self._rows(shot, orbit)
            step = np.zeros(problem.columns(orbit))
            step[times] = -np.linalg.solve(rows[:, times], rows[:, -1])
            more = shot.sensitivity @ np.append(step, 1.0)
            size = max(
                float(np.abs(more[:, :d] / self.units[:d]).max()),
                float(np.abs(step * self.weights).max()),
            )
            if size < SETTINGS.returned:
                found = ends[:, :m] - ends[:, times] @ np.linalg.solve(rows[:, times], rows[:, :m])
                return np.asarray(found * self.units / self.units[:, np.newaxis])
            orbit = replace(orbit, starts=orbit.starts + more, durations=orbit.durations + step[times])
        raise LostError("a start beside the orbit does not return as it does")

    def _rows(self, shot: "Shot", orbit: "Orbit") -> tuple[np.ndarray, np.ndarray]:
        """Equations of the durations, and the end beside the orbit's start, both linearised."""
        d, count = self.problem.states, len(orbit)
        ends = shot.equations[count : count + d].copy()
        ends[:, :d] += np.eye(d)
        ends[:, -1] += orbit.starts[0, :d] - self.orbit.starts[0, :d]
        rows = shot.equations[:count].copy()
        if orbit.segments[0, at.SEGMENT_END] == at.PLANE:
            # what the equations of an orbit ask of the start is asked of the end here
            rows[0] = rows[0, :d] @ ends
        if self.timed:
            final = shot.equations[count + d].copy()
            final[d] += 1.0
            final[-1] += orbit.phase - self.orbit.phase
            ends = np.vstack([ends, final])
        return rows, ends


def cubic_coefficient(problem: "Problem", orbit: "Orbit", multiplier: complex, radius: float) -> float:
    """The coefficient of the normal form at a multiplier that is -1, or one of a pair on the unit circle.

    Parameters
    ----------
    problem : Problem
    orbit : Orbit
    multiplier : complex
        That of the critical direction.
    radius : float
        Of the disc on which the return map is fitted, in sizes of the states.

    Returns
    -------
    float
        Positive at a soft period doubling, negative at a soft Neimark-Sacker point. Its size is that of the states.

    Raises
    ------
    LostError
        No return map, or its critical direction is not alone.
    """
    returns = ReturnMap(problem, orbit)
    matrix = returns.derivative(np.zeros(len(returns.units)))
    right, left = _vector(matrix, multiplier), _vector(matrix.T, np.conj(multiplier))
    scale = np.vdot(left, right)
    if abs(scale) < SETTINGS.missed_multiplier**2:
        raise LostError("the critical multiplier is not alone")
    left = left / np.conj(scale)
    identity = np.eye(len(matrix))
    if multiplier.imag == 0:
        bent, twice = _along(returns, matrix, right.real, radius)
        flat = np.linalg.solve(identity - matrix, bent @ right.real)
        return float(left.real @ (twice @ right.real / 6 + bent @ flat / 2))
    bent, twice = _around(returns, right, radius)
    flat = np.linalg.solve(identity - matrix, bent @ right.conj())
    turned = np.linalg.solve(multiplier**2 * identity - matrix, bent @ right)
    whole = twice @ right.conj() + 2 * bent @ flat + bent.conj() @ turned
    return float((np.conj(multiplier) * np.vdot(left, whole)).real / 2)


def _vector(matrix: np.ndarray, value: complex) -> np.ndarray:
    """The eigenvector of a value, of length 1, and in the plane of a pair as round as it can be."""
    _, _, rows = np.linalg.svd(matrix - value * np.eye(len(matrix)))
    vector = rows[-1].conj()
    # real and imaginary part at a right angle: the phase is fixed
    angle = np.angle(vector @ vector) / 2
    return np.asarray(vector * np.exp(-1j * angle))


def _along(returns: ReturnMap, matrix: np.ndarray, vector: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """B(q, .) and C(q, q, .) for a real q, from differences of the derivative at two distances."""
    odd, even = [], []
    for part in RINGS:
        plus, minus = (returns.derivative(sign * part * radius * vector) for sign in (1, -1))
        odd.append((plus - minus) / (2 * part * radius))
        even.append((plus + minus - 2 * matrix) / (part * radius) ** 2)
    return _extrapolated(odd), _extrapolated(even)


def _around(returns: ReturnMap, vector: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """B(q, .) and C(q, q, .) for a complex q, from the derivative at q w + q* w* over two rings of w."""
    ring = np.exp(2j * np.pi * np.arange(ANGLES) / ANGLES)
    first, second = [], []
    for part in RINGS:
        found = np.array([returns.derivative(2 * part * radius * (w * vector).real) for w in ring])
        first.append(np.tensordot(ring.conj(), found, 1) / ANGLES / (part * radius))
        second.append(2 * np.tensordot(ring.conj() ** 2, found, 1) / ANGLES / (part * radius) ** 2)
    return _extrapolated(first), _extrapolated(second)


def _extrapolated(values: list[np.ndarray]) -> np.ndarray:
    """What values at two distances tend to, whose errors go with the square of the distance."""
    squares = np.array(RINGS) ** 2
    return np.asarray((squares[0] * values[1] - squares[1] * values[0]) / (squares[0] - squares[1]))

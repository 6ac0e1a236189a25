"""Periodic orbits of the drill: fixed points of its period map, by Newton's method on differences of that map.

The unknowns are the strobe state and one more number, eta; the condition that goes with it is a function of the run:
a place along the branch, or a guard that is just touched.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
from mpmath import mp

from support.drill_in_series import SLIP, Drill, Run

Condition = Callable[[list[Any], Run], Any]
"""Of the unknowns (y, u, w, eta) and the run from there; zero where it is met."""


@dataclass
class Orbit:
    """A periodic orbit: strobe state and eta, its run, the derivative of the period map, the branch's direction."""

    unknowns: list[Any]
    run: Run
    map: mpmath.matrix
    direction: list[Any]

    @property
    def eta(self) -> Any:
        """Forcing frequency."""
        return self.unknowns[3]

    def determinant(self, multiplier: int) -> Any:
        """det(DP - multiplier): zero at a fold (1) and at a period doubling (-1)."""
        return mpmath.det(self.map - multiplier * mpmath.eye(3))

    @property
    def multipliers(self) -> np.ndarray:
        """The two multipliers that are not zero by structure."""
        values = np.linalg.eigvals(np.array(self.map.tolist(), float))
        return values[np.argsort(-np.abs(values))][:2]


class Branch:
    """Orbits of ``periods`` forcing periods that slip at the strobe; ``overlook`` as in `Drill.run`."""

    def __init__(self, periods: int, overlook: float = 0.0) -> None:
        self.periods, self.overlook = periods, overlook

    def run(self, z: list[Any]) -> Run:
        """The motion from (y, u, w, eta)."""
        return Drill(z[3]).run(z[:3], SLIP, self.periods, self.overlook)

    def find(self, guess: list[Any], condition: Condition, most: int = 12) -> Orbit | None:
        """Newton's method from ``guess`` for the orbit that meets ``condition``; None if it does not converge."""
        z = [mp.mpf(value) for value in guess]
        apart = mp.mpf(10) ** (-mp.dps // 2)
        for _ in range(most):
            run = self.run(z)
            off = [a - b for a, b in zip(run.state, z, strict=False)] + [condition(z, run)]
            matrix = mpmath.zeros(4)
            for j in range(4):
                moved = [a + (apart if i == j else 0) for i, a in enumerate(z)]
                there = self.run(moved)
                image = [a - b for a, b in zip(there.state, moved, strict=False)] + [condition(moved, there)]
                for i in range(4):
                    matrix[i, j] = (image[i] - off[i]) / apart
            if max(abs(a) for a in off) < apart * 1e-2:
                flow = matrix[:3, :3] + mpmath.eye(3)
                along = [(-1) ** j * mpmath.det(_without(matrix, j)) for j in range(4)]
                size = mpmath.norm(along)
                z = [a - b for a, b in zip(z, mpmath.lu_solve(matrix, mpmath.matrix(off)), strict=True)]
                return Orbit(z, run, flow, [a / size for a in along])
            z = [a - b for a, b in zip(z, mpmath.lu_solve(matrix, mpmath.matrix(off)), strict=True)]
        return None

    def beyond(self, orbit: Orbit, distance: Any) -> Orbit | None:
        """The orbit a pseudo-arclength further on."""
        guess = [a + distance * b for a, b in zip(orbit.unknowns, orbit.direction, strict=True)]
        found = self.find(
            guess, lambda z, run: mp.fdot(orbit.direction, [a - b for a, b in zip(z, guess, strict=True)])
        )
        if found is not None and mp.fdot(found.direction, orbit.direction) < 0:
            found.direction = [-a for a in found.direction]
        return found

    def root(self, orbit: Orbit, distance: Any, test: Callable[[Orbit], Any], most: int = 40) -> Orbit:
        """The orbit with ``test`` zero: secant method along the branch, from ``orbit`` and one ``distance`` on."""
        steps, values = [mp.zero, mp.mpf(distance)], [test(orbit), test(self._certain(orbit, distance))]
        for _ in range(most):
            s = steps[-1] - values[-1] * (steps[-1] - steps[-2]) / (values[-1] - values[-2])
            found = self._certain(orbit, s)
            steps, values = [steps[-1], s], [values[-1], test(found)]
            if abs(steps[1] - steps[0]) < mp.mpf(10) ** (-mp.dps // 3) or values[1] == values[0]:
                return found
        raise ArithmeticError("no root along the branch")

    def _certain(self, orbit: Orbit, distance: Any) -> Orbit:
        found = self.beyond(orbit, distance)
        if found is None:
            raise ArithmeticError(f"no orbit beside eta = {orbit.eta}")
        return found


def _without(matrix: mpmath.matrix, column: int) -> mpmath.matrix:
    """The first three rows without one column."""
    return mpmath.matrix([[matrix[i, j] for j in range(4) if j != column] for i in range(3)])


def touches(kind: str, near: Any) -> Condition:
    """The condition that the maximum of guard ``kind`` next to time ``near`` (in forcing periods) is zero."""

    def condition(z: list[Any], run: Run) -> Any:
        time = near * 2 * mp.pi / z[3]
        return min((m for m in run.misses if m[0] == kind), key=lambda m: abs(m[1] - time))[2]

    return condition

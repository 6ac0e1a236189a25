"""Points of a curve on the surface of orbits over two parameters, along which a scalar function vanishes.

A guess is corrected by the secant method across the curve, within the tangent plane; every trial is an orbit, by
Newton's method at a right angle to that plane.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine import branch
from chaosdrill.orbits.failures import admissible
from chaosdrill.orbits.plane import Plane, plane_at
from chaosdrill.orbits.special import ON_CHORD, LostError

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.targets import Target

FARTHEST = 0.05
"""Distance from where it was guessed at which a point is no longer taken for one of the curve."""

TURNS = 12
"""Steps of the secant method, at most."""

TIGHT = 1e-13
"""Step of the secant method that counts as none."""

NEARLY = 1e-11
"""Step from which on the slope is kept, since differences of the function may be round-off."""

DIFFERENCE = 1e-5
"""Distance over which the function is differenced at the first point."""


@dataclass(frozen=True)
class Spot:
    """A point of a curve.

    Attributes
    ----------
    orbit, lap : Orbit, Lap
    plane : Plane
    tangent, across : ndarray, shape (columns,)
        Along the curve, and at a right angle to it within the plane.
    slope : float
        Derivative of the function across.
    error : float
        Distance from the curve, across it.
    instant : float
        Of the target.
    arclength : float
    """

    orbit: "Orbit"
    lap: "Lap"
    plane: Plane
    tangent: np.ndarray
    across: np.ndarray
    slope: float
    error: float
    instant: float
    arclength: float

    def turned(self) -> "Spot":
        """The same, to be followed the other way."""
        return replace(self, tangent=-self.tangent, arclength=-self.arclength)


@dataclass(frozen=True)
class Corrector:
    """What finds points of the curve of one target.

    Attributes
    ----------
    family : Family
        Of two free parameters.
    target : Target
    limits : ndarray, shape (2, 2)
        Of both parameters.
    """

    family: "Family"
    target: "Target"
    limits: np.ndarray

    def first(self, orbit: "Orbit", lap: "Lap", instant: float) -> Spot:
        """The point of the curve next to an orbit, with the second parameter as it is there.

        Raises
        ------
        LostError
        """
        plane = plane_at(self.family, orbit, lap, self.weights(orbit))
        fixed = plane.rows[:, -1]
        across = np.array([fixed[1], -fixed[0]]) @ plane.rows / np.linalg.norm(fixed)
        slope = self._slope(orbit, lap, plane, across, instant)
        orbit, lap, slope, error, instant = self.onto(orbit, plane, across, slope, instant)
        plane = plane_at(self.family, orbit, lap, self.weights(orbit), plane)
        gradient = np.array([self._slope(orbit, lap, plane, row, instant) for row in plane.rows])
        steep = float(np.linalg.norm(gradient))
        across = gradient @ plane.rows / steep
        return Spot(orbit, lap, plane, -plane.across(across), across, steep, error, instant, 0.0)

    def values(self, orbit: "Orbit") -> np.ndarray:
        """The two parameters, shape (2,)."""
        return orbit.starts[0, self.family.states :]

    def weights(self, orbit: "Orbit") -> np.ndarray:
        """As they are at an orbit: states may grow by much along a curve, as over a resonance."""
        return self.family.weights(orbit, np.ptp(self.limits, axis=1))

    def _value(self, orbit: "Orbit", plane: Plane, instant: float) -> tuple["Orbit", "Lap", float, float]:
        """The orbit beside a guess, and the target's function there."""
        code, orbit, lap, _ = self.family.solve(orbit, plane.conditions, ON_CHORD)
        if code != branch.CONVERGED:
            raise LostError("no orbit beside the curve")
        return orbit, lap, *self.target.value(self.family, orbit, lap, plane, instant)

    def _slope(self, orbit: "Orbit", lap: "Lap", plane: Plane, direction: np.ndarray, instant: float) -> float:
        """Central difference of the function along a direction of the plane."""
        values = [
            self._value(self.family.moved(orbit, lap, sign * DIFFERENCE * direction), plane, instant)[2]
            for sign in (1, -1)
        ]
        return (values[0] - values[1]) / (2 * DIFFERENCE)

    def onto(
        self, guess: "Orbit", plane: Plane, across: np.ndarray, slope: float, instant: float
    ) -> tuple["Orbit", "Lap", float, float, float]:
        """The orbit of the curve next to a guess: (orbit, lap, slope, distance that is left, instant)."""
        step = np.inf
        value = np.nan
        for _ in range(TURNS):
            before, moved = value, step
            orbit, lap, value, instant = self._value(guess, plane, instant)
            if abs(moved) > NEARLY and np.isfinite(moved):
                slope = (value - before) / moved
            if slope == 0:
                break
            step = -value / slope
            if abs(step) <= TIGHT or (abs(step) < NEARLY and abs(step) > 0.3 * abs(moved)):
                return orbit, lap, slope, abs(step), instant
            if not abs(step) < FARTHEST:
                break
            guess = self.family.moved(orbit, lap, step * across)
        raise LostError("the secant method found no point of the curve")

    def beside(self, spot: Spot) -> tuple["Orbit", "Lap"] | None:
        """An orbit that the system follows: where it does so only up to the curve, one next to it; None without one."""
        if not self.target.margin:
            return spot.orbit, spot.lap
        away = -np.sign(spot.slope) * self.target.margin * spot.across
        guess = self.family.moved(spot.orbit, spot.lap, away)
        code, orbit, lap, _ = self.family.solve(guess, spot.plane.conditions, ON_CHORD)
        return (orbit, lap) if code == branch.CONVERGED else None

    def blocked(self, spot: Spot) -> tuple["Orbit", "Lap"] | None:
        """The orbit at or beside a point that the system does not follow as it is written down; None if it does."""
        found = self.beside(spot)
        if found is not None and admissible(*found):
            return None
        return found or (spot.orbit, spot.lap)

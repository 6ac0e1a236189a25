"""A curve on the surface of orbits over two parameters, along which a scalar function vanishes.

The next point is predicted by the polynomial through the last ones and corrected by the secant method across the curve,
within the tangent plane; every trial is an orbit, by Newton's method at a right angle to that plane.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine import branch
from chaosdrill.orbits.borders import BISECTIONS, Border, reason
from chaosdrill.orbits.failures import admissible
from chaosdrill.orbits.plane import Plane, plane_at
from chaosdrill.orbits.special import NOISE, ON_CHORD, LostError

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.targets import Target

DEGREE = 4
"""Points through which the predictor goes."""

PREDICTED = 1e-4
"""Error of prediction, in the norm of the weights, to which steps are adapted."""

FARTHEST = 0.05
"""Distance from where it was predicted at which a point is no longer taken for one of the curve."""

BEND = 0.95
"""Cosine of the largest angle between the curve's directions at two points."""

SHORTEST = 1e-6
"""Part of the longest step below which the curve is lost."""

FIRST = 0.1
"""First step, as a part of the longest."""

TURNS = 12
"""Steps of the secant method, at most."""

TIGHT = 1e-13
"""Step of the secant method that counts as none."""

NEARLY = 1e-11
"""Step from which on the slope is kept, since differences of the function may be round-off."""

DIFFERENCE = 1e-5
"""Distance over which the function is differenced at the first point."""

APART = 1e-8
"""Distance of two points from which on they tell the curve's direction."""


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


@dataclass
class Traced:
    """Points of a curve in one direction, and how it ended: in words, what happens there, and the parameter's error."""

    spots: list[Spot]
    end: BranchEnd = BranchEnd.MOST_POINTS
    words: str = BranchEnd.MOST_POINTS.advice
    happens: Special = Special.REGULAR
    error: float = 0.0


@dataclass
class Tracer:
    """The curve of one target.

    Parameters
    ----------
    family : Family
        Of two free parameters.
    target : Target
    limits : ndarray, shape (2, 2)
        Of both parameters.
    step : float
        Longest step, in the norm of the weights: a part of the ranges.
    most : int
        Points in one direction, at most.
    """

    family: "Family"
    target: "Target"
    limits: np.ndarray
    step: float
    most: int
    _history: list[Spot] = field(default_factory=list)

    def first(self, orbit: "Orbit", lap: "Lap", instant: float) -> Spot:
        """The point of the curve next to an orbit, with the second parameter as it is there.

        Raises
        ------
        LostError
        """
        plane = plane_at(self.family, orbit, lap, self._weights(orbit))
        fixed = plane.rows[:, -1]
        across = np.array([fixed[1], -fixed[0]]) @ plane.rows / np.linalg.norm(fixed)
        slope = self._slope(orbit, lap, plane, across, instant)
        orbit, lap, slope, error, instant = self._onto(orbit, plane, across, slope, instant)
        plane = plane_at(self.family, orbit, lap, self._weights(orbit), plane)
        gradient = np.array([self._slope(orbit, lap, plane, row, instant) for row in plane.rows])
        steep = float(np.linalg.norm(gradient))
        across = gradient @ plane.rows / steep
        return Spot(orbit, lap, plane, -plane.across(across), across, steep, error, instant, 0.0)

    def trace(self, first: Spot) -> Traced:
        """Follow the curve from a point of it, in the direction of its tangent."""
        self._history = spots = [first]
        traced = Traced(spots)
        h = FIRST * self.step
        while len(spots) < self.most:
            spot = self._after(h)
            if spot is None:
                h *= 0.5
                if h < SHORTEST * self.step:
                    last = spots[-1]
                    self._end(traced, Border(last.orbit, last.lap, None, None, SHORTEST * self.step))
                    return traced
                continue
            value = self._values(spot.orbit)
            if ((value < self.limits[:, 0]) | (value > self.limits[:, 1])).any():
                self._to_limit(traced, h)
                return traced
            if self._blocked(spot) is not None:
                self._to_border(traced, h)
                return traced
            spots.append(spot)
            if self._closed(h):
                traced.end, traced.words = BranchEnd.CLOSED, BranchEnd.CLOSED.advice
                return traced
            error = self._gap(spot.orbit, self._predicted(h, spots[:-1]))
            growth = (PREDICTED / error) ** (1.0 / min(len(spots), DEGREE)) if error > 0 else 2.0
            h = min(h * min(max(growth, 0.3), 2.0), self.step)
        return traced

    def _values(self, orbit: "Orbit") -> np.ndarray:
        return orbit.starts[0, self.family.states :]

    def _gap(self, one: "Orbit", other: "Orbit") -> float:
        d = self.family.states
        return float(np.linalg.norm((one.reduced(d) - other.reduced(d)) * self._history[-1].plane.weights))

    def _weights(self, orbit: "Orbit") -> np.ndarray:
        # states may grow by much along a curve, as over a resonance
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

    def _onto(
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

    def _predicted(self, h: float, spots: list[Spot]) -> "Orbit":
        """The polynomial through the last points, a step behind the last one."""
        last = spots[-1]
        if len(spots) == 1:
            return self.family.moved(last.orbit, last.lap, h * last.tangent)
        nodes = spots[-DEGREE:]
        shares = _shares(np.array([s.arclength for s in nodes]), last.arclength + h, 0)
        starts = np.tensordot(shares, np.array([s.orbit.starts for s in nodes]), 1)
        durations = shares @ np.array([s.orbit.durations for s in nodes])
        # the parameters of all arcs are one pair of numbers
        starts[1:, self.family.states :] = starts[0, self.family.states :]
        phase = float(shares @ np.array([s.orbit.phase for s in nodes]))
        return replace(last.orbit, starts=starts, phase=phase, durations=durations)

    def _after(self, h: float) -> Spot | None:
        """The point of the curve a step behind the last one; None if there is none on a smooth continuation."""
        last = self._history[-1]
        predicted = self._predicted(h, self._history)
        try:
            orbit, lap, slope, error, instant = self._onto(predicted, last.plane, last.across, last.slope, last.instant)
        except LostError:
            return None
        if not self._gap(orbit, predicted) < FARTHEST:
            return None
        d = self.family.states
        plane = plane_at(self.family, orbit, lap, self._weights(orbit), last.plane)
        length = last.arclength + self._gap(orbit, last.orbit)
        tangent = last.tangent
        if length - last.arclength > APART:
            nodes = self._history[1 - DEGREE :]
            shares = _shares(np.array([*(s.arclength for s in nodes), length]), length, 1)
            tangent = shares @ np.array([*(s.orbit.reduced(d) for s in nodes), orbit.reduced(d)])
        inside = plane.part(tangent)
        tangent = (inside @ plane.rows) / np.linalg.norm(inside)
        if not last.plane.part(tangent) @ last.plane.part(last.tangent) > BEND:
            return None
        across = plane.across(tangent)
        across = across if plane.part(across) @ plane.part(last.across) > 0 else -across
        return Spot(orbit, lap, plane, tangent, across, slope, error, instant, length)

    def _closed(self, h: float) -> bool:
        first, last = self._history[0], self._history[-1]
        if len(self._history) <= 10 or self._gap(first.orbit, last.orbit) >= h:
            return False
        return bool(first.plane.part(last.tangent) @ first.plane.part(first.tangent) > 0.5)

    def beside(self, spot: Spot) -> tuple["Orbit", "Lap"] | None:
        """An orbit that the system follows: where it does so only up to the curve, one next to it; None without one."""
        if not self.target.margin:
            return spot.orbit, spot.lap
        away = -np.sign(spot.slope) * self.target.margin * spot.across
        guess = self.family.moved(spot.orbit, spot.lap, away)
        code, orbit, lap, _ = self.family.solve(guess, spot.plane.conditions, ON_CHORD)
        return (orbit, lap) if code == branch.CONVERGED else None

    def _blocked(self, spot: Spot) -> tuple["Orbit", "Lap"] | None:
        """The orbit at or beside a point that the system does not follow as it is written down; None if it does."""
        found = self.beside(spot)
        if found is not None and admissible(*found):
            return None
        return found or (spot.orbit, spot.lap)

    def _to_limit(self, traced: Traced, h: float) -> None:
        """The last point is the one at the limit that is passed first."""
        last = self._history[-1]
        found: list[tuple[float, Spot]] = []
        for k, (low, high) in enumerate(self.limits):

            def excess(step: float, k: int = k, low: float = low, high: float = high) -> float:
                spot = self._after(step) if step > 0 else last
                if spot is None:
                    raise LostError("no point of the curve on the way to the limit")
                value = float(self._values(spot.orbit)[k])
                return min(value - low, high - value)

            if excess(0.0) > 0 > excess(h):
                step = brentq(excess, 0.0, h, xtol=1e-15, rtol=1e-14)
                spot = self._after(step)
                if spot is not None:
                    found.append((step, spot))
        if not found:
            traced.end, traced.words = BranchEnd.LIMIT, "a parameter is at its limit"
            return
        step, spot = min(found, key=lambda one: one[0])
        if self._blocked(spot) is not None:
            self._to_border(traced, step)
            return
        self._history.append(spot)
        traced.end, traced.words = BranchEnd.LIMIT, "a parameter reached its limit"

    def _to_border(self, traced: Traced, h: float) -> None:
        """The last point is the last one that the system follows; it is found by bisection."""
        low, high = 0.0, h
        last = good = self._history[-1]
        bad: tuple[Orbit, Lap] | None = None
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            spot = self._after(middle)
            blocked = None if spot is None else self._blocked(spot)
            if spot is not None and blocked is None:
                low, good = middle, spot
            else:
                high, bad = middle, blocked
        if good is not last:
            self._history.append(good)
        orbit, lap = self.beside(good) or (good.orbit, good.lap)
        bad_orbit, bad_lap = bad or (None, None)
        error = (high - low) + max(self.target.margin, NOISE)
        self._end(traced, Border(orbit, lap, bad_orbit, bad_lap, error))

    def _end(self, traced: Traced, border: Border) -> None:
        kind, text = reason(self.family, border)
        ends = {
            Special.GRAZING: BranchEnd.GRAZING,
            Special.EVENT_SWAP: BranchEnd.EVENT_SWAP,
            Special.OUTCOME_SWITCH: BranchEnd.OUTCOME_SWITCH,
        }
        traced.end = ends.get(kind, BranchEnd.NO_CONVERGENCE)
        traced.words = f"{text}; the curve ends" if text else traced.end.advice
        traced.happens = kind
        traced.error = border.error * float(np.ptp(self.limits[0]))


def _shares(nodes: np.ndarray, place: float, derivative: int) -> np.ndarray:
    """What the values at the nodes count in their polynomial at a place, or in its derivative there."""
    scale = float(np.ptp(nodes))
    powers = np.vander((nodes - place) / scale, increasing=True).T
    return np.linalg.solve(powers, np.eye(len(nodes))[derivative]) / scale**derivative

"""A curve of special points followed over two parameters, as far as its orbits keep their events.

The next point is predicted by the polynomial through the last ones; steps are adapted to the error of the prediction.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.orbits.borders import BISECTIONS, Border, reason
from chaosdrill.orbits.correcting import FARTHEST, Corrector, Spot
from chaosdrill.orbits.doubling import halves_apart
from chaosdrill.orbits.plane import plane_at
from chaosdrill.orbits.special import NOISE, LostError

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Lap
    from chaosdrill.orbits.orbit import Orbit

DEGREE = 4
"""Points through which the predictor goes."""

PREDICTED = 1e-4
"""Error of prediction, in the norm of the weights, to which steps are adapted."""

BEND = 0.95
"""Cosine of the largest angle between the curve's directions at two points."""

SHORTEST = 1e-6
"""Part of the longest step below which the curve is lost."""

FIRST = 0.1
"""First step, as a part of the longest."""

APART = 1e-8
"""Distance of two points from which on they tell the curve's direction."""


HALVES = 0.05
"""Difference between the halves of a doubled orbit, as a part of the largest on the curve, at which it ends as one."""

ENDS = {
    Special.GRAZING: BranchEnd.GRAZING,
    Special.EVENT_SWAP: BranchEnd.EVENT_SWAP,
    Special.OUTCOME_SWITCH: BranchEnd.OUTCOME_SWITCH,
}


@dataclass
class Traced:
    """Points of a curve with one sequence of events, in one direction, and how they end.

    Attributes
    ----------
    corrector : Corrector
    spots : list of Spot
    end : BranchEnd
    words : str
        The end in words.
    happens : Special
        What happens at the end.
    border : Border, optional
        Where the events change.
    """

    corrector: Corrector
    spots: list[Spot]
    end: BranchEnd = BranchEnd.MOST_POINTS
    words: str = BranchEnd.MOST_POINTS.advice
    happens: Special = Special.REGULAR
    border: Border | None = None


@dataclass
class Tracer:
    """Follows the curve of one target.

    Parameters
    ----------
    corrector : Corrector
    step : float
        Longest step, in the norm of the weights: a part of the ranges.
    most : int
        Points, at most.
    home : Spot
        Where the curve began; it is closed if it comes back there.
    """

    corrector: Corrector
    step: float
    most: int
    home: Spot
    _history: list[Spot] = field(default_factory=list)

    def trace(self, first: Spot) -> Traced:
        """Follow the curve from a point of it, in the direction of its tangent."""
        self._history = spots = [first]
        traced = Traced(self.corrector, spots)
        h = FIRST * self.step
        while len(spots) < self.most:
            spot = self._after(h)
            if spot is not None and self._outside(spot) and not self._to_limit(traced, h):
                spot = None
            if spot is None:
                h *= 0.5
                if h < SHORTEST * self.step:
                    self._lose(traced)
                    return traced
                continue
            if traced.end == BranchEnd.LIMIT:
                return traced
            if self.corrector.blocked(spot) is not None:
                self._to_border(traced, h)
                return traced
            if self._swapped(spot):
                self._to_half(traced, h)
                return traced
            spots.append(spot)
            if self._closed(h):
                traced.end, traced.words = BranchEnd.CLOSED, BranchEnd.CLOSED.advice
                return traced
            error = self._gap(spot.orbit, self._predicted(h, spots[:-1]))
            growth = (PREDICTED / error) ** (1.0 / min(len(spots), DEGREE)) if error > 0 else 2.0
            h = min(h * min(max(growth, 0.3), 2.0), self.step)
        return traced

    def _gap(self, one: "Orbit", other: "Orbit") -> float:
        d = self.corrector.family.states
        return float(np.linalg.norm((one.reduced(d) - other.reduced(d)) * self._history[-1].plane.weights))

    def _outside(self, spot: Spot) -> bool:
        value, limits = self.corrector.values(spot.orbit), self.corrector.limits
        return bool(((value < limits[:, 0]) | (value > limits[:, 1])).any())

    def _predicted(self, h: float, spots: list[Spot]) -> "Orbit":
        """The polynomial through the last points, a step behind the last one."""
        last = spots[-1]
        if len(spots) == 1:
            return self.corrector.family.moved(last.orbit, last.lap, h * last.tangent)
        nodes, d = spots[-DEGREE:], self.corrector.family.states
        shares = _shares(np.array([s.arclength for s in nodes]), last.arclength + h, 0)
        starts = np.tensordot(shares, np.array([s.orbit.starts for s in nodes]), 1)
        durations = shares @ np.array([s.orbit.durations for s in nodes])
        # the parameters of all arcs are one pair of numbers
        starts[1:, d:] = starts[0, d:]
        phase = float(shares @ np.array([s.orbit.phase for s in nodes]))
        return replace(last.orbit, starts=starts, phase=phase, durations=durations)

    def _after(self, h: float) -> Spot | None:
        """The point of the curve a step behind the last one; None if there is none on a smooth continuation."""
        last = self._history[-1]
        predicted = self._predicted(h, self._history)
        try:
            orbit, lap, slope, error, instant = self.corrector.onto(
                predicted, last.plane, last.across, last.slope, last.instant
            )
            plane = plane_at(self.corrector.family, orbit, lap, self.corrector.weights(orbit), last.plane)
        except LostError:
            return None
        if not self._gap(orbit, predicted) < FARTHEST:
            return None
        d = self.corrector.family.states
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
        last = self._history[-1]
        young = len(self._history) <= 10 and self._history[0] is self.home
        if young or not last.orbit.same_events(self.home.orbit) or self._gap(self.home.orbit, last.orbit) >= h:
            return False
        return bool(self.home.plane.part(last.tangent) @ self.home.plane.part(self.home.tangent) > 0.5)

    def _to_limit(self, traced: Traced, h: float) -> bool:
        """The last point is the one at the limit that is passed first; returns whether it could be found."""
        last = self._history[-1]
        steps: list[float] = []
        for k, (low, high) in enumerate(self.corrector.limits):

            def excess(step: float, k: int = k, low: float = low, high: float = high) -> float:
                spot = self._after(step) if step > 0 else last
                if spot is None:
                    raise LostError("no point of the curve on the way to the limit")
                value = float(self.corrector.values(spot.orbit)[k])
                return min(value - low, high - value)

            try:
                if excess(0.0) > 0 > excess(h):
                    steps.append(brentq(excess, 0.0, h, xtol=1e-15, rtol=1e-14))
            except LostError:
                return False
        spot = self._after(min(steps)) if steps else None
        if steps and spot is None:
            return False
        traced.end, traced.words = BranchEnd.LIMIT, "a parameter reached its limit"
        if spot is not None and self.corrector.blocked(spot) is not None:
            self._to_border(traced, min(steps))
        elif spot is not None:
            self._history.append(spot)
        return True

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
            blocked = None if spot is None else self.corrector.blocked(spot)
            if spot is not None and blocked is None:
                low, good = middle, spot
            else:
                high, bad = middle, blocked
        if good is not last:
            self._history.append(good)
        orbit, lap = self.corrector.beside(good) or (good.orbit, good.lap)
        bad_orbit, bad_lap = bad or (None, None)
        error = (high - low) + max(self.corrector.target.margin, NOISE) + (self._left() if bad is None else 0.0)
        self._end(traced, Border(orbit, lap, bad_orbit, bad_lap, error * float(np.ptp(self.corrector.limits[0]))))

    def _lose(self, traced: Traced) -> None:
        """No further point was found at the smallest step."""
        last, error = self._history[-1], self._left() * float(np.ptp(self.corrector.limits[0]))
        self._end(traced, Border(last.orbit, last.lap, None, None, error))

    def _left(self) -> float:
        """How far beyond the last point an event would have no speed; at least the smallest step."""
        left = SHORTEST * self.step
        if len(self._history) > 1:
            before, last = self._history[-2:]
            lost = before.lap.speeds - last.lap.speeds
            slowest = int(last.lap.speeds.argmin())
            if lost[slowest] > 0:
                along = last.arclength - before.arclength
                left = max(left, along * float(last.lap.speeds[slowest] / lost[slowest]))
        return left

    def _end(self, traced: Traced, border: Border) -> None:
        kind, text = reason(self.corrector.family, border)
        traced.end = ENDS.get(kind, BranchEnd.NO_CONVERGENCE)
        traced.words = f"{text}; the curve ends" if text else traced.end.advice
        traced.happens, traced.border = kind, border
        if traced.end == BranchEnd.NO_CONVERGENCE and self._halves(self._history[-1:]).size:
            gaps = np.abs(self._halves(self._history)).max(axis=1)
            if gaps[-1] < HALVES * gaps.max():
                traced.end, traced.words = BranchEnd.DOUBLING, BranchEnd.DOUBLING.advice

    def _halves(self, spots: list[Spot]) -> np.ndarray:
        """Difference between orbits and themselves half a duration later; empty if their halves have other events."""
        arcs, family = spots[0].orbit.arcs, self.corrector.family
        half = len(arcs) // 2
        odd = len(arcs) % 2 or (family.forced and spots[0].orbit.periods % 2)
        if odd or not np.array_equal(arcs[:half], arcs[half:]):
            return np.zeros((0, 0))
        return halves_apart(family, [s.orbit for s in spots], self._history[0].plane.weights)

    def _swapped(self, spot: Spot) -> bool:
        """Whether the halves of a doubled orbit have come together and traded places since the last point."""
        gaps = self._halves([self._history[-1], spot])
        return bool(gaps.size and gaps[0] @ gaps[1] < 0 and np.abs(gaps).max() < 0.5 * self._widest())

    def _widest(self) -> float:
        return float(np.abs(self._halves(self._history)).max())

    def _to_half(self, traced: Traced, h: float) -> None:
        """The last point is the last one before the halves come together; beyond, the same orbits come once more."""
        low, high = 0.0, h
        good = self._history[-1]
        while high - low > NOISE:
            middle = 0.5 * (low + high)
            spot = self._after(middle)
            if spot is None or self._swapped(spot):
                high = middle
            else:
                low, good = middle, spot
        if low > 0:
            self._history.append(good)
        traced.end, traced.words = BranchEnd.DOUBLING, BranchEnd.DOUBLING.advice


def _shares(nodes: np.ndarray, place: float, derivative: int) -> np.ndarray:
    """What the values at the nodes count in their polynomial at a place, or in its derivative there."""
    scale = float(np.ptp(nodes))
    powers = np.vander((nodes - place) / scale, increasing=True).T
    return np.linalg.solve(powers, np.eye(len(nodes))[derivative]) / scale**derivative

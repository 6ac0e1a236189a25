"""Where the two halves of a doubled orbit come together: beyond, the same orbits come again in the other order."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.branch import BranchSegment
    from chaosdrill.orbits.curve import Curve
    from chaosdrill.orbits.points import Point


def apart(segment: "BranchSegment") -> tuple[np.ndarray, float]:
    """Differences between the halves of a segment's orbits in the direction of the first one, shape (P,); its error."""
    problem, points = segment.curve.problem, segment.points
    gaps = np.array([problem.halves_apart(p.orbit, points[0].weights) for p in points])
    return gaps @ gaps[0] / max(float(np.linalg.norm(gaps[0])), 1e-300), problem.accuracy


class Halves:
    """Differences between the halves of the orbits along a curve, as it is followed."""

    def __init__(self, curve: "Curve", first: "Point") -> None:
        self.curve, self.weights = curve, first.weights
        gap = curve.problem.halves_apart(first.orbit, first.weights)
        self.before, self.last, self.largest, self.count = first, gap, float(np.abs(gap).max(initial=0)), 1
        self.turns: list[tuple[int, float]] = []
        """Orbits at which the difference has turned round, and how large it is beside them."""

    def left(self, point: "Point") -> bool:
        """Whether the halves suddenly coincide: the orbit is then one of half the period, beside a sharp doubling."""
        gap, size = self.curve.problem.halves_apart(point.orbit, self.weights), np.linalg.norm(self.last)
        return bool(np.linalg.norm(gap) < TUNING.together * size and size > TUNING.meeting)

    def passed(self, point: "Point") -> int | None:
        """Index of the first orbit beyond one whose halves coincide, or None, after the next orbit."""
        gap = self.curve.problem.halves_apart(point.orbit, self.weights)
        here = float(np.abs(gap).max(initial=0))
        self.largest = max(self.largest, here)
        if gap @ self.last < 0 and self._vanishes(self.before, point):
            self.turns.append((self.count, max(here, float(np.abs(self.last).max(initial=0)))))
        self.before, self.last, self.count = point, gap, self.count + 1
        return next((k for k, size in self.turns if size < 0.5 * self.largest), None)

    def _vanishes(self, before: "Point", after: "Point") -> bool:
        """Whether the difference is zero between two points, not only turned aside, as a state half a time later may.

        Where no orbit is found on the way the equations are singular, as they are at a doubling.
        """

        def gap(point: "Point") -> np.ndarray:
            return self.curve.problem.halves_apart(point.orbit, self.weights)

        low, high = gap(before), gap(after)
        small = TUNING.together * max(np.linalg.norm(low), np.linalg.norm(high))
        for _ in range(TUNING.touch_steps):
            way = low - high
            try:
                middle = self.curve.between(before, after, float(np.clip(low @ way / (way @ way), 0.1, 0.9)))
            except LostError:
                return True
            there = gap(middle)
            if np.linalg.norm(there) <= small:
                return True
            if there @ low < 0:
                after, high = middle, there
            elif there @ high < 0:
                before, low = middle, there
            else:
                return False
        return False


def halves_met(curve: "Curve", points: "Sequence[Point]", alone: bool) -> bool:
    """Whether the halves have come together at the last point.

    Where nothing else happens there (``alone``), it is enough that they are close.
    """
    gaps = [np.abs(curve.problem.halves_apart(p.orbit, points[0].weights)).max(initial=0) for p in points]
    if alone:
        return bool(gaps[-1] < TUNING.halves * max(gaps))
    return bool(gaps[-1] < TUNING.meeting < max(gaps))


def way_to_doubling(curve: "Curve", points: "Sequence[Point]") -> float:
    """How far the parameter is from where the halves come together: their difference goes with the root of the way."""
    *before, last = (float(np.linalg.norm(curve.problem.halves_apart(p.orbit, points[0].weights))) for p in points)
    far = max((k for k, gap in enumerate(before) if gap > TUNING.opened * last), default=None)
    if far is None:
        return float(curve.spans[0])
    way = abs(float((curve.values(points[far].orbit) - curve.values(points[-1].orbit))[0]))
    return way * last**2 / (before[far] ** 2 - last**2)

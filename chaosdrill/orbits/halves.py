"""Where the two halves of a doubled orbit come together: beyond, the same orbits come again in the other order."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.curve import Curve
    from chaosdrill.orbits.points import Point


class Halves:
    """Differences between the halves of the orbits along a curve, as from `Problem.halves_apart`."""

    def __init__(self, gap: np.ndarray) -> None:
        self.last, self.largest, self.count = gap, float(np.abs(gap).max(initial=0)), 1
        self.turns: list[tuple[int, float]] = []
        """Orbits at which the difference has turned round, and how large it is beside them."""

    def traded_places(self, gap: np.ndarray) -> int | None:
        """Index of the first orbit beyond one whose halves coincide, or None, after the next orbit."""
        here = float(np.abs(gap).max(initial=0))
        self.largest = max(self.largest, here)
        if gap @ self.last < 0:
            self.turns.append((self.count, max(here, float(np.abs(self.last).max(initial=0)))))
        self.last, self.count = gap, self.count + 1
        return next((k for k, size in self.turns if size < 0.5 * self.largest), None)


def halves_met(curve: "Curve", points: "Sequence[Point]", alone: bool) -> bool:
    """Whether the halves have come together at the last point.

    Where nothing else happens there (``alone``), it is enough that they are close.
    """
    gaps = [np.abs(curve.problem.halves_apart(p.orbit, points[0].weights)).max(initial=0) for p in points]
    if alone:
        return bool(gaps[-1] < TUNING.halves * max(gaps))
    return bool(gaps[-1] < TUNING.meeting < max(gaps))


def up_to_half(curve: "Curve", points: "list[Point]", beyond: "Point") -> "list[Point]":
    """The last point before the halves of doubled orbits coincide; beyond it the same orbits repeat."""
    last, good = points[-1], None
    start = curve.problem.halves_apart(last.orbit, last.weights)
    low, high = 0.0, 1.0
    while high - low > TUNING.tangent_error:
        middle = 0.5 * (low + high)
        try:
            point = curve.between(last, beyond, middle)
        except LostError:
            high = middle
            continue
        if start @ curve.problem.halves_apart(point.orbit, last.weights) < 0:
            high = middle
        else:
            low, good = middle, point
    return [] if good is None else [good]

"""An attractor is followed along a parameter: every point starts from the state in which its neighbour ended."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from chaosdrill.analysis.plan import Plan
from chaosdrill.analysis.points import Arrays, Axis, measure, point_columns
from chaosdrill.dataset import count_outcomes
from chaosdrill.engine.batch import Batch


@dataclass(frozen=True)
class LineTask:
    """Lines of points, forward or backward along a parameter; a unit is a whole line.

    Where a run ends early, as one that escapes, the next point starts from the line's own initial state.

    Attributes
    ----------
    plan : Plan
        How a point is measured.
    axis : Axis
        The swept parameter.
    directions : tuple of str
        ``"forward"`` or ``"backward"``, for each line.
    start : ndarray, shape (n,)
        Initial state of all lines.
    mode : int
        Their initial mode.
    keeps : tuple of str
        Arrays that are kept of every point.
    """

    plan: Plan
    axis: Axis
    directions: tuple[str, ...]
    start: np.ndarray
    mode: int
    keeps: tuple[str, ...]

    @property
    def units(self) -> int:
        """Lines."""
        return len(self.directions)

    @property
    def points_per_unit(self) -> int:
        """Points of a line."""
        return len(self.axis.values)

    @property
    def total(self) -> int:
        """Points in all."""
        return self.units * self.points_per_unit

    def columns(self) -> dict[str, tuple[str, tuple[int, ...]]]:
        """Dtype and shape of one line of each array, in the order of the values."""
        declared = point_columns(self.plan)
        return {name: (declared[name][0], (self.points_per_unit, *declared[name][1])) for name in self.keeps}

    def run(self, first: int, count: int) -> Arrays:
        """Results of some lines."""
        lines = [self._line(direction) for direction in self.directions[first : first + count]]
        return {name: np.stack([line[name] for line in lines]) for name in self.keeps}

    def _line(self, direction: str) -> Arrays:
        points = self.points_per_unit
        kept = {name: np.zeros(shape, dtype) for name, (dtype, shape) in self.columns().items()}
        before: Batch | None = None
        for index in range(points) if direction == "forward" else range(points - 1, -1, -1):
            parameters = {self.axis.name: self.axis.values[[index]]}
            found, before = measure(self.plan, parameters, self.start[np.newaxis], np.array([self.mode]), before)
            for name in self.keeps:
                kept[name][index] = found[name][0]
        return kept

    def counts(self, arrays: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Points by outcome."""
        return count_outcomes(arrays["outcome"])

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.plan.fingerprint() | {
            "line": {self.axis.name: self.axis.values.tolist()},
            "directions": list(self.directions),
            "start": self.start.tolist(),
            "mode": self.mode,
            "keeps": list(self.keeps),
        }

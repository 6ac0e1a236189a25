"""A branch of equilibria over one parameter by pseudo-arclength (Keller 1977), which passes folds.

The unknowns are the m free states and the parameter; each state counts in the larger of its size and its value, the
parameter in its range.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from chaosdrill.dataset.branches import BranchEnd
from chaosdrill.equilibrium.fields import UNIT, Field
from chaosdrill.equilibrium.points import Equilibrium, equilibrium, polished
from chaosdrill.equilibrium.tuning import TUNING


class LostError(Exception):
    """Raised where no next equilibrium is found."""


@dataclass(frozen=True)
class Point:
    """An equilibrium of a branch with the direction in which the branch goes on."""

    at: Equilibrium
    tangent: np.ndarray  # (m + 1,): of length 1 where unknowns count in their sizes
    arclength: float = 0.0

    def turned(self) -> "Point":
        """The same on the branch in the other direction."""
        return replace(self, tangent=-self.tangent, arclength=-self.arclength)


@dataclass(frozen=True)
class Curve:
    """The equilibria of a mode over a parameter."""

    field: Field
    which: int  # number of the parameter
    limits: tuple[float, float]
    sizes: np.ndarray  # (m,): of the free states
    bounds: np.ndarray  # (n, 2): beyond which a state has escaped
    step: float  # longest step of the parameter, as a part of its range

    @cached_property
    def places(self) -> list[int]:
        """Where the unknowns stand among the numbers."""
        return [*self.field.free, self.field.place(self.which)]

    def unknowns(self, one: Equilibrium) -> np.ndarray:
        """Free states and parameter, shape (m + 1,)."""
        found: np.ndarray = one.numbers[self.places]
        return found

    def value(self, one: Equilibrium) -> float:
        """The parameter."""
        return float(one.numbers[self.places[-1]])

    def weights(self, one: Equilibrium) -> np.ndarray:
        """How large each unknown is at an equilibrium."""
        return np.array([*np.maximum(self.sizes, np.abs(one.free)), self.limits[1] - self.limits[0]])

    def matrix(self, numbers: np.ndarray) -> np.ndarray:
        """Derivatives of the rates by the unknowns, shape (m, m + 1)."""
        return np.column_stack([self.field.jacobian(numbers), self.field.by_parameter(numbers, self.which)])

    def scaled(self, numbers: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same of scaled unknowns, with rows of length 1, and the factors of the rows."""
        found = self.matrix(numbers) * weights
        lengths = np.linalg.norm(found, axis=1)
        rows = 1 / np.where(lengths > 0, lengths, 1.0)
        return found * rows[:, np.newaxis], rows

    def tangent(self, one: Equilibrium, along: np.ndarray | None = None) -> np.ndarray:
        """The direction of the branch, that which goes with ``along``; by default to larger parameters."""
        matrix, _ = self.scaled(one.numbers, self.weights(one))
        if not np.isfinite(matrix).all():
            raise LostError("the rates have no derivatives there")
        way: np.ndarray = np.linalg.svd(matrix)[2][-1]
        forward = way[-1] if along is None else way @ along
        return way if forward >= 0 else -way

    def first(self, one: Equilibrium) -> Point:
        """The point where a branch is begun."""
        return Point(one, self.tangent(one))

    def corrected(self, guess: np.ndarray, from_: Point, row: np.ndarray | None = None) -> Equilibrium:
        """The equilibrium beside a guess of the unknowns, in the plane across the branch; else at a given direction.

        Raises `LostError`.
        """
        weights = self.weights(from_.at)
        row = from_.tangent if row is None else row
        numbers = from_.at.numbers.copy()
        numbers[self.places] = guess
        last = length = np.inf
        for _ in range(TUNING.newton_steps):
            rates = self.field.rate(numbers)
            matrix, rows = self.scaled(numbers, weights)
            left = np.array([*(rows * rates), row @ ((numbers[self.places] - guess) / weights)])
            whole = np.vstack([matrix, row])
            if not (np.isfinite(whole).all() and np.isfinite(left).all()):
                break
            # where branches cross, steps shrink no further than rounding over a pivot that vanishes
            settled = length <= TUNING.settled or length > last / 2
            if settled and (np.abs(rates) <= self.allowed(numbers, weights)).all():
                return equilibrium(self.field, numbers)
            try:
                step = -np.linalg.solve(whole, left)
            except np.linalg.LinAlgError:
                step = -np.linalg.lstsq(whole, left, rcond=None)[0]
            numbers = numbers.copy()
            numbers[self.places] += weights * step
            last, length = length, float(np.linalg.norm(step))
            if not length < TUNING.farthest:
                break
        raise LostError("Newton's method did not converge")

    def allowed(self, numbers: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """What may be left of the rates: their rounding, and that of states of their sizes, since one may be zero."""
        sizes = UNIT * np.abs(self.field.jacobian(numbers)) @ weights[:-1]
        found: np.ndarray = TUNING.rounded * (self.field.rounding(numbers) + sizes)
        return found

    def after(self, last: Point, h: float) -> Point:
        """The point a step further; raises `LostError`."""
        weights = self.weights(last.at)
        guess = self.unknowns(last.at) + h * weights * last.tangent
        one = self.corrected(guess, last)
        apart = float(np.linalg.norm((self.unknowns(one) - guess) / weights))
        tangent = self.tangent(one, last.tangent * weights / self.weights(one))
        straight = float(tangent @ last.tangent) / float(np.linalg.norm(last.tangent))
        if apart > TUNING.nearest * h or straight < TUNING.straight:
            raise LostError("the step is too long")
        return Point(one, tangent, last.arclength + h)

    def between(self, first: Point, last: Point, part: float) -> Point:
        """A point between two neighbours, part of the way."""
        weights = self.weights(first.at)
        way = (self.unknowns(last.at) - self.unknowns(first.at)) / weights
        guess = self.unknowns(first.at) + part * weights * way
        one = self.corrected(guess, first, way / np.linalg.norm(way))
        # the branch may turn by a right angle where another one crosses: the chord tells the direction
        along = first.tangent if first.tangent @ way > 0.5 * np.linalg.norm(way) else way
        tangent = self.tangent(one, along)
        return Point(one, tangent, first.arclength + part * (last.arclength - first.arclength))

    def at_value(self, first: Point, last: Point, value: float) -> Equilibrium | None:
        """The equilibrium between two neighbours at a value of the parameter between theirs."""
        low, high = self.value(first.at), self.value(last.at)
        part = 0.0 if low == high else (value - low) / (high - low)
        numbers = first.at.numbers.copy()
        numbers[self.places] += part * (self.unknowns(last.at) - self.unknowns(first.at))
        numbers[self.places[-1]] = value
        found = polished(self.field, numbers)
        return None if found is None else equilibrium(self.field, found)

    def escaped(self, one: Equilibrium) -> bool:
        """Whether a state is beyond its bounds."""
        states = one.states
        return bool(((states < self.bounds[:, 0]) | (states > self.bounds[:, 1])).any())

    def holds(self, points: Sequence[Point], one: Equilibrium) -> bool:
        """Whether an equilibrium is one of a branch."""
        weights, here = self.weights(one), self.unknowns(one)
        known = np.array([self.unknowns(p.at) for p in points])
        chords, away = np.diff(known, axis=0) / weights, (here - known[:-1]) / weights
        lengths = np.maximum((chords**2).sum(axis=1), 1e-300)
        parts = (away * chords).sum(axis=1) / lengths
        apart = np.linalg.norm(away - parts[:, np.newaxis] * chords, axis=1)
        beside = (parts >= -TUNING.beyond) & (parts <= 1 + TUNING.beyond) & (apart <= np.sqrt(lengths))
        near = TUNING.same + TUNING.same_errors * np.nan_to_num(np.append(one.error, 0.0), posinf=np.inf) / weights
        for k in np.flatnonzero(beside).tolist():
            try:
                other = self.between(points[k], points[k + 1], float(parts[k]))
            except LostError:
                continue
            if (np.abs(self.unknowns(other.at) - here) / weights <= near).all():
                return True
        return False


def followed(curve: Curve, first: Point, most: int) -> tuple[list[Point], BranchEnd]:
    """Points of a branch from the first on in the direction of its tangent, and how they end."""
    points, low, high = [first], *curve.limits
    longest = min(curve.step, TUNING.longest_step)
    h = TUNING.first_step * longest
    while len(points) < most:
        last = points[-1]
        try:
            point = curve.after(last, h)
        except LostError:
            h /= 2
            if h < TUNING.shortest_step * longest:
                return points, BranchEnd.NO_CONVERGENCE
            continue
        value = curve.value(point.at)
        if not low <= value <= high:
            end = low if value < low else high
            if curve.value(last.at) != end:
                limit = curve.at_value(last, point, end)
                if limit is not None:
                    part = (end - curve.value(last.at)) / (value - curve.value(last.at))
                    points.append(Point(limit, point.tangent, last.arclength + part * h))
            return points, BranchEnd.LIMIT
        if curve.escaped(point.at):
            return points, BranchEnd.ESCAPED
        points.append(point)
        if len(points) > 3 and _home(curve, points, h):
            points[-1] = replace(first, arclength=point.arclength)
            return points, BranchEnd.CLOSED
        steep = max(float(np.abs(point.tangent[:-1]).max()), 1e-300)
        most_h = min(curve.step / max(abs(float(point.tangent[-1])), 1e-300), TUNING.longest_step / steep)
        h = min(h * TUNING.growth, most_h)
    return points, BranchEnd.MOST_POINTS


def _home(curve: Curve, points: list[Point], h: float) -> bool:
    """Whether the branch has come back to its first point with the last step."""
    first, before, last = points[0], points[-2], points[-1]
    weights = curve.weights(before.at)
    to_first = (curve.unknowns(first.at) - curve.unknowns(before.at)) / weights
    if np.linalg.norm(to_first) > 2 * h or float(first.tangent @ last.tangent) < TUNING.straight:
        return False
    along = float(to_first @ before.tangent)
    if not 0 < along <= h:
        return False
    try:
        # in the plane of the first point
        there = curve.corrected(curve.unknowns(before.at) + along * weights * before.tangent, before)
    except LostError:
        return False
    away = np.abs(curve.unknowns(there) - curve.unknowns(first.at)) / weights
    return bool(away.max() <= TUNING.same)

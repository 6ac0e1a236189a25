"""Curves of orbits: how the next point is predicted and corrected.

A branch of orbits over one parameter and a curve of special points over two are alike: the next point is predicted by
the polynomial through the last ones and corrected at a right angle to the curve. Along a curve of special points a test
function vanishes as well. Every trial lies on the surface of orbits, by Newton's method; across the curve the
function's root is found by the secant method.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.engine import shooting as at
from chaosdrill.orbits.points import Border, Candidate, Direction, Plane, Point, Root, Whole, plane_at
from chaosdrill.orbits.problem import CONVERGED, LostError, admissible
from chaosdrill.orbits.sliding import Landing
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


class TestFunction(Protocol):
    """A function that vanishes along the curve.

    Attributes
    ----------
    margin : float
        0, or the distance from the curve, in the norm of the weights, at which it is seen whether the system follows
        the orbits: where it does so only up to the curve itself, and only where the function is negative.
    """

    margin: float

    @property
    def kind(self) -> Special:
        """What an orbit is at which it vanishes."""

    def value(self, candidate: Candidate) -> tuple[float, float]:
        """The function, and what it goes by on the next orbit: the time at which a guard is touched, or half the sum of
        a pair of multipliers.
        """


class Curve:
    """A branch of orbits over one parameter, and the equations for its points.

    ``limits``, shape (q, 2): smallest and largest value of each free parameter.
    """

    noun = "branch"
    kind = Special.REGULAR
    margin = 0.0

    def __init__(self, problem: "Problem", limits: np.ndarray) -> None:
        self.problem: Problem = problem
        self.limits = limits
        self.spans = np.ptp(limits, axis=1)
        if problem.ends:
            low, high = np.array([[end.value for end in pair] for pair in problem.ends[: len(limits)]]).T
            self.limits = np.stack([np.maximum(limits[:, 0], low), np.minimum(limits[:, 1], high)], axis=1)
        self.gain = 1.0
        """How much more than usual states count along it."""
        self._known: tuple[np.ndarray, Whole] | None = None

    def unlimited(self) -> "Curve":
        """The same curve without limits."""
        other = copy(self)
        other.limits = np.tile([-np.inf, np.inf], (len(self.limits), 1))
        return other

    def weights(self, orbit: "Orbit") -> np.ndarray:
        """Weights of differences between reduced unknowns."""
        return self.problem.weights(orbit, self.spans, self.gain)

    def values(self, orbit: "Orbit") -> np.ndarray:
        """The free parameters, shape (q,)."""
        return orbit.starts[0, self.problem.states :]

    def outside(self, orbit: "Orbit") -> bool:
        """Whether a parameter is beyond its limits."""
        value = self.values(orbit)
        return bool(((value < self.limits[:, 0]) | (value > self.limits[:, 1])).any())

    def kink_at(self, orbit: "Orbit") -> str:
        """In words, the kink or jump of the equations in a parameter at which an orbit is; empty if it is at none."""
        for name, value, pair in zip(self.problem.free, self.values(orbit), self.problem.ends, strict=False):
            for end in pair:
                if end.value == value:
                    return f"{end.part} has a kink or a jump at {name} = {value:.12g}; begin another one beyond it"
        return ""

    def apart(self, one: "Orbit", other: "Orbit", weights: np.ndarray) -> np.ndarray:
        """The weighted difference of two orbits in all their points."""
        return self.whole(weights).apart(one, other)

    def whole(self, weights: np.ndarray) -> Whole:
        """Weights of all differences, from these weights."""
        if self._known is None or self._known[0] is not weights:
            self._known = weights, Whole(self.problem, weights)
        return self._known[1]

    def gap(self, one: "Orbit", other: "Orbit", weights: np.ndarray) -> float:
        """Distance of two orbits of the same segments, in the norm of `Whole`."""
        difference = self.apart(one, other, weights)
        return float(np.sqrt(difference @ difference))

    def met(self, one: "Orbit", other: "Orbit", weights: np.ndarray, within: float) -> "Orbit | None":
        """An orbit written from where another one begins if the two are this close; otherwise None."""
        if len(one) != len(other) or one.periods != other.periods:
            return None
        if np.abs((self.values(one) - self.values(other)) / self.spans).max() > within:
            return None
        if one.segments[0, at.SEGMENT_END] == other.segments[0, at.SEGMENT_END] == at.PLANE:
            slid = self.problem.begun_beside(one, other, weights)
            if slid is None:
                return None
            one = slid
        period = self.problem.period_at(one)
        nearest = None
        away = self.problem.shifts.across((one.starts - other.starts[0])[:, : self.problem.states])
        apart = np.abs(away * self.whole(weights).starts).max(axis=1)
        for first in np.flatnonzero(apart <= within).tolist():
            if not np.array_equal(np.roll(one.segments, -first, axis=0), other.segments):
                continue
            turned = one.rotated(first, None)
            if self.problem.shifts:
                away = (other.starts - turned.starts)[0, : self.problem.states]
                turned = turned.shifted(self.problem.shifts.part(away))
            if period:
                turned = replace(turned, phase=turned.phase + period * round((other.phase - turned.phase) / period))
            gap = self.gap(other, turned, weights)
            if gap <= within:
                nearest, within = turned, gap
        return nearest

    def directed(self, shot: "Shot", change: np.ndarray, weights: np.ndarray) -> Direction:
        """The direction of a change of the reduced unknowns."""
        return self.whole(weights).direction(shot, change)

    def magnify(self, orbit: "Orbit", shot: "Shot") -> None:
        """Let states that hardly change over a narrow range count for more: a fold there is as sharp as a needle."""
        *changes, value = self.first(orbit, shot).tangent.course
        response = float(np.linalg.norm(changes) / max(abs(value), np.finfo(float).tiny))
        if response > TUNING.least_response:
            self.gain = max(1.0, TUNING.response / response)

    def first(self, orbit: "Orbit", shot: "Shot", ahead: np.ndarray | None = None) -> Point:
        """A converged orbit as the first point of a curve that is followed towards ``ahead``.

        By default the parameter increases.
        """
        weights = self.weights(orbit)
        # over all points the error of ``ahead`` may matter, which grows along an orbit
        row = None if ahead is None else ahead * weights * weights
        tangent = self.directed(shot, self.problem.direction(orbit, shot, weights, row), weights)
        return Point(orbit, shot.bare(), weights, tangent, orbit)

    def correct(self, guess: "Orbit", near: Point, row: np.ndarray) -> Point:
        """The point of the curve nearest to a guess.

        ``near``: the nearest known point. ``row``, shape (columns,): corrections are orthogonal to it.

        Raises `LostError`.
        """
        orbit, shot = self._solved(guess, near, row[np.newaxis])
        weights = self.weights(orbit)
        change = self.problem.direction(orbit, shot, weights, near.tangent.row)
        return Point(orbit, shot.bare(), weights, self.directed(shot, change, weights), near.section)

    def _solved(self, guess: "Orbit", near: Point, conditions: np.ndarray) -> tuple["Orbit", "Shot"]:
        code, orbit, shot, _ = self.problem.newton(
            guess, conditions, TUNING.farthest, weights=near.weights, section=near.section
        )
        if code != CONVERGED or not shot.regular:
            raise LostError("no orbit beside the curve")
        return orbit, shot

    def followed(self, point: Point) -> tuple["Orbit", "Shot"] | None:
        """An admissible orbit at a point, or next to it where orbits are admissible only up to the curve."""
        return point.orbit, point.shot

    def size(self, orbit: "Orbit") -> float:
        """Size of the first parameter at an orbit; its range where it passes zero."""
        return max(abs(float(self.values(orbit)[0])), float(self.spans[0]))

    def error_at(self, point: Point) -> float:
        """Error of the first parameter at a special point, as a result of the error of the orbit."""
        return sum(self.errors_at(point))

    def errors_at(self, point: Point) -> tuple[float, float]:
        """The error of the first parameter at a special point that lies elsewhere along the curve, or off it.

        The error of an orbit is the residual of its equations over their smallest singular value, and a special point
        is off along the curve by as much: near a multiplier 1 that is many times the residual. They are 0 where the
        equations have no derivatives.
        """
        shot = self.problem.shoot(point.orbit, False, point.section)
        if not shot.regular:
            return 0.0, 0.0
        change, weights, first = point.tangent.change, point.weights, -len(self.spans)
        along = abs(float(change[first])) / np.linalg.norm(weights * change)
        off = self.problem.off(point.orbit, shot, weights, self.gain)
        # what is left of the equations leads off the curve; the error of the method only moves the curve
        left = (shot.residual + np.finfo(float).eps) / self.problem.accuracy
        return float(along * np.linalg.norm(off)), float(left * abs(off[first]) / weights[first])

    def blocked(self, point: Point) -> tuple["Orbit", "Shot"] | None:
        """The orbit at or beside a point if it is inadmissible; otherwise None."""
        found = self.followed(point)
        if found is not None and admissible(*found):
            return None
        return found or (point.orbit, point.shot)

    def predicted(self, points: list[Point], h: float) -> "Orbit":
        """The polynomial through the last points, one step beyond the last."""
        last = points[-1]
        if len(points) == 1:
            shot = self.problem.shoot(last.orbit, False, last.section)
            return self.problem.moved(last.orbit, shot, h * last.tangent.change)
        places = np.array([p.arclength for p in points])
        orbit = self.interpolated([p.orbit for p in points], places, last.arclength + h, last.orbit)
        return self.problem.kept(orbit, last.orbit, h * last.tangent.change)

    def interpolated(self, orbits: "Sequence[Orbit]", places: np.ndarray, place: float, like: "Orbit") -> "Orbit":
        """The polynomial through orbits of the same segments, at one place."""
        shares = shares_of(places, place, 0)
        starts = np.tensordot(shares, np.array([one.starts for one in orbits]), 1)
        # all segments share one set of parameters
        starts[1:, self.problem.states :] = starts[0, self.problem.states :]
        durations = shares @ np.array([one.durations for one in orbits])
        phase = float(shares @ np.array([one.phase for one in orbits]))
        return replace(like, starts=starts, phase=phase, durations=durations)

    def after(self, points: list[Point], h: float) -> tuple[Point, float]:
        """The next point, one step along the curve, and the error of its prediction.

        ``points`` are those that the predictor passes through.

        Raises `LostError` if the smooth continuation has no such point.
        """
        last = points[-1]
        predicted = self.predicted(points, h)
        point = self.correct(predicted, last, last.tangent.row)
        error = self.gap(predicted, point.orbit, last.weights)
        if not error < min(TUNING.farthest, TUNING.aside * h):
            raise LostError("the orbit is far from where it was predicted")
        way = self.apart(last.orbit, point.orbit, last.weights)
        if not way @ last.tangent.course > 0:
            raise LostError("the orbit lies behind the last one")
        length = float(np.sqrt(way @ way))
        point = self.aligned(replace(point, arclength=last.arclength + length), points)
        if not self.cosine(last, point) > TUNING.bend:
            raise LostError("the curve bends too much")
        return point, error

    def turns_between(self, one: Point, other: Point) -> bool:
        """Whether the second point lies beyond a fold so sharp that its tangent is taken to lead on, not back."""
        sides = [self.problem.side(p.orbit, p.tangent.row, p.weights) for p in (one, other)]
        return sides[0] * sides[1] < 0

    def aligned(self, point: Point, points: list[Point]) -> Point:
        """A point with its tangent aligned to those of earlier points."""
        return point

    def cosine(self, one: Point, other: Point) -> float:
        """Cosine of the angle between the tangents at two points."""
        return float(one.tangent.course @ other.tangent.course)

    def between(
        self, one: Point, other: Point, part: float, row: np.ndarray | None = None, guess: "Orbit | None" = None
    ) -> Point:
        """The point of the curve next to the line between two points, orthogonal to ``row`` or to the first tangent.

        ``guess`` is a better one than the point of the line.

        Raises `LostError` if Newton's method fails, or leads to another part of the curve.
        """
        guess = one.orbit.between(other.orbit, part) if guess is None else guess
        point = self.correct(guess, one, one.tangent.row if row is None else row)
        done, left = (self.gap(point.orbit, end.orbit, one.weights) for end in (one, other))
        if done + left > TUNING.aside_between * self.gap(one.orbit, other.orbit, one.weights) + TUNING.meeting:
            raise LostError("the orbit is far from the two that it lies between")
        share = done / (done + left) if done > 0 else 0.0
        return replace(point, arclength=one.arclength + share * (other.arclength - one.arclength))

    def at_limit(self, last: Point, beyond: Point) -> Point | None:
        """The point at the first limit passed between two points; None if the last point lies on it.

        Raises `LostError`.
        """
        here, there = self.values(last.orbit), self.values(beyond.orbit)
        limit = np.where(there < here, self.limits[:, 0], self.limits[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = np.where((there - limit) * (there - here) > 0, (limit - here) / (there - here), np.inf)
        k = int(parts.argmin())
        if not 0 < parts[k] < np.inf:
            return None
        guess = last.orbit.between(beyond.orbit, parts[k])
        values = self.values(guess).copy()
        values[k] = limit[k]
        row = np.zeros(len(last.weights))
        row[len(row) - len(values) + k] = 1.0
        guess = guess.with_values(values, self.problem.states)
        point = self.correct(guess, last, row)
        if not self.gap(guess, point.orbit, last.weights) < TUNING.farthest:
            raise LostError("the orbit at the limit is far from where it was predicted")
        return replace(point, arclength=last.arclength + self.gap(last.orbit, point.orbit, last.weights))

    def bisect(self, last: Point, beyond: Point) -> tuple[Point, Border]:
        """Bisect between an admissible point and one that is not: the last point before the border, and the border.

        The former is ``last`` itself if there is nothing in between.
        """
        good, beyond, bad, part = self._bisected(last, beyond)
        orbit, shot = self.followed(good) or (good.orbit, good.shot)
        error = part * abs(float(self.values(beyond.orbit)[0] - self.values(good.orbit)[0]))
        error += self.problem.accuracy * self.size(orbit) + self.margin * self.spans[0]
        if self.margin:
            # how far the border moves with the distance from the curve at which it is seen
            wider = copy(self)
            wider.margin = 2 * self.margin
            moved = self.values(wider._bisected(last, beyond)[0].orbit) - self.values(good.orbit)
            error += 2 * abs(float(moved[0]))
        error += self._known_from(last, good, error) + self.stay_left(last, good)
        bad_orbit, bad_shot = bad or (None, None)
        return good, Border(orbit, shot, bad_orbit, bad_shot, float(error))

    def _bisected(self, last: Point, beyond: Point) -> tuple[Point, Point, "tuple[Orbit, Shot] | None", float]:
        """The last point before a border, one beyond, the orbit there, and which part of the way lies between them."""
        good, bad, part = last, self.blocked(beyond), 1.0
        row = last.tangent.row
        for _ in range(TUNING.bisections):
            half = 0.5 * part
            try:
                point = self.between(good, beyond, half, row)
                blocked = self.blocked(point)
            except LostError:
                part, bad = half, None
                continue
            if blocked is None:
                good, part = point, (part - half) / (1 - half)
            else:
                beyond, bad, part = point, blocked, 1.0
        return good, beyond, bad, part

    def stay_left(self, before: Point, border: Point) -> float:
        """How far from a border, in the first parameter, a stay that vanishes there has no effect.

        Orbits without it are found before it vanishes, and rounding decides which guards are met in it. Its rate along
        the curve tells how far that is; near a touch, where it grows as the root of the distance, twice as far.
        """
        lasting, longer = border.orbit.durations, before.orbit.durations
        if len(lasting) != len(longer):
            return 0.0
        i = int(lasting.argmin())
        whole = float(lasting.sum())
        if not lasting[i] < min(longer[i], TUNING.tangential * whole):
            return 0.0
        way = abs(float((self.values(before.orbit) - self.values(border.orbit))[0]))
        change = np.abs(border.tangent.change)
        left = float(abs(lasting[i]) * change[-len(self.spans)])
        rate = float(change[self.problem.states + 1 + i])
        # a longer stay that vanishes further away than the step is long does not do so there
        there = rate > 0 and (left <= way * rate or lasting[i] <= TUNING.touching * whole)
        return left / rate if there else 0.0

    def _known_from(self, before: Point, border: Point, within: float) -> float:
        """Error of a border from the orbits beside it: the distance at which their errors are smaller than that.

        If a multiplier tends to 1 there, the errors of the orbits exceed their distance from the border, and none of
        those closer to it tells on which side it lies.
        """
        error = self.error_at(border)
        step = abs(float((self.values(before.orbit) - self.values(border.orbit))[0]))
        if error <= within or not step > 0:
            return error
        low, high, least = np.log(TUNING.known_from), min(0.0, float(np.log(error / step))), error
        tried = high
        for _ in range(TUNING.known_tried):
            try:
                point = self.between(border, before, float(np.exp(tried)), before.tangent.row)
            except LostError:
                break
            away = abs(float((self.values(point.orbit) - self.values(border.orbit))[0]))
            there = self.error_at(point)
            if tried == high and there > 0.5 * error:
                # it is practically constant
                return error
            if there <= away:
                high, least = tried, away + there
            else:
                low = tried
            if not high > low:
                break
            tried = 0.5 * (low + high)
        return min(error, least)


class SpecialCurve(Curve):
    """A curve over two parameters along which a test function vanishes.

    ``problem``: of two free parameters. ``limits``, shape (2, 2). ``test``: the function.
    """

    noun = "curve"

    def __init__(self, problem: "Problem", limits: np.ndarray, test: "TestFunction") -> None:
        super().__init__(problem, limits)
        self.test, self.kind, self.margin = test, test.kind, test.margin

    def begin(self, orbit: "Orbit", shot: "Shot", tracked: float) -> Point:
        """The point of the curve next to an orbit, with the second parameter as it is there; raises `LostError`."""
        plane = plane_at(self.problem, orbit, shot, self.weights(orbit))
        across = plane.direction(np.array([plane.rows[1, -1], -plane.rows[0, -1]]))
        slope = self.slope(orbit, shot, plane, plane.part(across.course), tracked)
        row = np.eye(len(plane.weights))[-1]
        root = Root(plane, across, slope, 0.0, tracked)
        near = Point(orbit, shot, plane.weights, across, orbit, root=root)
        found, shot, root = self._on_curve(orbit, near, row)
        gradient = np.array([self.slope(found, shot, root.plane, r, root.tracked) for r in np.eye(2)])
        across, steep = root.plane.direction(gradient), float(np.linalg.norm(gradient))
        tangent = root.plane.direction(np.array([gradient[1], -gradient[0]]))
        root = replace(root, across=across, slope=steep)
        return Point(found, shot.bare(), root.plane.weights, tangent, found, special=self.kind, root=root)

    def correct(self, guess: "Orbit", near: Point, row: np.ndarray) -> Point:
        orbit, shot, root = self._on_curve(guess, near, row)
        tangent = root.plane.direction(root.plane.part(near.tangent.course))
        return self._turned_with(
            Point(orbit, shot.bare(), root.plane.weights, tangent, near.section, special=self.kind, root=root), near
        )

    def _turned_with(self, point: Point, near: Point) -> Point:
        """The point with its transverse direction orthogonal to its tangent, on the same side as a neighbour's."""
        assert point.root is not None
        assert near.root is not None
        plane = point.root.plane
        a, b = plane.part(point.tangent.course)
        across = plane.direction(np.array([-b, a]))
        if near.root.across.course @ across.course < 0:
            across = across.times(-1)
        return replace(point, root=replace(point.root, across=across))

    def _on_curve(self, guess: "Orbit", near: Point, row: np.ndarray) -> tuple["Orbit", "Shot", Root]:
        """The orbit next to a guess where the function vanishes."""
        assert near.root is not None
        plane, slope, tracked = near.root.plane, near.root.slope, near.root.tracked
        a, b = plane.rows @ row
        across = plane.direction(np.array([-b, a]))
        if across.course @ near.root.across.course < 0:
            across = across.times(-1)
        conditions = np.vstack([row, across.row])
        step, value = np.inf, np.nan
        for _ in range(TUNING.secant_steps):
            before, moved = value, step
            orbit, shot = self._solved(guess, near, conditions)
            value, tracked = self.test.value(Candidate(self.problem, orbit, shot, plane, tracked))
            if TUNING.secant_noise < abs(moved) < np.inf:
                slope = (value - before) / moved
            if slope == 0:
                break
            step = -value / slope
            if abs(step) <= TUNING.secant_step or (abs(step) < TUNING.secant_noise and abs(step) > 0.3 * abs(moved)):
                new = plane_at(self.problem, orbit, shot, self.weights(orbit), plane)
                return orbit, shot, Root(new, across, slope, abs(step), tracked)
            if not abs(step) < TUNING.farthest:
                break
            guess = self.problem.moved(orbit, shot, step * across.change)
        raise LostError("the secant method found no point of the curve")

    def slope(self, orbit: "Orbit", shot: "Shot", plane: Plane, part: np.ndarray, tracked: float) -> float:
        """Central difference of the function along a direction of the plane with these components."""
        values, direction = [], plane.direction(part)
        near = Point(orbit, shot, plane.weights, direction, orbit)
        for sign in (1, -1):
            guess = self.problem.moved(orbit, shot, sign * TUNING.difference * direction.change)
            beside = self._solved(guess, near, plane.duals)
            values.append(self.test.value(Candidate(self.problem, *beside, plane, tracked))[0])
        return (values[0] - values[1]) / (2 * TUNING.difference)

    def turns_between(self, one: Point, other: Point) -> bool:
        return False

    def followed(self, point: Point) -> tuple["Orbit", "Shot"] | None:
        if not self.margin:
            return point.orbit, point.shot
        if isinstance(self.test, Landing) and not self.test.holds(self.problem, point.orbit):
            return None
        assert point.root is not None
        plane = point.root.plane
        across = point.root.across.change
        away = -np.sign(point.root.slope) * self.margin / np.linalg.norm(plane.weights * across) * across
        shot = self.problem.shoot(point.orbit, False, point.section)
        guess = self.problem.moved(point.orbit, shot, away)
        try:
            return self._solved(guess, point, plane.duals)
        except LostError:
            return None

    def aligned(self, point: Point, points: list[Point]) -> Point:
        last, course = points[-1], points[-1].tangent.course
        assert point.root is not None
        if point.arclength - last.arclength > TUNING.apart:
            nodes = points[1 - TUNING.predictor_points :]
            shares = shares_of(np.array([*(p.arclength for p in nodes), point.arclength]), point.arclength, 1)
            course = shares @ np.array([self.apart(last.orbit, p.orbit, last.weights) for p in (*nodes, point)])
        plane = point.root.plane
        return self._turned_with(replace(point, tangent=plane.direction(plane.part(course))), last)

    def cosine(self, one: Point, other: Point) -> float:
        assert one.root is not None
        return float(one.root.plane.part(one.tangent.course) @ one.root.plane.part(other.tangent.course))


def shares_of(nodes: np.ndarray, place: float, derivative: int) -> np.ndarray:
    """Weights of nodal values in their interpolating polynomial at a place, or in one of its derivatives there."""
    scale = float(np.ptp(nodes))
    powers = np.vander((nodes - place) / scale, increasing=True).T
    return np.linalg.solve(powers, np.eye(len(nodes))[derivative]) / scale**derivative

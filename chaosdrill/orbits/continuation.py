"""Pseudo-arclength continuation of orbits, as long as their sequence of events does not change.

A branch of orbits over one parameter and a curve of special points over two are followed alike: the next point is
predicted by the polynomial through the last ones and corrected at a right angle to the curve; steps are adapted to the
error of the prediction (H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in
Applications of Bifurcation Theory, Academic Press 1977, 359-384). Along a curve of special points a test function
vanishes as well. Every trial lies on the surface of orbits, by Newton's method; across the curve the function's root is
found by the secant method.
"""

from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine import shooting as at
from chaosdrill.orbits.find import admissible
from chaosdrill.orbits.problem import CONVERGED, LostError
from chaosdrill.orbits.settings import SETTINGS

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot
    from chaosdrill.orbits.special import TestFunction


class Whole:
    """What a difference counts in all points of an orbit: all starts, when they are, durations, parameters.

    One start may hardly move, as the image of a turning point does not: seen from there alone a branch turns back in a
    hairpin. The mean square over the segments is taken, so that the length of an orbit does not count, nor which of its
    segments is the first.

    Parameters
    ----------
    weights : ndarray, shape (columns,)
        As from `Problem.weights`.
    """

    def __init__(self, problem: "Problem", weights: np.ndarray) -> None:
        self.states, self.forced, q = problem.states, problem.forced, len(problem.free)
        self.count = len(weights) - self.states - 1 - q
        share = 1 / np.sqrt(self.count)
        self.starts, self.times = share * weights[: self.states], share * weights[self.states]
        self.rest, self.values = weights[self.states + 1 :], weights[len(weights) - q :]

    def apart(self, one: "Orbit", other: "Orbit") -> np.ndarray:
        """The weighted difference of two orbits of the same segments."""
        d, durations = self.states, other.durations - one.durations
        starts = other.starts - one.starts
        times = self._times(other.phase - one.phase, durations)
        rest = np.concatenate([durations, starts[0, d:]])
        return np.concatenate([(starts[:, :d] * self.starts).ravel(), times, self.rest * rest])

    def direction(self, shot: "Shot", change: np.ndarray) -> "Direction":
        """The direction of a change of the reduced unknowns, of length 1 in all points, to first order.

        A start that a deviation of the first one reaches so much enlarged that it is known to round-off only counts
        less.
        """
        d, count = self.states, self.count
        seen = shot.sensitivity[:, :d, :-1]
        if count == 1:
            factors = self.starts[np.newaxis]
        else:
            growth = np.abs(seen[:, :, :d] * self.starts[:, np.newaxis] / self.starts).max(axis=(1, 2))
            factors = self.starts / (1 + (growth / SETTINGS.fast_growth) ** 2)[:, np.newaxis]
        moved = factors * (seen @ change)
        times = self._times(float(change[d]), change[d + 1 : d + 1 + count])
        course = np.concatenate([moved.ravel(), times, self.rest * change[d + 1 :]])
        length = float(np.sqrt(course @ course))
        row = np.zeros(len(change))
        row[d + 1 :] = self.rest**2 * change[d + 1 :]
        row += (factors * moved).ravel() @ seen.reshape(count * d, len(row))
        if self.forced:
            later = self.times * times[::-1].cumsum()[::-1]
            row[d] += later[0]
            row[d + 1 : d + count] += later[1:]
        return Direction(change / length, course / length, row / length)

    def _times(self, phase: float, durations: np.ndarray) -> np.ndarray:
        if not self.forced:
            return np.zeros(0)
        return self.times * (phase + np.concatenate([[0.0], durations[:-1].cumsum()]))


@dataclass(frozen=True)
class Direction:
    """A direction along which orbits change, of length 1 in all their points."""

    change: np.ndarray  # (columns,): of the reduced unknowns
    course: np.ndarray  # in all points, as from `Whole.apart`
    row: np.ndarray  # (columns,): changes at a right angle to the direction have no product with it

    def times(self, sign: float) -> "Direction":
        """This direction, or the opposite one."""
        return Direction(sign * self.change, sign * self.course, sign * self.row)


@dataclass(frozen=True)
class Plane:
    """Tangent plane of the orbits of one sequence of events over two parameters."""

    rows: np.ndarray  # (2, columns): two directions, of length 1 and at right angles in the norm of `Whole`
    courses: np.ndarray  # those of the rows, as in `Direction`
    duals: np.ndarray  # (2, columns): rows as in `Direction`
    weights: np.ndarray  # (columns,): as from `Problem.weights`

    @property
    def twist(self) -> float:
        """Area of the plane's unit square, projected onto the parameters; zero where the surface folds."""
        return float(np.linalg.det(self.courses[:, -2:]))

    def part(self, course: np.ndarray) -> np.ndarray:
        """Components of a change along the rows, shape (2,)."""
        return self.courses @ course

    def direction(self, part: np.ndarray) -> Direction:
        """The unit direction with these components."""
        unit = part / np.linalg.norm(part)
        return Direction(unit @ self.rows, unit @ self.courses, unit @ self.duals)


def plane_at(
    problem: "Problem", orbit: "Orbit", shot: "Shot", weights: np.ndarray, reference: Plane | None = None
) -> Plane:
    """Tangent plane at an orbit: the null space of its linearised equations.

    Parameters
    ----------
    problem : Problem
        Of two free parameters.
    weights : ndarray, shape (columns,)
    reference : Plane, optional
        Neighbouring plane whose rows these resemble as much as they can, so that they turn with the surface.

    Raises
    ------
    LostError
    """
    if not np.isfinite(shot.equations).all():
        raise LostError("the equations have no derivatives there")
    rows = problem.null_space(orbit, shot, weights, 2) / weights
    whole = Whole(problem, weights)
    both = [whole.direction(shot, row) for row in rows]
    courses, mixed = np.linalg.qr(np.array([one.course for one in both]).T)
    turn = np.linalg.inv(mixed.T)
    if reference is not None:
        # orthogonal Procrustes problem, Schoenemann 1966, doi:10.1007/BF02289451
        u, _, v = np.linalg.svd(reference.courses @ courses)
        turn = u @ v @ turn
    rows, courses, duals = (turn @ np.array([getattr(o, n) for o in both]) for n in ("change", "course", "row"))
    return Plane(rows, courses, duals, weights)


@dataclass(frozen=True)
class Root:
    """The root of a test function at a point of its curve."""

    plane: Plane
    across: Direction  # perpendicular to the curve, within the plane
    slope: float  # derivative of the function across
    error: float  # distance from the curve, across it
    tracked: float  # what the function goes by there, as `TestFunction` has it


@dataclass(frozen=True)
class Point:
    """A point of a curve."""

    orbit: "Orbit"
    shot: "Shot"  # without derivatives
    weights: np.ndarray
    """(columns,): what differences count here: states may grow by much along a curve, as over a resonance."""
    tangent: Direction  # along the curve
    section: "Orbit"
    """What defines the plane on which an orbit without events and without a period begins, as for `Problem.shoot`."""
    arclength: float = 0.0
    special: Special = Special.REGULAR  # what happens there
    root: Root | None = None  # on a curve of special points

    def turned(self) -> "Point":
        """The same point, to be followed in the opposite direction."""
        return replace(self, tangent=self.tangent.times(-1), arclength=-self.arclength)


@dataclass(frozen=True)
class Border:
    """Where the sequence of events changes: the last orbit before, its shot, and the first orbit beyond.

    ``bad`` is None where there is no orbit beyond; ``error`` is the distance between the two in the first parameter.
    """

    good: "Orbit"
    shot: "Shot"
    bad: "Orbit | None"
    bad_shot: "Shot | None"
    error: float


class Curve:
    """A branch of orbits over one parameter, and the equations for its points.

    Parameters
    ----------
    limits : ndarray, shape (q, 2)
        Smallest and largest value of each free parameter.
    """

    noun = "branch"
    kind = Special.REGULAR
    margin = 0.0

    def __init__(self, problem: "Problem", limits: np.ndarray) -> None:
        self.problem: Problem = problem
        self.limits = limits
        self.spans = np.ptp(limits, axis=1)
        self._known: tuple[np.ndarray, Whole] | None = None

    def unlimited(self) -> "Curve":
        """The same curve without limits."""
        other = copy(self)
        other.limits = np.tile([-np.inf, np.inf], (len(self.limits), 1))
        return other

    def weights(self, orbit: "Orbit") -> np.ndarray:
        """Weights of differences between reduced unknowns."""
        return self.problem.weights(orbit, self.spans)

    def values(self, orbit: "Orbit") -> np.ndarray:
        """The free parameters, shape (q,)."""
        return orbit.starts[0, self.problem.states :]

    def outside(self, orbit: "Orbit") -> bool:
        """Whether a parameter is beyond its limits."""
        value = self.values(orbit)
        return bool(((value < self.limits[:, 0]) | (value > self.limits[:, 1])).any())

    def apart(self, one: "Orbit", other: "Orbit", weights: np.ndarray) -> np.ndarray:
        """The weighted difference of two orbits in all their points."""
        return self.whole(weights).apart(one, other)

    def whole(self, weights: np.ndarray) -> Whole:
        """What differences count, by these weights."""
        if self._known is None or self._known[0] is not weights:
            self._known = weights, Whole(self.problem, weights)
        return self._known[1]

    def gap(self, one: "Orbit", other: "Orbit", weights: np.ndarray) -> float:
        """Distance of two orbits of the same segments, in the norm of `Whole`."""
        difference = self.apart(one, other, weights)
        return float(np.sqrt(difference @ difference))

    def met(self, one: "Orbit", other: "Orbit", weights: np.ndarray, within: float) -> "Orbit | None":
        """An orbit written from the segment at which another one begins, if they are that near; else None."""
        if len(one) != len(other) or one.periods != other.periods:
            return None
        if np.abs((self.values(one) - self.values(other)) / self.spans).max() > within:
            return None
        period = self.problem.period_at(one)
        nearest = None
        apart = np.abs((one.starts - other.starts[0])[:, : self.problem.states] * self.whole(weights).starts).max(
            axis=1
        )
        for first in np.flatnonzero(apart <= within).tolist():
            if not np.array_equal(np.roll(one.segments, -first, axis=0), other.segments):
                continue
            turned = one.rotated(first, None)
            if period:
                turned = replace(turned, phase=turned.phase + period * round((other.phase - turned.phase) / period))
            gap = self.gap(other, turned, weights)
            if gap <= within:
                nearest, within = turned, gap
        return nearest

    def directed(self, shot: "Shot", change: np.ndarray, weights: np.ndarray) -> Direction:
        """The direction of a change of the reduced unknowns."""
        return self.whole(weights).direction(shot, change)

    def first(self, orbit: "Orbit", shot: "Shot", ahead: np.ndarray | None = None) -> Point:
        """A converged orbit as the first point of a curve, to be followed towards ``ahead``.

        By default the parameter grows.
        """
        weights = self.weights(orbit)
        # in all points the error of ``ahead`` may count, which grows along an orbit
        row = None if ahead is None else ahead * weights**2
        tangent = self.directed(shot, self.problem.direction(orbit, shot, weights, row), weights)
        return Point(orbit, shot.bare(), weights, tangent, orbit)

    def correct(self, guess: "Orbit", near: Point, row: np.ndarray) -> Point:
        """The point of the curve nearest to a guess.

        Parameters
        ----------
        near : Point
            The nearest known point.
        row : ndarray, shape (columns,)
            Corrections are orthogonal to it.

        Raises
        ------
        LostError
        """
        orbit, shot = self._solved(guess, near, row[np.newaxis])
        weights = self.weights(orbit)
        change = self.problem.direction(orbit, shot, weights, near.tangent.row)
        return Point(orbit, shot.bare(), weights, self.directed(shot, change, weights), near.section)

    def _solved(self, guess: "Orbit", near: Point, conditions: np.ndarray) -> tuple["Orbit", "Shot"]:
        code, orbit, shot, _ = self.problem.newton(
            guess, conditions, SETTINGS.farthest, weights=near.weights, section=near.section
        )
        if code != CONVERGED or not np.isfinite(shot.equations).all():
            raise LostError("no orbit beside the curve")
        return orbit, shot

    def followed(self, point: Point) -> tuple["Orbit", "Shot"] | None:
        """An admissible orbit at a point, or next to it where orbits are admissible only up to the curve."""
        return point.orbit, point.shot

    def size(self, orbit: "Orbit") -> float:
        """Size of the first parameter at an orbit; its range where it passes zero."""
        return max(abs(float(self.values(orbit)[0])), float(self.spans[0]))

    def blocked(self, point: Point) -> tuple["Orbit", "Shot"] | None:
        """The orbit at or beside a point if it is not admissible; None if it is."""
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
        shares = _shares(np.array([p.arclength for p in points]), last.arclength + h, 0)
        starts = np.tensordot(shares, np.array([p.orbit.starts for p in points]), 1)
        # the parameters of all segments are one set of numbers
        starts[1:, self.problem.states :] = starts[0, self.problem.states :]
        durations = shares @ np.array([p.orbit.durations for p in points])
        phase = float(shares @ np.array([p.orbit.phase for p in points]))
        return self.problem.kept(
            replace(last.orbit, starts=starts, phase=phase, durations=durations), last.orbit, h * last.tangent.change
        )

    def after(self, points: list[Point], h: float) -> tuple[Point, float]:
        """The next point, one step along the curve, and the error of its prediction.

        ``points`` are those through which the predictor goes.

        Raises
        ------
        LostError
            The smooth continuation has no such point.
        """
        last = points[-1]
        predicted = self.predicted(points, h)
        point = self.correct(predicted, last, last.tangent.row)
        error = self.gap(predicted, point.orbit, last.weights)
        if not error < SETTINGS.farthest:
            raise LostError("the orbit is far from where it was predicted")
        length = self.gap(last.orbit, point.orbit, last.weights)
        point = self.aligned(replace(point, arclength=last.arclength + length), points)
        if not self.cosine(last, point) > SETTINGS.bend:
            raise LostError("the curve bends too much")
        return point, error

    def aligned(self, point: Point, points: list[Point]) -> Point:
        """A point with its tangent aligned to those of earlier points."""
        return point

    def cosine(self, one: Point, other: Point) -> float:
        """Cosine of the angle between the tangents at two points."""
        return float(one.tangent.course @ other.tangent.course)

    def between(self, one: Point, other: Point, part: float, row: np.ndarray | None = None) -> Point:
        """The point of the curve next to the line between two points, orthogonal to ``row`` or to the first tangent.

        Raises
        ------
        LostError
        """
        point = self.correct(one.orbit.between(other.orbit, part), one, one.tangent.row if row is None else row)
        done, left = (self.gap(point.orbit, end.orbit, one.weights) for end in (one, other))
        share = done / (done + left) if done > 0 else 0.0
        return replace(point, arclength=one.arclength + share * (other.arclength - one.arclength))

    def at_limit(self, last: Point, beyond: Point) -> Point | None:
        """The point at the first limit passed between two points; None if the last point lies on it.

        Raises
        ------
        LostError
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
        if not self.gap(guess, point.orbit, last.weights) < SETTINGS.farthest:
            raise LostError("the orbit at the limit is far from where it was predicted")
        return replace(point, arclength=last.arclength + self.gap(last.orbit, point.orbit, last.weights))

    def bisect(self, last: Point, beyond: Point) -> tuple[Point, Border]:
        """Bisect between an admissible point and one that is not: the last point before the border, and the border.

        The former is ``last`` itself if nothing lies between.
        """
        good, bad, part = last, self.blocked(beyond), 1.0
        row = last.tangent.row
        for _ in range(SETTINGS.bisections):
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
        orbit, shot = self.followed(good) or (good.orbit, good.shot)
        error = part * abs(float(self.values(beyond.orbit)[0] - self.values(good.orbit)[0]))
        error += self.problem.accuracy * self.size(orbit) + self.margin * self.spans[0]
        bad_orbit, bad_shot = bad or (None, None)
        return good, Border(orbit, shot, bad_orbit, bad_shot, float(error))


class SpecialCurve(Curve):
    """A curve over two parameters along which a test function vanishes.

    Parameters
    ----------
    problem : Problem
        Of two free parameters.
    limits : ndarray, shape (2, 2)
    test : TestFunction
        The function.
    """

    noun = "curve"

    def __init__(self, problem: "Problem", limits: np.ndarray, test: "TestFunction") -> None:
        super().__init__(problem, limits)
        self.test, self.kind, self.margin = test, test.kind, test.margin

    def begin(self, orbit: "Orbit", shot: "Shot", tracked: float) -> Point:
        """The point of the curve next to an orbit, with the second parameter as it is there.

        Raises
        ------
        LostError
        """
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
        for _ in range(SETTINGS.secant_steps):
            before, moved = value, step
            orbit, shot = self._solved(guess, near, conditions)
            value, tracked = self.test.value(self.problem, orbit, shot, plane, tracked)
            if SETTINGS.secant_noise < abs(moved) < np.inf:
                slope = (value - before) / moved
            if slope == 0:
                break
            step = -value / slope
            if abs(step) <= SETTINGS.secant_step or (
                abs(step) < SETTINGS.secant_noise and abs(step) > 0.3 * abs(moved)
            ):
                new = plane_at(self.problem, orbit, shot, self.weights(orbit), plane)
                return orbit, shot, Root(new, across, slope, abs(step), tracked)
            if not abs(step) < SETTINGS.farthest:
                break
            guess = self.problem.moved(orbit, shot, step * across.change)
        raise LostError("the secant method found no point of the curve")

    def slope(self, orbit: "Orbit", shot: "Shot", plane: Plane, part: np.ndarray, tracked: float) -> float:
        """Central difference of the function along a direction of the plane with these components."""
        values, direction = [], plane.direction(part)
        near = Point(orbit, shot, plane.weights, direction, orbit)
        for sign in (1, -1):
            guess = self.problem.moved(orbit, shot, sign * SETTINGS.difference * direction.change)
            beside = self._solved(guess, near, plane.duals)
            values.append(self.test.value(self.problem, *beside, plane, tracked)[0])
        return (values[0] - values[1]) / (2 * SETTINGS.difference)

    def followed(self, point: Point) -> tuple["Orbit", "Shot"] | None:
        if not self.margin:
            return point.orbit, point.shot
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
        if point.arclength - last.arclength > SETTINGS.apart:
            nodes = points[1 - SETTINGS.predictor_points :]
            shares = _shares(np.array([*(p.arclength for p in nodes), point.arclength]), point.arclength, 1)
            course = shares @ np.array([self.apart(last.orbit, p.orbit, last.weights) for p in (*nodes, point)])
        plane = point.root.plane
        return self._turned_with(replace(point, tangent=plane.direction(plane.part(course))), last)

    def cosine(self, one: Point, other: Point) -> float:
        assert one.root is not None
        return float(one.root.plane.part(one.tangent.course) @ one.root.plane.part(other.tangent.course))


@dataclass(frozen=True)
class Birth:
    """Where a branch was born: doublings lie close together beside it, so that steps may grow with the distance."""

    value: float  # of the first parameter
    before: float  # distance of the doubling before, beyond which the branch's own doubling lies behind
    widest: float  # longest step far from it, as a part of the ranges

    def longest(self, curve: Curve, orbit: "Orbit", step: float) -> float:
        """Longest step from an orbit, at least ``step``."""
        away = abs(float(curve.values(orbit)[0]) - self.value)
        steps = SETTINGS.steps_between_doublings if away < self.before else SETTINGS.steps_beyond_doublings
        return max(step, min(self.widest, away / float(curve.spans[0]) / steps))


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


@dataclass
class Continued:
    """Points of a curve with one sequence of events, in one direction, and how they end."""

    points: list[Point]
    end: BranchEnd = BranchEnd.MOST_POINTS
    border: Border | None = None  # where the events change, if that is the end; the last point is the last one before
    lost: bool = False  # whether the curve was lost: no further point was found


def continue_curve(
    curve: Curve,
    first: Point,
    step: float,
    most: int,
    first_step: float | None = None,
    home: Point | None = None,
    birth: Birth | None = None,
) -> Continued:
    """Follow a curve from a point in the direction of its tangent, as long as the events do not change.

    Parameters
    ----------
    step : float
        Longest step, in the norm of the weights: a part of the ranges.
    most : int
        Largest number of points.
    first_step : float, optional
        Default: a fraction of the longest.
    home : Point, optional
        Start of the curve, which is closed if it returns there. Default: the first point.
    birth : Birth, optional
        Where the branch was born, far from which its steps may be longer.
    """
    points, home, anchor = [first], home or first, 0
    halves = Halves(curve.problem.halves_apart(first.orbit, first.weights))
    found = Continued(points)
    h = SETTINGS.first_step * step if first_step is None else first_step
    while len(points) < most:
        if first.orbit.segments[0, at.SEGMENT_END] == at.PLANE and len(points) - anchor > SETTINGS.section_points:
            anchor = len(points) - 1
            points[-1] = _on_own_section(curve, points[-1])
        last = points[-1]
        try:
            point, error = curve.after(points[max(anchor, len(points) - SETTINGS.predictor_points) :], h)
            limit = curve.at_limit(last, point) if curve.outside(point.orbit) else point
        except LostError:
            h *= 0.5
            if h < SETTINGS.shortest_step * step:
                found.end, found.border, found.lost = BranchEnd.NO_CONVERGENCE, _lost(curve, points, step), True
                return found
            continue
        if limit is None:
            found.end = BranchEnd.LIMIT
            return found
        if curve.blocked(limit) is not None:
            good, border = curve.bisect(last, limit)
            points += [good] if good is not last else []
            if border.bad is None:
                border = replace(border, error=border.error + _left(points, step) * float(curve.spans[0]))
            found.end, found.border = BranchEnd.NO_CONVERGENCE, border
            return found
        points.append(limit)
        end = _closed(curve, last, limit, home)
        if end is not None:
            points[-1] = end
            found.end = BranchEnd.CLOSED
            return found
        if limit is not point:
            found.end = BranchEnd.LIMIT
            return found
        if _through_rest(curve, points):
            points.pop()
            found.end = BranchEnd.REST
            return found
        back = halves.traded_places(curve.problem.halves_apart(point.orbit, first.weights))
        if back is not None:
            beyond = points[back]
            del points[back:]
            if curve.kind != Special.REGULAR:
                points += _to_half(curve, points, beyond)
            found.end = BranchEnd.DOUBLING
            return found
        growth = (
            (SETTINGS.prediction_error / error) ** (1.0 / min(len(points) - anchor, SETTINGS.predictor_points))
            if error > 0
            else 2.0
        )
        longest = step if birth is None else birth.longest(curve, point.orbit, step)
        h = min(h * min(max(growth, 0.3), 2.0), longest)
    return found


def _on_own_section(curve: Curve, point: Point) -> Point:
    """The point with the plane across the flow at its own start, and the tangent that it has there."""
    shot = curve.problem.shoot(point.orbit, False)
    if point.root is None:
        return replace(
            point,
            tangent=curve.directed(
                shot, curve.problem.direction(point.orbit, shot, point.weights, point.tangent.row), point.weights
            ),
            section=point.orbit,
        )
    plane = plane_at(curve.problem, point.orbit, shot, point.weights, point.root.plane)
    return replace(
        point,
        tangent=plane.direction(plane.part(point.tangent.course)),
        section=point.orbit,
        root=replace(point.root, plane=plane, across=plane.direction(plane.part(point.root.across.course))),
    )


def _closed(curve: Curve, before: Point, last: Point, home: Point) -> Point | None:
    """The point between two neighbours at which the curve is back at its start, if it is."""
    step = last.arclength - before.arclength
    start = curve.met(home.orbit, last.orbit, last.weights, 2 * step)
    if start is None:
        return None

    def along(point: Point) -> float:
        return float(curve.apart(point.orbit, start, before.weights) @ before.tangent.course)

    low, high = along(before), along(last)
    # the start itself, the first time
    if low <= SETTINGS.meeting * step or high > 0:
        return None
    part = low / (low - high)
    try:
        for _ in range(SETTINGS.touch_steps):
            point = curve.between(before, last, part)
            left = along(point)
            if abs(left) <= SETTINGS.meeting * step:
                break
            part += left / (low - high)
    except LostError:
        return None
    away = curve.gap(point.orbit, start, before.weights)
    return point if away <= max(SETTINGS.meeting, 2 * SETTINGS.meeting * step) else None


def _through_rest(curve: Curve, points: list[Point]) -> bool:
    """Whether the orbits have shrunk onto an equilibrium just before the last point.

    Beyond, the same orbits come again, half a turn later: the curve seems to turn back.
    """
    orbit = points[-1].orbit
    if orbit.segments[0, at.SEGMENT_END] != at.PLANE or len(points) < 2:
        return False
    if not points[-1].tangent.change[-1] * points[-2].tangent.change[-1] < 0:
        return False
    orbits = [p.orbit for p in (points[max(len(points) - 1 - SETTINGS.shrunk_points, 0)], *points[-2:])]
    ends = np.array([o.durations.sum() for o in orbits])[:, np.newaxis]
    states = curve.problem.at(orbits, ends * np.linspace(0, 1, 33)[:-1])[0]
    extents = (np.ptp(states, axis=1) / curve.problem.sizes).max(axis=1)
    return bool(extents[1:].min() < SETTINGS.shrunk * extents[0])


def _to_half(curve: Curve, points: list[Point], beyond: Point) -> list[Point]:
    """The last point before the halves of doubled orbits coincide; beyond it the same orbits repeat."""
    last, good = points[-1], None
    start = curve.problem.halves_apart(last.orbit, last.weights)
    low, high = 0.0, 1.0
    while high - low > SETTINGS.tangent_error:
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


def _lost(curve: Curve, points: list[Point], step: float) -> Border:
    """No further point was found at the smallest step."""
    last = points[-1]
    return Border(last.orbit, last.shot, None, None, _left(points, step) * float(curve.spans[0]))


def _left(points: list[Point], step: float) -> float:
    """How far beyond the last point the slowest event would lose its speed; at least the smallest step."""
    left = SETTINGS.shortest_step * step
    if len(points) > 1:
        before, last = points[-2:]
        slowest = int(last.shot.speeds.argmin())
        speed, earlier = float(last.shot.speeds[slowest]), float(before.shot.speeds[slowest])
        if speed < earlier < np.inf:
            left = max(left, (last.arclength - before.arclength) * speed / (earlier - speed))
    return left


def _shares(nodes: np.ndarray, place: float, derivative: int) -> np.ndarray:
    """Weights of nodal values in their interpolating polynomial at a place, or in one of its derivatives there."""
    scale = float(np.ptp(nodes))
    powers = np.vander((nodes - place) / scale, increasing=True).T
    return np.linalg.solve(powers, np.eye(len(nodes))[derivative]) / scale**derivative

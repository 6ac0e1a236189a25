"""Points of a curve of orbits, the directions in which it goes on there, and what differences of orbits count."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


class Whole:
    """What a difference counts in all points of an orbit: all starts, when they are, durations, parameters.

    One start may hardly move, as the image of a turning point does not: seen from there alone a branch turns back in a
    hairpin. The mean square over the segments is taken, so that the length of an orbit does not count, nor which of its
    segments is the first.

    ``weights``, shape (columns,): as from `Problem.weights`.
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
            factors = self.starts / (1 + (growth / TUNING.fast_growth) ** 2)[:, np.newaxis]
        moved = factors * (seen @ change)
        times = self._times(float(change[d]), change[d + 1 : d + 1 + count])
        course = np.concatenate([moved.ravel(), times, self.rest * change[d + 1 :]])
        length = float(np.sqrt(course @ course))
        row = np.zeros(len(change))
        row[d + 1 :] = self.rest * (self.rest * change[d + 1 :])
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

    ``problem``: of two free parameters. ``weights``, shape (columns,). ``reference``: neighbouring plane whose rows
    these resemble as much as they can, so that they turn with the surface.

    Raises `LostError`.
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
class Candidate:
    """An orbit that may be on a curve, as its test function tells, with what is known of an orbit near by."""

    problem: "Problem"
    orbit: "Orbit"
    shot: "Shot"
    plane: Plane  # of the orbit near by
    tracked: float  # what the function goes by there, as `TestFunction` has it


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

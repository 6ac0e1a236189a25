"""Special points: test functions that vanish at them, along a branch and along a curve over two parameters.

A sign change between two points is followed by Brent's method along the line between them, each trial being corrected
onto the branch by Newton's method, so that a root is as exact as the multipliers are.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

import numpy as np
from scipy.optimize import brentq

from chaosdrill.dataset.branches import Special
from chaosdrill.engine import shooting as at
from chaosdrill.engine.setup import constrained_states
from chaosdrill.orbits.continuation import Border, Plane, plane_at
from chaosdrill.orbits.event_changes import Touch, distance, left_out, nearest_touch, slowest_event
from chaosdrill.orbits.find import least_period
from chaosdrill.orbits.guess import eventless
from chaosdrill.orbits.multipliers import based, free_multipliers, multipliers
from chaosdrill.orbits.problem import CONVERGED, LostError
from chaosdrill.orbits.settings import SETTINGS

if TYPE_CHECKING:
    from chaosdrill.orbits.branches import BranchSegment
    from chaosdrill.orbits.continuation import Curve, Point
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


def doubling_test(problem: "Problem", orbit: "Orbit", monodromy: np.ndarray) -> np.ndarray:
    """Function that vanishes where a multiplier is -1: the determinant of M + 1 in the free states."""
    free = np.flatnonzero(constrained_states(problem.plain)[orbit.segments[0, at.SEGMENT_MODE]] == 0)
    return np.linalg.det(monodromy[..., free[:, np.newaxis], free] + np.eye(len(free)))


def torus_test(values: np.ndarray) -> np.ndarray:
    """Function that vanishes where the product of two multipliers is 1: the product of 1 - mu_i mu_j over pairs."""
    m = values.shape[-1]
    first, second = np.triu_indices(m, 1)
    return np.prod(1 - values[..., first] * values[..., second], axis=-1).real


def fold_test(values: np.ndarray) -> np.ndarray:
    """Function that vanishes where a free multiplier is 1: the product of 1 - mu."""
    return np.prod(1 - values, axis=-1).real


def outside(values: np.ndarray) -> np.ndarray:
    """Number of multipliers outside the unit circle."""
    return np.asarray((np.abs(values) > 1).sum(axis=-1))


def pair_on_circle(values: np.ndarray) -> float:
    """Distance of the nearest complex pair from the unit circle; infinite without a pair."""
    pairs = values[np.abs(values.imag) > SETTINGS.real * np.abs(values)]
    return float(np.abs(np.abs(pairs) - 1).min(initial=np.inf))


def special_points(segment: "BranchSegment") -> list[tuple[int, Special]]:
    """Special points between neighbours: (index of the later point, kind).

    Where a multiplier passes through 1 and the branch turns back it is a fold; where it does not, another branch
    crosses. On the branches that a lost symmetry leaves the multiplier only touches 1 while the branch turns. Two
    multipliers whose product passes through 1 are a pair on the unit circle, or two real ones, which mean nothing:
    which of them, is seen where they are located. All functions are products over multipliers or over pairs of them,
    so that none is hidden by another one that stays near to the unit circle.
    """
    if len(segment) < 2:
        return []
    orbit, problem, monodromies = segment.orbit(0), segment.curve.problem, segment.monodromies
    values = free_multipliers(multipliers(problem, orbit, monodromies, segment.rank), problem.neutral.count)
    noise = noise_of(monodromies, len(orbit))
    back, through = set(changes(segment.tangents[:, -1])), set(changes(fold_test(values), noise))
    found = [(k, Special.FOLD) for k in back]
    found += [(k, Special.BRANCH_POINT) for k in through - back]
    found += [(k, Special.PERIOD_DOUBLING) for k in changes(doubling_test(problem, orbit, monodromies), noise)]
    pairs = set(changes(torus_test(values), noise))
    # of two pairs that cross within a step the product of all pairs keeps its sign
    pairs |= set((np.flatnonzero(np.abs(np.diff(outside(values))) > 3) + 1).tolist())
    found += [(k, Special.NEIMARK_SACKER) for k in pairs]
    return sorted(found)


def noise_of(monodromy: np.ndarray, segments: int) -> np.ndarray:
    """Error of the determinants of tangent maps, shape (..., d, d), around orbits with this number of segments."""
    return SETTINGS.tangent_error * segments * np.maximum(1.0, np.abs(monodromy).max(axis=(-2, -1))) ** 2


def changes(values: np.ndarray, noise: np.ndarray | float = 0.0) -> list[int]:
    """Indices of values before which the sign changes, between values above their errors, shape (m,), only."""
    sure = np.flatnonzero(np.abs(values) > noise)
    found = []
    for before, after in pairwise(sure.tolist()):
        if values[before] * values[after] < 0:
            turned = values[before + 1 : after + 1] * np.sign(values[before]) <= 0
            found.append(before + 1 + int(turned.argmax()))
    return found


def locate(pair: "BranchSegment", kind: Special) -> tuple["Point", float]:
    """A special point between two orbits of a branch, and the error of the parameter.

    What looks like a fold may turn out to be a point at which branches cross, and what looks like a pair of multipliers
    on the unit circle to be a regular point.

    Raises
    ------
    LostError
        No orbit was found on the way, or it has no such multiplier.
    """
    curve, (before, after) = pair.curve, pair.points
    problem = curve.problem
    tried: list[Point] = []

    def free(point: "Point") -> np.ndarray:
        values = multipliers(problem, point.orbit, point.shot.monodromy, pair.rank)
        return free_multipliers(values, problem.neutral.count)

    def value(part: float) -> float:
        try:
            point = curve.between(before, after, part)
        except LostError:
            # where branches cross the equations are singular, and on a straight branch exactly so
            orbit = before.orbit.between(after.orbit, part)
            shot = problem.shoot(orbit)
            if kind != Special.BRANCH_POINT or not shot.residual < SETTINGS.straight:
                raise
            length = before.arclength + part * (after.arclength - before.arclength)
            point = replace(before, orbit=orbit, shot=shot.bare(), arclength=length)
        tried.append(point)
        if kind == Special.FOLD:
            return float(point.tangent.change[-1])
        if kind == Special.PERIOD_DOUBLING:
            return float(doubling_test(problem, point.orbit, point.shot.monodromy))
        return float((fold_test if kind == Special.BRANCH_POINT else torus_test)(free(point)))

    low, high = value(0.0), value(1.0)
    if low * high > 0:
        raise LostError("the function has one sign at both ends")
    there = value(brentq(value, 0.0, 1.0, xtol=1e-15, rtol=1e-15))
    point = tried[-1]
    if abs(there) > SETTINGS.jump * max(abs(low), abs(high)) or _misses(free(point), kind):
        raise LostError("the function jumps")
    if kind == Special.NEIMARK_SACKER and pair_on_circle(free(point)) > SETTINGS.missed_multiplier:
        return point, 0.0
    if kind == Special.FOLD and _crossed(curve, before, point, after):
        kind = Special.BRANCH_POINT
    scale, size = problem.accuracy, curve.size(point.orbit)
    slope = abs(high - low) / max(abs(float(curve.values(after.orbit)[-1] - curve.values(before.orbit)[-1])), 1e-300)
    if kind == Special.BRANCH_POINT:
        # the equations vanish there to third order across, so that the orbit is known to the root of its residual only
        error = 3 * scale ** (2 / 3) * size
    elif kind == Special.FOLD:
        error = scale * size
    else:
        error = (
            float(noise_of(point.shot.monodromy, len(point.orbit))) * scale / SETTINGS.tangent_error / slope
            + scale * size
        )
    return replace(point, special=kind), float(error)


def _misses(values: np.ndarray, kind: Special) -> bool:
    """Whether no multiplier has its critical value."""
    if kind == Special.NEIMARK_SACKER:
        first, second = np.triu_indices(len(values), 1)
        return bool(np.abs(values[first] * values[second] - 1).min(initial=np.inf) > SETTINGS.missed_multiplier)
    return bool(
        np.abs(values - (-1 if kind == Special.PERIOD_DOUBLING else 1)).min(initial=np.inf) > SETTINGS.missed_multiplier
    )


def _crossed(curve: "Curve", before: "Point", there: "Point", after: "Point") -> bool:
    """Whether the equations lose rank at an orbit, unlike at its neighbours."""
    problem, weights = curve.problem, before.weights
    smallest = [problem.regularity(p.orbit, problem.shoot(p.orbit, False), weights) for p in (before, there, after)]
    return smallest[1] < SETTINGS.singular * min(smallest[0], smallest[2])


class TestFunction(Protocol):
    """A function that vanishes along the curve.

    Attributes
    ----------
    margin : float
        0, or the distance from the curve, in the norm of the weights, at which it is seen whether the system follows
        the orbits: where it does so only up to the curve itself, and only where the function is negative.
    """

    kind: Special
    margin: float

    def value(
        self, problem: "Problem", orbit: "Orbit", shot: "Shot", plane: Plane, instant: float
    ) -> tuple[float, float]:
        """The function, and the instant on the orbit to which it belongs; ``plane`` and ``instant`` are of an orbit
        near by."""


@dataclass(frozen=True)
class Doubling:
    """A multiplier is -1."""

    kind = Special.PERIOD_DOUBLING
    margin = 0.0

    def value(
        self, problem: "Problem", orbit: "Orbit", shot: "Shot", plane: Plane, instant: float
    ) -> tuple[float, float]:
        return float(doubling_test(problem, orbit, shot.monodromy)), instant


@dataclass(frozen=True)
class Fold:
    """The surface of orbits folds over the parameters, whichever of them moves: nothing is special at a cusp."""

    kind = Special.FOLD
    margin = 0.0

    def value(
        self, problem: "Problem", orbit: "Orbit", shot: "Shot", plane: Plane, instant: float
    ) -> tuple[float, float]:
        return plane_at(problem, orbit, shot, plane.weights, plane).twist, instant


@dataclass(frozen=True)
class Touching:
    """The maximum of a guard within a segment is zero."""

    touch: Touch
    kind = Special.GRAZING
    margin = 1e-8

    def value(
        self, problem: "Problem", orbit: "Orbit", shot: "Shot", plane: Plane, instant: float
    ) -> tuple[float, float]:
        return self.touch.greatest(problem, orbit, instant)


@dataclass(frozen=True)
class Vanishing:
    """An event has no speed, where no path without it is an orbit: its reset moves the state however slow it is met."""

    event: int
    kind = Special.GRAZING
    # a guard met with the speed v is above zero by no more than v^2 later
    margin = 1e-6

    def value(
        self, problem: "Problem", orbit: "Orbit", shot: "Shot", plane: Plane, instant: float
    ) -> tuple[float, float]:
        return -float(shot.speeds[self.event]), instant


def test_function_at(
    problem: "Problem", orbit: "Orbit", shot: "Shot", kind: Special, weights: np.ndarray
) -> tuple[TestFunction, "Orbit", "Shot", float]:
    """What vanishes at a special point: (test, orbit to begin with, its shot, instant).

    At grazing the orbit without the event that appears or vanishes is taken, since its multipliers are finite.

    Raises
    ------
    LostError
        The orbit touches no guard.
    """
    if kind == Special.PERIOD_DOUBLING:
        return Doubling(), orbit, shot, 0.0
    if kind == Special.FOLD:
        return Fold(), orbit, shot, 0.0
    slowest = slowest_event(problem, orbit, shot)
    found = nearest_touch(problem, orbit)
    if found is not None and slowest is None:
        return Touching(found[0]), orbit, shot, found[1]
    for guess in _without_event(problem, orbit, shot):
        code, other, _, _ = problem.newton(based(problem, guess))
        if code == CONVERGED and distance(problem, other, orbit, weights) < SETTINGS.same_path:
            # a doubled orbit whose halves graze one after the other is one of half the period at their common border
            other, _ = least_period(problem, other)
            touched = nearest_touch(problem, other)
            if touched is not None and slowest_event(problem, other, problem.shoot(other)) is None:
                return Touching(touched[0]), other, problem.shoot(other), touched[1]
    if found is not None:
        return Touching(found[0]), orbit, shot, found[1]
    if slowest is None:
        raise LostError("no guard is touched there, and no event has zero speed")
    return Vanishing(slowest), orbit, shot, 0.0


def _without_event(problem: "Problem", orbit: "Orbit", shot: "Shot") -> Iterator["Orbit"]:
    """The path without events that may have no effect."""
    yield from left_out(problem, Border(orbit, shot, None, None, 0.0))
    modes = set(orbit.segments[:, at.SEGMENT_MODE].tolist())
    if problem.forced and len(modes) == 1:
        period = problem.period_at(orbit)
        assert period is not None
        states, _ = problem.strobes([orbit])
        name = problem.plain.mode_names[modes.pop()]
        yield eventless(problem, states[0, 0], name, orbit.periods, orbit.starts[0, problem.states :], period)

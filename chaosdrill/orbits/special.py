"""Special points in two parameters: test functions that vanish along their curves."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.orbits.crossings import doubling_test, is_paired
from chaosdrill.orbits.curve import TestFunction
from chaosdrill.orbits.event_changes import distance, left_out, without_events
from chaosdrill.orbits.find import least_period
from chaosdrill.orbits.guards_met import Touch, nearest_touch, slowest_event
from chaosdrill.orbits.multipliers import all_multipliers, based, free_multipliers, pair_near
from chaosdrill.orbits.points import Border, Candidate, plane_at
from chaosdrill.orbits.problem import CONVERGED, LostError
from chaosdrill.orbits.sliding import LANDING, landings, uncrossed, unswitched
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


@dataclass(frozen=True)
class Doubling:
    """A multiplier is -1."""

    kind = Special.PERIOD_DOUBLING
    margin = 0.0

    def value(self, candidate: Candidate) -> tuple[float, float]:
        return float(doubling_test(candidate.problem, candidate.orbit, candidate.shot.monodromy)), candidate.tracked


@dataclass(frozen=True)
class Fold:
    """The surface of orbits folds over the parameters, whichever of them moves: nothing is special at a cusp."""

    kind = Special.FOLD
    margin = 0.0

    def value(self, candidate: Candidate) -> tuple[float, float]:
        near = candidate.plane
        plane = plane_at(candidate.problem, candidate.orbit, candidate.shot, near.weights, near)
        return plane.twist, candidate.tracked


@dataclass(frozen=True)
class Circling:
    """A pair of multipliers has the product 1; half its sum, the cosine of the angle of a complex one, tells which.

    Sum and product of the pair are smooth where its two meet, at 1 and -1: there the pair leaves the circle along the
    curve, and goes on as a multiplier and its inverse, which is no bifurcation.
    """

    kind = Special.NEIMARK_SACKER
    margin = 0.0

    def value(self, candidate: Candidate) -> tuple[float, float]:
        values = all_multipliers(candidate.problem, candidate.orbit, candidate.shot)
        half, product, _ = pair_near(values, candidate.problem.neutral.count, candidate.tracked)
        return product - 1, half


@dataclass(frozen=True)
class Touching:
    """The maximum of a guard within a segment is zero."""

    touch: Touch
    kind = Special.GRAZING
    margin = 1e-8

    def value(self, candidate: Candidate) -> tuple[float, float]:
        return self.touch.greatest(candidate.problem, candidate.orbit, candidate.tracked)


@dataclass(frozen=True)
class Vanishing:
    """An event has no speed, where no path without it is an orbit: its reset moves the state however slow it is met."""

    event: int
    kind = Special.GRAZING
    # a guard met with the speed v is above zero by no more than v^2 later
    margin = 1e-6

    def value(self, candidate: Candidate) -> tuple[float, float]:
        return -float(candidate.shot.speeds[self.event]), candidate.tracked


def test_function_at(
    problem: "Problem", orbit: "Orbit", shot: "Shot", kind: Special, weights: np.ndarray
) -> tuple[TestFunction, "Orbit", "Shot", float]:
    """What vanishes at a special point: (test, orbit to begin with, its shot, what it goes by).

    At grazing the orbit without the event that appears or vanishes is taken, since its multipliers are finite; where a
    stay on a surface begins, that without it.

    Raises `LostError` if the orbit touches no guard.
    """
    if kind == Special.PERIOD_DOUBLING:
        return Doubling(), orbit, shot, 0.0
    if kind == Special.FOLD:
        return Fold(), orbit, shot, 0.0
    if kind == Special.NEIMARK_SACKER:
        free = free_multipliers(all_multipliers(problem, orbit, shot), problem.neutral.count)
        pairs = free[is_paired(free)]
        if not len(pairs):
            raise LostError("no pair of multipliers is complex there")
        return Circling(), orbit, shot, float(pairs[np.abs(np.abs(pairs) - 1).argmin()].real)
    if kind in LANDING:
        for guess in (uncrossed if kind == Special.CROSSING_SLIDING else unswitched)(problem, orbit):
            code, other, seen, _ = problem.newton(based(problem, guess))
            if code == CONVERGED and distance(problem, other, orbit, weights) < TUNING.same_path:
                orbit, shot = other, seen
        landed = landings(problem, orbit, kind)
        if not landed:
            raise LostError("no event reaches the end of the part of the surface that slides")
        return landed[0][1], orbit, shot, 0.0
    slowest = slowest_event(problem, orbit, shot)
    found = nearest_touch(problem, orbit)
    if found is not None and slowest is None:
        return Touching(found[0]), orbit, shot, found[1]
    for guess in _without_event(problem, orbit, shot):
        code, other, _, _ = problem.newton(based(problem, guess))
        if code == CONVERGED and distance(problem, other, orbit, weights) < TUNING.same_path:
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
    yield from without_events(problem, orbit)

"""Branch switching: onto doubled orbits, and onto the curve behind a change of the event sequence."""

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from chaosdrill.orbits.curve import Curve, SpecialCurve
from chaosdrill.orbits.event_changes import Change, branch_behind, change_at, distance
from chaosdrill.orbits.guards_met import slowest_event, touches
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.points import Border, Point
from chaosdrill.orbits.problem import CONVERGED, LostError, Problem, Shot, admissible
from chaosdrill.orbits.sliding import Landing, landings
from chaosdrill.orbits.special import TestFunction, Touching, Vanishing
from chaosdrill.orbits.tuning import TUNING


def doubled(curve: Curve, orbit: Orbit, scale: float, most: float) -> Iterator[tuple[Orbit, Shot, np.ndarray, float]]:
    """Orbits of twice the period near a period doubling: the orbit, its shot, the direction and distance to it.

    Of the two null vectors of the equations of the orbit gone through twice one is the direction of the old branch; the
    new branch starts across it. ``scale`` is a part by which distances are shortened, high up in a cascade; the
    parameter changes by ``most`` at most, so that no further doubling is jumped over.
    """
    problem = curve.problem
    d = problem.states
    twice = orbit.repeated(2)
    shot = problem.shoot(twice, watched=False)
    weights = curve.weights(twice)
    plane = problem.null_space(twice, shot, weights, 2)
    old = problem.direction(orbit, problem.shoot(orbit, watched=False), curve.weights(orbit))
    times = np.tile(old[d + 1 : -1], 2) if len(twice) > len(orbit) else 2 * old[d + 1 : -1]
    old = weights * np.concatenate([old[: d + 1], times, old[-1:]])
    inside = plane @ old
    direction = np.array([-inside[1], inside[0]]) @ plane / np.linalg.norm(inside) / weights
    for first in TUNING.doubling_distances:
        length = scale * first
        for _ in range(TUNING.doubling_shorter):
            code, found, seen, _ = problem.beside(twice, shot, direction, length, weights)
            if code != CONVERGED or not admissible(found, seen):
                break
            gap = np.abs(problem.halves_apart(found, weights)).max()
            if gap <= TUNING.doubling_apart * length:
                break
            change = float(np.abs(found.starts[0, d:] - orbit.starts[0, d:]).max())
            if change <= most:
                yield found, seen, direction, length
                break
            # the parameter changes with the square of the distance
            length *= 0.9 * np.sqrt(most / change)


def crossing(
    curve: Curve, before: Orbit, orbit: Orbit, after: Orbit, most: float
) -> Iterator[tuple[Orbit, Shot, np.ndarray]]:
    """Orbits of the branch that crosses another one, on either side: the orbit, its shot, and the direction there.

    Of the two null vectors of the equations one is the direction of the known branch, on which ``before`` and ``after``
    are neighbours of the crossing; the other branch leaves across it. Where a symmetry is lost the two sides are the
    two partners. The parameter changes by ``most`` at most.
    """
    problem, d = curve.problem, curve.problem.states
    shot = problem.shoot(orbit, watched=False)
    weights = curve.weights(orbit)
    plane = problem.nearly_null(orbit, shot, weights)
    inside = plane @ (weights * (after.reduced(d) - before.reduced(d)))
    across = np.array([-inside[1], inside[0]]) @ plane / weights
    across /= np.linalg.norm(across * weights)
    for sign in (1.0, -1.0):
        for length in TUNING.doubling_distances:
            code, found, seen, _ = problem.beside(orbit, shot, across, sign * length, weights)
            if code != CONVERGED or not admissible(found, seen):
                continue
            away = (found.reduced(d) - orbit.reduced(d)) * weights
            if sign * away @ (across * weights) < 0.5 * length or abs(away[-1]) * float(curve.spans[0]) > most:
                continue
            yield found, seen, sign * across
            break


def crossings(
    curve: Curve, before: Orbit, orbit: Orbit, after: Orbit, count: int, most: float
) -> Iterator[tuple[Orbit, Shot, np.ndarray]]:
    """Orbits of all branches that cross another one where several multipliers, ``count``, are 1: as `crossing` has it.

    In the space of the null vectors each branch has a direction, of which the equations at the point tell nothing: with
    a symmetry their second order vanishes as well. Newton's method leads to it from another direction, a little beside
    the point, where the equations are regular: from those between axes, and then those between branches.
    """
    problem, d = curve.problem, curve.problem.states
    shot = problem.shoot(orbit, watched=False)
    weights = curve.weights(orbit)
    null = problem.nearly_null(orbit, shot, weights, count + 1)
    along = null @ (weights * (after.reduced(d) - before.reduced(d)))
    frame = np.linalg.svd(along[np.newaxis])[2]
    signs = [np.array(one) for one in product((0.0, 1.0, -1.0), repeat=count + 1) if any(one[1:])]
    signs = [one for one in sorted(signs, key=np.count_nonzero) if np.count_nonzero(one) <= TUNING.most_axes]
    known, ways = [frame[0], -frame[0]], deque(one @ frame for one in signs)
    for _ in range(TUNING.most_ways):
        if not ways:
            break
        way = ways.popleft()
        way = way / np.linalg.norm(way)
        for length in TUNING.doubling_distances:
            code, found, seen, _ = problem.beside(orbit, shot, way @ null / weights, length, weights)
            if code != CONVERGED or not admissible(found, seen):
                continue
            away = null @ (weights * (found.reduced(d) - orbit.reduced(d)))
            gone = float(np.linalg.norm(away))
            changed = abs(float(curve.values(found)[0] - curve.values(orbit)[0]))
            if not length * TUNING.branch_near < gone < length / TUNING.branch_near or changed > most:
                continue
            ahead = away / gone
            if max(one @ ahead for one in known) < TUNING.branch_apart:
                ways.extend(one + ahead for one in known if one @ ahead > -TUNING.branch_apart)
                known.append(ahead)
                yield found, seen, ahead @ null / weights
            break


def curve_behind(curve: SpecialCurve, last: Point, border: Border) -> tuple[SpecialCurve, Point, Change] | None:
    """The curve that goes on behind a border: (the curve, its first point with the way ahead, the change).

    With the second parameter held, the branch behind the border is the one that
    `chaosdrill.orbits.event_changes.branch_behind` finds. A special point of the same kind is looked for next to it, a
    little away from the border, where the new events have some speed. Where the tangent map jumps, as for the
    multipliers of orbits that begin to graze, no such point is near, and the curve ends.
    """
    if isinstance(curve.test, Vanishing):
        return None
    problem = curve.problem
    second = float(curve.values(border.good)[1])
    plain = problem.plain.with_parameters(**{problem.free[1]: second})
    one = Curve(problem.alike(plain, problem.free[:1]), curve.limits[:1])
    good, bad = _flat(border.good), None if border.bad is None else _flat(border.bad)
    flat = Border(good, one.problem.shoot(good), bad, None if bad is None else one.problem.shoot(bad), border.error)
    found = branch_behind(one, flat)
    if found is None:
        return None
    moved = one.problem.moved(found.orbit, found.shot, TUNING.ahead * found.ahead)
    code, orbit, _, _ = one.problem.newton(
        moved, (found.ahead * one.weights(moved) * one.weights(moved))[np.newaxis], TUNING.reach_beside
    )
    if code != CONVERGED:
        return None
    for shift in TUNING.shifts:
        try:
            behind, point = _beside(curve, lifted(orbit, second), second + shift * float(curve.spans[1]))
        except LostError:
            continue
        change = (behind.values(point.orbit) - curve.values(last.orbit)) / curve.spans
        gap = max(float(np.linalg.norm(change)), distance(problem, point.orbit, last.orbit, point.weights))
        if (
            gap < TUNING.joined
            and behind.blocked(point) is None
            and slowest_event(problem, point.orbit, point.shot) is None
        ):
            ahead = float(np.sign(change @ (point.tangent.change[-2:] / curve.spans)))
            first = replace(point, tangent=point.tangent.times(ahead), arclength=last.arclength + gap)
            return behind, first, change_at(one.problem, flat, found.orbit)
    return None


def _beside(curve: SpecialCurve, orbit: Orbit, second: float) -> tuple[SpecialCurve, Point]:
    """The point of the same kind at a value of the second parameter, next to an orbit with other events."""
    values = curve.values(orbit).copy()
    values[1] = second
    code, orbit, shot, _ = curve.problem.newton(orbit.with_values(values, curve.problem.states))
    if code != CONVERGED:
        raise LostError("no orbit beside the border")
    test, tracked = _same_test(curve.problem, orbit, curve.test)
    behind = SpecialCurve(curve.problem, curve.limits, test)
    return behind, behind.begin(orbit, shot, tracked)


def lifted(orbit: Orbit, value: float) -> Orbit:
    """The orbit with one more free parameter."""
    return replace(orbit, starts=np.column_stack([orbit.starts, np.full(len(orbit), value)]))


def _flat(orbit: Orbit) -> Orbit:
    """The same orbit without the last free parameter."""
    return replace(orbit, starts=np.ascontiguousarray(orbit.starts[:, :-1]))


def _same_test(problem: Problem, orbit: Orbit, test: TestFunction) -> tuple[TestFunction, float]:
    """The test of the same kind on an orbit next to a border, and what it goes by there."""
    if isinstance(test, Landing):
        landed = landings(problem, orbit, test.kind)
        if not landed:
            raise LostError("no event reaches the end of the part of the surface that slides")
        return landed[0][1], 0.0
    if not isinstance(test, Touching):
        return test, 0.0
    _, touch, tracked = min(touches(problem, orbit), key=lambda one: one[0], default=(0.0, None, 0.0))
    if touch is None:
        raise LostError("no guard has a greatest value within a segment")
    return Touching(touch), tracked

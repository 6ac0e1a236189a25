"""Pseudo-arclength continuation of orbits, as long as their sequence of events does not change.

Steps are adapted to the error of the prediction (H. B. Keller, "Numerical solution of bifurcation and nonlinear
eigenvalue problems", in Applications of Bifurcation Theory, Academic Press 1977, 359-384).
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine import shooting as at
from chaosdrill.orbits.crossings import TESTS
from chaosdrill.orbits.curve import Curve
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.points import Border, Point, plane_at
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.rests import collapsed, rounds, shrinks
from chaosdrill.orbits.tuning import TUNING


@dataclass(frozen=True)
class Birth:
    """Where a branch was born: doublings lie close together beside it, so that steps may grow with the way from it.

    The way is that along the curve: states move as the root of the parameter there, and the parameter may return.
    """

    arclength: float  # of its first point
    widest: float  # longest step far from it, as a part of the ranges

    def longest(self, point: Point, step: float) -> float:
        """Longest step from a point, at least ``step``."""
        return max(step, min(self.widest, (point.arclength - self.arclength) / TUNING.steps_beyond_doublings))


@dataclass
class Continued:
    """Points of a curve with one sequence of events, in one direction, and how they end.

    Where a test function of the branch ends it, the last point lies beyond its root.
    """

    points: list[Point]
    end: BranchEnd = BranchEnd.MOST_POINTS
    border: Border | None = None  # where the events change, if that is the end; the last point is the last one before
    lost: bool = False  # whether the curve was lost: no further point was found
    upright: int = 0  # the first points, at one value of the parameter: how it changes among them is round-off
    family: bool = False  # whether these are all of them
    beyond: Point | None = None  # of a curve that ends at a limit, the next point


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

    ``step``: longest step, in the norm of the weights: a part of the ranges. ``most``: largest number of points.
    ``first_step``: default: a fraction of the longest. ``home``: start of the curve, which is closed if it returns
    there. Default: the first point. ``birth``: where the branch was born, far from which its steps may be longer.
    """
    home = home or first
    whole = family(curve, first, step, most, first_step, home)
    if whole is not None:
        return whole
    found = _followed(curve, first, step, most, first_step, home, birth)
    return replace(found, upright=_upright(curve, found.points)) if _is_upright(curve, first) else found


def family(
    curve: Curve, first: Point, step: float, most: int, first_step: float | None = None, home: Point | None = None
) -> Continued | None:
    """The curve from a point on, as `continue_curve`, if all its points are at one value of the parameter."""
    if not _is_upright(curve, first) or not _stands(curve, first):
        return None
    long = Birth(first.arclength, TUNING.family_step)
    found = _followed(curve, first, step, most, first_step, home or first, long)
    count = _upright(curve, found.points)
    return replace(found, upright=count, family=True) if count == len(found.points) else None


def _is_upright(curve: Curve, first: Point) -> bool:
    return curve.kind == Special.REGULAR and abs(first.tangent.change[-1]) <= TUNING.upright * float(curve.spans[0])


def _followed(
    curve: Curve, first: Point, step: float, most: int, first_step: float | None, home: Point, birth: Birth | None
) -> Continued:
    """The curve from a point on, whether or not the parameter changes."""
    points, anchor = [first], 0
    watches = [
        (test.end, test.watch(curve, first)) for test in TESTS if test.end is not None and test.watch is not None
    ]
    planar, turned = first.orbit.segments[0, at.SEGMENT_END] == at.PLANE, False
    h = TUNING.first_step * step if first_step is None else first_step
    while len(points) < most:
        if planar and (len(points) - anchor > TUNING.section_points or turned):
            if curve.kind == Special.REGULAR and shrinks(curve, points[anchor], points[-1], 2 * step):
                return Continued(points, BranchEnd.REST)
            anchor, turned = len(points) - 1, False
            points[-1] = _on_own_section(curve, points[-1])
        last, recent = points[-1], points[max(anchor, len(points) - TUNING.predictor_points) :]
        try:
            point, error = curve.after(recent, h)
            limit = curve.at_limit(last, point) if curve.outside(point.orbit) else point
            if any(watch.left(point) for _, watch in watches):
                raise LostError("the orbit is one of half the period")
        except LostError:
            h *= 0.5
            if len(recent) > 1 and h < TUNING.straight_on * (last.arclength - recent[-2].arclength):
                sharp = next((k for k in range(len(recent) - 1) if curve.turns_between(*recent[k : k + 2])), None)
                if sharp is not None:
                    before = points[: len(points) - len(recent) + sharp]
                    way = TUNING.again * (recent[sharp + 1].arclength - recent[sharp].arclength)
                    rest = _followed(curve, recent[sharp], step, most - len(before), way, home, birth)
                    return replace(rest, points=before + rest.points)
                # the polynomial through the last points may lead elsewhere than their tangents
                anchor = len(points) - 1
            if h < TUNING.shortest_step * step:
                return Continued(points, BranchEnd.NO_CONVERGENCE, _lost(curve, points, step), lost=True)
            continue
        if limit is None:
            return Continued(points, BranchEnd.LIMIT)
        if curve.blocked(limit) is not None:
            if len(points) == 1 and h > TUNING.shortest_first * step:
                # the way to the next change of events may be shorter than any step yet
                h *= 0.25
                continue
            return _up_to_change(curve, points, limit, step, home)
        points.append(limit)
        end = _closed(curve, [*recent, limit], home)
        if end is not None:
            return Continued([*points[:-1], end], BranchEnd.CLOSED)
        if curve.kind == Special.REGULAR and collapsed(curve, points, home):
            return Continued(points, BranchEnd.REST)
        if limit is not point:
            return Continued(points, BranchEnd.LIMIT, beyond=point)
        if _through_rest(curve, points):
            return Continued(points[:-1], BranchEnd.REST)
        if planar and curve.kind == Special.REGULAR and anchor < len(points) - 2 and _turns(points):
            # it may be the plane that an orbit leaves
            points.pop()
            turned = True
            continue
        for ending, watch in watches:
            beyond = watch.passed(point)
            if beyond is not None:
                return Continued(points[: beyond + 1], ending)
        longest = step if birth is None else birth.longest(point, step)
        h = min(_next_step(h, error, len(points) - anchor), longest)
    return Continued(points)


def _next_step(h: float, error: float, count: int) -> float:
    """The length of the next step, after one of length h whose prediction from ``count`` points was off by an error."""
    if not error > 0:
        return 2.0 * h
    growth = (TUNING.prediction_error / error) ** (1.0 / min(count, TUNING.predictor_points))
    return h * min(max(growth, 0.3), 2.0)


def _up_to_change(curve: Curve, points: list[Point], beyond: Point, step: float, home: Point) -> Continued:
    """The curve up to where its events change, before a point that lies beyond."""
    good, border = curve.bisect(points[-1], beyond)
    within = beyond.arclength - good.arclength
    points += [good] if good is not points[-1] else []
    if curve.kind == Special.REGULAR and collapsed(curve, points, home):
        return Continued(points, BranchEnd.REST)
    if border.bad is None:
        border = replace(border, error=border.error + _left(curve, points, step, within))
    return Continued(points, BranchEnd.NO_CONVERGENCE, border)


def _stands(curve: Curve, first: Point) -> bool:
    """Whether the parameter stays the same at first, as behind a doubling of a map that is linear in parts."""
    for way in TUNING.family_ways:
        with suppress(LostError):
            # the first orbit may be known less exactly, as beside a point where branches cross
            near, far = (curve.values(curve.after([first], part * way)[0].orbit)[0] for part in (0.5, 1.0))
            return abs(float(far - near)) <= _same(curve, first)
    return False


def _upright(curve: Curve, points: list[Point]) -> int:
    """How many of the first points are at one value of the parameter, which a flat branch leaves in the end."""
    values = np.array([curve.values(p.orbit)[0] for p in points])
    left = np.abs(values - values[:2][-1]) > _same(curve, points[0])
    if not left[1:].any():
        return len(points)
    count = 1 + int(left[1:].argmax())
    return 0 if count == 2 and left[0] else count


def _same(curve: Curve, first: Point) -> float:
    """How far apart equal values of the parameter may be."""
    return curve.problem.accuracy * curve.size(first.orbit)


def _on_own_section(curve: Curve, point: Point) -> Point:
    """The point with the plane across the flow at its own start, and the tangent that it has there.

    On the plane before the start may have slid along the orbit much further than the orbits change: that part of the
    tangent goes, so that it leads on, not back.
    """
    problem, shot = curve.problem, curve.problem.shoot(point.orbit, False)
    if point.root is None:
        d, flow, ahead = problem.states, problem.flow_at(point.orbit), point.tangent.change.copy()
        normal = problem.plane(point.orbit)[at.NORMAL]
        ahead[:d] -= flow * (normal @ ahead[:d]) / (normal @ flow)
        direction = problem.direction(point.orbit, shot, point.weights, ahead * point.weights * point.weights)
        return replace(point, tangent=curve.directed(shot, direction, point.weights), section=point.orbit)
    plane = plane_at(problem, point.orbit, shot, point.weights, point.root.plane)
    return replace(
        point,
        tangent=plane.direction(plane.part(point.tangent.course)),
        section=point.orbit,
        root=replace(point.root, plane=plane, across=plane.direction(plane.part(point.root.across.course))),
    )


def _closed(curve: Curve, points: list[Point], home: Point) -> Point | None:
    """The point between the last two at which the curve is back at its start, if it is."""
    before, last = points[-2:]
    if before.orbit is home.orbit:
        return None
    step = last.arclength - before.arclength

    def ahead(point: Point) -> tuple[Orbit | None, float]:
        """The start, begun beside the point, and how far ahead of it along the curve it is."""
        start = curve.met(home.orbit, point.orbit, last.weights, 2 * step)
        if start is None:
            return None, np.nan
        return start, float(curve.apart(point.orbit, start, before.weights) @ before.tangent.course)

    high = ahead(last)[1]
    if not high <= 0:
        return None
    low = ahead(before)[1]
    if not low > TUNING.meeting * step:
        return None
    part, places = low / (low - high), np.array([p.arclength for p in points])
    # what a line between two orbits misses a turn of a smooth flow may enlarge beyond return
    planar = last.orbit.segments[0, at.SEGMENT_END] == at.PLANE
    try:
        for _ in range(TUNING.touch_steps):
            there = before.arclength + part * step
            guess = curve.interpolated([p.orbit for p in points], places, there, last.orbit) if planar else None
            point = curve.between(before, last, part, guess=guess)
            start, left = ahead(point)
            if start is None or abs(left) <= TUNING.meeting * step:
                break
            part += left / (low - high)
    except LostError:
        return None
    away = np.inf if start is None else curve.gap(point.orbit, start, before.weights)
    return point if away <= max(TUNING.meeting, 2 * TUNING.meeting * step) else None


def _turns(points: list[Point]) -> bool:
    """Whether the parameter turns back between the last two points."""
    return bool(points[-1].tangent.change[-1] * points[-2].tangent.change[-1] < 0)


def _through_rest(curve: Curve, points: list[Point]) -> bool:
    """Whether the orbits have shrunk onto an equilibrium just before the last point.

    Beyond, the same orbits come again, half a turn later: the curve seems to turn back.
    """
    orbit = points[-1].orbit
    if orbit.segments[0, at.SEGMENT_END] != at.PLANE or len(points) < 2:
        return False
    if not _turns(points):
        return False
    states = rounds(curve, points[-2:])
    # where the amplitude goes through zero the start comes to the other side of the middle
    before, beyond = (states[:, 0] - states.mean(axis=1)) / curve.problem.sizes
    return bool(before @ beyond < 0)


def _lost(curve: Curve, points: list[Point], step: float) -> Border:
    """No further point was found at the smallest step."""
    last = points[-1]
    left = _left(curve, points, step)
    if len(points) > 1:
        left = max(left, curve.stay_left(points[-2], last))
    return Border(last.orbit, last.shot, None, None, left)


def _left(curve: Curve, points: list[Point], step: float, within: float = np.inf) -> float:
    """How far beyond the last point, in the first parameter, an event that is nearly tangential would lose its speed.

    That is at least the smallest step, and at most the way along the curve ``within`` which it is known to end.
    """
    left, place = TUNING.shortest_step * step, -len(curve.spans)
    if len(points) > 1:
        before, last = points[-2:]
        slow = last.shot.speeds / curve.problem.paces(last.orbit)
        slowest = int(slow.argmin())
        speed, earlier = float(last.shot.speeds[slowest]), float(before.shot.speeds[slowest])
        if slow[slowest] <= TUNING.tangential and speed < earlier:
            left = max(left, (last.arclength - before.arclength) * speed / (earlier - speed))
    # where the curve turns it changes more slowly
    rate = max(abs(float(point.tangent.change[place])) for point in points[-2:])
    return min(left, within) * rate

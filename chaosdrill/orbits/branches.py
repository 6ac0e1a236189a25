"""Branches of orbits over one parameter, traced in both directions from a start and onto doubled orbits."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Criticality, Special
from chaosdrill.engine import shooting as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.setup import bounds_of
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.branch import Branch, BranchSegment, Mark
from chaosdrill.orbits.conserved import other_family
from chaosdrill.orbits.continuation import Birth, Continued, continue_curve, family
from chaosdrill.orbits.crossings import TESTS, Located, ended, noise_of
from chaosdrill.orbits.curve import Curve, SpecialCurve
from chaosdrill.orbits.event_changes import branch_behind, change_at
from chaosdrill.orbits.find import NoOrbitError, starting_orbit
from chaosdrill.orbits.function_points import mark_functions
from chaosdrill.orbits.grazing import grazing_form
from chaosdrill.orbits.guards_met import slowness
from chaosdrill.orbits.halves import halves_met, way_to_doubling
from chaosdrill.orbits.marks import NO_COLUMNS, Columns
from chaosdrill.orbits.multipliers import free_multipliers, is_stable, largest_growth, multipliers, structural_rank
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.points import Border, Point
from chaosdrill.orbits.problem import CONVERGED, LostError, Problem, Shot, admissible
from chaosdrill.orbits.rests import point_behind, rest_behind
from chaosdrill.orbits.results import NO_GRAZING, BranchResult, Cascade
from chaosdrill.orbits.roots import bracketed
from chaosdrill.orbits.sliding import TOUCHING, Landing, sliding_between, sliding_beyond
from chaosdrill.orbits.special_points import marked, marked_at_limit
from chaosdrill.orbits.switching import crossing, crossings, curve_behind, doubled
from chaosdrill.orbits.table import branch_table, cascade_from, nothing
from chaosdrill.orbits.tuning import TUNING

ENDS = {
    Special.GRAZING: BranchEnd.GRAZING,
    Special.EVENT_SWAP: BranchEnd.EVENT_SWAP,
    Special.OUTCOME_SWITCH: BranchEnd.OUTCOME_SWITCH,
}

FAMILY = "The orbits that begin there form a family at this one value of the parameter, up to an event or a bound."

NOT_FOUND = "Newton's method found no orbit beyond this value: it may end there, or be undefined."

PILED = (
    "changes of events pile up there, nearer to each other than orbits can be distinguished, as on the way to complete "
    "chatter; the branch ends"
)


def met(curve: Curve, first: Point, known: Sequence[BranchSegment], step: float) -> bool:
    """Whether the curve at a point is that of a known segment, one end of which is less than a step away.

    Of two ways to a border one may end, and the other begin, a little beside it: the smooth curve is compared in the
    plane that goes through that end.
    """
    weights = curve.weights(first.orbit)
    for end in (p.orbit for s in known if len(s) for p in (s.points[0], s.points[-1])):
        there = curve.met(end, first.orbit, weights, step)
        if there is None:
            continue
        if curve.gap(first.orbit, there, weights) <= TUNING.meeting:
            return True
        way = float(curve.apart(first.orbit, there, weights) @ first.tangent.course)
        if way < -TUNING.begins:
            # it comes from there, through changes of events that change little
            continue
        with suppress(LostError):
            beside = curve.correct(curve.predicted([first], way), first, first.tangent.row)
            if curve.gap(beside.orbit, there, weights) <= TUNING.meeting:
                return True
    return False


def trace_branch(
    curve: Curve,
    first: Point,
    step: float,
    most: int,
    known: Sequence[BranchSegment] = (),
    others: Sequence[BranchSegment] = (),
    birth: Birth | None = None,
) -> Branch:
    """Follow a curve in one direction from one of its points until it ends.

    ``first``: with the way to go as its tangent. ``step``: longest step, as a part of the ranges of the parameters.
    ``most``: points, at most. ``known``: what was followed before in the other direction; the curve ends where it meets
    it. ``others``: other branches, at which it ends as well. ``birth``: where the branch was born, far from which its
    steps may be longer.
    """
    branch, home, special = Branch(), first, isinstance(curve, SpecialCurve)
    if not special and curve.outside(first.orbit):
        return branch.ended(BranchEnd.NO_CONVERGENCE)
    for _ in range(TUNING.most_borders):
        room = most - len(branch)
        if room < 1:
            return branch
        part = continue_curve(curve, first, step, room, home=home, birth=birth)
        jumps = not special and _to_no_speed(curve, part)
        reached = _append(branch, curve, part, jumps)
        last = branch.segments[-1]
        if part.border is None:
            if part.end == BranchEnd.REST and not special:
                return _at_rest(branch, curve)
            words = ""
            if part.end == BranchEnd.LIMIT:
                reached_at = curve.kink_at(last.points[-1].orbit)
                words = reached_at or f"{'the' if curve.noun == 'branch' else 'a'} parameter reached its limit"
            elif reached is not None and not special:
                words = _reached_at(curve, part.end, reached.point, reached.error)
            return branch.ended(part.end, words)
        found = _behind(curve, part, last, branch)
        if not isinstance(found, tuple):
            return _ended_at(branch, curve, part, last, found)
        curve, first = found
        if last.points[-1].arclength - last.points[0].arclength <= TUNING.begins and met(
            curve, first, branch.segments[:-1], step
        ):
            # it turns back among orbits that cannot be distinguished
            branch.segments[-1] = last
            branch.marks = [mark for mark in branch.marks if mark.segment < len(branch.segments) - 1]
            return branch.ended(BranchEnd.NO_CONVERGENCE, PILED)
        if met(curve, first, [*known[-1:], *branch.segments[:1]], step):
            return branch.ended(BranchEnd.CLOSED)
        if met(curve, first, [*known[:-1], *branch.segments[1:]], step):
            # no loop comes back amid its way: a border has led back along it
            return branch.ended(BranchEnd.NO_CONVERGENCE, PILED)
        if met(curve, first, others, step):
            return branch.ended(BranchEnd.JOINED)
    branch.words = f"more than {TUNING.most_borders} changes of the sequence of events"
    return branch


def _reached_at(curve: Curve, end: BranchEnd, point: Point, error: float) -> str:
    """The end of a branch in words, with its place."""
    there = float(curve.values(point.orbit)[0])
    return f"{end.advice.rstrip('.')}, {curve.problem.free[0]} = {there:.12g} (error {error:.1g})."


def _append(branch: Branch, curve: Curve, part: Continued, jumps: bool) -> Located | None:
    """Append a continued segment to a branch, and mark the special points on it; where a test function ends it.

    At its last point multipliers may jump (``jumps``).
    """
    if jumps and len(part.points) > 1:
        # what happens in the last step does so before its end
        with suppress(LostError):
            part.points.insert(-1, curve.between(part.points[-2], part.points[-1], TUNING.before_touch))
    followed, _ = curve.followed(part.points[len(part.points) // 2]) or (part.points[0].orbit, None)
    rank, end = structural_rank(curve.problem, followed), None
    segment = BranchSegment(curve, part.points, rank, part.family)
    if any(test.end == part.end for test in TESTS):
        segment, end = ended(segment, part.end)
    if not isinstance(curve, SpecialCurve):
        segment, marks = marked(segment, part.upright, len(segment) - int(end is not None or jumps))
        if part.beyond is not None and not part.upright:
            segment, marks = marked_at_limit(segment, marks, segment.with_points([part.points[-2], part.beyond]))
        branch.marks += [replace(mark, segment=len(branch.segments)) for mark in marks]
    branch.segments.append(segment)
    return end


def _to_no_speed(curve: Curve, part: Continued) -> bool:
    """Move the last point to where an event loses its speed, if it ends there, and tell whether multipliers may jump.

    A run distinguishes two events in a row from none only if the guard is passed by more than its rounding error, which
    goes with the square of the speed; in the equations of the orbit the speed goes through zero like any other number.
    """
    problem, points = curve.problem, part.points
    if part.border is None:
        return False
    last = points[-1]
    slow = slowness(problem, last.orbit, last.shot)
    event, jumps = int(slow.argmin()), bool(slow.min() <= TUNING.tangential) and not part.lost
    if not slow[event] <= TUNING.touching or len(points) < 2:
        return jumps
    before = points[-2]

    def speed(share: float) -> float:
        tried[share] = curve.between(before, beyond, share)
        return float(tried[share].shot.speeds[event])

    tried: dict[float, Point] = {}
    found = None
    with suppress(LostError):
        h = 2 * curve.gap(before.orbit, last.orbit, last.weights)
        beyond = curve.after(points[-1 - TUNING.predictor_points : -1], h)[0]
        if speed(0.0) * speed(1.0) < 0:
            found = tried[bracketed(speed, 0.0, 1.0)]
    if found is None:
        # there may be no orbit with that speed, as where the way to a guard takes ever longer
        earlier, now = (float(p.shot.speeds[event]) for p in (before, last))
        way = abs(float(curve.values(last.orbit)[-1] - curve.values(before.orbit)[-1]))
        left = way * now / (earlier - now) if now < earlier else 0.0
        part.border = replace(part.border, error=part.border.error + left)
        return jumps
    if abs(float(curve.values(found.orbit)[-1] - curve.values(last.orbit)[-1])) > part.border.error:
        points[-1] = replace(found, arclength=before.arclength + curve.gap(before.orbit, found.orbit, last.weights))
    return jumps


def _behind(curve: Curve, part: Continued, last: BranchSegment, branch: Branch) -> tuple[Curve, Point] | str:
    """The curve that continues beyond a border, and its first point; mark the border.

    Where none does, why not, or nothing if the border itself tells.
    """
    assert part.border is not None
    length, at_border = last.points[-1].arclength, last.points[-1].orbit
    if isinstance(curve, SpecialCurve):
        if _degenerate(curve, last) is not None:
            return ""
        alone = change_at(curve.problem, part.border).kind == Special.REGULAR
        further = None if halves_met(curve, last.points, alone) else curve_behind(curve, last.points[-1], part.border)
        if further is None:
            return ""
        behind, first, change = further
        _mark(branch, part.border, change.kind, f"{change.text}; the curve continues")
        return behind, first
    beyond = branch_behind(curve, part.border)
    words = "" if beyond is None else other_family(curve.problem, beyond.orbit, beyond.shot)
    if beyond is None or words:
        return words
    kind, text = change_at(curve.problem, part.border, beyond.orbit)
    if kind != Special.REGULAR:
        before = last.points[-2].orbit if len(last) > 1 else at_border
        kind = sliding_between(curve.problem, part.border.good, beyond.orbit) or kind
        coming = float(curve.values(at_border)[-1] - curve.values(before)[-1])
        way = "continues" if part.family or coming * beyond.ahead[-1] > 0 else "folds back"
        _mark(branch, part.border, kind, f"{text}; the branch {way}")
    first = curve.first(beyond.orbit, beyond.shot, beyond.ahead)
    return curve, replace(first, arclength=length)


def _mark(branch: Branch, border: Border, kind: Special, text: str) -> None:
    """Mark the last point of a branch as a border."""
    segment = branch.segments[-1]
    k = len(segment) - 1
    if not isinstance(segment.curve, SpecialCurve):
        segment = segment.with_points([*segment.points[:-1], replace(segment.points[-1], special=kind)])
        branch.segments[-1] = segment
    if kind != Special.REGULAR:
        grazing = NO_GRAZING
        if kind in TOUCHING and not isinstance(segment.curve, SpecialCurve):
            grazing = grazing_form(segment.curve.problem, border.good, border.shot, segment.curve.weights(border.good))
        branch.marks.append(Mark(len(branch.segments) - 1, k, kind, border.error, text, grazing=grazing))


def _at_rest(branch: Branch, curve: Curve) -> Branch:
    """End a branch of orbits that shrink onto an equilibrium, at what is found there."""
    last = branch.segments[-1]
    planar = last.orbit(0).segments[0, at.SEGMENT_END] == at.PLANE
    found = rest_behind(curve, last.points[-1]) if planar else point_behind(curve, last.points)
    if found is None:
        return branch.ended(BranchEnd.REST)
    if found.point is None:
        there = f"{curve.problem.free[0]} = {found.value:.12g} (error {found.error:.1g})"
        return branch.ended(BranchEnd.REST, f"{found.text}, at {there}")
    branch.segments[-1] = last.with_points([*last.points, found.point])
    place = (len(branch.segments) - 1, len(last.points))
    branch.marks.append(Mark(*place, Special.HOPF, found.error, found.text, 2, found.form))
    return branch.ended(BranchEnd.REST, found.text)


def _ended_at(branch: Branch, curve: Curve, part: Continued, last: BranchSegment, why: str) -> Branch:
    """End a branch at a border beyond which no orbit was found, or none that it goes on with, for a reason."""
    assert part.border is not None
    if part.lost and _escapes(last):
        return branch.ended(BranchEnd.ESCAPED)
    away = _degenerate(curve, last)
    if away is not None:
        words = "the tangency is of third order; the curve ends"
        border = replace(part.border, error=part.border.error + 2 * away)
        _mark(branch, border, Special.DEGENERATE_SLIDING, words)
        return branch.ended(BranchEnd.OUTCOME_SWITCH, words)
    kind, text = change_at(curve.problem, part.border)
    words = why or (f"{text}; the {curve.noun} ends" if text else _lost(last))
    if halves_met(curve, last.points, kind == Special.REGULAR) and (isinstance(curve, SpecialCurve) or not words):
        if isinstance(curve, SpecialCurve):
            return branch.ended(BranchEnd.DOUBLING)
        error = part.border.error + way_to_doubling(curve, last.points) + curve.error_at(last.points[-1])
        return branch.ended(BranchEnd.DOUBLING, _reached_at(curve, BranchEnd.DOUBLING, last.points[-1], error))
    if not words and part.lost:
        events = not curve.problem.plain.discrete and np.isfinite(last.speeds).any()
        words = _hidden(last) or ("" if events else NOT_FOUND)
    branch.ended(ENDS.get(kind, BranchEnd.NO_CONVERGENCE), words)
    kind = sliding_beyond(curve.problem, part.border) or kind if kind != Special.REGULAR else kind
    _mark(branch, part.border, kind, words)
    return branch


def _degenerate(curve: Curve, last: BranchSegment) -> float | None:
    """How far the first parameter is from where the tangency to a surface is of third order; None if that is not near.

    It is near where the rate that vanishes there would do so within a small part of a step.
    """
    test = curve.test if isinstance(curve, SpecialCurve) else None
    if not isinstance(test, Landing) or len(last) < 3:
        return None
    near, other = last.points[-1], last.points[-3]
    rate, before = (test.at(curve.problem, point.orbit)[1] for point in (near, other))
    if before == rate:
        return None
    part = rate / (rate - before)
    return abs(part * float(last.values[-1, 0] - last.values[-3, 0])) if abs(part) <= TUNING.end_of_curve else None


def _lost(segment: BranchSegment) -> str:
    """Why Newton's method could not follow a branch, if its durations show it."""
    durations = segment.durations.sum(axis=1)
    if durations[-1] > TUNING.longer * durations[0]:
        return (
            f"the duration grows without bound, to {durations[-1]:.3g}: the orbit approaches a connection of equilibria"
        )
    return ""


def _hidden(segment: BranchSegment) -> str:
    """Why the next orbit may be hidden by rounding: deviations grow on a part of the last one, though it is stable."""
    problem = segment.curve.problem
    growth = largest_growth(problem, segment.points[-1].orbit)
    if growth * TUNING.step_error < TUNING.residual:
        return ""
    where = f"deviations grow {growth:.1e}-fold on a part of the orbit, as along a canard or past a singularity"
    return f"{where}: rounding hides the next one"


def _escapes(segment: BranchSegment) -> bool:
    """Whether a state of the last orbit reaches its bounds, to within a part of the range of the orbits.

    A bound at which the first orbit is as well, as at a wall, ends no branch.
    """
    problem = segment.curve.problem
    low, high = bounds_of(problem.plain)
    first, states = (_path(problem, p.orbit) for p in (segment.points[0], segment.points[-1]))
    starts = np.vstack([p.orbit.starts[:, : problem.states] for p in segment.points])
    near = TUNING.at_bounds * np.ptp(np.vstack([states, starts]), axis=0)
    was, reached = (np.stack([one.min(axis=0) < low + near, one.max(axis=0) > high - near]) for one in (first, states))
    return bool((reached & ~was).any())


def _path(problem: Problem, orbit: Orbit) -> np.ndarray:
    """States along an orbit and at the starts of its segments."""
    times = np.linspace(0.0, float(orbit.durations.sum()), TUNING.guard_samples)
    return np.vstack([problem.at([orbit], times[np.newaxis])[0][0], orbit.starts[:, : problem.states]])


Progress = Callable[[int, int, None], None]


def branches(
    system: HybridSystem,
    parameter: str,
    limits: tuple[float, float],
    period: int,
    start: str | float,
    transient: float,
    doublings: int,
    step: float,
    max_points: int,
    numerics: Numerics,
    progress: Progress | None,
    columns: Columns = NO_COLUMNS,
) -> BranchResult:
    """The branch through an orbit, and up to ``doublings`` generations of doubled branches.

    ``limits``: smallest and largest value of the parameter. ``period``, ``start``, ``transient``: of the first orbit,
    as for `chaosdrill.orbits.find.starting_orbit`. ``doublings``: generations of doubled orbits to follow. ``step``:
    longest step of the parameter. ``max_points``: largest number of points of one branch. ``progress``: called with the
    branches done, the branches planned and None. ``columns``: further results on every orbit.

    Returns an empty result, with the reason in its outcome and message, if no orbit was found to start from.
    """
    try:
        problem, orbit, shot, _, _ = starting_orbit(system, (parameter,), period, start, transient, numerics)
    except NoOrbitError as failure:
        return nothing(system, (parameter,), failure.outcome, failure.message)
    curve = Curve(problem, np.array([limits], dtype=float))
    curve.magnify(orbit, shot)
    span = float(curve.spans[0])
    first = _beside(curve, orbit, shot, step / span)
    forward = trace_branch(curve, first, step / span, max_points)
    whole = forward
    if forward.end != BranchEnd.CLOSED:
        backward = trace_branch(curve, first.turned(), step / span, max_points, forward.segments)
        whole = forward.joined(backward) if forward.segments else backward
    if not whole.segments:
        return nothing(system, (parameter,), Outcome.NO_ORBIT, "from its first orbit no branch could be followed")
    if not whole.marks and _unmoved(whole):
        whole.ended(BranchEnd.NO_EFFECT)
    whole.start = f"an orbit of period {orbit.periods} at {parameter} = {system.parameters[parameter]:g}"
    found = [whole]
    _report(progress, found, doublings)
    generation, missing = [0], list[str]()
    if doublings:
        found += _partners(curve, whole, step, max_points)
        generation += range(1, len(found))
    _once(curve, found)
    for turn in range(doublings):
        generation = _born_of(curve, found, generation, step, max_points, turn, missing)
        _report(progress, found, doublings)
    if doublings:
        missing += _several(found)
    _tell_families(curve, found, step, max_points)
    cascade = _longest_cascade(found) if doublings else None
    if columns.wanted is not None:
        missing += [words for one in found for words in mark_functions(one, columns.wanted)]
    return branch_table(problem, (parameter,), found, cascade, columns, missing)


def _tell_families(curve: Curve, found: list[Branch], step: float, most: int) -> None:
    """Say of special points where a branch is born whose orbits are all at one value of the parameter."""
    for branch in found:
        for k, mark in enumerate(branch.marks):
            if mark.multiplicity == 1 and mark.form.criticality == Criticality.UNDECIDED:
                first = next(_born(curve, branch, mark, step), None)
                if first is not None and family(curve, first, step / float(curve.spans[0]), most) is not None:
                    branch.marks[k] = replace(mark, text=f"{mark.kind.advice} {FAMILY}")


def _born(curve: Curve, branch: Branch, mark: Mark, step: float) -> Iterator[Point]:
    """First points of the branches that are born at a special point."""
    if mark.kind == Special.PERIOD_DOUBLING:
        for orbit, shot, ahead, _ in doubled(curve, branch.orbit(mark), 1.0, step):
            yield curve.first(orbit, shot, ahead)
    elif mark.kind == Special.BRANCH_POINT:
        points, k = branch.segments[mark.segment].points, mark.point
        beside = [points[max(k - 1, 0)].orbit, points[min(k + 1, len(points) - 1)].orbit]
        places = beside[0], points[k].orbit, beside[1]
        several = mark.multiplicity > 1
        found = crossings(curve, *places, mark.multiplicity, step) if several else crossing(curve, *places, step)
        for orbit, shot, ahead in found:
            yield curve.first(orbit, shot, ahead)


def _partners(curve: Curve, whole: Branch, step: float, most: int) -> list[Branch]:
    """The branches that cross the first one at its branch points, each on either side."""
    found: list[Branch] = []
    for mark in whole.marks:
        if mark.kind != Special.BRANCH_POINT or mark.multiplicity > TUNING.most_together:
            continue
        here = whole.segments[mark.segment].points[mark.point]
        again = replace(whole, marks=[m for m in whole.marks if m is not mark])
        if _passed(curve, [again], here, mark):
            continue  # it crosses itself: both ways have been gone
        for first in _born(curve, whole, mark, step):
            if _passed(curve, found, here, mark):
                continue
            others = [s for one in (whole, *found) for s in one.segments]
            branch = trace_branch(curve, first, step / float(curve.spans[0]), most, others=others)
            if not branch.segments:
                continue
            branch.parent, branch.born = 0, whole.value(mark)
            branch.start = f"the branch point at {curve.problem.free[0]} = {branch.born:.12g}"
            found.append(branch)
    return found


def _several(found: list[Branch]) -> list[str]:
    """Where branches are born that are not followed, since several multipliers are 1 or -1 together, in words."""
    told = {
        Special.BRANCH_POINT: "1 together at {}: the branches that cross there are not followed",
        Special.PERIOD_DOUBLING: "-1 together at {}: of the doubled branches that may begin there one is looked for",
    }
    return [
        f"{mark.multiplicity} multipliers are "
        + told[mark.kind].format(f"{branch.segments[0].curve.problem.free[0]} = {branch.value(mark):.9g}")
        for number, branch in enumerate(found)
        for mark in branch.marks
        if mark.multiplicity > 1 and mark.kind in told and not _followed_from(found, number, mark)
    ]


def _followed_from(found: list[Branch], number: int, mark: Mark) -> bool:
    """Whether branches were followed from a point at which this one crosses them."""
    value = found[number].value(mark)
    return mark.kind == Special.BRANCH_POINT and any(one.parent == number and one.born == value for one in found)


def _once(curve: Curve, found: list[Branch]) -> None:
    """Keep the mark of a point where branches cross, or one crosses itself, on the first way through it only."""
    for k, branch in enumerate(found):
        places, branch.marks = [(mark, branch.segments[mark.segment].points[mark.point]) for mark in branch.marks], []
        for mark, point in places:
            (branch.again if _passed(curve, found[: k + 1], point, mark) else branch.marks).append(mark)


def _passed(curve: Curve, found: list[Branch], point: Point, mark: Mark) -> bool:
    """Whether one of these branches has come through a branch point, which is marked on another one."""
    return mark.kind == Special.BRANCH_POINT and any(
        old.kind == mark.kind
        and abs(branch.value(old) - float(curve.values(point.orbit)[0])) <= 2 * (old.error + mark.error)
        and curve.met(branch.orbit(old), point.orbit, point.weights, TUNING.meeting**0.5) is not None
        for branch in found
        for old in branch.marks
    )


def _beside(curve: Curve, orbit: Orbit, shot: Shot, step: float) -> Point:
    """The first orbit, or a neighbour if it is near a special point: the branch passes that point, or returns there.

    Near is what a small part of a step takes at least twice as far from it.
    """
    problem, d, first = curve.problem, curve.problem.states, curve.first(orbit, shot)

    def away(orbit: Orbit, shot: Shot) -> float:
        values = free_multipliers(multipliers(problem, orbit, shot.monodromy, d), problem.neutral.count)
        return float(np.minimum(np.abs(values - 1), np.abs(values + 1)).min(initial=np.inf))

    near, weights, length = away(orbit, shot), first.weights, TUNING.beside_special * step
    if near > TUNING.near_special:
        return first
    one, other = problem.nearly_null(orbit, shot, weights) / weights
    # where branches cross, a direction between them leads to one of them, one at a right angle to it does not
    for way in (first.tangent.change, one, other, (one + other) / 2**0.5, (one - other) / 2**0.5):
        code, beside, seen, _ = problem.beside(orbit, shot, way, length, weights)
        moved = (beside.reduced(d) - orbit.reduced(d)) * weights
        if code == CONVERGED and admissible(beside, seen) and moved @ (way * weights) > 0.5 * length:
            return curve.first(beside, seen, way) if away(beside, seen) > 2 * near else first
    return first


def _unmoved(branch: Branch) -> bool:
    """Whether nothing but the parameter changes along a branch, neither the orbits nor what becomes of deviations."""
    segments = [s for s in branch.segments if len(s)]
    still = all((np.abs(s.tangents[:, :-1]) <= TUNING.no_effect * np.abs(s.tangents[:, -1:])).all() for s in segments)
    return still and all(
        (np.ptp(s.monodromies, axis=0) <= np.sqrt(noise_of(s.monodromies[0], len(s.orbit(0))))).all() for s in segments
    )


def _report(progress: Progress | None, found: list[Branch], doublings: int) -> None:
    if progress is not None:
        progress(len(found), max(len(found), doublings + 1), None)


def _longest_cascade(found: list[Branch]) -> Cascade | None:
    """The longest chain of branches, each born at a doubling of the one before, with the doubling that ends it."""
    best: list[tuple[float, int]] = []
    for number, branch in enumerate(found):
        first = _to_follow(branch, True) if number else []
        chain = [(branch.value(m), branch.segments[m.segment].orbit(0).periods) for m in first]
        while branch.parent >= 0:
            born, period, branch = branch.born, branch.segments[0].orbit(0).periods, found[branch.parent]
            if branch.segments[0].orbit(0).periods == period:
                break
            chain.append((born, branch.segments[0].orbit(0).periods))
        if len(chain) > len(best):
            best = chain
    return cascade_from(*zip(*reversed(best), strict=True)) if best else None


def _to_follow(branch: Branch, first_only: bool) -> list[Mark]:
    """Period doublings at which to switch branches: those where stability is lost, else the first one."""
    marks = sorted((m for m in branch.marks if m.kind == Special.PERIOD_DOUBLING), key=lambda m: (m.segment, m.point))
    if first_only:
        return marks[:1]
    return [m for m in marks if _beside_stable(branch.segments[m.segment], m)] or marks


def _beside_stable(segment: BranchSegment, mark: Mark) -> bool:
    beside = [k for k in (mark.point - 1, mark.point + 1) if 0 <= k < len(segment)]
    return bool(is_stable(segment.spectra.values[beside], segment.curve.problem.neutral.count).any())


def _reached(found: list[Branch], parent: int, mark: Mark, step: float) -> bool:
    """Whether a doubled branch followed from elsewhere has arrived at this doubling."""
    here = found[parent].value(mark)
    doubled = (b for b in found if b.parent == parent and b.end == BranchEnd.DOUBLING)
    return any(abs(float(b.segments[-1].values[-1, 0]) - here) < step for b in doubled)


def _born_of(
    curve: Curve, found: list[Branch], parents: list[int], step: float, most: int, turn: int, missing: list[str]
) -> list[int]:
    """Follow the branches that are born at doublings of some, and return their numbers; ``missing`` tells of others."""
    following, parameter = list[int](), curve.problem.free[0]
    for parent in parents:
        for mark in _to_follow(found[parent], first_only=turn > 0):
            if _reached(found, parent, mark, step):
                continue
            branch = _doubled_branch(curve, found, parent, mark, step, most, turn)
            born = found[parent].value(mark)
            if branch is not None:
                branch.start = f"the period doubling at {parameter} = {branch.born:.12g}"
                found.append(branch)
                following.append(len(found) - 1)
            elif born not in curve.limits:  # there the doubled orbits may be beyond
                missing.append(f"no doubled orbit was found next to the period doubling at {parameter} = {born:.9g}")
    return following


def _doubled_branch(
    curve: Curve, found: list[Branch], parent: int, mark: Mark, step: float, most: int, turn: int
) -> Branch | None:
    born, longest = found[parent].value(mark), step
    if turn > 0:
        longest = min(step, abs(born - found[parent].born) / TUNING.steps_between_doublings)
    others, span = [s for one in found for s in one.segments], float(curve.spans[0])
    best: Branch | None = None
    for orbit, shot, ahead, distance in doubled(curve, found[parent].orbit(mark), longest / step, longest):
        point = curve.first(orbit, shot, ahead)
        branch = trace_branch(
            curve, point, longest / span, most, others=others, birth=Birth(point.arclength, step / span)
        )
        if not branch.segments:
            continue
        branch.parent, branch.born = parent, born
        if best is None or branch.arclength > best.arclength:
            best = branch
        # so near the doubling the way ahead may be lost in round-off
        if best.end != BranchEnd.NO_CONVERGENCE or best.arclength > distance:
            break
    return best

"""Curves of folds, period doublings, Neimark-Sacker points, grazing and sliding over two parameters."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.model import HybridSystem
from chaosdrill.orbits.branch import Branch, Mark
from chaosdrill.orbits.branches import Progress, trace_branch
from chaosdrill.orbits.codimension_two import mark_conditions
from chaosdrill.orbits.curve import Curve, SpecialCurve
from chaosdrill.orbits.find import NoOrbitError, starting_orbit
from chaosdrill.orbits.function_points import first_test, mark_functions
from chaosdrill.orbits.marks import NO_COLUMNS, Columns
from chaosdrill.orbits.multipliers import free_multipliers, pair_near
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.points import Point
from chaosdrill.orbits.problem import LostError, Problem
from chaosdrill.orbits.results import BranchResult
from chaosdrill.orbits.sliding import TOUCHING
from chaosdrill.orbits.special import test_function_at
from chaosdrill.orbits.switching import lifted
from chaosdrill.orbits.table import branch_table, nothing

FOLLOWED = {
    kind.meaning: kind
    for kind in (
        *(Special.FOLD, Special.PERIOD_DOUBLING, Special.NEIMARK_SACKER, Special.GRAZING),
        *(Special.CROSSING_SLIDING, Special.SWITCHING_SLIDING, Special.LEVEL, Special.OPTIMUM),
    )
}
"""What can be followed, by name."""


def curve(
    system: HybridSystem,
    parameters: tuple[str, str],
    limits: Sequence[Sequence[float]] | np.ndarray,
    period: int,
    start: str | float,
    transient: float,
    follow: str,
    step: float,
    max_points: int,
    numerics: Numerics,
    progress: Progress | None,
    columns: Columns = NO_COLUMNS,
) -> BranchResult:
    """The curve of special points of one kind over two parameters through the nearest such point.

    The point is located on the branch of orbits over the first parameter, in both directions from the start, at the
    system's value of the second one. From there the curve is followed in both directions, around its folds and cusps.

    ``limits``, shape (2, 2): smallest and largest value of each. ``period``, ``start``, ``transient``: of the first
    orbit, as for `chaosdrill.orbits.find.starting_orbit`. ``follow``: one of `FOLLOWED`. The last two: where the first
    function of ``columns`` takes its value, or has a maximum or minimum. ``step``: longest step of the first parameter;
    that of the second is the same part of its range. ``max_points``: largest number of points in one direction.
    ``progress``: called with the directions done, their total and None. ``columns``: further properties of every orbit,
    and the functions of which one is followed.

    Returns: One branch, all of whose points are of the kind that is followed, except on a Neimark-Sacker curve beyond a
    multiplier of 1 or -1: there the pair is real, and nothing bifurcates. ``stable`` says whether all multipliers but
    those on the unit circle are inside. At grazing the orbit is the one without the event that appears. It has no
    points, and the reason in its message, if there is no orbit or no such point.
    """
    ranges = np.array(limits, dtype=float)
    kind, called = FOLLOWED[follow], follow.replace("_", " ")
    part, name = step / float(np.ptp(ranges[0])), parameters[0]
    try:
        alone, orbit, shot, _, _ = starting_orbit(system, (name,), period, start, transient, numerics)
    except NoOrbitError as failure:
        return nothing(system, parameters, failure.outcome, failure.message)
    over = Curve(alone, ranges[:1])
    along = over.first(orbit, shot)
    ways = [trace_branch(over, one, part, max_points) for one in (along, along.turned())]
    if kind in (Special.LEVEL, Special.OPTIMUM) and columns.wanted is not None:
        for way in ways:
            mark_functions(way, columns.wanted)
    found = _nearest(ways, kind)
    if found is None:
        text = f"no {called} on the branch of {name} through the orbit: {_special_points_of(ways)}"
        return nothing(system, parameters, Outcome.NO_SPECIAL_POINT, text)
    problem = alone.alike(system, parameters)
    try:
        lifted_orbit = lifted(found, system.parameters[parameters[1]])
        curve, first = _begin(problem, lifted_orbit, kind, ranges, columns)
    except LostError as lost:
        text = f"the {called} at {name} = {found.starts[0, -1]:.12g} cannot be followed: {lost}"
        return nothing(system, parameters, Outcome.NO_SPECIAL_POINT, text)
    branch, place = trace_branch(curve, first, part, max_points), (0, 0)
    report = progress or (lambda done, total, outcomes: None)
    report(1, 2, None)
    if branch.end != BranchEnd.CLOSED:
        backward = trace_branch(curve, first.turned(), part, max_points)
        place = len(backward.segments) - 1, len(backward.segments[0]) - 1
        branch = branch.joined(backward)
        report(2, 2, None)
    assert first.root is not None
    value = float(curve.values(first.orbit)[0])
    error = (
        first.root.error * float(curve.spans[0]) + problem.accuracy * curve.size(first.orbit) + curve.error_at(first)
    )
    branch.marks.append(Mark(*place, kind, error, "start of the curve"))
    branch.start = f"the {called} at {name} = {value:.12g}"
    missing = mark_conditions(branch)
    if columns.wanted is not None:
        missing += mark_functions(branch, columns.wanted)
    result = branch_table(problem, parameters, [branch], None, columns, missing)
    if kind == Special.NEIMARK_SACKER:
        return _circling(problem, result, branch)
    return replace(result, stable=_stable(problem, result.multipliers, kind))


def _nearest(ways: list[Branch], kind: Special) -> Orbit | None:
    """The special orbit of a kind that is nearest to the start of a branch, along either half of it."""
    places = [
        (abs(way.segments[m.segment].points[m.point].arclength), way.orbit(m))
        for way in ways
        for m in way.marks
        if m.kind == kind or (kind == Special.GRAZING and m.kind in TOUCHING)
    ]
    return min(places, key=lambda place: place[0])[1] if places else None


def _special_points_of(ways: list[Branch]) -> str:
    """The special points that the branch has instead, in words."""
    marks = sorted((way.value(m), m.kind.meaning.replace("_", " ")) for way in ways for m in way.marks)
    there = ", ".join(f"{name} at {value:.9g}" for value, name in marks) or "nothing special"
    ends = [float(way.segments[-1].values[-1, 0]) if way.segments else float("nan") for way in ways]
    return f"{there} between {' and '.join(f'{v:.9g}' for v in sorted(ends))}"


def _begin(
    problem: Problem, orbit: Orbit, kind: Special, ranges: np.ndarray, columns: Columns
) -> tuple[SpecialCurve, Point]:
    if kind in (Special.LEVEL, Special.OPTIMUM):
        assert columns.wanted is not None
        curve = SpecialCurve(problem, ranges, first_test(columns.wanted, kind))
        return curve, curve.begin(orbit, problem.shoot(orbit), 0.0)
    weights = problem.weights(orbit, np.ptp(ranges, axis=1))
    test, orbit, shot, tracked = test_function_at(problem, orbit, problem.shoot(orbit), kind, weights)
    curve = SpecialCurve(problem, ranges, test)
    return curve, curve.begin(orbit, shot, tracked)


def _stable(problem: Problem, values: np.ndarray, kind: Special) -> np.ndarray:
    """Whether all multipliers but the critical one are inside the unit circle; False where one is NaN."""
    free = free_multipliers(values, problem.neutral.count)
    moduli = np.abs(free)
    if kind in (Special.FOLD, Special.PERIOD_DOUBLING):
        critical = 1.0 if kind == Special.FOLD else -1.0
        np.put_along_axis(moduli, np.abs(free - critical).argmin(axis=-1)[:, np.newaxis], 0.0, axis=-1)
    return (moduli < 1).all(axis=-1)


def _circling(problem: Problem, result: BranchResult, branch: Branch) -> BranchResult:
    """The table of a Neimark-Sacker curve: regular where the pair is real, stable where the rest is inside."""
    halves = np.array([p.root.tracked for s in branch.segments for p in s.points if p.root is not None])
    regular = (np.abs(halves) > 1) & (result.special == Special.NEIMARK_SACKER)
    both, neutral = zip(result.multipliers, halves, strict=True), problem.neutral.count
    inside = [bool((np.abs(pair_near(values, neutral, half)[2]) < 1).all()) for values, half in both]
    special = np.where(regular, int(Special.REGULAR), result.special)
    return replace(result, stable=np.array(inside, dtype=bool) & ~regular, special=special)

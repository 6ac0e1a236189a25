"""What happens along curves of special points: a second condition is met where one is met already.

Each condition is a function along the curve that changes its sign where it is met. Those of multipliers are symmetric
in them, so that they stay smooth where several meet. Every trial between two points is corrected onto the curve, as
`chaosdrill.orbits.crossings` does on branches. Names and conditions as in Kuznetsov 2004, Elements of Applied
Bifurcation Theory, chapter 9, doi:10.1007/978-1-4757-3978-7, and Kuznetsov and Meijer 2005, doi:10.1137/030601508.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np

from chaosdrill.codegen.layout import UNIT
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.orbits.branch import Mark
from chaosdrill.orbits.criticality import cubic_term
from chaosdrill.orbits.crossings import changes, noise_of, pair_on_circle, torus_test
from chaosdrill.orbits.grazing import height_of_return
from chaosdrill.orbits.multipliers import all_multipliers, free_multipliers, pair_near
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.roots import bracketed
from chaosdrill.orbits.sliding import LANDING
from chaosdrill.orbits.special import Touching
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.branch import Branch, BranchSegment
    from chaosdrill.orbits.curve import SpecialCurve
    from chaosdrill.orbits.points import Point

Values = Callable[["SpecialCurve", Sequence["Point"]], np.ndarray]


@dataclass(frozen=True)
class Condition:
    """A second condition along a curve.

    ``kind``: what it makes of a point. ``curve``: kind of the curve. ``values``: the function at each of the
    neighbouring points of a curve, shape (P,). ``multiplicity``: how many multipliers are on the unit circle there.
    ``proper``: whether the function's root at a point of the curve is one of this kind. ``error``: error of the
    function at a point.
    """

    kind: Special
    curve: Special
    values: Values
    multiplicity: int
    proper: Callable[["SpecialCurve", "Point"], bool] = lambda curve, point: True
    error: Callable[["SpecialCurve", "Point"], float] = lambda curve, point: float(
        noise_of(point.shot.monodromy, len(point.orbit))
    )


def _values(curve: "SpecialCurve", point: "Point") -> np.ndarray:
    return all_multipliers(curve.problem, point.orbit, point.shot)


def further(values: np.ndarray, place: float, count: int) -> float:
    """Function that vanishes where more than ``count`` multipliers are at a place, if at least ``count`` always are.

    A coefficient of the characteristic polynomial about the place, to which no multiplier need be assigned.
    """
    return float(np.poly(values - place)[len(values) - count].real)


def _each(function: Callable[["SpecialCurve", "Point"], float]) -> Values:
    return lambda curve, points: np.array([function(curve, point) for point in points])


def _at(place: float, more: int, neutral: bool) -> Values:
    """Another multiplier is at a place where ``more`` are, beside those that are 1 by structure."""
    return _each(
        lambda curve, point: further(
            _values(curve, point), place, more + (curve.problem.neutral.count if neutral else 0)
        )
    )


def _half(curve: "SpecialCurve", point: "Point") -> float:
    """Half the sum of the pair of a Neimark-Sacker curve: the cosine of its angle."""
    assert point.root is not None
    return pair_near(_values(curve, point), curve.problem.neutral.count, point.root.tracked)[0]


def _angle(cosine: float) -> Values:
    return _each(lambda curve, point: _half(curve, point) - cosine)


def _rest(curve: "SpecialCurve", point: "Point") -> np.ndarray:
    """The multipliers beside those that make the point one of the curve."""
    values, neutral = _values(curve, point), curve.problem.neutral.count
    if curve.kind == Special.NEIMARK_SACKER:
        assert point.root is not None
        return pair_near(values, neutral, point.root.tracked)[2]
    if curve.kind == Special.FOLD:
        return free_multipliers(values, neutral + 1)
    free = free_multipliers(values, neutral)
    return np.delete(free, np.abs(free + 1).argmin()) if curve.kind == Special.PERIOD_DOUBLING else free


def _circling(curve: "SpecialCurve", point: "Point") -> float:
    """A pair of the other multipliers is on the unit circle."""
    return float(torus_test(_rest(curve, point)))


def _on_circle(curve: "SpecialCurve", point: "Point") -> bool:
    return pair_on_circle(_rest(curve, point)) < TUNING.missed_multiplier and _complex(curve, point)


def _complex(curve: "SpecialCurve", point: "Point") -> bool:
    """Whether the pair that makes the curve one of Neimark-Sacker points is complex, if one does."""
    return curve.kind != Special.NEIMARK_SACKER or abs(_half(curve, point)) < 1


def _folding(curve: "SpecialCurve", points: Sequence["Point"]) -> np.ndarray:
    """Slope of the fold's function along the direction in which the surface of orbits folds.

    At a cusp the curve itself runs there, so that it has no slope.
    """
    found, before = [], np.zeros(0)
    for point in points:
        assert point.root is not None
        plane = point.root.plane
        part = np.linalg.svd(plane.courses[:, -2:].T)[2][-1]
        course = plane.courses.T @ part
        if len(before) and course @ before < 0:
            part, course = -part, -course
        before = course
        shot = curve.problem.shoot(point.orbit, False, point.section)
        found.append(curve.slope(point.orbit, shot, plane, part, point.root.tracked))
    return np.array(found)


def _cubic_term(curve: "SpecialCurve", point: "Point") -> tuple[float, float]:
    """The cubic coefficient of the normal form and its error; NaN without one."""
    multiplier = -1.0 + 0j
    if curve.kind == Special.NEIMARK_SACKER:
        half = _half(curve, point)
        multiplier = complex(half, np.sqrt(1 - half**2)) if abs(half) < 1 else complex(np.nan)
    if np.isnan(multiplier):
        return float("nan"), float("nan")
    try:
        return cubic_term(curve.problem, point.orbit, multiplier)
    except (LostError, np.linalg.LinAlgError):
        return float("nan"), float("nan")


def _cubic(curve: "SpecialCurve", point: "Point") -> float:
    return _cubic_term(curve, point)[0]


def _cubic_error(curve: "SpecialCurve", point: "Point") -> float:
    return _cubic_term(curve, point)[1]


def _height(curve: "SpecialCurve", point: "Point", number: int) -> float:
    """Height of a return after an event that grazes."""
    if not isinstance(curve.test, Touching) or point.root is None:
        return float("nan")
    return height_of_return(curve.problem, point.orbit, curve.test.touch, point.root.tracked, number)


def _returning(number: int) -> Condition:
    """A return after an event that grazes is as high as the guard, and none before."""

    def first(curve: "SpecialCurve", point: "Point") -> bool:
        return all(abs(_height(curve, point, k)) > TUNING.missed_multiplier for k in range(1, number))

    values = _each(lambda curve, point: _height(curve, point, number))
    return Condition(Special.RESONANT_GRAZING, Special.GRAZING, values, 0, first)


_PAIR = Special.NEIMARK_SACKER

CONDITIONS = [
    Condition(Special.CUSP, Special.FOLD, _folding, 1),
    Condition(Special.RESONANCE_1_1, Special.FOLD, _at(1, 1, True), 2),
    Condition(Special.FOLD_FLIP, Special.FOLD, _at(-1, 0, False), 2),
    Condition(Special.FOLD_NEIMARK_SACKER, Special.FOLD, _each(_circling), 3, _on_circle),
    Condition(Special.FOLD_FLIP, Special.PERIOD_DOUBLING, _at(1, 0, True), 2),
    Condition(Special.RESONANCE_1_2, Special.PERIOD_DOUBLING, _at(-1, 1, False), 2),
    Condition(Special.GENERALISED_FLIP, Special.PERIOD_DOUBLING, _each(_cubic), 1, error=_cubic_error),
    Condition(Special.FLIP_NEIMARK_SACKER, Special.PERIOD_DOUBLING, _each(_circling), 3, _on_circle),
    Condition(Special.CHENCINER, _PAIR, _each(_cubic), 2, error=_cubic_error),
    Condition(Special.RESONANCE_1_1, _PAIR, _angle(1.0), 2),
    Condition(Special.RESONANCE_1_2, _PAIR, _angle(-1.0), 2),
    Condition(Special.RESONANCE_1_3, _PAIR, _angle(-0.5), 2),
    Condition(Special.RESONANCE_1_4, _PAIR, _angle(0.0), 2),
    Condition(
        Special.FOLD_NEIMARK_SACKER, _PAIR, _each(lambda c, p: float(np.prod(1 - _rest(c, p)).real)), 3, _complex
    ),
    Condition(
        Special.FLIP_NEIMARK_SACKER, _PAIR, _each(lambda c, p: float(np.prod(1 + _rest(c, p)).real)), 3, _complex
    ),
    Condition(Special.DOUBLE_NEIMARK_SACKER, _PAIR, _each(_circling), 4, _on_circle),
    *(
        condition
        for curve, fold, flip, pair in (
            (Special.GRAZING, Special.GRAZING_FOLD, Special.GRAZING_FLIP, Special.GRAZING_NEIMARK_SACKER),
            *((one, Special.SLIDING_FOLD, Special.SLIDING_FLIP, Special.SLIDING_NEIMARK_SACKER) for one in LANDING),
        )
        for condition in (
            Condition(fold, curve, _at(1, 0, True), 1),
            Condition(flip, curve, _at(-1, 0, False), 1),
            Condition(pair, curve, _each(_circling), 2, _on_circle),
        )
    ),
    *map(_returning, (1, 2, 3)),
    *(
        Condition(kind, curve, values, multiplicity, proper)
        for curve in (Special.LEVEL, Special.OPTIMUM)
        for kind, values, multiplicity, proper in (
            (Special.FOLD, _at(1, 0, True), 1, lambda curve, point: True),
            (Special.PERIOD_DOUBLING, _at(-1, 0, False), 1, lambda curve, point: True),
            (Special.NEIMARK_SACKER, _each(_circling), 2, _on_circle),
        )
    ),
]
"""What is looked for along curves."""


def mark_conditions(branch: "Branch") -> list[str]:
    """Insert the points of a curve at which a second condition is met, and mark them.

    Returns: where one is met but was not located, in words.
    """
    missing: list[str] = []
    for first, last in _chains(branch.segments):
        curve = cast("SpecialCurve", branch.segments[first].curve)
        chain = [(s, k) for s in range(first, last) for k in range(len(branch.segments[s]))]
        points = [branch.segments[s].points[k] for s, k in chain]
        if len(points) < 2 or not np.isfinite([p.shot.monodromy for p in points]).all():
            continue
        found: list[tuple[int, float, Located]] = []
        for condition in (c for c in CONDITIONS if c.curve == curve.kind):
            values = condition.values(curve, points)
            noise = noise_of(np.array([p.shot.monodromy for p in points]), len(points[0].orbit))
            for k in {*changes(values, noise), *_at_limits(curve, points, values, noise)}:
                try:
                    one = _located(curve, condition, points[k - 1], points[k])
                except LostError:
                    names = zip(curve.problem.free, curve.values(points[k].orbit), strict=True)
                    place = ", ".join(f"{name} = {value:.9g}" for name, value in names)
                    missing.append(f"a {condition.kind.meaning.replace('_', ' ')} near {place} was not located")
                    continue
                if one is not None:
                    found.append((k, one.part, one))
        if branch.end == BranchEnd.CLOSED and len(branch.segments) == last - first:
            found = [one for one in found if not _again(curve, one[2], found)]
        for k, _, one in sorted(found, key=lambda entry: entry[:2], reverse=True):
            insert(branch, *chain[k - (one.part == 0.0)], one, one.point.special.advice)
    return missing


@dataclass(frozen=True)
class Located:
    """A point of codimension two between two points of a curve."""

    point: "Point"
    part: float  # of the step between the two
    error: float  # of the first parameter
    multiplicity: int


def _chains(segments: Sequence["BranchSegment"]) -> list[tuple[int, int]]:
    """Runs of segments of one curve: the two halves share the segment in which they began."""
    starts = [k for k in range(len(segments)) if k == 0 or segments[k].curve is not segments[k - 1].curve]
    return list(zip(starts, [*starts[1:], len(segments)], strict=True))


def _at_limits(curve: "SpecialCurve", points: Sequence["Point"], values: np.ndarray, noise: np.ndarray) -> list[int]:
    """Of the steps at the ends of a curve those at whose end it reaches its limits, and a function is zero there.

    It is so to its error and to what the secant method leaves of the way to the curve.
    """
    found = []
    for end, beside in ((0, 1), (len(points) - 1, len(points) - 2)):
        rate = (values[end] - values[beside]) / (points[end].arclength - points[beside].arclength)
        limited = np.abs(curve.values(points[end].orbit) - curve.limits.T) <= UNIT * curve.spans
        if limited.any() and abs(values[end]) <= noise[end] + abs(rate) * TUNING.secant_noise:
            found.append(max(end, beside))
    return found


def _located(curve: "SpecialCurve", condition: Condition, before: "Point", after: "Point") -> Located | None:
    """Where a condition is met between two points; None if its function passes a pole, or it is of another kind.

    Raises `LostError`.
    """
    tried: dict[float, Point] = {0.0: before, 1.0: after}

    def value(part: float) -> float:
        if part not in tried:
            tried[part] = curve.between(before, after, part)
        found = float(condition.values(curve, [before, tried[part]])[1])
        if np.isnan(found):
            raise _PoleError
        return found

    try:
        low, high = value(0.0), value(1.0)
        part = bracketed(value, 0.0, 1.0)
    except _PoleError:
        return None
    point = tried[part]
    if abs(value(part)) > TUNING.jump * max(abs(low), abs(high)) or not condition.proper(curve, point):
        return None
    own, rise = condition.error(curve, point), abs(high - low)
    # of a function that is zero all along the curve only errors change sign
    if not max(own, *(condition.error(curve, end) for end in (before, after))) < TUNING.jump * rise:
        return None
    way = abs(float(curve.values(after.orbit)[0] - curve.values(before.orbit)[0]))
    own = own * max(1.0, curve.problem.accuracy / TUNING.tangent_error) + abs(value(part))
    error = curve.problem.accuracy * curve.size(point.orbit) + curve.error_at(point) + own * way / rise
    return Located(replace(point, special=condition.kind), part, float(error), condition.multiplicity)


class _PoleError(Exception):
    """A function has no value on the way to its root."""


def _again(curve: "SpecialCurve", one: Located, found: Sequence[tuple[int, float, Located]]) -> bool:
    """Whether a point at the end of a closed curve is one at its start."""
    earlier = [other for _, _, other in found if other.point.arclength < one.point.arclength]
    return any(
        other.point.special == one.point.special
        and curve.met(other.point.orbit, one.point.orbit, one.point.weights, TUNING.meeting) is not None
        for other in earlier
    )


def insert(branch: "Branch", number: int, place: int, one: Located, text: str) -> None:
    """Put a located point before another one of a segment, or in its place if it is there, and mark it."""
    segment = branch.segments[number]
    points = list(segment.points)
    there = one.part in (0.0, 1.0)
    points[place : place + there] = [one.point]
    branch.segments[number] = segment.with_points(points)
    moved = [
        replace(m, point=m.point + 1) if not there and m.segment == number and m.point >= place else m
        for m in branch.marks
    ]
    kind = one.point.special
    branch.marks = [*moved, Mark(number, place, kind, one.error, text, one.multiplicity)]

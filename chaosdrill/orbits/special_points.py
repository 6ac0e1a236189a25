"""Special points of a segment of a branch: located, with what is born there in words."""

from dataclasses import replace

from chaosdrill.dataset.branches import Special
from chaosdrill.orbits.branch import BranchSegment, Mark
from chaosdrill.orbits.continuation import continue_curve
from chaosdrill.orbits.criticality import normal_form
from chaosdrill.orbits.crossings import Located, located, steps_with
from chaosdrill.orbits.curve import Curve
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.results import NormalForm
from chaosdrill.orbits.tuning import TUNING


def marked(segment: BranchSegment, begin: int, count: int) -> tuple[BranchSegment, list[Mark]]:
    """The segment with the special points from ``begin`` on among its first ``count`` inserted, and their marks."""
    points, marks = list(segment.points), []
    for k in reversed(steps_with(segment.with_points(points[begin:count]))):
        for one in reversed(_between(segment, begin + k, TUNING.finer)):
            points.insert(begin + k, one.point)
            marks.append(one)
    places = {id(p): k for k, p in enumerate(points)}
    found = []
    for one in reversed(marks):
        found.append(_mark_of(segment.curve, places[id(one.point)], one))
    return segment.with_points(points), found


def marked_at_limit(
    segment: BranchSegment, marks: list[Mark], across: BranchSegment
) -> tuple[BranchSegment, list[Mark]]:
    """The same with a special point that coincides with the limit, if there is one in the step across it."""
    limit = float(segment.values[-1, 0])
    for one in _between(across, 1, 0) if steps_with(across) else []:
        away = abs(float(segment.curve.values(one.point.orbit)[0]) - limit)
        alike = (m for m in marks if m.kind == one.point.special)
        if away <= one.error and all(abs(segment.values[m.point, 0] - limit) > m.error + one.error for m in alike):
            last = replace(segment.points[-1], special=one.point.special)
            segment = segment.with_points([*segment.points[:-1], last])
            marks = [*marks, _mark_of(segment.curve, len(segment) - 1, one)]
    return segment, marks


def _mark_of(curve: Curve, place: int, one: Located) -> Mark:
    """The mark of a special point, with what is born there."""
    kind = one.point.special
    form = normal_form(curve.problem, one.point.orbit, kind, one.multiplicity)
    text = _form_words(one, form, bool(len(curve.problem.conserved)))
    return Mark(0, place, kind, one.error, text, one.multiplicity, form)


def _form_words(mark: Located, form: NormalForm, held: bool) -> str:
    """What happens at a special point, in words; ``held``: only the differential of what is conserved is held."""
    if held and mark.point.special == Special.FOLD:
        return (
            "A multiplier is +1: two orbits with one value of what is conserved meet and vanish. The branch goes on, "
            "since that value changes along it."
        )
    words, usual = mark.point.special.advice, 2 if mark.point.special == Special.NEIMARK_SACKER else 1
    if mark.multiplicity > usual:
        words = f"{words} {mark.multiplicity // usual} are there together."
    return f"{words} {form.criticality.advice}".rstrip()


def _between(segment: BranchSegment, k: int, finer: int) -> list[Located]:
    """Special points between point k - 1 and point k, in order, with the errors of the parameter.

    Where one is not found, because too much happens in the step, the branch between is followed in smaller steps.
    """
    before, after = segment.points[k - 1 : k + 1]
    pair = segment.with_points((before, after))
    try:
        return located(pair)
    except LostError:
        if not finer:
            return []
    gap = after.arclength - before.arclength
    part = continue_curve(
        segment.curve.unlimited(),
        before,
        gap / TUNING.finer_parts,
        8 * TUNING.finer_parts,
        gap / TUNING.finer_parts,
    )
    points = [p for p in part.points if p.arclength < before.arclength + 1.02 * gap]
    points += part.points[len(points) : len(points) + 1]
    inside = segment.with_points(points)
    return [one for i in steps_with(inside) for one in _between(inside, i, finer - 1)]

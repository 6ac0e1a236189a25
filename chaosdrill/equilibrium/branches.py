"""Branches of equilibria over a parameter with what happens on them, from all equilibria at its own value.

Special points are recognised by what changes between neighbours: the number of eigenvalues with a positive real part,
the direction of the parameter, and the sides of guards. A step with several changes is divided until each has its own
step, also where the number is the same at both ends: the rates of the eigenvalues show that they come back. Each change
is located as a zero of the quantity that changes, by Brent's method.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from chaosdrill.codegen.layout import UNIT
from chaosdrill.dataset.branches import BranchEnd, Criticality
from chaosdrill.dataset.equilibria import Beyond, SpecialEquilibrium
from chaosdrill.equilibrium.curve import Curve, LostError, Point, followed
from chaosdrill.equilibrium.forms import HopfForm, beyond, branch_point, crossing, hopf_form
from chaosdrill.equilibrium.hidden import refined
from chaosdrill.equilibrium.points import Equilibrium, undecided
from chaosdrill.equilibrium.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Mark:
    """A special point of a branch."""

    point: int  # its number on the branch
    kind: SpecialEquilibrium
    error: float  # of the parameter
    multiplicity: int  # eigenvalues on the imaginary axis; 0 where a guard is met
    text: str
    form: HopfForm | None = None
    beyond: Beyond = Beyond.NONE
    side: int = -1  # guard that is met


@dataclass
class Branch:
    """A branch of equilibria of one mode."""

    curve: Curve
    points: list[Point]
    start: str  # in words
    ends: tuple[BranchEnd, BranchEnd]
    parent: int = -1
    marks: list[Mark] = field(default_factory=list)

    @property
    def end(self) -> BranchEnd:
        """The end that tells most: that which is not the parameter's limit, if there is one."""
        return next((one for one in self.ends if one != BranchEnd.LIMIT), BranchEnd.LIMIT)


ENDS = {
    BranchEnd.LIMIT: "the parameter reached its limit",
    BranchEnd.CLOSED: "the branch returned to its start: it is a closed loop",
    BranchEnd.MOST_POINTS: "the maximum number of points was reached; raise max_points, or allow a larger step",
    BranchEnd.ESCAPED: "a state left its bounds; widen them if larger states are meant",
    BranchEnd.NO_CONVERGENCE: "Newton's method found no equilibrium at the smallest step; the rates end there, or turn",
}


@dataclass(frozen=True)
class Task:
    """What branches are followed over."""

    system: "HybridSystem"
    parameter: str
    limits: tuple[float, float]
    sizes: np.ndarray  # (n,)
    step: float  # longest step, as a part of the range
    most: int  # points on either side

    def curve(self, one: Equilibrium) -> Curve:
        """The curve that an equilibrium lies on."""
        bounds = np.array([self.system.escapes[name] for name in self.system.state_names], dtype=float)
        which = list(self.system.parameters).index(self.parameter)
        return Curve(one.field, which, self.limits, self.sizes[list(one.field.free)], bounds, self.step)


def branches(task: Task, starts: Sequence[Equilibrium], report: Callable[[int], None] | None = None) -> list[Branch]:
    """All branches that start at equilibria, cross these, or go on at guards."""
    found: list[Branch] = []
    own = task.system.parameters[task.parameter]
    for one in starts:
        mode = task.system.mode_names[one.field.mode]
        _enter(task, found, one, f"an equilibrium of mode {mode!r} at {task.parameter} = {own:g}", -1)
    number = 0
    while number < len(found) and len(found) < TUNING.most_branches:
        branch = found[number]
        _mark(task, found, number)
        if report is not None:
            report(number + 1)
        for mark in branch.marks:
            if mark.kind == SpecialEquilibrium.BRANCH_POINT and mark.multiplicity == 1:
                _switch(task, found, number, mark)
        number += 1
    for branch in found[number:]:
        branch.marks = []
    return found


def _enter(task: Task, found: list[Branch], one: Equilibrium, words: str, parent: int) -> None:
    """Follow the branch through an equilibrium, unless it is known."""
    curve = task.curve(one)
    try:
        curve, first = _beside_crossing(curve, curve.first(one))
    except LostError:
        return
    if any(b.curve.field is one.field and b.curve.holds(b.points, first.at) for b in found):
        return
    branch = _both_ways(curve, (first, first.turned()), task.most, words, parent)
    if len(branch.points) == 1:
        # where branches cross, each has a direction of its own
        for way in [] if curve.field.system.sources else reversed(crossing(curve, first)):
            if sides := _sides(curve, first, way):
                branch = _both_ways(curve, sides, task.most, words, parent, Point(first.at, way))
                break
    found.append(branch)


def _beside_crossing(curve: Curve, first: Point) -> tuple[Curve, Point]:
    """The curve and its first point; where branches cross nearby, one further on, with the sizes of its states.

    Nearby is what a small part of the range takes at least twice as far. In sizes that the states have next to a
    crossing at zero the branches there have nearly the same direction, and a fold far away has none.
    """
    point, h, low, high = first, TUNING.first_step * TUNING.longest_step, *curve.limits
    while abs(curve.value(point.at) - curve.value(first.at)) < TUNING.beside * (high - low):
        try:
            point = curve.after(point, h)
        except LostError:
            return curve, first
        h *= TUNING.growth
        if h > TUNING.farthest:
            return curve, first
    weights = curve.weights(point.at)
    _, rows = curve.scaled(point.at.numbers, weights)
    near, away = (
        np.linalg.svd(curve.matrix(p.at.numbers) * weights * rows[:, np.newaxis], compute_uv=False)[-1]
        for p in (first, point)
    )
    if away <= 2 * near or not low <= curve.value(point.at) <= high or curve.escaped(point.at):
        return curve, first
    curve = replace(curve, sizes=weights[:-1])
    return curve, curve.first(point.at)


def _both_ways(
    curve: Curve, starts: Sequence[Point], most: int, words: str, parent: int, middle: Point | None = None
) -> Branch:
    """The branch from two starts on: a point and the same turned round, or points on both sides of a ``middle``."""
    ahead, end = followed(curve, starts[0], most)
    if end == BranchEnd.CLOSED:
        return Branch(curve, ahead, words, (end, end), parent)
    back, start = followed(curve, starts[1], most)
    before = [p.turned() for p in reversed(back[1:] if middle is None else back)]
    return Branch(curve, [*before, *([] if middle is None else [middle]), *ahead], words, (start, end), parent)


def _switch(task: Task, found: list[Branch], parent: int, mark: Mark) -> None:
    """Follow the branch that crosses at a branch point, unless it is known."""
    branch = found[parent]
    curve, here = branch.curve, branch.points[mark.point]
    if curve.field.system.sources:
        return
    ways = sorted(crossing(curve, here), key=lambda way: abs(float(way @ here.tangent)))
    if not ways:
        return
    sides = _sides(curve, here, ways[0])
    if not sides or any(b.curve.field is curve.field and b.curve.holds(b.points, p.at) for p in sides for b in found):
        return
    words = f"the branch point at {task.parameter} = {curve.value(here.at):.12g}"
    found.append(_both_ways(curve, sides, task.most, words, parent, Point(here.at, ways[0])))


def _sides(curve: Curve, here: Point, way: np.ndarray) -> list[Point]:
    """Points on both sides of a branch point on the branch that goes in a direction, with the way on; none if lost."""
    step, sides = min(TUNING.along, curve.step), []
    for sign in (1, -1):
        start = Point(here.at, sign * way, here.arclength)
        try:
            one = curve.corrected(curve.unknowns(here.at) + step * curve.weights(here.at) * start.tangent, start)
            sides.append(Point(one, curve.tangent(one, start.tangent), step))
        except LostError:
            return []
    return sides


@dataclass(frozen=True)
class _State:
    """Signs at a point by which special points are recognised; entries of 0 are undecided."""

    unstable: tuple[int, int]
    way: int
    sides: tuple[int, ...]


def _state(point: Point) -> _State:
    one = point.at
    doubt = UNIT * TUNING.level
    way = 0 if abs(point.tangent[-1]) <= doubt else int(np.sign(point.tangent[-1]))
    sides = np.where(np.abs(one.heights) <= one.height_errors, 0, np.sign(one.heights)).astype(int)
    return _State(one.spectrum.unstable, way, tuple(sides.tolist()))


def _mark(task: Task, found: list[Branch], number: int) -> None:
    """Locate the special points of a branch and put them among its points; branches that go on at guards are added."""
    branch = found[number]
    branch.points = refined(branch.curve, branch.points)
    places = []
    for first, last in _intervals(branch.points):
        places += _events(branch.curve, first, last)
    places += _at_limits(branch, places)
    places.sort(key=lambda place: place[0].arclength)
    points = branch.points
    for point, kind, error, multiplicity, detail in places:
        k = int(np.searchsorted([p.arclength for p in points], point.arclength))
        if k < len(points) and points[k].arclength == point.arclength:
            points[k] = point
        else:
            points.insert(k, point)
        branch.marks.append(Mark(k, kind, error, multiplicity, "", side=int(detail)))
    # later points have moved the earlier ones on
    at = {id(point): k for k, point in enumerate(points)}
    for k, (place, mark) in enumerate(zip(places, branch.marks, strict=True)):
        branch.marks[k] = _told(task, found, number, replace(mark, point=at[id(place[0])]), place[4])


def _intervals(points: list[Point]) -> list[tuple[Point, Point]]:
    """Neighbours between which something changes: of what is undecided at some points, the last and next decided."""
    found: dict[tuple[int, int], tuple[Point, Point]] = {}
    states = [_state(p) for p in points]

    def seen(decided: Callable[[_State], int | None]) -> None:
        last = None
        for k, state in enumerate(states):
            value = decided(state)
            if value is None:
                continue
            if last is not None and decided(states[last]) != value:
                found.setdefault((last, k), (points[last], points[k]))
            last = k

    seen(lambda s: s.unstable[0] if s.unstable[0] == s.unstable[1] else None)
    seen(lambda s: s.way or None)
    for side in range(len(states[0].sides)):
        seen(lambda s, side=side: s.sides[side] or None)  # type: ignore[misc]
    # one interval within another tells the same
    kept = [key for key in found if not any(o != key and o[0] >= key[0] and o[1] <= key[1] for o in found)]
    return [found[key] for key in sorted(kept)]


Place = tuple[Point, SpecialEquilibrium, float, int, float]


def _events(curve: Curve, first: Point, last: Point) -> list[Place]:
    """The special points between two neighbours."""
    found: list[Place] = []
    for low, high in _one_by_one(curve, first, last, TUNING.halvings):
        a, b = _state(low), _state(high)
        for side, (one, other) in enumerate(zip(a.sides, b.sides, strict=True)):
            if one * other < 0:
                found += _boundary(curve, low, high, side)
        changed = b.unstable[0] - a.unstable[0]
        if a.way * b.way < 0:
            found += _turning(curve, low, high, changed)
        if abs(changed) > (a.way * b.way < 0):
            found += _crossings(curve, low, high, changed, a.way * b.way < 0)
    return found


def _at_limits(branch: Branch, places: Sequence[Place]) -> list[Place]:
    """The special points that coincide with the limits of the parameter, by steps across these."""
    curve, points, found = branch.curve, branch.points, list[Place]()
    for end, (last, before), turn in ((branch.ends[1], points[:-3:-1], False), (branch.ends[0], points[:2], True)):
        if end != BranchEnd.LIMIT:
            continue
        inside, limit = (before.turned(), last.turned()) if turn else (before, last)
        with suppress(LostError):
            for one in _events(curve, inside, curve.after(limit, TUNING.along)):
                known = any(_apart(curve, other, last) <= other[2] + one[2] for other in places)
                if _apart(curve, one, last) <= one[2] and not known:
                    found.append((last, *one[1:]))
    return found


def _apart(curve: Curve, place: Place, point: Point) -> float:
    """How far the parameter of a special point is from that of another one."""
    return abs(curve.value(place[0].at) - curve.value(point.at))


def _one_by_one(curve: Curve, first: Point, last: Point, halvings: int) -> list[tuple[Point, Point]]:
    """Parts of a stretch in each of which one thing happens, or several at one place."""
    a, b = _state(first), _state(last)
    if a == b:
        return []
    things = abs(b.unstable[0] - a.unstable[0]) + (a.way != b.way) + sum(np.not_equal(a.sides, b.sides))
    if halvings == 0 or things == 1:
        return [(first, last)]
    for part in TUNING.parts:
        try:
            middle = curve.between(first, last, part)
        except LostError:
            continue
        state = _state(middle)
        if state.unstable[0] == state.unstable[1] and state.way and all(state.sides):
            left = _one_by_one(curve, first, middle, halvings - 1)
            return left + _one_by_one(curve, middle, last, halvings - 1)
    return [(first, last)]


def _zero(curve: Curve, first: Point, last: Point, value: Callable[[Point], float]) -> tuple[Point, float] | None:
    """Where a function of the points vanishes, and at which part of the way; None where it does not."""
    ends = value(first), value(last)
    if not ends[0] * ends[1] < 0:
        return None

    def at(part: float) -> float:
        return ends[0] if part == 0 else ends[1] if part == 1 else value(curve.between(first, last, part))

    try:
        part = float(brentq(at, 0.0, 1.0, xtol=1e-15, rtol=4 * np.finfo(float).eps, maxiter=200))
        return curve.between(first, last, part), part
    except (LostError, RuntimeError):
        return None


def _error(
    curve: Curve, first: Point, last: Point, part: float, value: Callable[[Point], tuple[float, float]]
) -> float:
    """How far off the parameter may be at a zero, given the function and its error at points between neighbours."""

    def at(where: float) -> tuple[Point, float, float]:
        point = curve.between(first, last, where)
        return point, *value(point)

    here = curve.value(curve.between(first, last, part).at)
    off = [abs(curve.value(end.at) - here) for end in undecided(at, part, (0.0, 1.0))]
    return max(off) + UNIT * abs(here)


def _boundary(curve: Curve, first: Point, last: Point, side: int) -> list[Place]:
    """Where a guard is met."""
    found = _zero(curve, first, last, lambda p: float(p.at.heights[side]))
    if found is None:
        return []
    point, part = found
    one = point.at
    others = [k for k in np.flatnonzero(one.heights > one.height_errors).tolist() if k != side]
    if any(curve.field.crossed(k, one.numbers) for k in others):
        return []  # it is virtual on either side

    def height(there: Point) -> tuple[float, float]:
        return float(there.at.heights[side]), float(there.at.height_errors[side])

    error = _error(curve, first, last, part, height)
    return [(point, SpecialEquilibrium.BOUNDARY, error, 0, float(side))]


def _turning(curve: Curve, first: Point, last: Point, changed: int) -> list[Place]:
    """A fold; where no eigenvalue changes its sign, the vertex of a branch that another one crosses there."""
    if changed == 0:
        return _branch_point(curve, first, last)
    found = _zero(curve, first, last, lambda p: float(p.tangent[-1]))
    if found is None:
        return []
    point = found[0]
    matrix, rows = curve.scaled(point.at.numbers, curve.weights(point.at))
    w = np.linalg.svd(matrix[:, :-1])[0][:, -1] * rows
    by = abs(float(w @ curve.field.by_parameter(point.at.numbers, curve.which)))
    error = float(np.abs(w) @ curve.field.rounding(point.at.numbers)) / by if by else float("inf")
    return [(point, SpecialEquilibrium.FOLD, error + UNIT * abs(curve.value(point.at)), 1, 0.0)]


def _branch_point(curve: Curve, first: Point, last: Point) -> list[Place]:
    """The branch point between two neighbours."""
    if curve.field.system.sources:
        return []
    weights = curve.weights(first.at)
    apart = float(np.abs((curve.unknowns(last.at) - curve.unknowns(first.at)) / weights).max())
    for near, other in ((first, last), (last, first)):
        found = branch_point(curve, near, 2 * apart)
        if found is not None:
            point, error = found
            part = np.abs((curve.unknowns(point.at) - curve.unknowns(near.at)) / weights).max() / max(apart, 1e-300)
            arclength = near.arclength + min(part, 1.0) * (other.arclength - near.arclength)
            point = replace(point, tangent=near.tangent, arclength=arclength)
            return [(point, SpecialEquilibrium.BRANCH_POINT, error, 1, 0.0)]
    return []


def _crossings(curve: Curve, first: Point, last: Point, changed: int, turned: bool) -> list[Place]:
    """Where eigenvalues cross the imaginary axis: pairs at Hopf points, real ones at branch points.

    By falling real part the eigenvalue at each place moves continuously, whichever meet on the way. Where the branch
    ``turned``, one real eigenvalue is that of the fold.
    """
    found: list[Place] = []
    count = first.at.spectrum.unstable[0]
    real = -int(turned)
    for place in range(min(count, count + changed), max(count, count + changed)):

        def critical(point: Point, place: int = place) -> tuple[float, float]:
            spectrum = point.at.spectrum
            return float(spectrum.values[place].real), float(spectrum.errors[place])

        zero = _zero(curve, first, last, lambda point: critical(point)[0])
        if zero is None:
            # where branches cross the equations are singular
            real += not any(end.at.spectrum.values[place].imag for end in (first, last))
            continue
        point, part = zero
        turning = abs(float(point.at.spectrum.values[place].imag))
        if turning:
            error = _error(curve, first, last, part, critical)
            found.append((point, SpecialEquilibrium.HOPF, error, 1, turning))
        else:
            real += 1
    if real == 1 and not curve.field.system.sources:
        found += _branch_point(curve, first, last)
    elif real > 0:
        zero = _zero(curve, first, last, _least)
        if zero is not None:
            error = UNIT**0.5 * abs(curve.value(last.at) - curve.value(first.at))
            found.append((zero[0], SpecialEquilibrium.BRANCH_POINT, error, real, 0.0))
    return _together(curve, found)


def _least(point: Point) -> float:
    """The real eigenvalue nearest to zero."""
    real = point.at.spectrum.values.real[point.at.spectrum.values.imag == 0]
    return float(real[np.abs(real).argmin()]) if len(real) else float("nan")


def _together(curve: Curve, found: list[Place]) -> list[Place]:
    """Those at one place as one of larger multiplicity."""
    kept: list[Place] = []
    for one in found:
        for k, other in enumerate(kept):
            near = 10 * (one[2] + other[2]) + TUNING.same * (curve.limits[1] - curve.limits[0])
            if one[1] == other[1] and _apart(curve, one, other[0]) <= near:
                kept[k] = (other[0], other[1], max(other[2], one[2]), other[3] + one[3], other[4])
                break
        else:
            kept.append(one)
    return kept


def _told(task: Task, found: list[Branch], number: int, mark: Mark, detail: float) -> Mark:
    """A special point with what is known of it, in words."""
    branch = found[number]
    curve, point = branch.curve, branch.points[mark.point]
    if mark.kind == SpecialEquilibrium.BOUNDARY:
        side = curve.field.sides[mark.side]
        names = " or ".join(repr(task.system.transitions[i].name) for i in side.outcomes) or "what the mode asks"
        what, partner = Beyond.UNDECIDED, None
        if side.outcomes:
            what, partner = beyond(task.system, curve, point, mark.side, task.sizes, mark.error)
        text = f"it meets the guard of {names}. {what.advice}"
        if partner is not None:
            mode = task.system.mode_names[partner.field.mode]
            text = text.replace("another mode", f"mode {mode!r}")
            words = f"the boundary equilibrium at {task.parameter} = {curve.value(point.at):.12g}"
            _enter(task, found, partner, words, number)
        return replace(mark, text=text, beyond=what)
    if mark.kind == SpecialEquilibrium.HOPF:
        if mark.multiplicity > 2:
            form = HopfForm(detail, Criticality.UNDECIDED)
            return replace(mark, text=f"{mark.multiplicity // 2} pairs cross together: {mark.kind.advice}", form=form)
        form = hopf_form(curve, *_beside(branch, mark.point), detail, mark.error)
        born = {
            Criticality.SUPERCRITICAL: "It is supercritical, or soft: the cycle attracts within the centre manifold.",
            Criticality.SUBCRITICAL: "It is subcritical, or hard: the cycle repels within the centre manifold.",
        }.get(form.criticality, "Whether it is soft or hard is undecided.")
        return replace(mark, text=f"{mark.kind.advice} {born}", form=form)
    text = mark.kind.advice
    if mark.multiplicity > 1:
        text = f"{mark.multiplicity} eigenvalues are zero together; the branches that cross there are not followed."
    return replace(mark, text=text)


def unexplained(branch: Branch) -> list[str]:
    """Where the number of eigenvalues with a positive real part changes without a special point, in words."""
    special = {mark.point for mark in branch.marks if mark.multiplicity}
    words, last = list[str](), 0
    counts = [point.at.spectrum.unstable for point in branch.points]
    for k, (low, high) in enumerate(counts):
        if low != high:
            continue
        before = counts[last]
        if before[0] == before[1] != low and not special & set(range(last, k + 1)):
            values = [branch.curve.value(branch.points[i].at) for i in (last, k)]
            words.append(
                f"between {values[0]:.9g} and {values[1]:.9g} the number of unstable directions changes from "
                f"{before[0]} to {low} without a special point; try a smaller step"
            )
        last = k
    return words


def _beside(branch: Branch, k: int) -> tuple[Point, Point, Point]:
    """A located point between two others a little away, over which coefficients change smoothly."""
    curve, points = branch.curve, branch.points
    here = points[k]
    found = []
    for other in (points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]):
        apart = abs(other.arclength - here.arclength)
        part = min(1.0, TUNING.displaced * curve.step / apart) if apart else 0.0
        try:
            found.append(curve.between(here, other, part) if part else here)
        except LostError:
            found.append(here)
    return found[0], here, found[1]

"""What happens to the multipliers along a branch: test functions, the count outside the unit circle, and their roots.

A test function changes its sign where an odd number of multipliers passes its critical value. What passes in even
numbers, as it does in symmetric systems, shows in the count alone: there the moduli are followed, in order, each of
which passes 1 once. Every trial between two points is corrected onto the branch by Newton's method, so that a root is
as exact as the multipliers are.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine import shooting as at
from chaosdrill.engine.setup import constrained_states
from chaosdrill.orbits.curve import shares_of
from chaosdrill.orbits.halves import Halves, apart
from chaosdrill.orbits.multipliers import free_multipliers
from chaosdrill.orbits.problem import LostError
from chaosdrill.orbits.roots import bracketed
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.branch import BranchSegment
    from chaosdrill.orbits.curve import Curve
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.points import Point
    from chaosdrill.orbits.problem import Problem


def doubling_test(problem: "Problem", orbit: "Orbit", monodromy: np.ndarray) -> np.ndarray:
    """Function that vanishes where a multiplier is -1: the determinant of M + 1 in the free states."""
    free = np.flatnonzero(constrained_states(problem.plain)[orbit.segments[0, at.SEGMENT_MODE]] == 0)
    return np.linalg.det(monodromy[..., free[:, np.newaxis], free] + np.eye(len(free)))


def torus_test(values: np.ndarray) -> np.ndarray:
    """Function that vanishes where the product of two multipliers is 1: the product of 1 - mu_i mu_j over pairs."""
    m = values.shape[-1]
    first, second = np.triu_indices(m, 1)
    return np.prod(1 - values[..., first] * values[..., second], axis=-1).real


def fold_test(values: np.ndarray, neutral: int) -> np.ndarray:
    """Function that vanishes where a free multiplier is 1: the product of 1 - mu over the free ones.

    It is the symmetric function of that degree of all multipliers, which is exact to round-off also where those that
    are 1 by structure, as many as ``neutral``, cannot be distinguished from one that passes them.
    """
    n = values.shape[-1]
    symmetric = np.zeros((*values.shape[:-1], n + 1), dtype=complex)
    symmetric[..., 0] = 1.0
    for k in range(n):
        symmetric[..., 1 : k + 2] += (1 - values[..., k, np.newaxis]) * symmetric[..., : k + 1]
    return symmetric[..., n - neutral].real


def outside(values: np.ndarray) -> np.ndarray:
    """Number of multipliers outside the unit circle."""
    return np.asarray((np.abs(values) > 1).sum(axis=-1))


def is_paired(values: np.ndarray) -> np.ndarray:
    """Which multipliers belong to a complex pair."""
    return np.asarray(np.abs(values.imag) > TUNING.real * np.abs(values))


def pair_on_circle(values: np.ndarray) -> float:
    """Distance of the nearest complex pair from the unit circle; infinite without a pair."""
    return float(np.abs(np.abs(values[is_paired(values)]) - 1).min(initial=np.inf))


def free_of(segment: "BranchSegment") -> np.ndarray:
    """The multipliers of a segment's orbits without those that are 1 by structure, shape (P, m)."""
    return free_multipliers(segment.spectra.values, segment.curve.problem.neutral.count)


def noise_of(monodromy: np.ndarray, segments: int) -> np.ndarray:
    """Error of the determinants of tangent maps, shape (..., d, d), around orbits with this number of segments."""
    return TUNING.tangent_error * segments * np.maximum(1.0, np.abs(monodromy).max(axis=(-2, -1))) ** 2


def changes(values: np.ndarray, noise: np.ndarray | float = 0.0) -> list[int]:
    """Indices of values before which the sign changes, between values above their errors, shape (m,), only."""
    sure = np.flatnonzero(np.abs(values) > noise)
    found = []
    for before, after in pairwise(sure.tolist()):
        if values[before] * values[after] < 0:
            turned = values[before + 1 : after + 1] * np.sign(values[before]) <= 0
            found.append(before + 1 + int(turned.argmax()))
    return found


@dataclass(frozen=True)
class BranchTest:
    """A function along a branch that changes its sign at special points of one kind.

    ``values``: of a segment of P points, the function at each, shape (P,), and its error there, a number or of that
    shape. ``critical``: of the free multipliers at one point, shape (m,), their distances from the value that one has
    at such a point. ``multiplicity``: of the same, how many are on the unit circle where the function vanishes; 0 if
    nothing happens there. ``crossed``: whether another branch may cross there, so that the equations of the orbit lose
    rank. ``end``: how a branch ends where the function vanishes; by default it goes on. ``watch``: of a curve and its
    first point, what tells, after every further point, the index of the first one beyond, or None. Of a function that
    ends a branch, whose values count beside that of the first point of the segment.
    """

    kind: Special
    values: Callable[["BranchSegment"], tuple[np.ndarray, np.ndarray | float]]
    critical: Callable[[np.ndarray], np.ndarray]
    multiplicity: Callable[[np.ndarray], int] = lambda values: 1
    crossed: bool = False
    end: BranchEnd | None = None
    watch: "Callable[[Curve, Point], Halves] | None" = None

    def at(self, segment: "BranchSegment") -> tuple[np.ndarray, np.ndarray | float]:
        """The function at each point; NaN where it raises an exception, which `Problem.remarks` tells."""
        try:
            return self.values(segment)
        except Exception as failure:
            words = f"the test function of a {self.kind.meaning.replace('_', ' ')} failed: {failure!r:.100}"
            segment.curve.problem.remarks[words] = None
            return np.full(len(segment), np.nan), 0.0


def _noisy(function: Callable[["BranchSegment"], np.ndarray]) -> Callable[["BranchSegment"], tuple]:
    return lambda segment: (function(segment), noise_of(segment.monodromies, len(segment.orbit(0))))


def _products(values: np.ndarray) -> np.ndarray:
    first, second = np.triu_indices(len(values), 1)
    return np.abs(values[first] * values[second] - 1)


def _pair(values: np.ndarray) -> int:
    """2 where a complex pair is on the circle; two real ones with the product 1 are not."""
    return 2 if pair_on_circle(values) <= TUNING.missed_multiplier else 0


def _turning(segment: "BranchSegment") -> tuple[np.ndarray, float]:
    """The parameter's part of the direction.

    Where only the differential of what is conserved is held, as it was at the first orbit, the branch leads from level
    to level, and turns back where that differential vanishes along the family of orbits at one parameter: no two orbits
    of one level meet there.
    """
    way = segment.tangents[:, -1]
    return (np.full(len(segment), np.nan) if len(segment.curve.problem.conserved) else way), 0.0


TESTS = [
    BranchTest(Special.FOLD, _turning, lambda values: np.abs(values - 1), crossed=True),
    BranchTest(
        Special.BRANCH_POINT,
        _noisy(lambda s: fold_test(s.spectra.values, s.curve.problem.neutral.count)),
        lambda values: np.abs(values - 1),
        crossed=True,
    ),
    BranchTest(
        Special.PERIOD_DOUBLING,
        _noisy(lambda s: doubling_test(s.curve.problem, s.orbit(0), s.monodromies)),
        lambda values: np.abs(values + 1),
    ),
    BranchTest(Special.NEIMARK_SACKER, _noisy(lambda s: torus_test(free_of(s))), _products, _pair),
    BranchTest(
        Special.REGULAR, apart, lambda values: np.abs(values - 1), crossed=True, end=BranchEnd.DOUBLING, watch=Halves
    ),
]
"""What is looked for along a branch; more may be appended. Where a branch turns back, that a multiplier passes 1
says no more, and the second is not asked."""


@dataclass(frozen=True)
class Located:
    """A special point between two points of a branch."""

    point: "Point"
    part: float  # of the step between the two
    error: float  # of the parameter
    multiplicity: int  # how many multipliers are on the unit circle there


def steps_with(segment: "BranchSegment") -> list[int]:
    """Indices of points before which something happens."""
    if len(segment) < 2:
        return []
    found = {k for _, steps in _signs(segment) for k in steps}
    counts = _counts(segment)
    sure = np.flatnonzero(counts >= 0)
    for before, after in pairwise(sure.tolist()):
        if counts[before] != counts[after] and not found & set(range(before + 1, after + 1)):
            now = outside(free_of(segment.with_points(segment.points[before : after + 1])))
            found.add(before + int((now != now[0]).argmax()))
        elif abs(counts[after] - counts[before]) > 1:
            found.add(after)
    return sorted(found)


def _signs(segment: "BranchSegment") -> list[tuple[BranchTest, list[int]]]:
    """Where each test function changes its sign.

    Where the branch turns back, that a multiplier passes 1 says no more.
    """
    found = [(test, changes(*test.at(segment))) for test in TESTS if test.end is None]
    turned = {k for test, steps in found if test.kind == Special.FOLD for k in steps}
    return [(test, [k for k in steps if test.kind != Special.BRANCH_POINT or k not in turned]) for test, steps in found]


def _counts(segment: "BranchSegment") -> np.ndarray:
    """Number of multipliers outside the unit circle, shape (P,); -1 where one is too near to it to tell."""
    unknown = segment.spectra.unknown(segment.curve.problem.neutral.count)
    return np.where(unknown, -1, outside(free_of(segment)))


def unexplained(segment: "BranchSegment", multiplicities: dict[int, int]) -> tuple[int, int, int, int] | None:
    """The first two points between which the count changes more than special points between them explain.

    ``multiplicities``: of the special points, by their index.

    Returns the two points and the counts at them, or None.
    """
    counts = _counts(segment)
    for k in multiplicities:
        counts[k] = -1
    sure = np.flatnonzero(counts >= 0)
    for before, after in pairwise(sure.tolist()):
        most = sum(multiplicities.get(k, 0) for k in range(before + 1, after))
        if abs(counts[after] - counts[before]) > most:
            return before, after, int(counts[before]), int(counts[after])
    return None


def located(pair: "BranchSegment") -> list[Located]:
    """The special points between two neighbours of a branch, in order.

    What looks like a fold may turn out to be a point at which branches cross, and what looks like a pair of multipliers
    on the unit circle to be a regular point.

    Raises `LostError` if no orbit was found on the way, or it has no such multiplier.
    """
    step = _Step(pair)
    return [step.whole(one) for one in _found(step, pair)]


def _found(step: "_Step", pair: "BranchSegment") -> list[Located]:
    found = [one for test, steps in _signs(pair) if steps and (one := step.located(test)) is not None]
    found.sort(key=lambda one: one.part)
    begin, end = outside(free_of(pair))
    if len(found) < 2:
        jumped = int(abs(end - begin))
        turned = {Special.FOLD, Special.BRANCH_POINT}
        if found and (jumped == found[0].multiplicity or (not jumped and found[0].point.special in turned)):
            return found
        return found if not found and not jumped else step.crossed()
    # each for itself
    between = [step.point(0.5 * (one.part + other.part), True) for one, other in pairwise(found)]
    counts = outside(free_of(pair.with_points([pair.points[0], *between, pair.points[1]])))
    if all(abs(b - a) == one.multiplicity for one, (a, b) in zip(found, pairwise(counts.tolist()), strict=True)):
        return found
    if begin == end:
        return found
    return step.crossed()


def ended(segment: "BranchSegment", end: BranchEnd) -> tuple["BranchSegment", Located | None]:
    """A segment whose last point lies beyond the root of a test function that ends it, up to that root.

    Where no orbit is found on the way, up to the point before.
    """
    found = None
    for test in TESTS:
        if test.end == end:
            with suppress(LostError):
                found = _Step(segment.with_points(segment.points[-2:])).located(test)
    return segment.with_points([*segment.points[:-1], *([] if found is None else [found.point])]), found


class _Step:
    """The branch between two neighbouring points."""

    def __init__(self, pair: "BranchSegment") -> None:
        self.pair, self.curve = pair, pair.curve
        self.before, self.after = pair.points
        self.points: dict[float, Point] = {0.0: self.before, 1.0: self.after}
        self.held = bool(len(self.curve.problem.conserved))
        """Whether a differential is held: folds on a level of what is conserved are on the branch, which goes on."""

    def point(self, part: float, singular: bool) -> "Point":
        """The point at a part of the step."""
        if part not in self.points:
            try:
                self.points[part] = self.curve.between(self.before, self.after, part)
            except LostError:
                # where branches cross the equations are singular, and on a straight branch exactly so
                orbit = self.before.orbit.between(self.after.orbit, part)
                shot = self.curve.problem.shoot(orbit)
                if not singular or not shot.residual < TUNING.straight:
                    raise
                length = self.before.arclength + part * (self.after.arclength - self.before.arclength)
                self.points[part] = replace(self.before, orbit=orbit, shot=shot.bare(), arclength=length)
        return self.points[part]

    def located(self, test: BranchTest) -> Located | None:
        """Where a test function vanishes; None if nothing happens there.

        Raises `LostError`.
        """

        def value(part: float) -> float:
            return there(part)[0]

        def there(part: float) -> tuple[float, float]:
            beside = [] if test.end is None else [self.before]
            values, noise = test.at(self.pair.with_points([*beside, self.point(part, test.crossed)]))
            if not np.isfinite(values[-1]):
                raise LostError("the function has no value on the way")
            return float(values[-1]), float(np.broadcast_to(noise, len(values))[-1])

        low, high = value(0.0), value(1.0)
        if low * high > 0:
            raise LostError("the function has one sign at both ends")
        part, rise = bracketed(value, 0.0, 1.0), abs(high - low)
        point = self.points[part]
        free = free_of(self.pair.with_points([point]))[0]
        missed = test.critical(free).min(initial=np.inf)
        if abs(value(part)) > TUNING.jump * max(abs(low), abs(high)) or missed > TUNING.missed_multiplier:
            # beside the root Newton's method may lead to the branch that crosses there, and directions to either
            beside = self._beside(low / (low - high), value, rise) if test.crossed else None
            if beside is None or self.before.root is not None or (test.end is None and not self._loses(beside.point)):
                raise LostError("the function jumps")
            kind = test.kind if test.end is not None else Special.BRANCH_POINT
            return self._marked(beside.part, kind, 0.0, rise, 1, beside)
        kind, multiplicity = test.kind, test.multiplicity(free)
        if not multiplicity:
            return None
        sharp = None
        if test.crossed and test.end is None and (kind == Special.FOLD or self.held):
            crosses, sharp = self._crossing(part, value, rise)
            kind = Special.BRANCH_POINT if crosses else Special.FOLD
        # on a curve of special points its root would be needed as well
        elif kind == Special.BRANCH_POINT or (test.end is not None and self.before.root is None):
            sharp = self._sharp(part, value, rise)
        return self._marked(part, kind, there(part)[1], rise, multiplicity, sharp)

    def whole(self, one: Located) -> Located:
        """A point with all multipliers that are at the critical value there, also those that come back from it.

        The lowest coefficients of the characteristic polynomial about that value vanish; they are as smooth as the
        tangent map. Where areas are preserved a multiplier and its inverse are there together, and the count sees one.
        """
        place = {Special.FOLD: 1.0, Special.PERIOD_DOUBLING: -1.0}.get(one.point.special)
        if place is None or self.held:
            return one
        points = [self.before, one.point, self.after]
        ends = free_of(self.pair.with_points(points))
        first, there, last = (np.poly(values - place).real[::-1] for values in ends)
        noise = noise_of(one.point.shot.monodromy, len(one.point.orbit)) + TUNING.same_crossing * np.abs(last - first)
        zeros = np.abs(there) <= noise
        return replace(one, multiplicity=max(one.multiplicity, int(zeros.argmin())))

    def crossed(self) -> list[Located]:
        """Where the moduli pass 1, each in its place; those that do so together are one point.

        Raises `LostError`.
        """
        ends = outside(free_of(self.pair))
        places = range(int(ends.min()), int(ends.max()))
        found: list[tuple[float, int]] = []
        for place in places:

            def one(part: float, place: int = place) -> float:
                return self._size(part, place, place + 1)

            part = bracketed(one, 0.0, 1.0)
            if abs(one(part)) > TUNING.missed_multiplier:
                raise LostError("a modulus jumps")
            found.append((part, place))
        marks: list[Located] = []
        turned = self.before.tangent.change[-1] * self.after.tangent.change[-1] < 0
        for group in _together(found):
            part, count = group[0][0], len(group)
            point = self.points[part]
            noise = TUNING.tangent_error * len(point.orbit) * max(1.0, float(np.abs(point.shot.monodromy).max()))
            first, last = min(place for _, place in group), 1 + max(place for _, place in group)

            def size(part: float, first: int = first, last: int = last) -> float:
                return self._size(part, first, last)

            rise = abs(size(1.0) - size(0.0)) / count
            noise += rise * (group[-1][0] - part)
            for kind, number in _kinds(free_of(self.pair.with_points([point]))[0], count):
                crosses, sharp = not turned, None
                if kind == Special.BRANCH_POINT and not turned and self.held:
                    crosses, sharp = self._crossing(part, size, rise)
                elif kind == Special.BRANCH_POINT and not turned:
                    sharp = self._sharp(part, size, rise)
                if kind == Special.BRANCH_POINT and not crosses:
                    kind = Special.FOLD
                marks.append(self._marked(part, kind, noise, rise, number, sharp))
        return sorted(marks, key=lambda one: one.part)

    def _size(self, part: float, first: int, last: int) -> float:
        """Logarithm of the product of some moduli, the largest first."""
        moduli = np.sort(np.abs(free_of(self.pair.with_points([self.point(part, True)]))[0]))[::-1]
        return float(np.log(np.maximum(moduli[first:last], 1e-300)).sum())

    def _crossing(self, part: float, value: Callable[[float], float], rise: float) -> "tuple[bool, Sharp | None]":
        """Whether another branch crosses where a function vanishes, and the point there, as in `_sharp`.

        There an orbit is known to the root of its residual only, so that its equations may keep some rank.
        """
        loses = self._loses(self.points[part])
        if self._keeps_side(part) or not (loses or self._loses(self.points[part], TUNING.hardly_singular)):
            return False, None
        sharp = self._sharp(part, value, rise)
        crosses = loses or (sharp is not None and self._loses(sharp.point))
        return crosses, sharp if crosses else None

    def _keeps_side(self, part: float) -> bool:
        """Whether one multiplier alone is 1, and the equations with the direction keep the sign of their determinant.

        That changes where another branch crosses. A sharp fold almost loses rank as well.
        """
        problem, values = self.curve.problem, free_of(self.pair.with_points([self.points[part]]))[0]
        if (np.abs(values - 1) <= TUNING.missed_multiplier).sum() > 1:
            return False
        return bool(np.prod([problem.side(p.orbit, p.tangent.row, p.weights) for p in self.pair.points]) > 0)

    def _loses(self, there: "Point", rank: float = TUNING.singular) -> bool:
        """Whether the equations lose rank at a point, unlike at its neighbours, of which one may lie there as well."""
        problem, weights = self.curve.problem, self.before.weights
        ways = [abs(p.arclength - there.arclength) for p in (self.before, self.after)]
        apart = [p for p, way in zip(self.pair.points, ways, strict=True) if way >= TUNING.singular * max(ways)]
        here, *beside = (problem.regularity(p.orbit, problem.shoot(p.orbit, False), weights) for p in (there, *apart))
        return here < rank * min(beside)

    def _beside(self, part: float, value: Callable[[float], float], rise: float) -> "Sharp | None":
        """Where a function vanishes as points away from there tell, from the part at which a straight one would."""
        found = None
        for _ in range(2):
            sharp = self._sharp(part, value, rise)
            if sharp is None or not 0 <= sharp.part <= 1 or sharp.off > TUNING.jump:
                return found
            found, part = sharp, sharp.part
        return found

    def _sharp(self, part: float, value: Callable[[float], float], rise: float) -> "Sharp | None":
        """Where a function vanishes next to a root found where branches cross, and the point there, from points beside.

        At the crossing the equations are singular, and an orbit is known to the root of its residual only. Beside it
        it is known the better the further off it is, as the polynomial through such points is the worse.
        """
        count, best = TUNING.sharp_nodes, None
        nodes = np.cos(np.pi * (np.arange(count) + 0.5) / count)
        way = max(self._way, 1e-300)
        for reach in TUNING.sharp_reaches:
            parts = part + reach * nodes
            try:
                points = [self.point(float(one), False) for one in parts]
                values = np.array([value(float(one)) for one in parts])
                along, aside = np.array([self.curve.errors_at(one) for one in points]).T
                errors = rise * along / way
            except LostError:
                continue
            errors += [TUNING.tangent_error * max(1.0, float(np.abs(p.shot.monodromy).max())) for p in points]
            roots = [_root(parts, values, degree, part) for degree in (count - 3, count - 1)]
            if roots[0] is None or roots[1] is None:
                continue
            slope = (values[0] - values[-1]) / (parts[0] - parts[-1])
            there = roots[1]
            shares = np.abs(shares_of(parts, there, 0))
            off = abs(there - roots[0]) + float(shares @ errors / max(abs(slope), 1e-300))
            error = off * self._way + float(shares @ aside)
            if best is None or error < best.error:
                orbit = self.curve.interpolated([p.orbit for p in points], parts, there, self.before.orbit)
                shot = self.curve.problem.shoot(orbit)
                length = self.before.arclength + there * (self.after.arclength - self.before.arclength)
                best = Sharp(replace(self.before, orbit=orbit, shot=shot.bare(), arclength=length), there, off, error)
        return best

    @property
    def _way(self) -> float:
        """How far the parameter changes over the step."""
        return abs(float(self.curve.values(self.after.orbit)[-1] - self.curve.values(self.before.orbit)[-1]))

    def _marked(
        self, part: float, kind: Special, noise: float, rise: float, multiplicity: int, sharp: "Sharp | None" = None
    ) -> Located:
        """The point with the error of its parameter, from that of a function which rises by so much over the step."""
        curve, scale = self.curve, self.curve.problem.accuracy
        if sharp is not None:
            error = sharp.error + scale * curve.size(sharp.point.orbit)
            return Located(replace(sharp.point, special=kind), sharp.part, float(error), multiplicity)
        point = self.points[part]
        size = curve.size(point.orbit)
        error = scale * size
        if kind == Special.BRANCH_POINT:
            # the equations vanish there to second order across, so that the orbit is known to the root of its residual
            error = 3 * scale**0.5 * size
        elif kind != Special.FOLD or self.held:
            error += noise * scale / TUNING.tangent_error * max(self._way, 1e-300) / rise
        if kind != Special.BRANCH_POINT:
            error += curve.error_at(point)
        return Located(replace(point, special=kind), part, float(error), multiplicity)


@dataclass(frozen=True)
class Sharp:
    """A point at which branches cross, as points beside it tell."""

    point: "Point"
    part: float  # of the step
    off: float  # error of that part
    error: float  # of the parameter


def _root(places: np.ndarray, values: np.ndarray, degree: int, near: float) -> float | None:
    """The root of a polynomial through values, or near them, that is nearest to a place; None if none is real."""
    fitted = np.polynomial.Chebyshev.fit(places, values, degree)
    roots = fitted.roots()
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real - near) < np.ptp(places) / 2)]
    return float(real[np.abs(real - near).argmin()]) if len(real) else None


def _together(found: Sequence[tuple[float, int]]) -> list[list[tuple[float, int]]]:
    """Crossings at one place of a step: those that are no further apart than round-off may put them."""
    groups: list[list[tuple[float, int]]] = []
    for one in sorted(found):
        if groups and one[0] - groups[-1][-1][0] < TUNING.same_crossing:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def _kinds(values: np.ndarray, count: int) -> Iterator[tuple[Special, int]]:
    """Kinds of bifurcation where ``count`` multipliers are on the unit circle, and how many of them take part."""
    critical = values[np.abs(np.abs(values) - 1).argsort(kind="stable")[:count]]
    paired = is_paired(critical)
    for kind, those in (
        (Special.BRANCH_POINT, ~paired & (critical.real > 0)),
        (Special.PERIOD_DOUBLING, ~paired & (critical.real < 0)),
        (Special.NEIMARK_SACKER, paired),
    ):
        if those.any():
            yield kind, int(those.sum())

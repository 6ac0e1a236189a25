"""Where a function of the orbit takes a value along a branch or curve, or is largest or smallest; curves of these.

Every trial is corrected onto the branch by Newton's method, as those of other special points are. Followed over two
parameters, a value is a constraint, and its optima along that curve are those under the constraint; along a curve of
optima an optimum is one in both parameters. Optimisation by continuation in this way: Doedel, Keller and Kernevez
1991, doi:10.1142/S0218127491000555.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.orbits.codimension_two import Located, insert
from chaosdrill.orbits.crossings import changes
from chaosdrill.orbits.functions import Functions, Wanted
from chaosdrill.orbits.points import Candidate, plane_at
from chaosdrill.orbits.problem import CONVERGED, LostError
from chaosdrill.orbits.roots import bracketed
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.branch import Branch, BranchSegment
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.points import Point
    from chaosdrill.orbits.problem import Shot


@dataclass(frozen=True)
class Holding:
    """A function of the orbit has a value."""

    functions: Functions
    index: int
    held: float
    kind = Special.LEVEL
    margin = 0.0

    def value(self, candidate: Candidate) -> tuple[float, float]:
        return self.functions.at(self.index, candidate.problem, candidate.orbit) - self.held, candidate.tracked


@dataclass(frozen=True)
class Extremal:
    """A function of the orbit does not change to first order with the first parameter, the second held."""

    functions: Functions
    index: int
    kind = Special.OPTIMUM
    margin = 0.0

    def value(self, candidate: Candidate) -> tuple[float, float]:
        problem, orbit, shot = candidate.problem, candidate.orbit, candidate.shot
        here = plane_at(problem, orbit, shot, candidate.plane.weights, candidate.plane)
        ahead = here.direction(np.array([here.rows[1, -1], -here.rows[0, -1]]))
        conditions, step = np.vstack([ahead.row, np.eye(len(ahead.row))[-1]]), TUNING.function_step
        found = []
        for steps in (-2, -1, 1, 2):
            guess = problem.moved(orbit, shot, steps * step * ahead.change)
            code, beside, _, _ = problem.newton(guess, conditions, TUNING.farthest, here.weights, orbit)
            if code != CONVERGED:
                raise LostError("no orbit beside the optimum")
            found.append(self.functions.at(self.index, problem, beside))
        return float(np.array([1, -8, 8, -1]) @ found) / (12 * step), candidate.tracked


def first_test(wanted: Wanted, kind: Special) -> Holding | Extremal:
    """The test function of the first value, or of the first optimum."""
    if kind == Special.LEVEL:
        name, values = next(iter(wanted.levels.items()))
        return Holding(wanted.functions, wanted.functions.names.index(name), values[0])
    return Extremal(wanted.functions, wanted.functions.names.index(wanted.optima[0]))


def mark_functions(branch: "Branch", wanted: Wanted) -> list[str]:
    """Insert the points of a branch at which its functions take values or are largest or smallest, and mark them.

    Returns: what was seen and not located, in words.
    """
    missing: list[str] = []
    names = wanted.functions.names
    for number, segment in enumerate(branch.segments):
        if len(segment) < 2:
            continue
        values, errors = wanted.functions(segment.curve.problem, *_seen(segment.points))
        found: list[tuple[float, Located, str]] = []
        for name, wished in wanted.levels.items():
            k = names.index(name)
            for value in wished:
                if segment.curve.kind != Special.LEVEL or name != next(iter(wanted.levels)):
                    found += _levels(segment, wanted.functions, k, value, values[:, k], errors[:, k], missing)
        for name in wanted.optima:
            k = names.index(name)
            found += _optima(segment, wanted.functions, k, values[:, k], errors[:, k], missing)
        for _, one, text in sorted(found, key=lambda entry: entry[0], reverse=True):
            place = int(np.searchsorted(branch.segments[number].arclengths, one.point.arclength))
            insert(branch, number, place, one, text)
    return missing


def _levels(
    segment: "BranchSegment",
    functions: Functions,
    index: int,
    value: float,
    values: np.ndarray,
    errors: np.ndarray,
    missing: list[str],
) -> list[tuple[float, Located, str]]:
    """Where a function takes a value along a segment."""
    curve, name = segment.curve, functions.functions[index].name
    found = []
    for k in changes(values - value, errors):
        before, after = segment.points[k - 1 : k + 1]
        tried: dict[float, Point] = {0.0: before, 1.0: after}

        def off(part: float, before: "Point" = before, after: "Point" = after, tried: dict = tried) -> float:
            if part not in tried:
                tried[part] = curve.between(before, after, part)
            found = functions.at(index, curve.problem, tried[part].orbit) - value
            if not np.isfinite(found):
                raise LostError(f"{name} has no value on the way")
            return found

        try:
            part = bracketed(off, 0.0, 1.0)
            left = abs(off(part))
        except LostError:
            missing.append(f"where {name} = {value:g} near {_place(segment, k)} was not located")
            continue
        low, high = values[k - 1] - value, values[k] - value
        if left > TUNING.jump * max(abs(low), abs(high)):
            continue
        point = tried[part]
        way = abs(float(curve.values(after.orbit)[0] - curve.values(before.orbit)[0]))
        own = float(functions(curve.problem, *_seen([point]))[1][0, index]) + left
        error = curve.problem.accuracy * curve.size(point.orbit) + curve.error_at(point) + own * way / abs(high - low)
        located = Located(replace(point, special=Special.LEVEL), part, float(error), 0)
        found.append((point.arclength, located, f"{name} = {value:.9g}"))
    return found


def _optima(
    segment: "BranchSegment",
    functions: Functions,
    index: int,
    values: np.ndarray,
    errors: np.ndarray,
    missing: list[str],
) -> list[tuple[float, Located, str]]:
    """Where a function is largest or smallest along a segment, smoothly."""
    curve, name = segment.curve, functions.functions[index].name
    steps = np.diff(values)
    sure = np.flatnonzero(np.abs(steps) > 2 * (errors[1:] + errors[:-1]))
    found = []
    for a, b in zip(sure[:-1].tolist(), sure[1:].tolist(), strict=True):
        if not steps[a] * steps[b] < 0:
            continue
        before, after = segment.points[a], segment.points[b + 1]
        try:
            one = _top(segment, functions, index, before, after)
        except LostError:
            one = None
        kind = "maximum" if steps[a] > 0 else "minimum"
        if one is None:
            missing.append(f"a {kind} of {name} near {_place(segment, b)} was not located")
            continue
        value = functions.at(index, curve.problem, one.point.orbit)
        found.append((one.point.arclength, one, f"{name} has a {kind} of {value:.9g}"))
    return found


def _top(segment: "BranchSegment", functions: Functions, index: int, before: "Point", after: "Point") -> Located | None:
    """The optimum between two points by the polynomial through values between them; None where it is no smooth one.

    Its error is how far that of a polynomial of two degrees less is away, and what errors of the values make of it.
    """
    curve, count = segment.curve, TUNING.function_nodes
    parts = (1 - np.cos(np.pi * np.arange(count) / (count - 1))) / 2
    points = [before, *(curve.between(before, after, float(part)) for part in parts[1:-1]), after]
    values, errors = functions(curve.problem, *_seen(points))
    places = []
    for degree in (count - 3, count - 1):
        fitted = np.polynomial.Chebyshev.fit(parts, values[:, index], degree, domain=[0.0, 1.0])
        roots = fitted.deriv().roots()
        real = np.sort(roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0) & (roots.real < 1)])
        if len(real) != 1:
            return None
        places.append(float(real[0]))
    part, bend = places[1], abs(float(fitted.deriv(2)(places[1])))
    noise = 2 * count * float(errors[:, index].max())
    if not bend * max(part, 1 - part) > noise:
        return None
    off = abs(places[1] - places[0]) + noise / bend
    point = curve.between(before, after, part)
    # two steps may bend: what the parameter does over the error is taken at the point
    beside = curve.between(before, after, part + (1e-3 if part < 0.5 else -1e-3))
    slope = abs(float(curve.values(beside.orbit)[0] - curve.values(point.orbit)[0])) / 1e-3
    error = curve.problem.accuracy * curve.size(point.orbit) + curve.error_at(point) + off * slope
    return Located(replace(point, special=Special.OPTIMUM), part, float(error), 0)


def _seen(points: "Sequence[Point]") -> tuple[list["Orbit"], list["Shot"]]:
    return [p.orbit for p in points], [p.shot for p in points]


def _place(segment: "BranchSegment", k: int) -> str:
    named = zip(segment.curve.problem.free, segment.values[k], strict=True)
    return ", ".join(f"{name} = {value:.9g}" for name, value in named)

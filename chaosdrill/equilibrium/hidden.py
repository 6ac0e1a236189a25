"""Eigenvalues that are on the other side of the imaginary axis between two points of a branch than at either."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg
from scipy.optimize import linear_sum_assignment

from chaosdrill.codegen.layout import UNIT
from chaosdrill.equilibrium.curve import Curve, LostError, Point
from chaosdrill.equilibrium.points import similar
from chaosdrill.equilibrium.tuning import TUNING


@dataclass(frozen=True)
class _Moving:
    """A point with its eigenvalues, of a pair the one that turns forward, and their rates along the branch."""

    point: Point
    values: np.ndarray  # complex (k,)
    rates: np.ndarray  # complex (k,)

    @property
    def real(self) -> int:
        """How many of the eigenvalues are real."""
        return int((self.values.imag == 0).sum())


def _moving(curve: Curve, point: Point) -> _Moving:
    numbers, way = point.at.numbers, UNIT ** (1 / 3)
    sides = []
    for sign in (1, -1):
        moved = numbers.copy()
        moved[curve.places] += sign * way * curve.weights(point.at) * point.tangent
        sides.append(curve.field.jacobian(moved))
    change = (sides[0] - sides[1]) / (2 * way)
    balanced, scale = similar(curve.field.jacobian(numbers))
    values, left, right = scipy.linalg.eig(balanced, left=True)
    change = np.nan_to_num(change * scale / scale[:, np.newaxis])
    with np.errstate(divide="ignore", invalid="ignore"):
        rates = np.einsum("ik,ij,jk->k", left.conj(), change, right) / np.einsum("ik,ik->k", left.conj(), right)
    upper = values.imag >= 0
    return _Moving(point, values[upper], np.nan_to_num(rates[upper], posinf=0.0, neginf=0.0))


def refined(curve: Curve, points: list[Point]) -> list[Point]:
    """The points, with others where an eigenvalue is on the other side of the axis between neighbours.

    Two crossings within one step, there and back or of two eigenvalues that go opposite ways, leave the count as it is.
    """
    moving = [_moving(curve, point) for point in points]
    found = points[:1]
    for first, last in pairwise(moving):
        found += [*_hidden(curve, first, last, TUNING.halvings), last.point]
    return found


def _hidden(curve: Curve, first: _Moving, last: _Moving, halvings: int) -> list[Point]:
    """Points between two neighbours at which the number of unstable eigenvalues is not explained by that at the two."""
    part = _suspected(first, last)
    if part is None or not halvings:
        return []
    try:
        middle = _moving(curve, curve.between(first.point, last.point, part))
    except LostError:
        return []
    count = middle.point.at.spectrum.unstable
    counts = {end.point.at.spectrum.unstable for end in (first, last)}
    here = [middle.point] if count[0] == count[1] and count not in counts else []
    return [*_hidden(curve, first, middle, halvings - 1), *here, *_hidden(curve, middle, last, halvings - 1)]


def _suspected(first: _Moving, last: _Moving) -> float | None:
    """At which part of a step eigenvalues may be on the other side of the axis than its ends tell."""
    if first.real != last.real:
        # two of them meet on the way, and are followed on either side of that place
        near = min(float(np.abs(one.values.real).min(initial=np.inf)) for one in (first, last))
        far = max(float(np.abs(one.rates).max(initial=0.0)) for one in (first, last))
        return 0.5 if near <= far * (last.point.arclength - first.point.arclength) else None
    h = last.point.arclength - first.point.arclength
    ahead, back = first.values + first.rates * h / 2, last.values - last.rates * h / 2
    rows, columns = linear_sum_assignment(np.abs(ahead[:, np.newaxis] - back))
    crossings = []
    for a, b in zip(rows.tolist(), columns.tolist(), strict=True):
        low, high = float(first.values[a].real), float(last.values[b].real)
        rise, end = float(first.rates[a].real) * h, float(last.rates[b].real) * h
        if low * high < 0:
            crossings.append((low / (low - high), 1 if high > 0 else -1))
            continue
        sign = 1.0 if low + high > 0 else -1.0
        # a convex function lies above its tangents, which meet below zero if it may
        if sign * rise < 0 < sign * end:
            meet = (high - end - low) / (rise - end)
            if 0 < meet < 1 and sign * (low + rise * meet) <= 0:
                return _lowest(sign * low, sign * high, sign * rise, sign * end)
    ways = {way for _, way in crossings}
    if len(ways) < 2:
        return None
    up, down = (min(part for part, way in crossings if way == one) for one in (1, -1))
    return min(max((up + down) / 2, 0.05), 0.95)


def _lowest(low: float, high: float, rise: float, end: float) -> float:
    """Where the cubic with these values and slopes at 0 and 1 is smallest, not too near to either."""
    slope = [3 * (rise + end - 2 * (high - low)), 2 * (3 * (high - low) - 2 * rise - end), rise]
    roots = [float(one.real) for one in np.roots(slope) if abs(one.imag) < 1e-9 and 0 < one.real < 1]
    cubic = np.polynomial.Polynomial([low, rise, slope[1] / 2, slope[0] / 3])
    return min(max(min(roots, key=lambda one: float(cubic(one)), default=0.5), 0.05), 0.95)

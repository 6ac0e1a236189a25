"""Impact oscillator with its wall at the rest position: every orbit from the exact flow between impacts.

    x'' + x = cos(w t),  x <= 0;   at x = 0: v := -r v

With the forced part p(t) = cos(w t)/(1 - w^2) a flight from an impact at t0 to the next at t1, h = t1 - t0, is

    x(t) = p(t) - p(t0) cos(t - t0) + B sin(t - t0),   B = [p(t0) cos h - p(t1)]/sin h,

so that only the times of the impacts remain unknown, and the law v+ = -r v- at each of them is an equation between
three successive times. Linearised, these are a recursion of second order; its product over an orbit is the monodromy
matrix in other coordinates. Everything is evaluated by mpmath at its working precision.

Source: Shaw and Holmes 1983, doi:10.1016/0022-460X(83)90407-8; the closed forms of `period_one` follow by putting
t1 = t0 + 2 pi n/w and adding and subtracting the two equations for the speeds.
"""

from dataclasses import dataclass
from typing import Any

import mpmath
from mpmath import mp


@dataclass(frozen=True)
class PeriodOne:
    """The orbit with one impact in n forcing periods; phase w t of the impact in [0, 2 pi), speed before it."""

    phase: Any
    speed: Any
    trace: Any
    determinant: Any


def period_one(w: Any, r: Any, n: int = 1) -> PeriodOne:
    """Closed form; whether the flight stays below the wall is another question."""
    w, r = mp.mpf(w), mp.mpf(r)
    half, c = mp.pi * n / w, mp.cos(2 * mp.pi * n / w)
    sine, cosine = -(1 - r) * (1 - w**2) / (2 * w), (1 + r) * (1 - w**2) / (2 * mp.tan(half))
    speed = 1 / mp.hypot(sine, cosine)
    phase = mp.atan2(sine, cosine) % (2 * mp.pi)
    return PeriodOne(phase, speed, -2 * r * c + (1 + r) ** 2 * (1 - w**2) * (1 + c) / 2, r**2)


def doubling(r: Any, guess: Any, n: int = 1) -> Any:
    """The frequency next to ``guess`` at which that orbit has the multiplier -1."""
    q = (1 - mp.mpf(r)) / (1 + mp.mpf(r))
    return mp.findroot(lambda w: mp.cos(mp.pi * n / w) ** 2 * (w**2 - q**2) - 1, mp.mpf(guess))


def _forced(w: Any, t: Any) -> tuple[Any, Any, Any]:
    k = 1 / (1 - w**2)
    return k * mp.cos(w * t), -k * w * mp.sin(w * t), -k * w**2 * mp.cos(w * t)


class Flight:
    """Flight between impacts at ``t0`` and ``t1``: speeds ``start`` and ``end``, their derivatives by both times."""

    def __init__(self, w: Any, t0: Any, t1: Any) -> None:
        (p0, s0, a0), (p1, s1, a1) = _forced(w, t0), _forced(w, t1)
        c, s = mp.cos(t1 - t0), mp.sin(t1 - t0)
        free = (p0 * c - p1) / s
        free_0 = (s0 * c + p0 * s) / s + free * c / s
        free_1 = -(p0 * s + s1) / s - free * c / s
        self.start, self.end = s0 + free, s1 + p0 * s + free * c
        self.start_0, self.start_1 = a0 + free_0, free_1
        self.end_0 = s0 * s - p0 * c + free * s + c * free_0
        self.end_1 = a1 + p0 * c - free * s + c * free_1


Row = tuple[Any, Any, Any]


@dataclass(frozen=True)
class Orbit:
    """A closed sequence of impacts.

    Attributes
    ----------
    times : list of mpf
        Of the impacts in one cycle of ``periods`` forcing periods.
    rows : list of tuple
        Derivatives of the impact law, as from `impact_law`.
    """

    w: Any
    r: Any
    periods: int
    times: list[Any]
    rows: list[Row]

    @property
    def monodromy(self) -> mpmath.matrix:
        """How moved times of two successive impacts come back a cycle later; its determinant is r^(2 impacts)."""
        product = mpmath.eye(2)
        for before, here, after in self.rows:
            product = mpmath.matrix([[0, 1], [-before / after, -here / after]]) * product
        return product

    @property
    def doubling_gap(self) -> Any:
        """det(monodromy + 1), zero where the orbit doubles."""
        return mpmath.det(self.monodromy + mpmath.eye(2))


def flights_of(w: Any, times: list[Any], periods: int) -> list[Flight]:
    """Flights from each impact to the next, the last one into the next cycle."""
    ends = [*times[1:], times[0] + 2 * mp.pi / w * periods]
    return [Flight(w, t0, t1) for t0, t1 in zip(times, ends, strict=True)]


def impact_law(flights: list[Flight], r: Any) -> tuple[list[Any], list[Row]]:
    """v+ + r v- at every impact, and its derivatives by the times of the impact before, of this one and of the next."""
    pairs = [(flights[i - 1], flight) for i, flight in enumerate(flights)]
    law = [after.start + r * before.end for before, after in pairs]
    return law, [(r * before.end_0, after.start_0 + r * before.end_1, after.start_1) for before, after in pairs]


def cyclic(rows: list[Row]) -> mpmath.matrix:
    """The matrix of these rows."""
    size = len(rows)
    matrix = mpmath.zeros(size)
    for i, row in enumerate(rows):
        for j, value in zip((i - 1, i, i + 1), row, strict=True):
            matrix[i, j % size] += value
    return matrix


def orbit(w: Any, r: Any, times: list[Any], periods: int) -> Orbit:
    """Newton's method on the times of the impacts, from guesses ``times`` of one cycle, in order."""
    w, r, times = mp.mpf(w), mp.mpf(r), [mp.mpf(t) for t in times]
    for _ in range(40):
        flights = flights_of(w, times, periods)
        law, rows = impact_law(flights, r)
        if max(abs(value) for value in law) < mp.eps * 1e6:
            return Orbit(w, r, periods, times, rows)
        step = mpmath.lu_solve(cyclic(rows), mpmath.matrix(law))
        times = [t - d for t, d in zip(times, step, strict=True)]
    raise ArithmeticError("Newton's method does not converge")

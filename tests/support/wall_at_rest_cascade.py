"""The cascade of the impact oscillator with its wall at rest: from each period doubling to the next, by itself.

A doubled orbit near its birth is the old one run twice, moved by +-a along the direction that the monodromy reverses.
The amplitude a then serves as the parameter and the frequency is an unknown, so that Newton's method cannot fall back
onto the old orbit.
"""

from typing import Any

import mpmath
from mpmath import mp

from support.wall_at_rest import Orbit, cyclic, doubling, flights_of, impact_law, orbit, period_one

R = "0.8"

DOUBLINGS = (
    "2.653347727855322934164893",
    "2.71598725143876471717320460",
    "2.72911791816051833199700858",
    "2.73136381616993382217786465",
    "2.73183412223483747960824926",
    "2.73193506093164719745329036",
    "2.73195670895238468396593002",
)
"""Frequencies at which the orbits of 1, 2, 4, ..., 64 impacts double, r = 0.8; computed with 45 digits.

Every doubled orbit exists and is stable above its birth. No orbit of the cascade grazes: the slowest impact has the
speed 0.375, and no flight has a maximum.
"""

RATIOS = (4.770475476, 5.846510690, 4.775396656, 4.659323726, 4.662721735)
"""Quotients of successive intervals between them; the limit is Feigenbaum's 4.669201609."""


def doublings(count: int, r: Any = R, guess: float = 2.65) -> list[Orbit]:
    """The orbits at the first ``count`` doublings, beginning with that of the orbit with one impact a period."""
    r = mp.mpf(r)
    w = doubling(r, guess)
    found = [orbit(w, r, [period_one(w, r).phase / w], 1)]
    amplitude = mp.mpf("0.01")
    while len(found) < count:
        found.append(_next_doubling(found[-1], amplitude))
        amplitude = amplitude / mp.mpf("2.5")
    return found


def _next_doubling(old: Orbit, amplitude: Any) -> Orbit:
    """Follow the doubled orbit with growing amplitude until it doubles, then find that amplitude."""
    cycle = 2 * mp.pi / old.w * old.periods
    base, flip = [*old.times, *(t + cycle for t in old.times)], _reversed(old)
    grown = [t + amplitude * f for t, f in zip(base, flip, strict=True)]
    there = _at_amplitude(old, base, flip, amplitude, grown, old.w)
    a, gap_a = amplitude, there.doubling_gap
    while True:
        b = 3 * a / 2
        grown = [t + (b - a) * f for t, f in zip(there.times, flip, strict=True)]
        there = _at_amplitude(old, base, flip, b, grown, there.w)
        gap_b = there.doubling_gap
        if gap_b < 0 < gap_a:
            break
        a, gap_a = b, gap_b
    while abs(b - a) > mp.mpf(10) ** (-mp.dps // 2):
        c = b - gap_b * (b - a) / (gap_b - gap_a)
        there = _at_amplitude(old, base, flip, c, there.times, there.w)
        a, gap_a, b, gap_b = b, gap_b, c, there.doubling_gap
    return there


def _reversed(old: Orbit) -> list[Any]:
    """How two cycles of times move along the direction with multiplier -1; of length 1."""
    back = old.monodromy + mpmath.eye(2)
    row = max((back[0, :], back[1, :]), key=mpmath.norm)
    before, here = -row[1], row[0]
    moved = []
    for first, second, third in old.rows:
        moved.append(here)
        before, here = here, -(first * before + second * here) / third
    length = mp.sqrt(2 * mp.fdot(moved, moved))
    return [m / length for m in moved] + [-m / length for m in moved]


def _at_amplitude(old: Orbit, base: list[Any], flip: list[Any], amplitude: Any, times: list[Any], w: Any) -> Orbit:
    """The doubled orbit whose times differ from ``base`` by ``amplitude`` along ``flip``: Newton, w unknown."""
    apart = mp.mpf(10) ** (-mp.dps // 2)
    size = len(times)
    for _ in range(40):
        law, rows = impact_law(flights_of(w, times, 2 * old.periods), old.r)
        moved, _ = impact_law(flights_of(w + apart, times, 2 * old.periods), old.r)
        matrix = mpmath.zeros(size + 1)
        matrix[:size, :size] = cyclic(rows)
        for i in range(size):
            matrix[i, size], matrix[size, i] = (moved[i] - law[i]) / apart, flip[i]
        off = mp.fdot(flip, [t - b for t, b in zip(times, base, strict=True)]) - amplitude
        step = mpmath.lu_solve(matrix, mpmath.matrix([*law, off]))
        times = [t - step[i] for i, t in enumerate(times)]
        w -= step[size]
        if mpmath.norm(step, mp.inf) < apart:
            return orbit(w, old.r, times, 2 * old.periods)
    raise ArithmeticError("Newton's method does not converge")

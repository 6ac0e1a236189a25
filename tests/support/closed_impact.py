"""Orbits of the damped impact oscillator with one impact, in closed form.

    x'' + 2 zeta x' + x = cos(w t),  x <= d;   at x = d: v := -r v

The forced motion p has the amplitude A and runs on the ellipse p^2 + (p'/w)^2 = A^2. What is left of the state obeys
the matrix M of the free oscillator; that it returns after n periods makes d - p and -p' at the impact proportional to
the speed V before it, (d - p, -p') = V k with (M - 1) k = (1 + r M) e_v, and the ellipse becomes a quadratic equation:

    V^2 (k1^2 + k2^2/w^2) - 2 d k1 V + d^2 - A^2 = 0.

One of its roots vanishes where A = d: there the free motion grazes, and this orbit is born or dies. Source: Shaw and
Holmes 1983, doi:10.1016/0022-460X(83)90407-8; the saltation matrix of an impact: Nordmark 1991,
doi:10.1016/0022-460X(91)90592-8.
"""

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sqrt
from typing import Any

import numpy as np


@dataclass(frozen=True)
class OneImpact:
    """Phase w t of the impact in [0, 2 pi), speed before it, and the monodromy matrix from just before it.

    The trace is that of the map over n periods, whose determinant is r^2 exp(-2 zeta T); ``highest`` is the largest
    position in flight, looked for on a grid of 20 000 points: the orbit exists if it is not above the wall.
    """

    phase: float
    speed: float
    trace: float
    determinant: float
    highest: float


def amplitude(w: float, zeta: float) -> float:
    """Amplitude of the motion that never meets the wall."""
    return 1 / hypot(1 - w**2, 2 * zeta * w)


def free(zeta: float, t: Any) -> np.ndarray:
    """State of the free oscillator after a time ``t`` from unit position and from unit speed, shape (2, 2, ...)."""
    turn = sqrt(1 - zeta**2)
    c, s = np.cos(turn * t), np.sin(turn * t) / turn
    return np.exp(-zeta * t) * np.array([[c + zeta * s, s], [-s, c - zeta * s]])


def one_impact(w: float, d: float, zeta: float, r: float, n: int = 1) -> list[OneImpact]:
    """All orbits with one impact in n periods, slowest impact first; and whether they stay below the wall."""
    if _discriminant(w, d, zeta, r, n) < 0:
        return []
    k, a, b, c = _quadratic(w, d, zeta, r, n)
    speeds = sorted((b + sign * sqrt(b * b - a * c)) / a for sign in (-1, 1))
    return [_orbit(w, d, zeta, r, n, v, d - v * k[0], -v * k[1]) for v in speeds if v > 0]


def _quadratic(w: float, d: float, zeta: float, r: float, n: int) -> tuple[np.ndarray, float, float, float]:
    """The vector k, and a, b, c of a V^2 - 2 b V + c = 0."""
    m = free(zeta, 2 * pi * n / w)
    k = np.linalg.solve(m - np.eye(2), (np.eye(2) + r * m)[:, 1])
    return k, k[0] ** 2 + (k[1] / w) ** 2, d * k[0], d**2 - amplitude(w, zeta) ** 2


def _discriminant(w: float, d: float, zeta: float, r: float, n: int) -> float:
    _, a, b, c = _quadratic(w, d, zeta, r, n)
    return b * b - a * c


def _orbit(w: float, d: float, zeta: float, r: float, n: int, v: float, p: float, rate: float) -> OneImpact:
    # p = A cos(w t - lag): the force leads it by the lag
    phase = (atan2(-rate / w, p) + atan2(2 * zeta * w, 1 - w**2)) % (2 * pi)
    before, after = (cos(phase) - 2 * zeta * u - d for u in (v, -r * v))
    saltation = np.array([[-r, 0.0], [(after + r * before) / v, -r]])
    period = 2 * pi * n / w
    map_ = free(zeta, period) @ saltation
    t = np.linspace(0, period, 20_001)[1:-1]
    flight = free(zeta, t)[0]
    x = p * np.cos(w * t) + rate / w * np.sin(w * t) + (d - p) * flight[0] - (r * v + rate) * flight[1]
    return OneImpact(phase, float(v), float(np.trace(map_)), float(np.linalg.det(map_)), float(x.max()))

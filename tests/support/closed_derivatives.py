"""What closed forms say of orbits, as functions of parameters that mpmath differentiates to any number of digits.

The forms themselves, with their sources, are those of `closed_impact`, `closed_bouncing_ball` and `closed_autonomous`.
"""

from collections.abc import Callable, Mapping
from typing import Any

from mpmath import acos, atan2, cos, diff, ellipf, exp, hypot, log, matrix, mp, pi, sin, sqrt

Told = dict[str, Any]


def by_parameters(
    form: Callable[..., Told], values: Mapping[str, float], digits: int = 40
) -> dict[str, dict[str, float]]:
    """Derivatives of all that a form tells, by parameter: name -> parameter -> value."""
    with mp.workdps(digits):
        point = {name: mp.mpf(value) for name, value in values.items()}
        return {
            told: {
                name: diff(lambda x, name=name, told=told: form(**{**point, name: x})[told], point[name])
                for name in point
            }
            for told in form(**point)
        }


def impact(wall: Any, zeta: Any, amplitude: Any, omega: Any, e: Any, fast: bool = True) -> Told:
    """The orbit of the damped impact oscillator with one impact a period: time, speed, mean of x, multipliers' sums.

    Over a flight x'' + 2 zeta x' + x = A cos(w t) integrates to the mean of x, -(1 + e) V/T.
    """
    period, turn = 2 * pi / omega, sqrt(1 - zeta**2)
    c, s = cos(turn * period), sin(turn * period) / turn
    m = exp(-zeta * period) * matrix([[c + zeta * s, s], [-s, c - zeta * s]])
    unit = matrix([[1, 0], [0, 1]])
    k = (m - unit) ** -1 * ((unit + e * m) * matrix([0, 1]))
    size = amplitude / hypot(1 - omega**2, 2 * zeta * omega)
    a, b, rest = k[0] ** 2 + (k[1] / omega) ** 2, wall * k[0], wall**2 - size**2
    speed = (b + (1 if fast else -1) * sqrt(b * b - a * rest)) / a
    p, rate = wall - speed * k[0], -speed * k[1]
    phase = atan2(-rate / omega, p) + atan2(2 * zeta * omega, 1 - omega**2)
    before, after = (amplitude * cos(phase) - 2 * zeta * v - wall for v in (speed, -e * speed))
    jump = matrix([[-e, 0], [(after + e * before) / speed, -e]])
    map_ = m * jump
    determinant = map_[0, 0] * map_[1, 1] - map_[0, 1] * map_[1, 0]
    return {
        "period": period,
        "time": (phase % (2 * pi)) / omega,
        "mean": -(1 + e) * speed / period,
        "trace": map_[0, 0] + map_[1, 1],
        "determinant": determinant,
        "exponents": log(determinant) / period,
    }


def bounce(amplitude: Any, omega: Any, e: Any, gravity: Any, low: bool = False) -> Told:
    """The orbit of the bouncing ball with one bounce a period, and its unstable partner."""
    phase = acos(pi * (1 - e) / (1 + e) * gravity / (amplitude * omega**2)) * (-1 if low else 1)
    trace = 1 + e**2 - (1 + e) ** 2 * amplitude * omega**2 / gravity * sin(phase)
    return {
        "period": 2 * pi / omega,
        "time": (phase % (2 * pi)) / omega,
        "trace": trace,
        "determinant": e**2 + 0 * omega,
    }


def belt(belt: Any, F_s: Any, F_k: Any) -> Told:
    """Stick-slip on a belt: durations of the round and of its slip."""
    drop = F_s - F_k
    slip = 2 * pi - 2 * atan2(drop, belt)
    return {"period": 2 * drop / belt + slip, "slip": slip}


def gait(alpha: Any, gamma: Any) -> Told:
    """The rimless wheel: velocity after a step, period, multiplier."""
    after = 2 * sqrt(sin(gamma) * sin(alpha)) / sin(2 * alpha) * cos(2 * alpha)
    m = after**2 / 2 + cos(gamma - alpha) - 1
    way = ellipf((gamma + alpha) / 2, -2 / m) - ellipf((gamma - alpha) / 2, -2 / m)
    return {"after": after, "period": sqrt(2 / m) * way, "multiplier": cos(2 * alpha) ** 2}

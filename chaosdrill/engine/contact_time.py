"""How long a Hunt-Crossley contact lasts, and how that depends on its arguments.

With P = p0/lam, p0^2/2 = lam v - ln(1 + lam v), the depth x = x_m (1 - s^2) is passed twice, with speeds that belong to
p = p0 sigma(s), sigma^2 = 1 - (1 - s^2)^(n + 1). In these variables nothing is singular and nothing cancels:

    t = 2 ((n + 1)/(2 k))^(1/(n + 1)) P^((1 - n)/(1 + n)) I,    I = integral over 0 < s < 1 of s E(p)/sigma,

where E(p) = p/X(p) + p/Y(p), and X, Y are lam times the speeds on the way in and out (`chaosdrill.engine.special`).
"""

import math
from fractions import Fraction

import numba
import numpy as np

from chaosdrill.engine.special import ORDER, SERIES, horner, potential, series_of_exit, slope

NEAR = 0.8
"""Largest p at which the series are used; they have the radius 2 sqrt(pi)."""

_gauss = np.polynomial.legendre.leggauss(80)
NODES = np.ascontiguousarray((_gauss[0] + 1) / 2)
WEIGHTS = np.ascontiguousarray(_gauss[1] / 2)


def _even_part() -> np.ndarray:
    """Coefficients of E(p) = 1/A(p) + 1/A(-p) by powers of p^2, with A = Y(p)/p, as exact rationals rounded once."""
    a = series_of_exit()
    inverse = [Fraction(1)]
    for m in range(1, ORDER):
        inverse.append(-sum((a[j] * inverse[m - j] for j in range(1, m + 1)), Fraction(0)))
    return np.array([2 * float(c) for c in inverse[::2]])


SUM = _even_part()
SUM_SLOPE = np.array([2 * j * c for j, c in enumerate(SUM)][1:])
RATIO_SLOPE = np.array([j * c for j, c in enumerate(SERIES)][1:])


@numba.njit(error_model="numpy", cache=True)
def _ways(p):
    """X, Y and 1 - Y at p > `NEAR`, by Newton's method on p^2/2 = X - ln(1 + X) = -Y - ln(1 - Y)."""
    g = 0.5 * p * p
    x = g + math.log1p(g + p)
    for _ in range(4):
        x -= (x - math.log1p(x) - g) * (1.0 + x) / x
    q = math.exp(-1.0 - g)
    for _ in range(6):
        q -= (q - math.log(q) - 1.0 - g) * q / (q - 1.0)
    return x, 1.0 - q, q


@numba.njit(error_model="numpy", cache=True)
def _both_ways(p):
    """E(p) and its derivative."""
    if p <= NEAR:
        return horner(SUM, p * p), p * horner(SUM_SLOPE, p * p)
    x, y, q = _ways(p)
    slope_in = 1.0 / x - p * p * (1.0 + x) / x**3
    slope_out = 1.0 / y - p * p * q / y**3
    return p / x + p / y, slope_in + slope_out


@numba.njit(error_model="numpy", cache=True)
def _integrals(p0, n):
    """I(p0, n) and its derivatives by p0 and n."""
    total = 0.0
    by_p = 0.0
    by_n = 0.0
    for i in range(NODES.size):
        s = NODES[i]
        logarithm = math.log1p(-s * s)
        square = -math.expm1((n + 1.0) * logarithm)
        sigma = math.sqrt(square)
        value, rate = _both_ways(p0 * sigma)
        total += WEIGHTS[i] * s * value / sigma
        by_p += WEIGHTS[i] * s * rate
        by_n += WEIGHTS[i] * s * (p0 * sigma * rate - value) * (square - 1.0) * logarithm / (2.0 * square * sigma)
    return total, by_p, by_n


@numba.njit(error_model="numpy", cache=True)
def _impulse(v, lam):
    """P, and its derivatives by v and lam."""
    x = lam * v
    ratio = slope(x) if x <= 1.0 else math.sqrt(2.0 * potential(x))
    p = x * ratio
    value = v * ratio
    if p <= NEAR:
        bend = -horner(RATIO_SLOPE, -p)
        rise = horner(SERIES, -p) + p * bend
    else:
        rise = p * (1.0 + x) / x
        bend = (rise - x / p) / p
    return value, 1.0 / rise, -value * value * bend / rise


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration(v, lam, n, k):
    """Duration of a contact d'' = -k d^n (1 + lam d').

    Parameters
    ----------
    v : float
        Approach speed, > 0.
    lam : float
        Damping constant of the contact, 1/speed, >= 0.
    n : float
        Exponent, >= 1.
    k : float
        Stiffness per unit of relative mass, > 0.

    Returns
    -------
    float
        Time from touch to parting, to 12 digits for 1e-12 <= lam v <= 50.
    """
    value, _, _ = _impulse(v, lam)
    total, _, _ = _integrals(lam * value, n)
    return 2.0 * ((n + 1.0) / (2.0 * k)) ** (1.0 / (n + 1.0)) * value ** ((1.0 - n) / (1.0 + n)) * total


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_v(v, lam, n, k):
    """Derivative of the duration by v; arguments as for `hunt_crossley_duration`."""
    value, by_v, _ = _impulse(v, lam)
    total, by_p, _ = _integrals(lam * value, n)
    time = hunt_crossley_duration(v, lam, n, k)
    return time * by_v * ((1.0 - n) / (1.0 + n) / value + lam * by_p / total)


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_lam(v, lam, n, k):
    """Derivative of the duration by lam; arguments as for `hunt_crossley_duration`."""
    value, _, by_lam = _impulse(v, lam)
    total, by_p, _ = _integrals(lam * value, n)
    time = hunt_crossley_duration(v, lam, n, k)
    return time * ((1.0 - n) / (1.0 + n) * by_lam / value + (value + lam * by_lam) * by_p / total)


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_n(v, lam, n, k):
    """Derivative of the duration by n; arguments as for `hunt_crossley_duration`."""
    value, _, _ = _impulse(v, lam)
    total, _, by_n = _integrals(lam * value, n)
    time = hunt_crossley_duration(v, lam, n, k)
    growth = 1.0 - math.log((n + 1.0) / (2.0 * k)) - 2.0 * math.log(value)
    return time * (growth / (n + 1.0) ** 2 + by_n / total)

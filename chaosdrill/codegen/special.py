"""Numerical code of the functions of `chaosdrill.model.special`.

All of them rest on x = lam v, y = lam s and the variable p with p^2/2 = x - ln(1 + x) = -y - ln(1 - y), in which both
sides of a contact are one analytic function: y = Y(p), x = -Y(-p). Its Taylor series has the radius 2 sqrt(pi), and the
closed form with Lambert's W is used by nobody: it is NaN at x = 1e-8 and wrong by 1e-9 at x = 1e-4.

For the duration of a contact, with P = p0/lam, p0^2/2 = lam v - ln(1 + lam v), the depth x = x_m (1 - s^2) is passed
twice, with speeds that belong to p = p0 sigma(s), sigma^2 = 1 - (1 - s^2)^(n + 1). In these variables
nothing is singular and nothing cancels:

    t = 2 ((n + 1)/(2 k))^(1/(n + 1)) P^((1 - n)/(1 + n)) I,    I = integral over 0 < s < 1 of s E(p)/sigma,

where E(p) = p/X(p) + p/Y(p), and X, Y are lam times the speeds on the way in and out.
"""

import math
from fractions import Fraction

import numba
import numpy as np

ORDER = 24


def series_of_exit() -> list[Fraction]:
    """Coefficients of Y(p)/p, exactly: the solution of Y Y' = p (1 - Y)."""
    a = [Fraction(0), Fraction(1)]
    for m in range(2, ORDER + 1):
        middle = sum((a[i] * (m + 1 - i) * a[m + 1 - i] for i in range(2, m)), Fraction(0))
        a.append(-(a[m - 1] + middle) / (m + 1))
    return a[1:]


SERIES = np.array([float(c) for c in series_of_exit()])
EVEN = np.ascontiguousarray(SERIES[1::2])
ATANH = np.array([1.0 / (2 * j + 3) for j in range(18)])


@numba.njit(error_model="numpy", cache=True)
def horner(coefficients, x):
    """Polynomial with these coefficients, the lowest first, at x; even and odd terms apart, for two short chains."""
    square = x * x
    even = 0.0
    odd = 0.0
    top = coefficients.size - 1
    for j in range(top - top % 2, -1, -2):
        even = even * square + coefficients[j]
    for j in range(top - 1 + top % 2, -1, -2):
        odd = odd * square + coefficients[j]
    return even + x * odd


@numba.njit(error_model="numpy", cache=True)
def slope(x):
    """p/x for -1/2 <= x <= 1, through ln(1 + x) = 2 artanh(z), z = x/(2 + x), |z| <= 1/3."""
    z = x / (2.0 + x)
    rest = 1.0 - z
    return math.sqrt(rest - rest * rest * z * horner(ATANH, z * z))


@numba.njit(error_model="numpy", cache=True)
def _deficit(x):
    """1 - y for x > 1: the root q of q = c exp(q), c = (1 + x) exp(-1 - x), by two Halley steps."""
    c = (1.0 + x) * math.exp(-1.0 - x)
    q = c * (1.0 + c * (1.0 + 1.5 * c / (1.0 - 1.78 * c)))
    for _ in range(2):
        g = c * math.exp(q)
        f = q - g
        q -= f / (1.0 - g + 0.5 * f * g / (1.0 - g))
    return q


@numba.njit(error_model="numpy", cache=True)
def potential(x):
    """(x - ln(1 + x))/x^2 for x >= 0; 1/2 at 0."""
    if x <= 1.0:
        ratio = slope(x)
        return 0.5 * ratio * ratio
    return (x - math.log1p(x)) / (x * x)


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_exit(v, lam):
    """Exit speed s of a Hunt-Crossley contact.

    Parameters
    ----------
    v : float
        Approach speed, > 0.
    lam : float
        Damping constant of the contact, 1/speed; 0 stands for an elastic contact.

    Returns
    -------
    float
        Exit speed, > 0, within two units in the last place (4e-16 relative) for 1e-12 <= lam v <= 50. The law is
        continued analytically to -1/2 <= lam v < 0; below that it is NaN.
    """
    x = lam * v
    if x <= 1.0:
        if x < -0.5:
            return math.nan
        ratio = slope(x)
        return v * (ratio * horner(SERIES, x * ratio))
    return (1.0 - _deficit(x)) / lam


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_exit_lam(v, lam):
    """Derivative of the exit speed by lam.

    (v ds/dv - s)/lam written as v^2 (x + y)(x - y - x y)/((1 + x) y x^2), with x - y from the even part of the series,
    so that no digits cancel where lam v is small. Arguments as for `hunt_crossley_exit`.
    """
    x = lam * v
    if x <= 1.0:
        if x < -0.5:
            return math.nan
        rise = slope(x)
        p = x * rise
        ratio = rise * horner(SERIES, p)
        gap = -2.0 * rise * rise * horner(EVEN, p * p)
    else:
        y = 1.0 - _deficit(x)
        ratio = y / x
        gap = (x - y) / (x * x)
    return v * v * (1.0 + ratio) * (gap - ratio) / ((1.0 + x) * ratio)


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_peak(v, lam, n, k):
    """Peak of k d^n (1 + lam d') over a contact d'' = -k d^n (1 + lam d').

    Parameters
    ----------
    v : float
        Approach speed, >= 0.
    lam : float
        Damping constant, 1/speed, >= 0.
    n : float
        Exponent, > 0.
    k : float
        Stiffness per unit of relative mass.

    Returns
    -------
    float
        Peak force per unit of relative mass. With q = lam d' at the peak and w = q/x^2, Newton's method solves
        n w + (n + 1)(w x)^2 P(q) = (n + 1) P(x), where P(x) = (x - ln(1 + x))/x^2; it is convex in w.
    """
    x = lam * v
    goal = (n + 1.0) * potential(x)
    w = 2.0 * goal / (n + math.sqrt(n * n + 2.0 * (n + 1.0) * x * x * goal))
    for _ in range(30):
        q = w * x * x
        step = (n * w + (n + 1.0) * w * w * x * x * potential(q) - goal) / (n + (n + 1.0) * q / (1.0 + q))
        w -= step
        if abs(step) <= 1e-15 * w:
            break
    depth = (n * w * v * v / k) ** (1.0 / (n + 1.0))
    return k * depth**n * (1.0 + w * x * x)


@numba.njit(error_model="numpy", cache=True)
def positive_power(d, n):
    """max(d, 0)^n.

    Parameters
    ----------
    d : float
        Base.
    n : float
        Exponent, >= 0; with 0 the value is 1 for d > 0 and 0 elsewhere.
    """
    return d**n if d > 0.0 else 0.0


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


CODE = {
    function.__name__: function
    for function in (
        hunt_crossley_exit,
        hunt_crossley_exit_lam,
        hunt_crossley_peak,
        hunt_crossley_duration,
        hunt_crossley_duration_v,
        hunt_crossley_duration_lam,
        hunt_crossley_duration_n,
        positive_power,
    )
}
"""Code of the special functions by name."""

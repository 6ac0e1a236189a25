"""Numba implementations of the contact laws of `chaosdrill.model.special`.

All of them rest on x = lam v, y = lam s and the variable p with p^2/2 = x - ln(1 + x) = -y - ln(1 - y), in which both
sides of a contact are one analytic function: y = Y(p), x = -Y(-p). Its Taylor series has the radius 2 sqrt(pi), and the
closed form with Lambert's W is used by nobody: it is NaN at x = 1e-8 and wrong by 1e-9 at x = 1e-4.
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

"""Numerical code of the special functions of contacts.

They rest on x = lam v, y = lam s and the variable p with p^2/2 = x - ln(1 + x) = -y - ln(1 - y), in which both
sides of a contact are one analytic function: y = Y(p), x = -Y(-p). Its Taylor series has the radius 2 sqrt(pi), and the
closed form with Lambert's W is used by nobody: it is NaN at x = 1e-8 and wrong by 1e-9 at x = 1e-4.

For the duration of a contact, with P = p0/lam, p0^2/2 = lam v - ln(1 + lam v), the depth x = x_m (1 - s^2) is passed
twice, with speeds that belong to p = p0 sigma(s), sigma^2 = 1 - (1 - s^2)^(n + 1). In these variables
nothing is singular and nothing cancels:

    t = 2 ((n + 1)/(2 k))^(1/(n + 1)) P^((1 - n)/(1 + n)) I,    I = integral over 0 < s < 1 of s E(p)/sigma,

where E(p) = p/X(p) + p/Y(p), and X, Y are lam times the speeds on the way in and out. Where p0 is small I is a power
series in p0^2: the integral of s sigma^(2 j - 1) is B(1/(n + 1), j + 1/2)/(2 (n + 1)). Otherwise it is a sum over Gauss
nodes, each of which has Taylor recurrences of its own.
"""

import math
from fractions import Fraction

import numba
import numpy as np

ORDER = 24


def series_of_exit(order: int = ORDER) -> list[Fraction]:
    """Coefficients of Y(p)/p, exactly: the solution of Y Y' = p (1 - Y)."""
    a = [Fraction(0), Fraction(1)]
    for m in range(2, order + 1):
        middle = sum((a[i] * (m + 1 - i) * a[m + 1 - i] for i in range(2, m)), Fraction(0))
        a.append(-(a[m - 1] + middle) / (m + 1))
    return a[1:]


SERIES = np.array([float(c) for c in series_of_exit()])
EVEN = np.ascontiguousarray(SERIES[1::2])
ATANH = np.array([1.0 / (2 * j + 3) for j in range(18)])

RECIPROCAL_GAMMA = np.array(
    [
        1.0, 0.5772156649015329, -0.6558780715202539, -0.04200263503409524, 0.16653861138229148,
        -0.04219773455554433, -0.009621971527876973, 0.0072189432466631, -0.0011651675918590652,
        -0.00021524167411495098, 0.0001280502823881162, -2.013485478078824e-05, -1.2504934821426706e-06,
        1.133027231981696e-06, -2.056338416977607e-07, 6.116095104481416e-09, 5.002007644469223e-09,
        -1.18127457048702e-09, 1.0434267116911005e-10, 7.782263439905071e-12, -3.696805618642206e-12,
        5.100370287454476e-13, -2.0583260535665066e-14, -5.348122539423018e-15, 1.2267786282382608e-15,
    ]
)  # fmt: skip
"""Taylor coefficients of 1/Gamma(1 + x) at 0 (Abramowitz and Stegun, 6.1.34), enough of them for |x| <= 1."""


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
def _deficit(c):
    """1 - y for x > 1: the root q of q = c exp(q), c = (1 + x) exp(-1 - x) = exp(-1 - p^2/2), by two Halley steps."""
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

    ``v``: approach speed, > 0. ``lam``: damping constant of the contact, 1/speed; 0 stands for an elastic contact.

    Returns: exit speed, > 0, within two units in the last place (4e-16 relative) for 1e-12 <= lam v <= 50. The law is
    continued analytically to -1/2 <= lam v < 0; below that it is NaN.
    """
    x = lam * v
    if x <= 1.0:
        if x < -0.5:
            return math.nan
        ratio = slope(x)
        return v * (ratio * horner(SERIES, x * ratio))
    return (1.0 - _deficit((1.0 + x) * math.exp(-1.0 - x))) / lam


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
        y = 1.0 - _deficit((1.0 + x) * math.exp(-1.0 - x))
        ratio = y / x
        gap = (x - y) / (x * x)
    return v * v * (1.0 + ratio) * (gap - ratio) / ((1.0 + x) * ratio)


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_peak(v, lam, n, k):
    """Peak of k d^n (1 + lam d') over a contact d'' = -k d^n (1 + lam d').

    ``v``: approach speed, >= 0. ``lam``: damping constant, 1/speed, >= 0. ``n``: exponent, > 0. ``k``: stiffness per
    unit of relative mass.

    Returns: peak force per unit of relative mass. With q = lam d' at the peak and w = q/x^2, Newton's method solves n w
    + (n + 1)(w x)^2 P(q) = (n + 1) P(x), where P(x) = (x - ln(1 + x))/x^2; it is convex in w.
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


NEAR = 0.8
"""Largest p at which the series of a speed is used; x is above 1 beyond."""

GENTLE = 1.0
"""Largest p0 at which the duration is a series of p0^2 with `TERMS` terms. What they leave out is 1e-26 of the value
and 1e-12 of the tenth derivative; the quadrature beyond takes twenty times as long."""

TERMS = 24

_gauss = np.polynomial.legendre.leggauss(80)
NODES = np.ascontiguousarray((_gauss[0] + 1) / 2)
WEIGHTS = np.ascontiguousarray(_gauss[1] / 2)


def _even_part() -> np.ndarray:
    """Coefficients of E(p) = 1/A(p) + 1/A(-p) by powers of p^2, with A = Y(p)/p, as exact rationals rounded once."""
    a = series_of_exit(2 * TERMS)
    inverse = [Fraction(1)]
    for m in range(1, 2 * TERMS):
        inverse.append(-sum((a[j] * inverse[m - j] for j in range(1, m + 1)), Fraction(0)))
    return np.array([2 * float(c) for c in inverse[::2]])


SUM = _even_part()
RATIO_SLOPE = np.array([j * c for j, c in enumerate(SERIES)][1:])
RATIO_BEND = np.array([j * (j - 1) * c for j, c in enumerate(SERIES)][2:])


@numba.njit(error_model="numpy", cache=True)
def _speed(p, way):
    """X and 1 + X on the way in (1), or Y and 1 - Y on the way out (-1), at p > 0."""
    if p <= NEAR:
        y = p * horner(SERIES, -way * p)
        return y, 1.0 + way * y
    g = 0.5 * p * p
    if way > 0.0:
        # Newton's method on p^2/2 = X - ln(1 + X)
        x = g + math.log1p(g + p)
        for _ in range(4):
            x -= (x - math.log1p(x) - g) * (1.0 + x) / x
        return x, 1.0 + x
    q = _deficit(math.exp(-1.0 - g))
    return 1.0 - q, q


@numba.njit(error_model="numpy", cache=True)
def _ratio(p, way):
    """X/p or Y/p and two derivatives, from X X' = p (1 + X) and Y Y' = p (1 - Y)."""
    if p <= NEAR:
        z = -way * p
        return horner(SERIES, z), -way * horner(RATIO_SLOPE, z), horner(RATIO_BEND, z)
    y, rest = _speed(p, way)
    rise = p * rest / y
    bend = (rest + way * p * rise - rise * rise) / y
    ratio = y / p
    rate = (rise - ratio) / p
    return ratio, rate, (bend - 2.0 * rate) / p


@numba.njit(error_model="numpy", cache=True)
def _both_ways(p):
    """E(p) and two derivatives."""
    value = rate = bend = 0.0
    for way in (1.0, -1.0):
        a, b, c = _ratio(p, way)
        value += 1.0 / a
        rate -= b / (a * a)
        bend += (2.0 * b * b / a - c) / (a * a)
    return value, rate, bend


@numba.njit(error_model="numpy", cache=True)
def _node(i, n):
    """Of a node of the quadrature: s, sigma, and the logarithm of 1 - s^2."""
    s = NODES[i]
    logarithm = math.log1p(-s * s)
    return s, math.sqrt(-math.expm1((n + 1.0) * logarithm)), logarithm


@numba.njit(error_model="numpy", cache=True)
def _first_moment(n):
    """Integral of s/sigma, B(a, 1/2) a/2 with a = 1/(n + 1)."""
    a = 1.0 / (n + 1.0)
    # numba's own gamma function is there with numba alone
    return 0.5 * math.sqrt(math.pi) * horner(RECIPROCAL_GAMMA, a - 0.5) / horner(RECIPROCAL_GAMMA, a)


@numba.njit(error_model="numpy", cache=True)
def _next_moment(n, j):
    """What the integral of s sigma^(2 j - 1) is multiplied by for the next j."""
    return (j + 0.5) / (1.0 / (n + 1.0) + j + 0.5)


@numba.njit(error_model="numpy", cache=True)
def _moments(n):
    """Coefficients of I by powers of p0^2: those of E times integrals of s sigma^(2 j - 1), beta functions."""
    found = np.empty(TERMS)
    moment = _first_moment(n)
    for j in range(TERMS):
        found[j] = SUM[j] * moment
        moment *= _next_moment(n, j)
    return found


@numba.njit(error_model="numpy", cache=True)
def _integrals(p0, n):
    """I(p0, n) and its first two derivatives by p0; without arrays, which would have code that needs numba to run."""
    total = by_p = twice = 0.0
    if p0 <= GENTLE:
        square = p0 * p0
        moment = _first_moment(n)
        total, power = SUM[0] * moment, 1.0
        for j in range(1, TERMS):
            moment *= _next_moment(n, j - 1)
            term = SUM[j] * moment * power
            total += term * square
            by_p += 2 * j * term
            twice += 2 * j * (2 * j - 1) * term
            power *= square
        return total, by_p * p0, twice
    for i in range(NODES.size):
        s, sigma, _ = _node(i, n)
        value, rate, bend = _both_ways(p0 * sigma)
        total += WEIGHTS[i] * s * value / sigma
        by_p += WEIGHTS[i] * s * rate
        twice += WEIGHTS[i] * s * sigma * bend
    return total, by_p, twice


@numba.njit(error_model="numpy", cache=True)
def _integrals_by_n(p0, n):
    """Derivative of I(p0, n) by n, and that of this by p0."""
    by_n = both = 0.0
    for i in range(NODES.size):
        s, sigma, logarithm = _node(i, n)
        value, rate, bend = _both_ways(p0 * sigma)
        change = WEIGHTS[i] * s * logarithm * (sigma * sigma - 1.0) / (2.0 * sigma * sigma)
        by_n += change * (p0 * rate - value / sigma)
        both += change * p0 * sigma * bend
    return by_n, both


@numba.njit(error_model="numpy", cache=True)
def _root(x):
    """p/x for x >= 0; 1 at 0."""
    if x < 0.0:
        return math.nan
    return slope(x) if x <= 1.0 else math.sqrt(2.0 * potential(x))


@numba.njit(error_model="numpy", cache=True)
def _unit(v, n, k):
    """What the duration is a multiple of, whatever the damping: 2 ((n + 1)/(2 k))^(1/(n + 1)) v^((1 - n)/(1 + n))."""
    if v < 0.0:
        return math.nan
    return 2.0 * ((n + 1.0) / (2.0 * k)) ** (1.0 / (n + 1.0)) * v ** ((1.0 - n) / (1.0 + n))


@numba.njit(error_model="numpy", cache=True)
def _product(a, b, m):
    """Coefficient m of the product of two series."""
    total = 0.0
    for j in range(m + 1):
        total += a[j] * b[m - j]
    return total


@numba.njit(error_model="numpy", cache=True)
def _gentle(square, n):
    """Series of I, given that of p0^2."""
    moments = _moments(n)
    total = np.zeros(square.size)
    for j in range(TERMS - 1, -1, -1):
        for m in range(square.size - 1, -1, -1):
            total[m] = _product(total, square, m)
        total[0] += moments[j]
    return total


@numba.njit(error_model="numpy", cache=True)
def _products(a, b, m):
    """Coefficient m of the products of as many series as the rows are long."""
    total = np.zeros(b.shape[1])
    for j in range(m + 1):
        left, right = a[j], b[m - j]
        for i in range(total.size):
            total[i] += left[i] * right[i]
    return total


@numba.njit(error_model="numpy", cache=True)
def _violent(x, root, n, count):
    """Series of I/q by powers of w, given p0/x, where q = p0/(lam v); see `hunt_crossley_duration_series`.

    At a node the speeds are X = kappa/f, Y = kappa/f with kappa = x sigma, and f' = -g f^2 (f +- kappa) with
    g = (1 + w)/(1 + x + x w). So E = q times the sum of both f, and 1 - Y is kept where it is tiny.
    """
    size = 2 * NODES.size
    f, squares = np.empty((count, size)), np.empty((count, size))
    rest, weights, found = np.empty(size), np.empty(size), np.empty(count)
    before, rate = np.zeros(size), np.zeros(size)
    for i in range(NODES.size):
        s, sigma, _ = _node(i, n)
        for half in range(2):
            place = 2 * i + half
            value, left = _speed(x * root * sigma, 1.0 - 2.0 * half)
            f[0, place] = x * sigma / value
            rest[place] = x * sigma * left / value
            weights[place] = WEIGHTS[i] * s / sigma
    for m in range(count - 1):
        squares[m] = _products(f, f, m)
        cubes = squares[m] * rest + _products(squares[:m], f[1:], m - 1)
        # times g: its denominator is linear, so that one more coefficient needs the one before it only
        rate = (cubes + before - x * rate) / (1.0 + x)
        before = cubes
        f[m + 1] = -rate / (m + 1)
    for m in range(count):
        found[m] = (f[m] * weights).sum()
    return found


@numba.njit(error_model="numpy", cache=True)
def _power(base, exponent):
    """Series of a power of a series."""
    found = np.empty(base.size)
    found[0] = base[0] ** exponent
    for m in range(1, base.size):
        total = 0.0
        for j in range(1, m + 1):
            total += (exponent * j - (m - j)) * base[j] * found[m - j]
        found[m] = total / (m * base[0])
    return found


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_series(v, lam, n, k, count):
    """Taylor coefficients of the duration at the speed v (1 + w), by powers of w.

    Parameters
    ----------
    v, lam, n, k : float
        As for `hunt_crossley_duration`.
    count : int
        How many, > 0.

    Returns
    -------
    ndarray, shape (count,)

    Notes
    -----
    With q = p0/(lam v), (q^2)' = 2 (1 + w)/(1 + lam v (1 + w)), so that nothing cancels where lam v is small. The
    recurrences of powers and products are those of Jorba and Zou 2005, doi:10.1080/10586458.2005.10128904.
    """
    x = lam * v
    root = _root(x)
    squares = np.empty(count)
    squares[0] = root * root
    term = 2.0 / (1.0 + x)
    for m in range(1, count):
        squares[m] = term / m
        term *= 1.0 / (1.0 + x) if m == 1 else -x / (1.0 + x)
    if x * root <= GENTLE:
        factor, rest = _power(squares, 0.5 * (1.0 - n) / (1.0 + n)), _gentle(x * x * squares, n)
    else:
        factor, rest = _power(squares, 1.0 / (n + 1.0)), _violent(x, root, n, count)
    unit = _unit(v, n, k)
    found = np.empty(count)
    for m in range(count):
        found[m] = unit * _product(factor, rest, m)
    return found


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_expanded(v, lam, n, k, derivative, count, target, stride):
    """Write Taylor coefficients of a derivative of the duration by v, at the speed v (1 + w), by powers of w."""
    found = hunt_crossley_duration_series(v, lam, n, k, count + derivative)
    for m in range(count):
        value = found[m + derivative]
        for i in range(derivative):
            value *= (m + derivative - i) / v
        target[m * stride] = value


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration(v, lam, n, k):
    """Duration of a contact d'' = -k d^n (1 + lam d').

    ``v``: approach speed, > 0. ``lam``: damping constant of the contact, 1/speed, >= 0. ``n``: exponent, >= 1. ``k``:
    stiffness per unit of relative mass, > 0.

    Returns: time from touch to parting, to 12 digits for lam v <= 50; NaN for v < 0.
    """
    root = _root(lam * v)
    return _unit(v, n, k) * root ** ((1.0 - n) / (1.0 + n)) * _integrals(lam * v * root, n)[0]


@numba.njit(error_model="numpy", cache=True)
def _by_damping(x, n):
    """The duration in units of `_unit` as a function of x = lam v alone, and its first two derivatives."""
    p = x * _root(x)
    total, by_p, twice = _integrals(p, n)
    ratio, rate, bend = _ratio(p, 1.0)
    power = (n - 1.0) / (1.0 + n)
    rise, curve = ratio + p * rate, 2.0 * rate + p * bend
    value = ratio**power * total
    first = power * rate / ratio + by_p / total
    second = power * (bend / ratio - (rate / ratio) ** 2) + twice / total - (by_p / total) ** 2
    by_x = value * first / rise
    return value, by_x, (value * (first * first + second) - by_x * curve) / (rise * rise)


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_lam(v, lam, n, k):
    """Derivative of the duration by lam; arguments as for `hunt_crossley_duration`."""
    return _unit(v, n, k) * v * _by_damping(lam * v, n)[1]


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_lam_lam(v, lam, n, k):
    """Second derivative of the duration by lam; arguments as for `hunt_crossley_duration`."""
    return _unit(v, n, k) * v * v * _by_damping(lam * v, n)[2]


@numba.njit(error_model="numpy", cache=True)
def _by_exponent(v, lam, n, k):
    """Derivatives by n of the duration and of its derivative by lam."""
    x = lam * v
    p = x * _root(x)
    total, by_p, _ = _integrals(p, n)
    by_n, both = _integrals_by_n(p, n)
    ratio, rate, _ = _ratio(p, 1.0)
    power, turn, unit = (n - 1.0) / (1.0 + n), 2.0 / (1.0 + n) ** 2, _unit(v, n, k)
    growth = turn * (0.5 * (1.0 - math.log((n + 1.0) / (2.0 * k))) - math.log(v) + math.log(ratio))
    scale, bend = unit * ratio**power, rate / ratio
    by_x = v / (ratio + p * rate)
    first = scale * (growth * total + by_n)
    mixed = (growth * total + by_n) * power * bend + growth * by_p + turn * bend * total + both
    return first, scale * by_x * mixed


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_n(v, lam, n, k):
    """Derivative of the duration by n; arguments as for `hunt_crossley_duration`."""
    return _by_exponent(v, lam, n, k)[0]


@numba.njit(error_model="numpy", cache=True)
def hunt_crossley_duration_lam_n(v, lam, n, k):
    """Derivative of the duration by lam and n; arguments as for `hunt_crossley_duration`."""
    return _by_exponent(v, lam, n, k)[1]

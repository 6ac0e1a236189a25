"""Numerical code of the functions of `chaosdrill.model.special`.

Contacts rest on x = lam v, y = lam s and the variable p with p^2/2 = x - ln(1 + x) = -y - ln(1 - y), in which both
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
        Time from touch to parting, to 12 digits for lam v <= 50; NaN for v < 0.
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


@numba.njit(error_model="numpy", cache=True)
def gate(m, n, u, e):
    """exp(e)/(m + n exp(u)), finite where its exponentials are not."""
    if n == 0.0:
        return math.exp(e) / m
    if m == 0.0:
        return math.exp(e - u) / n
    if u <= 0.0:
        return math.exp(e) / (m + n * math.exp(u))
    return math.exp(e - u) / (m * math.exp(-u) + n)


@numba.njit(error_model="numpy", cache=True)
def log_sum(m, n, u):
    """log(m + n exp(u)), finite where the exponential is not, and as exact as it where that is small."""
    if u <= 0.0:
        left, right, whole = m, n * math.exp(u), 0.0
    else:
        left, right, whole = n, m * math.exp(-u), u
    if left > 0.0 and right > -left:
        return whole + math.log(left) + math.log1p(right / left)
    return whole + math.log(left + right) if left + right > 0.0 else math.nan


@numba.njit(error_model="numpy", cache=True)
def log_cosh(u):
    """log(cosh(u)), with all digits near 0, finite everywhere."""
    size = abs(u)
    if size <= 1.0:
        half = math.sinh(0.5 * size)
        return math.log1p(2.0 * half * half)
    return size + math.log1p(math.exp(-2.0 * size)) - math.log(2.0)


NEARBY = math.pi
"""Size of an argument up to which powers of it are added, whose poles are at 2 pi i; beyond it exponentials, which
have one at 0."""

BERNOULLI_TERMS = 160

BERNOULLI = np.array(
    [1.0, -0.5]
    + [
        0.0 if n % 2 else (-1) ** (n // 2 + 1) * 2.0 * sum(k**-n for k in range(60, 0, -1)) * (2.0 * math.pi) ** -n
        for n in range(2, BERNOULLI_TERMS)
    ]
)
"""Bernoulli numbers over factorials (Abramowitz and Stegun, 23.1.1 and 23.2.16)."""
BERNOULLI[2:9:2] = [1 / 12, -1 / 720, 1 / 30240, -1 / 1209600]

HALVES = BERNOULLI * (2.0 ** (1.0 - np.arange(BERNOULLI_TERMS)) - 1.0)
"""Those of the polynomials at 1/2 (23.1.21)."""


@numba.njit(error_model="numpy", cache=True)
def _bernoulli_coefficient(v, s, k):
    """Coefficient k of v exp(s v)/(exp(v) - 1) by powers of a change of v."""
    if math.isnan(v):
        return v
    if v < 0.0:
        # the reflected function has s for 1 - s
        v, s, sign = -v, 1.0 - s, -1.0 if k % 2 == 1 else 1.0
    else:
        sign = 1.0
    total = 0.0
    if v <= NEARBY:
        # sum of b_j times j over k, v^(j - k)
        weight = 1.0
        for j in range(k, BERNOULLI_TERMS):
            b = HALVES[j] if s == 0.5 else BERNOULLI[j]
            if j == 1 and s == 1.0:
                b = -b
            total += b * weight
            weight *= v * (j + 1.0) / (j + 1.0 - k)
            if j > k + 3 and weight * abs(BERNOULLI[j - j % 2]) * 40.0 <= 1e-17 * abs(total):
                break
        return sign * total
    # sum of v exp(-a v), a = 1 - s, 2 - s, ...
    a = 1.0 - s
    while True:
        power, before = math.exp(-a * v), 0.0
        for j in range(1, k + 1):
            before = power
            power *= -a / j
        total += v * power + before
        if a * v > k + 1.0 and (a * v > 800.0 or abs(v * power) + abs(before) <= 1e-18 * abs(total)):
            return sign * total
        a += 1.0


@numba.njit(error_model="numpy", cache=True)
def bernoulli_ratio_expanded(v, s, order, derivative, count, target, stride):
    """Write Taylor coefficients of a derivative of the function of that order, at v + w, by powers of w."""
    whole = int(order) + derivative
    for m in range(count):
        value = _bernoulli_coefficient(v, s, m + whole)
        for i in range(whole):
            value *= m + whole - i
        target[m * stride] = value


@numba.njit(error_model="numpy", cache=True)
def bernoulli_ratio(v, s, order):
    """Derivative of an order of v exp(s v)/(exp(v) - 1).

    Parameters
    ----------
    v : float
    s : float
        0, 1/2 or 1.
    order : float
        A whole number >= 0.
    """
    value = _bernoulli_coefficient(v, s, int(order))
    for i in range(int(order)):
        value *= i + 1
    return value


RESTS = ("exp", "sin", "cos", "sinh", "cosh", "log1p", "asin", "atan", "asinh", "atanh", "tanh", "log_cosh", "power")
"""Functions of `taylor_rest`, by their numbers; the last is that of `power_rest`. A power is one of 1 + v, as log1p."""

_EXP, _SIN, _COS, _SINH, _COSH, _LOG, _ASIN, _ATAN, _ASINH, _ATANH, _TANH, _LOG_COSH, _POWER = range(len(RESTS))

REST_TERMS = 200


def series_of_rests(count: int = REST_TERMS) -> np.ndarray:
    """Taylor coefficients at 0 of the functions of `taylor_rest`, one a row; those of powers depend on the exponent."""
    found = np.zeros((len(RESTS), count))
    found[:, 0] = [f in ("exp", "cos", "cosh") for f in RESTS]
    inverse, odd = 1.0, 1.0
    # T of T' = 1 + T^2, all of whose coefficients are positive
    tangent = [0.0]
    for j in range(1, count):
        tangent.append((float(j == 1) + sum(tangent[i] * tangent[j - 1 - i] for i in range(j))) / j)
        inverse /= j
        turning = (-1.0) ** (j // 2)
        found[_EXP, j], found[_LOG, j] = inverse, -((-1.0) ** j) / j
        if j % 2 == 0:
            found[[_COS, _COSH], j] = turning * inverse, inverse
            found[_LOG_COSH, j] = found[_TANH, j - 1] / j
            continue
        found[[_SIN, _SINH], j] = turning * inverse, inverse
        found[[_ATAN, _ATANH], j] = turning / j, 1.0 / j
        found[[_ASINH, _ASIN], j] = turning * odd / j, odd / j
        found[_TANH, j] = turning * tangent[j]
        odd *= j / (j + 1.0)
    return found


REST_SERIES = series_of_rests()

REST_NEAR = np.array([3.0 if g <= _COSH else 1.0 if g in (_TANH, _LOG_COSH) else 0.5 for g in range(len(RESTS))])
"""Size of an argument up to which powers of it are added: half of the radius of their series, or 3. Beyond it what is
left of the function is divided, which loses the fewer digits the larger the argument is beside a step."""


@numba.njit(error_model="numpy", cache=True)
def _rest_term(g, a, j):
    """Taylor coefficient j of a function at 0."""
    if g != _POWER:
        return REST_SERIES[g, j]
    c = 1.0
    for i in range(j):
        c *= (a - i) / (i + 1.0)
    return c


@numba.njit(error_model="numpy", cache=True)
def _rest_nearby(v, g, a, m, k):
    """Coefficient k of a rest by powers of a change of v: the sum of c_(j + m) C(j, k) v^(j - k)."""
    total, weight, quiet = 0.0, 1.0, 0
    c = _rest_term(g, a, k + m)
    for j in range(k, REST_TERMS - m):
        if g != _POWER:
            c = REST_SERIES[g, j + m]
        term = c * weight
        total += term
        # every second one may be zero
        quiet = quiet + 1 if abs(term) <= 1e-18 * abs(total) else 0
        if quiet > 3 and j > 2 * k + 4:
            break
        weight *= v * (j + 1.0) / (j + 1.0 - k)
        c *= (a - (j + m)) / (j + m + 1.0)
    return total


@numba.njit(error_model="numpy", cache=True)
def _rest_value(v, g, a):
    """A function of `taylor_rest` itself."""
    if g == _EXP:
        return math.exp(v)
    if g == _SIN:
        return math.sin(v)
    if g == _COS:
        return math.cos(v)
    if g == _SINH:
        return math.sinh(v)
    if g == _COSH:
        return math.cosh(v)
    if g == _ATAN:
        return math.atan(v)
    if g == _ASINH:
        return math.asinh(v)
    if g == _TANH:
        return math.tanh(v)
    if g == _LOG_COSH:
        return log_cosh(v)
    if v < -1.0 or (v > 1.0 and g in (_ASIN, _ATANH)):
        return math.nan
    if g == _LOG:
        return math.log1p(v)
    if g == _ASIN:
        return math.asin(v)
    return math.atanh(v) if g == _ATANH else (1.0 + v) ** a


@numba.njit(error_model="numpy", cache=True)
def _rest_slope(v, g, a):
    """Its derivative."""
    if g == _EXP:
        return math.exp(v)
    if g == _SIN:
        return math.cos(v)
    if g == _COS:
        return -math.sin(v)
    if g == _SINH:
        return math.cosh(v)
    if g == _COSH:
        return math.sinh(v)
    if g == _ATAN:
        return 1.0 / (1.0 + v * v)
    if g == _ASINH:
        return 1.0 / math.hypot(1.0, v)
    if g == _TANH:
        return _tanh_coefficient(v, 1)
    if g == _LOG_COSH:
        return math.tanh(v)
    if v < -1.0 or (v > 1.0 and g in (_ASIN, _ATANH)):
        return math.nan
    if g == _LOG:
        return 1.0 / (1.0 + v)
    if g == _ASIN:
        return 1.0 / math.sqrt((1.0 - v) * (1.0 + v))
    return 1.0 / ((1.0 - v) * (1.0 + v)) if g == _ATANH else a * (1.0 + v) ** (a - 1.0)


@numba.njit(error_model="numpy", cache=True)
def _tanh_coefficient(v, k):
    """Coefficient k >= 1 of tanh by powers of a change of v, |v| >= 1: twice the sum of (-1)^j exp(-2 j |v|)."""
    total, j = 0.0, 1.0
    while True:
        term = math.exp(-2.0 * j * abs(v)) * (1.0 if j % 2.0 == 0.0 else -1.0)
        for i in range(1, k + 1):
            term *= -2.0 * j / i
        total += term
        if 2.0 * j * abs(v) > k + 1.0 and (abs(term) <= 1e-18 * abs(total) or 2.0 * j * abs(v) > 800.0):
            # an odd function's coefficients of even orders are odd
            return 2.0 * total * (-1.0 if v < 0.0 and k % 2 == 0 else 1.0)
        j += 1.0


@numba.njit(error_model="numpy", cache=True)
def _rest_next(v, g, a, k, last, before):
    """Coefficient k >= 2 of a function by powers of a change of v, from the two before it."""
    if g == _EXP:
        return last / k
    if g in (_SIN, _COS):
        return -before / (k * (k - 1.0))
    if g in (_SINH, _COSH):
        return before / (k * (k - 1.0))
    if g == _LOG:
        return -last * (k - 1.0) / (k * (1.0 + v))
    if g == _POWER:
        return last * (a - k + 1.0) / (k * (1.0 + v))
    if g == _TANH:
        return _tanh_coefficient(v, k)
    if g == _LOG_COSH:
        return _tanh_coefficient(v, k - 1) / k
    # (1 + s u^2) f'' = -s p u f'
    s = 1.0 if g in (_ATAN, _ASINH) else -1.0
    p = 1.0 if g in (_ASIN, _ASINH) else 2.0
    i = k - 2.0
    turned = (i + 1.0) * (2.0 * i + p) * v * last + i * (i - 1.0 + p) * before
    return -s * turned / ((1.0 + s * v * v) * k * (k - 1.0))


@numba.njit(error_model="numpy", cache=True)
def _rest_coefficient(v, g, a, m, k):
    """Coefficient k of a rest by powers of a change of v."""
    if abs(v) <= REST_NEAR[g]:
        return _rest_nearby(v, g, a, m, k)
    last = before = one = two = three = four = value = 0.0
    for i in range(k + 1):
        if i == 0:
            value = _rest_value(v, g, a)
        elif i == 1:
            value = _rest_slope(v, g, a)
        else:
            value = _rest_next(v, g, a, i, last, before)
        before, last = last, value
        power = 1.0
        for p in range(i, m):
            value -= _rest_term(g, a, p) * power
            power *= v * (p + 1.0) / (p + 1.0 - i)
        # over the change beside v, as often as the function vanishes
        one = value = (value - one) / v
        if m > 1:
            two = value = (value - two) / v
        if m > 2:
            three = value = (value - three) / v
        if m > 3:
            four = value = (value - four) / v
    return value


@numba.njit(error_model="numpy", cache=True)
def _rest(v, g, a, m, order):
    """Derivative of an order of a rest."""
    value = _rest_coefficient(v, g, a, m, order)
    for i in range(order):
        value *= i + 1
    return value


@numba.njit(error_model="numpy", cache=True)
def _write_rest(v, g, a, m, order, count, target, stride):
    """Write Taylor coefficients of a derivative of a rest, at v + w, by powers of w."""
    for k in range(count):
        value = _rest_coefficient(v, g, a, m, k + order)
        for i in range(order):
            value *= k + order - i
        target[k * stride] = value


@numba.njit(error_model="numpy", cache=True)
def taylor_rest_expanded(v, g, m, order, derivative, count, target, stride):
    """Write Taylor coefficients of a derivative of the function of that order, at v + w, by powers of w."""
    _write_rest(v, int(g), 0.0, int(m), int(order) + derivative, count, target, stride)


@numba.njit(error_model="numpy", cache=True)
def power_rest_expanded(v, a, m, order, derivative, count, target, stride):
    """Write Taylor coefficients of a derivative of the function of that order, at v + w, by powers of w."""
    _write_rest(v, _POWER, a, int(m), int(order) + derivative, count, target, stride)


@numba.njit(error_model="numpy", cache=True)
def taylor_rest(v, g, m, order):
    """Derivative of an order of what the first terms of its Taylor series leave of a function, over a power.

    Parameters
    ----------
    v : float
    g : float
        Number of the function in `RESTS`.
    m : float
        How many terms are taken away, and the power of v that divides, 1 to 4.
    order : float
        A whole number >= 0.

    Notes
    -----
    Coefficients of the functions obey linear recurrences of two terms at most, but for tanh, whose exponentials are
    added.
    """
    return _rest(v, int(g), 0.0, int(m), int(order))


@numba.njit(error_model="numpy", cache=True)
def power_rest(v, a, m, order):
    """The same for (1 + v)^a."""
    return _rest(v, _POWER, a, int(m), int(order))


CODE = {
    function.__name__: function
    for function in (
        hunt_crossley_exit,
        hunt_crossley_exit_lam,
        hunt_crossley_peak,
        hunt_crossley_duration,
        hunt_crossley_duration_lam,
        hunt_crossley_duration_lam_lam,
        hunt_crossley_duration_lam_n,
        hunt_crossley_duration_n,
        positive_power,
        gate,
        log_sum,
        log_cosh,
        bernoulli_ratio,
        taylor_rest,
        power_rest,
    )
}
"""Code of the special functions by name."""

EXPANSIONS = {
    "hunt_crossley_duration": hunt_crossley_duration_expanded,
    "bernoulli_ratio": bernoulli_ratio_expanded,
    "taylor_rest": taylor_rest_expanded,
    "power_rest": power_rest_expanded,
}
"""Code of the Taylor coefficients of those that have it, by name."""

"""Numerical code of the functions of `chaosdrill.model.special`; that of contacts is in a file of its own."""

import math

import numba
import numpy as np

from chaosdrill.codegen.contacts import (
    hunt_crossley_duration,
    hunt_crossley_duration_expanded,
    hunt_crossley_duration_lam,
    hunt_crossley_duration_lam_lam,
    hunt_crossley_duration_lam_n,
    hunt_crossley_duration_n,
    hunt_crossley_exit,
    hunt_crossley_exit_lam,
    hunt_crossley_peak,
)


@numba.njit(error_model="numpy", cache=True)
def positive_power(d, n):
    """max(d, 0)^n.

    ``d``: base. ``n``: exponent, >= 0; with 0 the value is 1 for d > 0 and 0 elsewhere.
    """
    return d**n if d > 0.0 else 0.0


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

    ``s``: 0, 1/2 or 1. ``order``: a whole number >= 0.
    """
    value = _bernoulli_coefficient(v, s, int(order))
    for i in range(int(order)):
        value *= i + 1
    return value


RESTS = ("exp", "sin", "cos", "sinh", "cosh", "log1p", "asin", "atan", "asinh", "atanh", "tanh", "log_cosh", "power")
"""Functions of `taylor_rest`, by their numbers; the last is that of `power_rest`. A power is one of 1 + v, as log1p."""

_EXP, _SIN, _COS, _SINH, _COSH, _LOG, _ASIN, _ATAN, _ASINH, _ATANH, _TANH, _LOG_COSH, _POWER = range(len(RESTS))

REST_TERMS = 400


def _series_of_rests() -> np.ndarray:
    """Taylor coefficients at 0 of the functions of `taylor_rest`, one a row; those of powers depend on the exponent."""
    found = np.zeros((len(RESTS), REST_TERMS))
    found[:, 0] = [f in ("exp", "cos", "cosh") for f in RESTS]
    inverse, odd = 1.0, 1.0
    # T of T' = 1 + T^2, all of whose coefficients are positive
    tangent = [0.0]
    for j in range(1, REST_TERMS):
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


REST_SERIES = _series_of_rests()

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
        if m > 0:
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


EVEN_NEAR = np.full(len(RESTS), 0.5)
"""Square up to which powers of it are added: half of the radius of their series; of sines, whose terms cancel, that of
3; of hyperbolic sines, whose terms do not, as far as there are enough of them."""
EVEN_NEAR[[_SIN, _COS, _SINH, _COSH, _TANH, _LOG_COSH]] = 9.0, 9.0, 100.0, 100.0, math.pi**2 / 8.0, math.pi**2 / 8.0


@numba.njit(error_model="numpy", cache=True)
def _is_near(s, g, k):
    """Whether coefficient k of an even rest is its power series; of a sine the first ones cancel earlier."""
    return s <= EVEN_NEAR[g] * (3.0 if k > 2 and g in (_SIN, _COS) else 1.0)


@numba.njit(error_model="numpy", cache=True)
def _even_nearby(s, g, m, k):
    """Coefficient k of an even rest by powers of a change of s: the sum of c_(2 j + m) C(j, k) s^(j - k)."""
    total, weight = 0.0, 1.0
    for j in range(k, (REST_TERMS - m) // 2):
        term = REST_SERIES[g, 2 * j + m] * weight
        total += term
        if abs(term) <= 1e-18 * abs(total) and j > 2 * k + 4:
            break
        weight *= s * (j + 1.0) / (j + 1.0 - k)
    return total


@numba.njit(error_model="numpy", cache=True)
def _of_square(s, i, k):
    """Ratio of the weights of coefficient i of a function of v in the coefficients k + 1 and k by powers of s = v^2.

    By Lagrange's inversion of s = (v + w)^2 the weight is (i/k) (-1)^(k - i) C(2 k - i - 1, k - i) (2 v)^(i - 2 k).
    """
    return -(2.0 * k - i + 1.0) * (2.0 * k - i) / ((k + 1.0) * (k - i + 1.0) * 4.0 * s)


@numba.njit(error_model="numpy", cache=True)
def _even_coefficient(s, g, m, k):
    """Coefficient k of an even rest by powers of a change of s."""
    if _is_near(s, g, k):
        return _even_nearby(s, g, m, k)
    v, total = math.sqrt(s), 0.0
    for i in range(k + 1):
        weight = (2.0 * v) ** -float(i)
        for j in range(i, k):
            weight *= _of_square(s, i, j)
        total += weight * _rest_coefficient(v, g, 0.0, m, i)
    return total


@numba.njit(error_model="numpy", cache=True)
def even_rest_expanded(s, g, m, order, derivative, count, target, stride):
    """Write Taylor coefficients of a derivative of the function of that order, at s + w, by powers of w."""
    g, m, whole = int(g), int(m), int(order) + derivative
    for k in range(count):
        target[k * stride] = _even_nearby(s, g, m, k + whole) if _is_near(s, g, k + whole) else 0.0
    if not _is_near(s, g, whole):
        v = math.sqrt(s)
        for i in range(whole + count):
            value = _rest_coefficient(v, g, 0.0, m, i)
            weight = (2.0 * v) ** -float(i)
            for k in range(i, whole + count):
                if k >= whole and not _is_near(s, g, k):
                    target[(k - whole) * stride] += weight * value
                weight *= _of_square(s, i, k)
    for k in range(count):
        for i in range(whole):
            target[k * stride] *= k + whole - i


@numba.njit(error_model="numpy", cache=True)
def even_rest(s, g, m, order):
    """Derivative of an order by s of what the first m terms of the Taylor series of g(v) leave, over v^m, s = v^2 >= 0.

    ``g``: number of the function in `RESTS`, whose terms from m on are even. ``m``: 0 to 4.
    """
    value = _even_coefficient(s, int(g), int(m), int(order))
    for i in range(int(order)):
        value *= i + 1
    return value


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
        even_rest,
    )
}
"""Code of the special functions by name."""

EXPANSIONS = {
    "hunt_crossley_duration": hunt_crossley_duration_expanded,
    "bernoulli_ratio": bernoulli_ratio_expanded,
    "taylor_rest": taylor_rest_expanded,
    "power_rest": power_rest_expanded,
    "even_rest": even_rest_expanded,
}
"""Code of the Taylor coefficients of those that have it, by name."""

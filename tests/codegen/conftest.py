"""Taylor coefficients from outside: Cauchy's integral in many digits, of expressions that mpmath evaluates."""

from functools import cache

import mpmath
import numpy as np
import pytest
import sympy

DIGITS = 160
RADIUS = mpmath.mpf("1e-4")


@cache
def _turns(count):
    """Unit roots: (cos, sin) of j/count of a turn."""
    with mpmath.workdps(DIGITS):
        return [(z.real, z.imag) for z in (mpmath.expjpi(mpmath.mpf(2 * j) / count) for j in range(count))]


def _circle(order):
    """Places on half of a circle; on the other half a function that is real on the axis has the conjugate values."""
    return [RADIUS * mpmath.mpc(*z) for z in _turns(order + 1)[: (order + 1) // 2 + 1]]


def _cauchy(values, order):
    """Coefficients 0 to order at 0 from values on ``_circle``; the aliases are smaller by RADIUS^(order + 1)."""
    count = order + 1
    turns = _turns(count)
    # a place and its conjugate give twice the real part; what is its own conjugate counts once
    parts = [(v.real, v.imag) if 2 * j % count == 0 else (2 * v.real, 2 * v.imag) for j, v in enumerate(values)]
    found = []
    for k in range(count):
        at = [turns[j * k % count] for j in range(len(parts))]
        total = mpmath.fsum(x * c + y * s for (x, y), (c, s) in zip(parts, at, strict=True))
        found.append(total / (count * RADIUS**k))
    return found


@pytest.fixture(scope="session")
def numeric():
    """An expression as a function of mpmath numbers, in the order of the symbols given."""

    def make(symbols, expression):
        return sympy.lambdify(symbols, expression, "mpmath")

    return make


@pytest.fixture
def circle():
    """``circle(order)``: the places at which ``from_circle(values, order)`` wants values, in the digits it needs."""
    with mpmath.workdps(DIGITS):
        yield _circle


@pytest.fixture
def from_circle():
    """Coefficients of a function from its values at the places of ``circle``."""
    with mpmath.workdps(DIGITS):
        yield lambda values, order: _cauchy([mpmath.mpc(v) for v in values], order)


@pytest.fixture
def coefficients(circle, from_circle):
    """``coefficients(function, order)`` of a function of a complex mpmath number."""
    return lambda function, order: from_circle([function(z) for z in circle(order)], order)


@pytest.fixture(scope="session")
def polynomial():
    """A polynomial with double coefficients as a function of an mpmath number, exact."""

    def make(row):
        exact = [mpmath.mpf(float(a)) for a in row[::-1]]
        return lambda s: mpmath.polyval(exact, s)

    return make


@pytest.fixture(scope="session")
def agree():
    """Assert that coefficients agree, each on the scale that the radius of convergence gives it.

    ``beside`` are coefficients that these are computed from, whose radius may be smaller.
    """

    def check(found, expected, tolerance, beside=()):
        expected = np.array([float(e) for e in expected])
        powers = np.arange(len(expected))
        rows = np.abs([expected, *beside])
        rate = max(1e-3, float((rows[:, 1:] ** (1 / powers[1:])).max()))
        bound = tolerance * (rows / rate**powers).max() * rate**powers + 1e-300
        np.testing.assert_array_less(np.abs(np.asarray(found, dtype=float) - expected), bound)

    return check

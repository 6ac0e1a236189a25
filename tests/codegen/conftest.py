"""Taylor coefficients from outside: Cauchy's integral in many digits, of expressions that mpmath evaluates."""

import mpmath
import numpy as np
import pytest
import sympy

DIGITS = 160
RADIUS = mpmath.mpf("1e-4")


def _cauchy(function, order):
    """Coefficients 0 to order at 0 of a function that is real there; the aliases are smaller by RADIUS^(order + 1)."""
    count = order + 1
    turns = [mpmath.expjpi(mpmath.mpf(2 * j) / count) for j in range(count)]
    values = [function(RADIUS * z) for z in turns[: count // 2 + 1]]
    # at conjugate places they are conjugate
    values += [mpmath.conj(values[count - j]) for j in range(count // 2 + 1, count)]
    found = []
    for k in range(count):
        total = mpmath.fsum(value * turns[(-j * k) % count] for j, value in enumerate(values))
        found.append(mpmath.re(total) / (count * RADIUS**k))
    return found


@pytest.fixture(scope="session")
def numeric():
    """An expression as a function of mpmath numbers, in the order of the symbols given."""

    def make(symbols, expression):
        return sympy.lambdify(symbols, expression, "mpmath")

    return make


@pytest.fixture
def coefficients():
    """``coefficients(function, order)`` of a function of a complex mpmath number."""
    with mpmath.workdps(DIGITS):
        yield _cauchy


@pytest.fixture(scope="session")
def polynomial():
    """A polynomial with double coefficients as a function of an mpmath number, exact."""

    def make(row):
        return lambda s: mpmath.polyval([mpmath.mpf(float(a)) for a in row[::-1]], s)

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

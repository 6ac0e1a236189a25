"""Functions of lanes against the standard library, whose results are right to about half a unit in the last place."""

import math
import operator

import numba
import numpy as np
import pytest
from numba import float64, void

import chaosdrill.engine.lane_functions  # noqa: F401  defines sine, cosine and exponential of lanes
from chaosdrill.engine.lanes import LANES, aligned, chosen, larger, magnitude, row_of

matrix = float64[:, ::1]


def applied(function, x):
    """The compiled function of every row of lanes of x, shape (rows, 8)."""

    @numba.njit(void(matrix, matrix), error_model="numpy")
    def over_rows(given, out):
        source, target = row_of(given), row_of(out)
        for i in range(given.shape[0]):
            target[i] = function(source[i])

    given, out = aligned(*x.shape), aligned(*x.shape)
    given[:] = x
    over_rows(given, out)
    return out


def random(low, high, rows=2000):
    return np.random.default_rng(5).uniform(low, high, (rows, LANES))


@pytest.mark.parametrize("span", [1.0, 30.0, 9e4])
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine(name, span):
    x = random(-span, span)
    expected = getattr(np, name)(x)
    function = math.sin if name == "sin" else math.cos
    error = np.abs(applied(numba.njit(lambda v: function(v)), x) - expected)
    assert (error <= 2 * np.spacing(np.maximum(np.abs(expected), 0.125))).all()


@pytest.mark.parametrize("span", [0.3, 20.0, 690.0])
def test_exponential(span):
    x = random(-span, span)
    expected = np.exp(x)
    assert (np.abs(applied(numba.njit(lambda v: math.exp(v)), x) - expected) <= 2 * np.spacing(expected)).all()


def test_what_is_out_of_range_goes_to_the_standard_library_and_leaves_its_neighbours():
    x = random(-1, 1, 1)
    beside = applied(numba.njit(lambda v: math.sin(v) + math.exp(v)), x)
    x[0, [2, 5]] = 1e7, np.nan
    found = applied(numba.njit(lambda v: math.sin(v) + math.exp(v)), x)
    assert found[0, 2] == np.inf
    assert np.isnan(found[0, 5])
    others = [0, 1, 3, 4, 6, 7]
    np.testing.assert_array_equal(found[0, others], beside[0, others])
    far = applied(numba.njit(lambda v: math.cos(v)), np.full((1, LANES), 1e15))
    np.testing.assert_array_equal(far, np.full((1, LANES), math.cos(1e15)))
    ends = applied(
        numba.njit(lambda v: math.exp(v)), np.array([[-np.inf, -800.0, -745.0, 0.0, 709.0, 710.0, 1.0, 2.0]])
    )
    np.testing.assert_array_equal(ends[0, [0, 1, 3, 5]], [0.0, 0.0, 1.0, np.inf])
    assert ends[0, 2] == math.exp(-745.0)


@pytest.mark.parametrize("name", ["tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "atanh", "sqrt"])
def test_functions_taken_lane_by_lane(name):
    x = np.abs(random(0.0, 0.99, 50))
    function = getattr(math, name)
    expected = np.vectorize(function)(x)
    np.testing.assert_allclose(applied(numba.njit(lambda v: function(v)), x), expected, rtol=3e-16)


def test_logarithm_and_powers():
    x = random(0.1, 9.0, 50)
    np.testing.assert_allclose(applied(numba.njit(lambda v: math.log(v)), x), np.log(x), rtol=3e-16, atol=1e-16)
    np.testing.assert_allclose(applied(numba.njit(lambda v: v**1.7), x), x**1.7, rtol=1e-15)
    np.testing.assert_allclose(applied(numba.njit(lambda v: 1.7**v), x), 1.7**x, rtol=1e-15)


@pytest.mark.parametrize("symbol", [operator.add, operator.sub, operator.mul, operator.truediv])
def test_a_number_stands_for_eight(symbol):
    x = random(1.0, 2.0, 3)
    np.testing.assert_array_equal(applied(numba.njit(lambda v: symbol(v, 3)), x), symbol(x, 3.0))
    np.testing.assert_array_equal(applied(numba.njit(lambda v: symbol(0.5, v)), x), symbol(0.5, x))


def test_larger_magnitude_and_choice():
    x = random(-1.0, 1.0, 3)
    np.testing.assert_array_equal(applied(numba.njit(lambda v: larger(v, 0.25)), x), np.maximum(x, 0.25))
    np.testing.assert_array_equal(applied(numba.njit(lambda v: magnitude(-v)), x), np.abs(x))
    choice = applied(numba.njit(lambda v: chosen(larger(v, 0.0), v, -1.0 * v)), x)
    np.testing.assert_array_equal(choice, np.abs(x))

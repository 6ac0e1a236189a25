"""What compiled functions do with numbers, done with eight at once."""

import operator

import numba
import numpy as np
import pytest
from numba import float64, void

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

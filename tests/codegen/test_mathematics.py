"""Functions of one number and of eight side by side, against the standard library.

Its results are right to about half a unit in the last place.
"""

import ctypes
import math

import numpy as np
import pytest

from chaosdrill.codegen.addresses import called_back
from chaosdrill.codegen.emitter import Function, Module, array
from chaosdrill.codegen.kinds import float64, void
from chaosdrill.codegen.machine import NativeFunction, compile_object, load
from chaosdrill.codegen.mathematics import START, power, root
from chaosdrill.codegen.signatures import LANES
from chaosdrill.engine.lanes import aligned


def applied(function, x, width=LANES):
    """The compiled function of every number of x, shape (rows, width)."""
    module = Module(width)
    f = Function(module, "over_rows", {"given": array(2), "out": array(2)})
    source, target = (f.row(argument) for argument in f.arguments)
    with f.loop(0, len(x)) as i:
        target[i] = function(source[i])
    f.end()
    matrix = float64[:, ::1]
    library = load(compile_object(str(module)), {})
    call = NativeFunction("over_rows", void(matrix, matrix), library)
    given, out = aligned(len(x), LANES), aligned(len(x), LANES)
    shape = (len(x), width)
    given.reshape(-1)[: x.size] = x.reshape(-1)
    call(given, out)
    return out.reshape(-1)[: x.size].reshape(shape).copy()


def random(low, high, rows=2000):
    return np.random.default_rng(5).uniform(low, high, (rows, LANES))


@pytest.mark.parametrize("span", [1.0, 30.0, 9e4])
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine(name, span):
    x = random(-span, span)
    expected = getattr(np, name)(x)
    function = START[name]
    error = np.abs(applied(function, x) - expected)
    assert (error <= 2 * np.spacing(np.maximum(np.abs(expected), 0.125))).all()


@pytest.mark.parametrize("span", [0.3, 20.0, 690.0])
def test_exponential_is_right_to_two_last_digits(span):
    x = random(-span, span)
    expected = np.exp(x)
    assert (np.abs(applied(START["exp"], x) - expected) <= 2 * np.spacing(expected)).all()


def test_what_is_out_of_range_goes_to_the_standard_library_and_leaves_its_neighbours():
    x = random(-1, 1, 1)
    beside = applied(lambda v: START["sin"](v) + START["exp"](v), x)
    x[0, [2, 5]] = 1e7, np.nan
    found = applied(lambda v: START["sin"](v) + START["exp"](v), x)
    assert found[0, 2] == np.inf
    assert np.isnan(found[0, 5])
    others = [0, 1, 3, 4, 6, 7]
    np.testing.assert_array_equal(found[0, others], beside[0, others])
    far = applied(START["cos"], np.full((1, LANES), 1e15))
    np.testing.assert_array_equal(far, np.full((1, LANES), math.cos(1e15)))
    ends = applied(START["exp"], np.array([[-np.inf, -800.0, -745.0, 0.0, 709.0, 710.0, 1.0, 2.0]]))
    np.testing.assert_array_equal(ends[0, [0, 1, 3, 5]], [0.0, 0.0, 1.0, np.inf])
    assert ends[0, 2] == math.exp(-745.0)


@pytest.mark.parametrize("name", ["tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "atanh"])
def test_functions_taken_lane_by_lane(name):
    x = np.abs(random(0.0, 0.99, 50))
    function, expected = START[name], np.vectorize(getattr(math, name))(x)
    np.testing.assert_allclose(applied(function, x), expected, rtol=3e-16)


def test_logarithm_and_powers():
    x = random(0.1, 9.0, 50)
    np.testing.assert_allclose(applied(START["log"], x), np.log(x), rtol=3e-16, atol=1e-16)
    np.testing.assert_allclose(applied(lambda v: power(v, v.function.number(1.7)), x), x**1.7, rtol=1e-15)
    np.testing.assert_allclose(applied(lambda v: power(v.function.number(1.7), v), x), 1.7**x, rtol=1e-15)


@pytest.mark.parametrize("width", [1, LANES])
def test_square_root_is_that_of_numpy(width):
    x = random(0.0, 9.0, 50)[:, :width]
    np.testing.assert_array_equal(applied(root, x, width), np.sqrt(x))


def test_what_python_refuses_to_compute_is_nan_for_machine_code():
    """Machine code that calls a function of Python cannot pass its exceptions on: the result would be left unset."""
    double = ctypes.c_double
    one = called_back(lambda x: math.sqrt(x) / x, double, double)
    assert math.isnan(one(-1.0))
    assert math.isnan(one(0.0))
    assert one(4.0) == 0.5

    def terms(x, count, target, stride):
        target[0] = 1.0
        target[stride] = math.log(x)

    rows = np.full((3, 2), 5.0)
    whole, pointer = ctypes.c_int64, ctypes.POINTER(double)
    called_back(terms, None, double, whole, pointer, whole)(-1.0, 3, rows.ctypes.data_as(pointer), 2)
    assert np.isnan(rows[:, 0]).all()
    assert (rows[:, 1] == 5.0).all()

"""The coefficients of order 8: scipy's, and of the order that they claim, with the step and with the dense output."""

import numpy as np
import pytest
from scipy.integrate import DOP853

from chaosdrill.engine import dop853_tables as tables


def test_coefficients_are_those_of_scipy():
    n = tables.STAGES
    np.testing.assert_array_equal(tables.A[:n, :n], DOP853.A)
    np.testing.assert_array_equal(tables.A[n, :n], DOP853.B)
    np.testing.assert_array_equal(tables.A[n + 1 :], DOP853.A_EXTRA)
    np.testing.assert_array_equal(tables.C, [*DOP853.C, 1, *DOP853.C_EXTRA])
    np.testing.assert_array_equal([*tables.E3, 0], DOP853.E3)
    np.testing.assert_array_equal([*tables.E5, 0], DOP853.E5)


def field(t, x):
    """x = exp(sin(t)) and y = cos(x): nothing in it is linear."""
    return np.array([x[0] * np.cos(t), -np.sin(x[0]) * x[0] * np.cos(t)])


def exact(t):
    x = np.exp(np.sin(t))
    return np.array([x, np.cos(x)])


def step(t, x, h, stages):
    rates = np.zeros((tables.DENSE_STAGES, 2))
    for k in range(stages):
        rates[k] = field(t + tables.C[k] * h, x + h * tables.A[k] @ rates)
    return rates


def orders(lengths, errors):
    return np.diff(np.log(errors)) / np.diff(np.log(lengths))


def test_the_step_is_of_order_eight():
    errors, counts = [], np.array([8, 16, 32])
    for count in counts:
        x, h = exact(0.0), 3 / count
        for i in range(count):
            x = x + h * tables.A[tables.STAGES] @ step(i * h, x, h, tables.STAGES)
        errors.append(np.abs(x - exact(3.0)).max())
    assert orders(1 / counts, errors).min() > 7.8


def test_the_dense_output_is_of_order_seven_and_starts_as_the_flow_does():
    lengths, errors = np.array([0.8, 0.4, 0.2]), []
    for h in lengths:
        rates = step(0.1, exact(0.1), h, tables.DENSE_STAGES)
        powers = h * tables.DENSE @ rates
        np.testing.assert_array_equal(powers[0], h * rates[0])
        u = np.linspace(0, 1, 21)[:, None]
        path = exact(0.1) + sum(u ** (k + 1) * powers[k] for k in range(tables.DEGREE))
        errors.append(np.abs(path - np.array([exact(0.1 + s * h) for s in u[:, 0]])).max())
    # order 7 is a local error of h**8
    assert orders(lengths, errors).min() > 7.5


@pytest.mark.parametrize("function", [np.exp, lambda u: np.cos(3 * u), lambda u: 1 / (2 + u)])
def test_guards_are_interpolated_to_eleven_digits(function):
    series = tables.TO_CHEBYSHEV @ function(tables.NODES)
    powers = tables.TO_POWERS.T @ series
    u = np.linspace(0, 1, 33)
    np.testing.assert_allclose(np.polynomial.polynomial.polyval(u, powers), function(u), atol=1e-11)

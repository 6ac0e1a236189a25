"""Multipliers far below the round-off of the largest one of their orbit, against closed forms and many digits."""

import numpy as np
import pytest
import sympy
from mpmath import mp

import chaosdrill as cd

x, y, a, b = sympy.symbols("x y a b", real=True)


@pytest.fixture(scope="module")
def henon():
    """x := 1 - a x^2 + y, y := b x: areas change by -b an iterate."""
    system = cd.Map(states=(x, y), parameters={"a": 0.3, "b": 1e-3}, images={x: 1 - a * x**2 + y, y: b * x})
    return cd.continue_orbit(system.with_initial(x=0.8, y=0.0), {"a": (0.3, 1.6)}, doublings=3, step=0.02)


def _multipliers(found):
    return found["multiplier_real"].values + 1j * found["multiplier_imag"].values


def test_multipliers_multiply_to_the_change_of_areas(henon):
    assert henon["doubling_period"].values.tolist() == [1, 2, 4, 8]
    known = (-1e-3) ** henon["period"].values.astype(float)
    assert (np.abs(_multipliers(henon).prod(axis=1) / known - 1) < 1e-8).all()


@pytest.mark.parametrize("period", [2, 8])
def test_each_multiplier_has_its_digits(henon, period, digits):
    digits(60)
    point = np.flatnonzero(henon["period"].values == period)[-1]
    value, size = mp.mpf(float(henon["a"][point])), mp.mpf(1e-3)
    state = mp.matrix(henon["orbit_state"].values[point].tolist())
    for _ in range(4):
        place, tangent = state.copy(), mp.eye(2)
        for _ in range(period):
            tangent = mp.matrix([[-2 * value * place[0], 1], [size, 0]]) * tangent
            place = mp.matrix([1 - value * place[0] ** 2 + place[1], size * place[0]])
        state -= mp.lu_solve(tangent - mp.eye(2), place - state)
    exact = sorted((complex(v) for v in mp.eig(tangent, left=False, right=False)), key=abs, reverse=True)
    assert abs(exact[1]) < 1e-14 * abs(exact[0]) or period == 2
    np.testing.assert_allclose(_multipliers(henon)[point], exact, rtol=1e-8)

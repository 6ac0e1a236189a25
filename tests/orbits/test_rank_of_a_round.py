"""A round that ends on its only event loses the rank that the event takes, exactly."""

import math

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import find_orbit


@pytest.mark.parametrize("names", ["x y s", "s y x"])
def test_a_reset_that_forgets_a_state(names):
    """x' = -x + y, y' = -y/3, and y := 1/2 and x := x + 1/10 after a unit of time: multipliers 1, 1/e and 0."""
    x, y, s = sympy.symbols("x y s", real=True)
    half, tenth, third = sympy.Rational(1, 2), sympy.Rational(1, 10), sympy.Rational(1, 3)
    turn = cd.Transition("turn", "on", "on", guard=s - 1, direction=1, reset={s: 0, y: half, x: x + tenth})
    system = cd.HybridSystem(
        name="forgetful", states=sympy.symbols(names, real=True), parameters={},
        modes={"on": {x: -x + y, y: -third * y, s: sympy.Integer(1)}}, transitions=[turn],
        initial={"mode": "on", x: 0.1, y: 0.5, s: 0.0},
    )  # fmt: skip
    found = find_orbit(system, 1, "attractor", 20, Numerics(tolerance=1e-13))
    assert found.rank == 2
    np.testing.assert_allclose(found.multipliers[:2], [1, 1 / math.e], atol=1e-12)
    assert found.multipliers[2] == 0
    np.testing.assert_allclose(found.checks.exponents[:2], [0, -1], atol=1e-12)
    assert np.isneginf(found.checks.exponents[2])
    assert found.checks.consistent, found.checks.disagreements

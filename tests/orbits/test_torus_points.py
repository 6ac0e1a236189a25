"""Neimark-Sacker points are found whatever other multipliers are near to the unit circle."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.special import outside, pair_on_circle, torus_test


@pytest.mark.parametrize("slow", [1e-4, 1e-7])
def test_a_slow_real_multiplier_hides_no_pair(slow):
    """x'' + p x' + x = cos(w t)/10 turns unstable at p = 0, with |mu| = exp(-p T/2); beside it z decays slowly."""
    x, v, z, t, p, w, k = sympy.symbols("x v z t p w k", real=True)
    system = cd.HybridSystem(
        name="slow-beside", states=(x, v, z), time=t, parameters={"p": 0.2, "w": 1.7, "k": slow},
        modes={"on": {x: v, v: -p * v - x + sympy.cos(w * t) / 10, z: -k * z}}, period=2 * sympy.pi / w,
        initial={"mode": "on"},
    )  # fmt: skip
    result = branches(system, "p", (-0.5, 0.5), 1, "attractor", 200, 0, 0.02, 200, Numerics(), None)
    assert [e.code for e in result.events] == [Special.NEIMARK_SACKER]
    assert abs(result.events[0].values[0]) < 1e-12
    assert (result.stable == (result.values[:, 0] > 0))[result.special == Special.REGULAR].all()


@pytest.mark.parametrize("others", [[], [0.0], [0.0, 0.0, 0.9999], [0.9999, -0.9999, 1.0001]])
def test_the_sign_changes_with_the_pair_alone(others):
    values = [np.array([r * np.exp(1j), r * np.exp(-1j), *others]) for r in (0.999, 1.001)]
    assert torus_test(values[0]) * torus_test(values[1]) < 0
    assert outside(values[1]) - outside(values[0]) == 2
    assert pair_on_circle(values[0]) == pytest.approx(1e-3)


def test_two_real_multipliers_are_no_pair():
    assert pair_on_circle(np.array([2.0, 0.5], dtype=complex)) == np.inf

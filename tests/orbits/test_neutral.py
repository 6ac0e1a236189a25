"""Orbits that come in families: what the structure of a system leaves neutral is no obstacle, and is told."""

import math

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.model.derive import conserved_combinations, shift_directions
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.find import find_orbit
from chaosdrill.orbits.multipliers import neutral_of

FINE = Numerics(tolerance=1e-13)
x, v, y, z, t, c, w = sympy.symbols("x v y z t c w", real=True)


@pytest.fixture(scope="module")
def carried():
    """A forced linear oscillator and z' = v: z - x is conserved, and z can be anything."""
    return cd.HybridSystem(
        name="carried", states=(x, v, z), time=t, parameters={"c": 0.2, "w": 1.7}, period=2 * sympy.pi / w,
        modes={"on": {x: v, v: -c * v - x + sympy.cos(w * t) / 10, z: v}}, initial={"mode": "on", z: 3.0},
    )  # fmt: skip


def response(damping, frequency=1.7):
    """State (x, v) at phase 0, and the multipliers of the oscillator."""
    amplitude = 0.1 / (1 - frequency**2 + 1j * damping * frequency)
    rate = complex(-damping / 2, math.sqrt(1 - damping**2 / 4))
    pair = np.exp(np.array([rate, rate.conjugate()]) * 2 * math.pi / frequency)
    return np.array([amplitude.real, (1j * frequency * amplitude).real]), pair


def test_a_shift_and_what_it_changes_are_one(carried):
    assert shift_directions(carried) == [[0, 0, 1]]
    assert np.array(conserved_combinations(carried)) @ [1, 0, 1] == pytest.approx([0])
    assert neutral_of(carried).count == 1


def test_a_stable_orbit_beside_a_conserved_quantity(carried):
    found = find_orbit(carried, 1, "attractor", 200, FINE)
    state, pair = response(0.2)
    np.testing.assert_allclose(found.states[0, :2], state, atol=1e-12)
    # z - x stays 3
    assert found.states[0, 2] == pytest.approx(3 + state[0], abs=1e-10)
    assert found.multipliers[0] == pytest.approx(1, abs=1e-13)
    assert sorted(found.multipliers[1:].imag) == pytest.approx(sorted(pair.imag), abs=1e-12)
    assert found.neutral == 1
    assert found.checks.consistent, found.checks.disagreements
    orbit = cd.periodic_orbit(carried)
    assert int(orbit["stable"]) == 1
    assert int(orbit["neutral"]) == 1
    assert "shifted along z" in orbit.attrs["structure"]


def test_a_branch_of_them(carried):
    result = branches(carried, "c", (0.1, 0.5), 1, "attractor", 200, 0, 0.02, 200, FINE, None)
    assert (result.values[0, 0], result.values[-1, 0]) == (0.1, 0.5)
    assert not result.events
    assert result.stable.all()
    expected = np.array([response(damping)[0] for damping in result.values[:, 0]])
    np.testing.assert_allclose(result.section[:, 0, :2], expected, atol=1e-11)


def test_a_sum_that_is_kept_is_that_of_the_start():
    """x and y turn into each other at a forced rate: their sum is kept, and deviations at a constant sum die out."""
    flow = (2 + sympy.cos(t)) * x - y
    system = cd.HybridSystem(
        name="exchange", states=(x, y), time=t, parameters={}, modes={"on": {x: -flow, y: flow}},
        period=2 * sympy.pi, initial={"mode": "on", x: 0.7, y: 0.1},
    )  # fmt: skip
    found = find_orbit(system, 1, "guess", 0, FINE)
    assert found.states[0].sum() == pytest.approx(0.8, abs=1e-12)
    np.testing.assert_allclose(found.multipliers, [1, math.exp(-6 * math.pi)], atol=1e-13)
    assert found.neutral == 1


def test_a_state_that_drifts_has_no_orbit(carried):
    drifting = cd.HybridSystem(
        name="drifting", states=(x, v, z), time=t, parameters={"c": 0.2, "w": 1.7}, period=2 * sympy.pi / w,
        modes={"on": {x: v, v: -c * v - x + sympy.cos(w * t) / 10, z: v + x**2}}, initial={"mode": "on", z: 3.0},
    )  # fmt: skip
    assert find_orbit(drifting, 1, "attractor", 200, FINE).outcome.meaning == "open"

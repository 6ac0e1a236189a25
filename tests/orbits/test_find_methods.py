"""Every method of integration finds the same orbit, each to its own tolerance."""

import numpy as np
import pytest
from support.closed_autonomous import belt, gait

from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import find_orbit
from chaosdrill.systems import build

METHODS = [
    (Numerics(tolerance=1e-13), 1e-11),
    (Numerics(tolerance=1e-7), 1e-5),
    (Numerics("dop853", 1e-12), 1e-9),
    (Numerics("rk4", 1e-12, 1000), 1e-8),
]


@pytest.mark.parametrize(("numerics", "error"), METHODS)
def test_the_drill(drill, numerics, error):
    found = find_orbit(drill, 1, "attractor", 200, numerics)
    assert found.outcome == Outcome.PERIODIC
    assert found.checks.consistent, found.checks.disagreements
    # quadruple precision, another program
    expected = [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]
    np.testing.assert_allclose(found.states[0], expected, atol=error)
    np.testing.assert_allclose(found.multipliers[0].real, 0.11672896840556, atol=10 * error)
    assert found.rank == 2


@pytest.mark.parametrize(("numerics", "error"), METHODS)
def test_the_belt(numerics, error):
    system = build("belt-stick-slip")
    own = system.parameters
    closed = belt(own["belt"], own["F_s"], own["F_k"])
    found = find_orbit(system, 1, "attractor", 50, numerics)
    assert found.duration == pytest.approx(closed.period, abs=error)
    np.testing.assert_allclose(found.multipliers, [1, 0], atol=10 * error)
    assert found.multipliers[1] == 0


@pytest.mark.parametrize(("numerics", "error"), METHODS)
def test_the_wheel(numerics, error):
    system = build("rimless-wheel")
    closed = gait(system.parameters["alpha"], system.parameters["gamma"])
    found = find_orbit(system, 1, "attractor", 50, numerics)
    assert found.duration == pytest.approx(closed.period, abs=error)
    np.testing.assert_allclose(found.multipliers.real, closed.multipliers, atol=10 * error)

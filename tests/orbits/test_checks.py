"""An orbit's numbers are compared with each other, and one that is wrong is told."""

from dataclasses import replace

import numpy as np
import pytest

from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import find_orbit, starting_orbit
from chaosdrill.orbits.verification import check, describe, verify
from chaosdrill.systems import build

FINE = Numerics(tolerance=1e-13)


@pytest.fixture(scope="module")
def bouncing():
    problem, orbit, shot, residuals, _ = starting_orbit(build("bouncing-ball"), (), 1, "attractor", 200, FINE)
    return problem, orbit, describe(problem, orbit, shot, residuals), verify(problem, orbit)


def test_true_numbers_agree(bouncing):
    problem, orbit, found, lapped = bouncing
    checks = check(problem, orbit, found, lapped)
    assert checks.consistent
    assert checks.disagreements == ""
    # both multipliers have the modulus e = 0.8
    np.testing.assert_allclose(checks.exponents * found.duration, np.log(0.8), atol=1e-12)
    assert max(checks.exponent_difference, checks.determinant_difference, checks.recurrence_difference) < 1e-12


def test_a_wrong_multiplier_is_told(bouncing):
    problem, orbit, found, lapped = bouncing
    wrong = replace(found, multipliers=found.multipliers * np.array([1 + 1e-7, 1]))
    checks = check(problem, orbit, wrong, lapped)
    assert not checks.consistent
    assert "exponents" in checks.disagreements
    assert "product of all contractions" in checks.disagreements


def test_a_wrong_rank_is_told():
    found = find_orbit(build("belt-stick-slip"), 1, "attractor", 50, FINE)
    assert found.checks.consistent
    problem, orbit, *_ = starting_orbit(build("belt-stick-slip"), (), 1, "attractor", 50, FINE)
    checks = check(problem, orbit, replace(found, multipliers=np.array([1.0, 1e-14 + 0j])), verify(problem, orbit))
    assert checks.exponent_difference == np.inf
    assert not checks.consistent


def test_a_start_beside_the_orbit_is_told(bouncing):
    problem, orbit, found, _ = bouncing
    beside = replace(orbit, starts=orbit.starts + 1e-6)
    lapped = verify(problem, beside)
    assert lapped.residual > lapped.explained(1e-13)
    assert "second period" in check(problem, orbit, found, lapped).disagreements


@pytest.mark.parametrize("name", ["lorenz", "roessler", "chua"])
def test_multipliers_far_apart_keep_their_digits(name):
    found = find_orbit(build(name), 1, "attractor", 300, FINE)
    assert found.checks.consistent
    assert abs(found.multipliers[-1]) < 1e-5
    logs = np.log(np.abs(found.multipliers))
    assert found.multipliers[1] == pytest.approx(1, abs=1e-8)
    if name == "lorenz":
        # the divergence is the same everywhere: -(sigma + 1 + beta)
        assert logs.sum() == pytest.approx(-(10 + 1 + 8 / 3) * found.duration, abs=1e-9)

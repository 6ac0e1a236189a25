"""Stick-slip on a belt: period in closed form, multipliers 1 and 0."""

from math import atan, pi

import numpy as np
import pytest

import chaosdrill as cd

CASES = [(0.2, 1.0, 0.5), (0.1, 1.0, 0.6), (0.7, 1.5, 0.3)]


def period(belt, static, kinetic):
    drop = static - kinetic
    return 2 * drop / belt + 2 * pi - 2 * atan(drop / belt)


@pytest.mark.parametrize("case", CASES)
def test_period(case):
    belt, static, kinetic = case
    system = cd.build("belt-stick-slip", {"belt": belt, "F_s": static, "F_k": kinetic}, initial={"v": belt})
    run = cd.trajectory(system, duration=200)
    names = run["event_kind"].attrs["flag_meanings"].split()
    releases = run["event_time"].values[run["event_kind"].values == names.index("release")]
    assert len(releases) > 5
    np.testing.assert_allclose(np.diff(releases), period(*case), rtol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_multipliers(case, strobed, multipliers):
    belt, static, kinetic = case
    system = cd.build("belt-stick-slip", {"belt": belt, "F_s": static, "F_k": kinetic}, initial={"v": belt})
    section = cd.poincare_section(strobed(system, period(*case)), periods=16, transient=8)
    assert int(section["period"]) == 1
    np.testing.assert_allclose(multipliers(section), [1, 0], atol=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_exponents_are_zero_and_minus_infinity(case):
    belt, static, kinetic = case
    # within the stick, so that no event falls on the end of a whole number of cycles
    start = {"x": 0.25, "v": belt}
    system = cd.build("belt-stick-slip", {"belt": belt, "F_s": static, "F_k": kinetic}, initial=start)
    cycle = period(*case)
    spectrum = cd.lyapunov_spectrum(system, duration=200 * cycle, transient=8 * cycle)
    exponents = spectrum["lyapunov_exponent"].values
    assert abs(exponents[0]) < 1e-10
    assert exponents[1] == -np.inf

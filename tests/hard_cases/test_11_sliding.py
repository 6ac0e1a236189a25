"""Case 11: sticking that is only just touched, and a cycle that begins to stick."""

from math import exp, log, pi

import numpy as np
import pytest

import chaosdrill as cd


@pytest.mark.parametrize("excess", [1e-12, 1e-10, 1e-6, 1e-2])
def test_a_demand_that_only_just_exceeds_friction_lets_go(excess, case):
    run = cd.trajectory(case(11).block(1 + excess), periods=3, samples=2)
    release, stick = case(11).slipping(1 + excess)
    peaks = 1 + 2 * pi * np.arange(3)
    expected = np.ravel([peaks + release, peaks + stick], order="F")
    # the demand near its peak is flat: round-off moves a crossing of slope `release` by this much
    np.testing.assert_allclose(run["event_time"].values, expected, rtol=0, atol=1e-15 / abs(release) + 1e-14)


@pytest.mark.parametrize("excess", [-1e-14, -1e-10, -1e-6])
def test_a_demand_that_stays_below_does_not(excess, case):
    assert cd.trajectory(case(11).block(1 + excess), periods=3, samples=2).sizes["event"] == 0


@pytest.mark.parametrize("short", [-1e-2, -1e-6])
def test_below_the_belt_speed_both_exponents_are_the_damping(short, case):
    sliding = case(11)
    system = sliding.on_a_belt(sliding.grazing_force() * (1 + short))
    section = cd.poincare_section(system, periods=4, transient=1000)
    modulus = np.hypot(section["multiplier_real"].values, section["multiplier_imag"].values)
    assert modulus == pytest.approx([exp(-sliding.ZETA * 2 * pi / sliding.OMEGA)] * 2, rel=1e-10)
    spectrum = cd.lyapunov_spectrum(system, periods=500, transient=1000)
    assert spectrum["lyapunov_exponent"].values.sum() == pytest.approx(-2 * sliding.ZETA, abs=1e-12)
    assert int(spectrum["rank"]) == 2


@pytest.mark.parametrize("beyond", [1e-10, 1e-8, 1e-6])
def test_from_the_first_touch_on_one_exponent_is_minus_infinity(beyond, case):
    sliding = case(11)
    system = sliding.on_a_belt(sliding.grazing_force() * (1 + beyond))
    section = cd.poincare_section(system, periods=4, transient=1000)
    limit = sliding.multiplier_beyond()
    # the cycle leaves its limit as the square root of how far the force is beyond
    assert section["multiplier_real"].values[0] == pytest.approx(limit, abs=3 * beyond**0.5)
    assert section["multiplier_real"].values[1] == section["multiplier_imag"].values[1] == 0.0
    spectrum = cd.lyapunov_spectrum(system, periods=200, transient=1000)
    first, second = spectrum["lyapunov_exponent"].values
    assert first == pytest.approx(log(abs(limit)) * sliding.OMEGA / (2 * pi), abs=3 * beyond**0.5)
    assert second == -np.inf
    assert int(spectrum["rank"]) == 1

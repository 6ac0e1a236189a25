"""Rimless wheel: multipliers 1 and cos^2(2 alpha) exactly."""

from math import cos, log

import mpmath
import numpy as np
import pytest

import chaosdrill as cd

CASES = [(0.3, 0.15), (0.2, 0.1), (0.39269908169872414, 0.2)]


def step_time(alpha, slope):
    """Duration of a step of the rolling gait, from its energy balance."""
    with mpmath.workdps(30):
        keep = mpmath.cos(2 * alpha) ** 2
        gain = 2 * (mpmath.cos(slope - alpha) - mpmath.cos(slope + alpha))
        start = keep * gain / (1 - keep)

        def pace(angle):
            return 1 / mpmath.sqrt(start + 2 * (mpmath.cos(slope - alpha) - mpmath.cos(angle)))

        return float(mpmath.quad(pace, mpmath.linspace(slope - alpha, slope + alpha, 9)))


@pytest.mark.parametrize(("alpha", "slope"), CASES)
def test_gait(alpha, slope):
    run = cd.trajectory(cd.build("rimless-wheel", {"alpha": alpha, "gamma": slope}), duration=300)
    steps = np.diff(run["event_time"].values)
    np.testing.assert_allclose(steps[-10:], step_time(alpha, slope), rtol=1e-10)


@pytest.mark.parametrize(("alpha", "slope"), CASES)
def test_multipliers(alpha, slope, strobed, multipliers):
    system = cd.build("rimless-wheel", {"alpha": alpha, "gamma": slope})
    section = cd.poincare_section(strobed(system, step_time(alpha, slope)), periods=16, transient=200)
    assert int(section["period"]) == 1
    np.testing.assert_allclose(multipliers(section), [1, cos(2 * alpha) ** 2], atol=1e-9)


@pytest.mark.parametrize(("alpha", "slope"), CASES)
def test_exponents(alpha, slope):
    step = step_time(alpha, slope)
    system = cd.build("rimless-wheel", {"alpha": alpha, "gamma": slope})
    spectrum = cd.lyapunov_spectrum(system, duration=400 * step, transient=200 * step)
    expected = [0.0, 2 * log(cos(2 * alpha)) / step]
    np.testing.assert_allclose(spectrum["lyapunov_exponent"].values, expected, atol=1e-9)

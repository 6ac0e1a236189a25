"""One bounce a period on a moving floor: impact speed and multipliers in closed form, without the high-bounce limit."""

from math import pi, sqrt

import numpy as np
import pytest

import chaosdrill as cd

CASES = [(0.8, 0.9), (0.8, 0.4), (0.6, 0.95)]


def closed_form(e, amplitude):
    """Normal speed, trace and determinant of the period map, gravity and frequency 1."""
    floor = (1 - e) / (1 + e) * pi
    acceleration = -amplitude * sqrt(1 - (floor / amplitude) ** 2)
    return floor + pi, 1 + e**2 + (1 + e) ** 2 * acceleration, e**2


@pytest.mark.parametrize(("e", "amplitude"), CASES)
def test_impact_speed_and_multipliers(e, amplitude, multipliers):
    floor = (1 - e) / (1 + e) * pi
    phase = np.arccos(floor / amplitude)
    # on its way down, a little slower than on the orbit
    start = {"x": amplitude * np.sin(phase) + pi * phase - phase**2 / 2, "v": phase - pi + 0.01}
    system = cd.build("bouncing-ball", {"e": e, "amplitude": amplitude}, initial=start)
    section = cd.poincare_section(system, periods=16, transient=2000)
    speed, trace, determinant = closed_form(e, amplitude)
    assert int(section["period"]) == 1
    expected = sorted(np.roots([1.0, -trace, determinant]), key=lambda z: (-round(abs(z), 9), -z.imag))
    np.testing.assert_allclose(multipliers(section), expected, atol=1e-9)
    run = cd.trajectory(system, periods=3, transient=2000)
    np.testing.assert_allclose(-run["event_speed"].values, speed, rtol=1e-11)

"""Impact oscillator with its wall at the rest position: orbit, multipliers and period doubling in closed form."""

from math import cos, pi, sqrt, tan

import numpy as np
import pytest

import chaosdrill as cd

R = 0.8
DOUBLING = 2.65334772785532


def oscillator(w, **start):
    return cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": w, "e": R}, initial=start)


def closed_form(w):
    """Trace of the period map, and impact speed, of the orbit with one impact a period."""
    c, half = cos(2 * pi / w), pi / w
    trace = -2 * R * c + (1 + R) ** 2 * (1 - w**2) * (1 + c) / 2
    speed = 1 / abs(1 - w**2) / sqrt(((1 + R) / tan(half) / 2) ** 2 + ((1 - R) / (2 * w)) ** 2)
    return trace, speed


@pytest.mark.parametrize("w", [2.5, 2.6, 2.65])
def test_multipliers_and_impact_speed(w, multipliers):
    trace, speed = closed_form(w)
    section = cd.poincare_section(oscillator(w), periods=64, transient=2000)
    assert int(section["period"]) == 1
    expected = np.roots([1.0, -trace, R**2])
    expected = sorted(expected, key=lambda z: (-round(abs(z), 9), -z.imag))
    np.testing.assert_allclose(multipliers(section), expected, atol=1e-9)

    run = cd.trajectory(oscillator(w), periods=3, transient=2000)
    np.testing.assert_allclose(np.abs(run["event_speed"].values), speed, rtol=1e-10)
    assert run["state"].values[:, 0].max() <= 1e-12


def test_the_orbit_doubles_where_it_should():
    periods = []
    for w in (DOUBLING - 2e-3, DOUBLING + 2e-3):
        section = cd.poincare_section(oscillator(w), periods=64, transient=20_000)
        periods.append(int(section["period"]))
    assert periods == [1, 2]


def test_measured_multipliers_put_the_doubling_in_its_place(multipliers):
    assert closed_form(DOUBLING)[0] == pytest.approx(-(1 + R**2), abs=1e-12)
    frequencies = DOUBLING - 1e-3 * np.arange(1, 6)
    distance = []
    for w in frequencies:
        section = cd.poincare_section(oscillator(w), periods=16, transient=20_000)
        distance.append(np.prod(1 + multipliers(section)).real)
    # the frequency as a polynomial of the distance to a multiplier -1, continued to 0
    found = np.polynomial.Polynomial.fit(distance, frequencies, 4)(0.0)
    assert found == pytest.approx(DOUBLING, abs=1e-10)

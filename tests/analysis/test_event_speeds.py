"""The speed of an event is the rate of its guard as it is written, whatever other guards share the surface."""

from math import cos, exp, sin

import numpy as np
import pytest

import chaosdrill as cd

C = 2.0
"""Rate of x"""

# x = 1, met with y = 1/C, by guards of all kinds: direction, and the rate of each there by hand
GUARDS = {
    "x - 1": (1, C),
    "5*x - 5": (1, 5 * C),
    "3 - 3*x": (-1, -3 * C),
    "exp(-x) - exp(-1)": (-1, -C * exp(-1)),
    "(x - 1)*(1 + y**2)": (1, C * (1 + C**-2)),
    "(1 - x)*(2 + sin(y))": (-1, -C * (2 + sin(1 / C))),
    "tanh(3*(x - 1)) + k*(x - 1)": (1, C * (3 + 7)),
    "cos(x) - cos(1)": (-1, -C * sin(1)),
    "sin(x*y) - sin(y)": (1, C * cos(1 / C) / C),
}
SPEEDS = [speed for _, speed in GUARDS.values()]


@pytest.fixture(scope="module")
def system():
    """x grows to 1 in mode after mode, each with its own guard there, and starts again."""
    modes = [f"m{i}" for i in range(len(GUARDS))]
    return cd.HybridSystem(
        name="one surface",
        states=("x", "y"),
        parameters={"c": C, "k": 7.0},
        modes={mode: {"x": "c", "y": "1"} for mode in modes},
        transitions=[
            cd.Transition(f"e{i}", mode, modes[(i + 1) % len(modes)], guard, way, {"x": "0", "y": "0"})
            for i, (mode, (guard, (way, _))) in enumerate(zip(modes, GUARDS.items(), strict=True))
        ],
        initial={"mode": "m0", "x": 0.0, "y": 0.0},
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
def test_events(system, method):
    run = cd.trajectory(system, duration=len(GUARDS) / C + 0.1, method=method)
    np.testing.assert_allclose(run["event_speed"].values, SPEEDS, rtol=1e-9)


def test_orbits(system):
    orbit = cd.periodic_orbit(system, at="e0", method="dop853")
    np.testing.assert_allclose(orbit["event_speed"].values, np.roll(SPEEDS, -1), rtol=1e-9)
    assert float(orbit["smallest_speed"]) == pytest.approx(C * exp(-1), rel=1e-12)


def test_smallest_speeds(system):
    spectrum = cd.lyapunov_spectrum(system, duration=20.0, transient=0, method="dop853")
    assert float(spectrum["closest_grazing"]) == pytest.approx(C * exp(-1), rel=1e-12)
    branch = cd.continue_orbit(system, {"c": (1.9, 2.1)}, at="e0", method="dop853")
    np.testing.assert_allclose(branch["smallest_speed"], branch["c"] * exp(-1), rtol=1e-9)

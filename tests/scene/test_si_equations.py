"""A scene in SI units moves as equations (1) to (4) of the paper do in SI units."""

import math

import pytest
import sympy

from chaosdrill.scene import parse_scene

# the quantities of the scene, and a state of the drill: stretch, speeds of bit and rock (m, m/s), time (s)
M1, M2, K, C, A, B, W = 250.0, 125.0, 4e6, 3800.0, 2000.0, 5600.0, 100.0
STATIC, KINETIC, GAMMA = 0.8 * 10e3, 0.48 * 10e3, 12.0
STRETCH, BIT, ROCK, TIME = 1.3e-3, 0.11, 0.04, 0.017


@pytest.fixture
def scene(in_si):
    return parse_scene(in_si)


@pytest.fixture
def here(scene):
    """Parameters, state and time of the dimensionless system at the state above."""
    system = scene.system
    length, second = scene.scales["length_m"], scene.scales["time_s"]
    state = {"y": STRETCH / length, "u": BIT / length * second, "w": ROCK / length * second, "t": TIME / second}
    return {sympy.Symbol(name, real=True): value for name, value in (system.parameters | state).items()}


def rate(scene, here, mode, state):
    return float(scene.system.modes[mode][sympy.Symbol(state, real=True)].subs(here))


def test_scales(scene):
    assert scene.scales["length_m"] == pytest.approx(STATIC / K, rel=1e-15)
    assert scene.scales["time_s"] == pytest.approx(math.sqrt(M1 / K), rel=1e-15)


def test_acceleration_of_the_bit(scene, here):
    force = A * math.cos(W * TIME + math.pi / 2) + B - C * (BIT - ROCK) - K * STRETCH
    expected = force / M1 * scene.scales["time_s"] ** 2 / scene.scales["length_m"]
    assert rate(scene, here, "slip", "u") == pytest.approx(expected, rel=1e-12)


def test_acceleration_of_the_rock(scene, here):
    friction = KINETIC + (STATIC - KINETIC) * math.exp(-GAMMA * ROCK)
    force = C * (BIT - ROCK) + K * STRETCH - friction
    expected = force / M2 * scene.scales["time_s"] ** 2 / scene.scales["length_m"]
    assert rate(scene, here, "slip", "w") == pytest.approx(expected, rel=1e-12)


def test_stop_and_stiffness(scene):
    parameters = scene.system.parameters
    assert parameters["r"] * scene.scales["length_m"] == pytest.approx(2e-3, rel=1e-15)
    # the contact's force at a depth of a micrometre, in units of the static friction
    depth = 1e-6
    expected = 4.8e12 * depth / STATIC
    assert parameters["k"] * depth / scene.scales["length_m"] == pytest.approx(expected, rel=1e-12)
    # lam times a dimensionless speed is lambda times the speed in m/s
    speed = scene.scales["length_m"] / scene.scales["time_s"]
    assert parameters["lam"] == pytest.approx(2.4 * speed, rel=1e-12)

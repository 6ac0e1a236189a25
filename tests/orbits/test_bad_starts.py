"""A start that leads to no orbit gets an outcome and words, never numbers."""

from math import sqrt

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import find_orbit
from chaosdrill.systems import build


def nothing(system, outcome, words, period=1, start="guess", transient=100):
    found = find_orbit(system, period, start, transient, Numerics(tolerance=1e-13))
    assert found.outcome == outcome, found.message
    assert words in found.message
    assert found.period == period
    assert len(found.states) == len(found.event_times) == 0
    assert np.isnan(found.multipliers).all()
    assert np.isnan(found.residual)


def test_chatter_that_never_rests():
    pressed = build("impact-oscillator", {"wall": -0.5, "amplitude": 0.1}, initial={"x": -0.6})
    nothing(pressed, Outcome.STALLED, "infinitely many impacts")


def test_a_state_beyond_a_guard():
    nothing(build("impact-oscillator", initial={"x": 0.5}), Outcome.INVALID_START, "beyond a guard")


def test_a_mode_that_escapes(drill):
    nothing(drill.with_initial(y=-1.0, u=2.0), Outcome.ESCAPED, "runs away")
    nothing(drill.with_parameters(eta=0.48), Outcome.ESCAPED, "ended", start="attractor")


@pytest.mark.parametrize("rho", [0.5, 10.0])
def test_a_flow_that_comes_to_rest(rho):
    nothing(build("lorenz", {"rho": rho}), Outcome.EQUILIBRIUM, "comes to rest", start="attractor")


def test_a_flow_that_starts_at_rest():
    at_rest = sqrt(8 / 3 * 27)
    for x in (0.0, at_rest):
        start = {"x": x, "y": x, "z": 27.0 if x else 0.0}
        nothing(build("lorenz", initial=start), Outcome.EQUILIBRIUM, "comes to rest")


def test_a_forced_system_without_force(drill):
    words = "a point at rest"
    nothing(build("impact-oscillator", {"amplitude": 0.0}), Outcome.EQUILIBRIUM, words, start="attractor")
    nothing(drill.with_parameters(a=0.0, b=0.3), Outcome.EQUILIBRIUM, words, start="attractor")


def test_states_that_only_grow():
    nothing(build("percussive-drill-5d"), Outcome.OPEN, "x1 by 0.9", start="attractor")


def test_an_angle_that_only_grows():
    angle, rate = sympy.symbols("angle rate", real=True)
    turning = cd.HybridSystem(
        name="turning",
        states=(angle, rate),
        parameters={},
        modes={"on": {angle: rate, rate: 1 + sympy.cos(angle) - rate}},
        initial={"mode": "on", angle: 0.0, rate: 1.0},
    )
    nothing(turning, Outcome.OPEN, "angle by", start="attractor")


def test_a_period_that_no_orbit_has():
    # counted by another program: no orbit of period 3 or 5
    for period in (3, 5):
        nothing(build("impact-oscillator"), Outcome.NO_ORBIT, "Newton's method", period, "attractor")

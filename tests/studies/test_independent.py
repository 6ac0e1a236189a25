"""The program that checks the impact oscillator from outside is itself right where the answer is known."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp


@pytest.fixture(scope="module")
def independent():
    sys.path.insert(0, str(Path(__file__).parents[2] / "studies" / "silent_error"))
    try:
        import independent

        yield independent
    finally:
        sys.path.pop(0)


def _rates(t, state):
    return [state[1], -state[0] - 0.1 * state[1] + math.cos(2.5 * t)]


def _wall(t, state):
    return state[0] - 0.3


_wall.terminal, _wall.direction = True, 1


def test_free_flight_solves_the_equation(independent):
    solution = solve_ivp(_rates, (0.7, 2.2), [0.1, -0.4], rtol=1e-12, atol=1e-13)
    assert independent._flow(0.1, -0.4, 0.7, 1.5) == pytest.approx(solution.y[:, -1], abs=1e-10)


def test_an_impact_is_met_and_reverses_the_speed(independent):
    state, time, impacts = [0.0, 0.3], 0.0, 0
    while time < independent.PERIOD:
        leg = solve_ivp(_rates, (time, independent.PERIOD), state, rtol=1e-12, atol=1e-13, events=_wall)
        time, state = leg.t[-1], leg.y[:, -1]
        if leg.status == 1:
            state, impacts = [0.3, -0.8 * state[1]], impacts + 1
    x, v, count = independent._period(0.0, 0.3)
    assert count == impacts > 0
    assert [x, v] == pytest.approx(list(state), abs=1e-9)


def test_growth_of_a_small_distance_is_the_largest_exponent(independent):
    growth, impacts = independent.two_trajectories(20_000, 500, 50, 1e-8)
    error = np.std(growth, ddof=1) / math.sqrt(growth.size)
    assert growth.mean() == pytest.approx(0.0914, abs=3 * error)
    assert -0.1 + 2 * math.log(0.8) * impacts.mean() == pytest.approx(0.0914 - 0.3190, abs=3e-3)


def test_tangents_without_impacts_know_only_the_damping(independent):
    history = independent.events_left_out(2_000, 10)
    assert history[-1] == pytest.approx([-0.05, -0.05], abs=1e-4)

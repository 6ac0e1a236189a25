"""The linearised equations of an orbit against differences of the equations themselves."""

from dataclasses import replace

import numpy as np
import pytest

from chaosdrill.orbits.find import orbit_read
from chaosdrill.orbits.guess import initial_guess, reached, settled
from chaosdrill.orbits.problem import Problem
from chaosdrill.systems import build

CASES = {
    "impact-oscillator": ({"wall": 0.0, "zeta": 0.02, "omega": 2.6}, {"x": -0.6, "v": 0.0}, "omega"),
    "bouncing-ball": ({}, {}, "amplitude"),
    "rimless-wheel": ({}, {}, "alpha"),
}
STEP = 1e-6


def moved(problem, orbit, column, step):
    """The path with one reduced unknown changed; starts of later segments stay, the parameter changes along all."""
    d, count = problem.states, len(orbit)
    starts, phase, durations = orbit.starts.copy(), orbit.phase, orbit.durations.copy()
    if column < d:
        starts[0, column] += step
    elif column == d:
        phase += step
    elif column < d + 1 + count:
        durations[column - d - 1] += step
    else:
        starts[:, d + column - (d + 1 + count)] += step
    return replace(orbit, starts=starts, phase=phase, durations=durations)


@pytest.mark.parametrize("name", CASES)
def test_equations_of_one_arc_are_linearised_exactly(name):
    parameters, initial, free = CASES[name]
    system = build(name, parameters, {}).with_initial(**initial)
    plain = Problem(system)
    _, run = settled(plain, 200)
    orbit, _, _ = orbit_read(plain, initial_guess(plain, reached(run, plain.numerics), 1), 1)
    assert len(orbit) == 1
    problem = Problem(system, (free,))
    value = system.parameters[free]
    orbit = replace(orbit, starts=np.column_stack([orbit.starts, np.full(len(orbit), value)]))
    here = problem.shoot(orbit)
    columns = here.equations.shape[1] - 1
    for column in range(columns):
        ahead, behind = (problem.shoot(moved(problem, orbit, column, s)).equations[:, -1] for s in (STEP, -STEP))
        difference = (ahead - behind) / (2 * STEP)
        if not problem.forced and column == problem.states:
            # the last equation keeps a phase that means nothing where it is
            difference[-1] = 1.0
        assert np.abs(difference - here.equations[:, column]).max() < 1e-7 * (1 + np.abs(difference).max())


def test_a_frequency_changes_the_orbit_as_two_solutions_differ(drill_period_one):
    """Several segments, and a parameter that the period depends on."""
    problem, orbit, shot = drill_period_one
    weights = problem.weights(orbit, np.array([0.5]))
    direction = problem.direction(orbit, shot, weights)
    slope = direction / direction[-1]
    value = orbit.starts[0, -1]
    ahead, behind = (problem.newton(orbit.with_values(np.array([value + s]), 3))[1].reduced(3) for s in (1e-5, -1e-5))
    assert np.abs((ahead - behind) / 2e-5 - slope).max() < 1e-6 * np.abs(slope).max()


def test_the_flow_direction_of_an_autonomous_orbit_has_the_multiplier_one(rimless):
    _, _, shot = rimless
    assert np.abs(np.linalg.eigvals(shot.monodromy) - 1).min() < 1e-13


@pytest.fixture
def rimless():
    problem = Problem(build("rimless-wheel", {}, {}))
    _, run = settled(problem, 50)
    orbit, shot, _ = orbit_read(problem, initial_guess(problem, reached(run, problem.numerics), 1), 1)
    return problem, orbit, shot

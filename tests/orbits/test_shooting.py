"""The equations of an orbit, their derivatives and solution, and what an orbit's numbers are checked against."""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import find_orbit, orbit_read, starting_orbit
from chaosdrill.orbits.guess import initial_guess, settled
from chaosdrill.orbits.multipliers import is_stable, multipliers
from chaosdrill.orbits.place import reached
from chaosdrill.orbits.problem import Problem, solve
from chaosdrill.orbits.verification import check, describe, verify
from chaosdrill.systems import build

# The linearised equations of an orbit against differences of the equations themselves.


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


def test_a_direction_that_goes_on_from_another_takes_no_singular_values(drill_period_one, monkeypatch):
    """Those of a thousand segments take seconds: every step along the branch of a long orbit would."""
    problem, orbit, shot = drill_period_one
    weights = problem.weights(orbit, np.array([0.5]))
    ahead = -problem.direction(orbit, shot, weights) + 0.01 / weights
    monkeypatch.setattr(np.linalg, "svd", None)
    found = problem.direction(orbit, shot, weights, ahead * weights**2)
    equations = shot.equations[: len(orbit) + problem.states + 1, :-1]
    assert np.abs(equations @ found).max() < 1e-12 * np.abs(equations / weights).max()
    assert np.linalg.norm(weights * found) == pytest.approx(1)
    assert found[-1] < 0


def test_a_map_without_a_derivative_has_no_multipliers(drill_period_one):
    """As at grazing; those of the maps beside it are not touched."""
    problem, orbit, shot = drill_period_one
    d = problem.states
    whole = shot.monodromy[:d, :d]
    found = multipliers(problem, orbit, np.stack([whole, np.full((d, d), np.nan)]), d)
    assert np.isnan(found[1]).all()
    np.testing.assert_array_equal(found[0], multipliers(problem, orbit, whole, d))


def test_the_flow_direction_of_an_autonomous_orbit_has_the_multiplier_one(rimless):
    _, _, shot = rimless
    assert np.abs(np.linalg.eigvals(shot.monodromy) - 1).min() < 1e-13


@pytest.fixture
def rimless():
    problem = Problem(build("rimless-wheel", {}, {}))
    _, run = settled(problem, 50)
    orbit, shot, _ = orbit_read(problem, initial_guess(problem, reached(run, problem.numerics), 1), 1)
    return problem, orbit, shot


# Linear equations of a step of Newton's method: square ones, more than unknowns, and some that say nothing.


def test_square_equations_of_very_different_sizes():
    rng = np.random.default_rng(3)
    sizes = 10.0 ** rng.uniform(-8, 8, 6)
    matrix = rng.normal(size=(6, 6)) * 10.0 ** rng.uniform(-8, 8, (6, 1)) / sizes
    known = rng.normal(size=6) * sizes
    assert solve(matrix, matrix @ known, 1 / sizes) == pytest.approx(known, rel=1e-10)


def test_an_equation_that_follows_from_others_holds_with_them():
    rng = np.random.default_rng(4)
    matrix, known = rng.normal(size=(5, 4)), rng.normal(size=4)
    matrix[4] = matrix[0] - 2 * matrix[1]
    assert solve(matrix, matrix @ known, np.ones(4)) == pytest.approx(known, rel=1e-12)


def test_what_no_equation_tells_stays_where_it_is():
    matrix = np.array([[1.0, 0.0, 2.0], [0.0, 0.0, 1.0], [2.0, 0.0, 4.0]])
    assert solve(matrix, np.array([3.0, 1.0, 6.0]), np.ones(3)) == pytest.approx([1.0, 0.0, 1.0], abs=1e-14)


def test_an_entry_that_is_no_number_leaves_no_solution():
    assert np.isnan(solve(np.array([[1.0, np.inf], [0.0, 1.0]]), np.ones(2), np.ones(2))).all()


# A round that ends on its only event loses the rank that the event takes, exactly.


@pytest.mark.parametrize("names", ["x y s", "s y x"])
def test_a_reset_that_forgets_a_state(names):
    """x' = -x + y, y' = -y/3, and y := 1/2 and x := x + 1/10 after a unit of time: multipliers 1, 1/e and 0."""
    x, y, s = sympy.symbols("x y s", real=True)
    half, tenth, third = sympy.Rational(1, 2), sympy.Rational(1, 10), sympy.Rational(1, 3)
    turn = cd.Transition("turn", "on", "on", guard=s - 1, direction=1, reset={s: 0, y: half, x: x + tenth})
    system = cd.HybridSystem(
        name="forgetful", states=sympy.symbols(names, real=True), parameters={},
        modes={"on": {x: -x + y, y: -third * y, s: sympy.Integer(1)}}, transitions=[turn],
        initial={"mode": "on", x: 0.1, y: 0.5, s: 0.0},
    )  # fmt: skip
    found = find_orbit(system, 1, "attractor", 20, Numerics(tolerance=1e-13))
    assert found.rank == 2
    np.testing.assert_allclose(found.multipliers[:2], [1, 1 / math.e], atol=1e-12)
    assert found.multipliers[2] == 0
    np.testing.assert_allclose(found.checks.exponents[:2], [0, -1], atol=1e-12)
    assert np.isneginf(found.checks.exponents[2])
    assert found.checks.consistent, found.checks.disagreements


# An orbit's numbers are compared with each other, and a wrong one is reported.


FINE = Numerics(tolerance=1e-13)


@pytest.fixture(scope="module")
def bouncing():
    problem, orbit, shot, residuals, _ = starting_orbit(build("bouncing-ball"), (), 1, "attractor", 200, FINE)
    return problem, orbit, describe(problem, orbit, shot, residuals), verify(problem, orbit)


def test_true_numbers_agree(bouncing):
    problem, orbit, found, lapped = bouncing
    checks = check(problem, orbit, found, lapped)
    assert checks.consistent
    assert checks.disagreements == ""
    # both multipliers have the modulus e = 0.8
    np.testing.assert_allclose(checks.exponents * found.duration, np.log(0.8), atol=1e-12)
    assert max(checks.exponent_difference, checks.determinant_difference, checks.recurrence_difference) < 1e-12


def test_a_wrong_multiplier_is_told(bouncing):
    problem, orbit, found, lapped = bouncing
    wrong = replace(found, multipliers=found.multipliers * np.array([1 + 1e-7, 1]))
    checks = check(problem, orbit, wrong, lapped)
    assert not checks.consistent
    assert "exponents" in checks.disagreements
    assert "product of all contractions" in checks.disagreements


def test_a_wrong_rank_is_told():
    found = find_orbit(build("belt-stick-slip"), 1, "attractor", 50, FINE)
    assert found.checks.consistent
    problem, orbit, *_ = starting_orbit(build("belt-stick-slip"), (), 1, "attractor", 50, FINE)
    checks = check(problem, orbit, replace(found, multipliers=np.array([1.0, 1e-14 + 0j])), verify(problem, orbit))
    assert checks.exponent_difference == np.inf
    assert not checks.consistent


def test_a_start_beside_the_orbit_is_told(bouncing):
    problem, orbit, found, _ = bouncing
    beside = replace(orbit, starts=orbit.starts + 1e-6)
    lapped = verify(problem, beside)
    assert lapped.residual > lapped.explained(1e-13)
    assert "second period" in check(problem, orbit, found, lapped).disagreements


NEAR_ORBITS = {
    "lorenz": (4.53, {"x": -4.11, "y": -6.89, "z": 14.44}),
    "roessler": (17.52, {"x": 0.23, "y": 4.46, "z": 0.05}),
    "chua": (7.12, {"x": -1.0, "y": 0.2, "z": 0.85}),
}
"""A time and a state near an orbit: which orbit a chaotic run comes near to depends on its round-off."""


@pytest.mark.parametrize("name", NEAR_ORBITS)
def test_multipliers_far_apart_keep_their_digits(name):
    time, state = NEAR_ORBITS[name]
    found = find_orbit(build(name).with_initial(**state), 1, time, 0, FINE)
    assert found.duration == pytest.approx(time, abs=0.01)
    assert found.checks.consistent
    assert abs(found.multipliers[-1]) < 1e-5
    logs = np.log(np.abs(found.multipliers))
    assert found.multipliers[1] == pytest.approx(1, abs=1e-8)
    if name == "lorenz":
        # the divergence is the same everywhere: -(sigma + 1 + beta)
        assert logs.sum() == pytest.approx(-(10 + 1 + 8 / 3) * found.duration, abs=1e-9)


# Stability follows from the multipliers, the one along the flow of an autonomous system apart.


@pytest.mark.parametrize(
    ("multipliers", "autonomous", "stable"),
    [
        ([0.9 + 0.1j, 0.9 - 0.1j], False, True),
        ([-1.1, 0.2], False, False),
        ([1.0, 0.2], False, False),
        ([1.0 + 1e-13, 0.2], True, True),
        ([1.5, 1.0], True, False),
        ([-1.0, 1.0], True, False),
        ([np.nan, np.nan], False, False),
        ([np.nan, np.nan], True, False),
    ],
)
def test_stability(multipliers, autonomous, stable):
    assert bool(is_stable(np.array(multipliers, dtype=complex), int(autonomous))) is stable


def test_many_orbits_at_once():
    many = np.array([[2.0, 1.0], [1.0, 0.5]], dtype=complex)
    assert is_stable(many, 1).tolist() == [False, True]
    assert is_stable(many[:0], 1).shape == (0,)

"""Multipliers that pass through 1 without a fold, branches that shrink onto rest, and hits that are the only ones."""

import math

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.systems import build

x, v, y, t = sympy.symbols("x v y t", real=True)


def follow(system, parameter, limits, start="attractor", doublings=0):
    step = (limits[1] - limits[0]) / 200
    return branches(system, parameter, limits, 1, start, 300, doublings, step, 2000, Numerics(), None)


@pytest.fixture(scope="module")
def cubic():
    """y := k y - y^3 once a period: y = 0, and beyond k = 1 the two orbits y^2 = k - 1 of multiplier 3 - 2 k."""
    k = sympy.Symbol("k", real=True)
    jump = cd.Transition("jump", "rest", "rest", guard=sympy.sin(t), direction=1, reset={y: k * y - y**3})
    return cd.HybridSystem(
        name="cubic", states=(y,), time=t, parameters={"k": 1.5}, modes={"rest": {y: 0}}, transitions=[jump],
        period=2 * sympy.pi, initial={"mode": "rest", y: 0.5},
    )  # fmt: skip


def test_a_pitchfork_is_no_fold(cubic):
    result = follow(cubic, "k", (0.2, 2.5))
    crossings = [e for e in result.events if e.code == Special.BRANCH_POINT]
    assert [abs(e.values[0] - 1) < e.error < 1e-7 for e in crossings] == [True]
    assert not any(e.code == Special.FOLD for e in result.events)
    doublings = [e.values[0] for e in result.events if e.code == Special.PERIOD_DOUBLING]
    assert np.abs(np.array(doublings) - 2).max() < 1e-12
    regular = result.special == Special.REGULAR
    assert np.abs(result.multipliers[:, 0].real - (3 - 2 * result.values[:, 0]))[regular].max() < 1e-9


def test_a_symmetric_branch_says_where_it_loses_its_stability(cubic):
    result = follow(cubic.with_initial(y=0.0), "k", (0.3, 2.5), start="guess")
    crossings = [e for e in result.events if e.code == Special.BRANCH_POINT]
    assert [abs(e.values[0] - 1) < 1e-12 for e in crossings] == [True]
    assert (result.stable == (np.abs(result.values[:, 0]) < 1))[result.special == 0].all()


def test_a_cycle_that_shrinks_onto_rest_ends_there():
    """The normal form of a Hopf bifurcation at m = 0; the cycle has the radius sqrt(m)."""
    m = sympy.Symbol("m", real=True)
    square = x**2 + v**2
    field = {x: m * x - v - x * square, v: x + m * v - v * square}
    system = cd.HybridSystem(name="hopf", states=(x, v), parameters={"m": 1.0}, modes={"flow": field}, initial={x: 0.5})
    result = follow(system, "m", (-1.0, 2.0))
    assert BranchEnd.REST.advice in result.branches[0].end
    assert not len(result.events)
    radius = np.hypot(result.section[:, 0, 0], result.section[:, 0, 1])
    assert np.abs(radius**2 - result.values[:, 0]).max() < 1e-10


def test_the_lorenz_cycle_has_no_fold_between_its_homoclinic_orbit_and_40():
    system = build("lorenz", {}, {}).with_initial(x=-13.763610682134, y=-19.578751942452, z=27.0)
    result = branches(system, "rho", (15.0, 40.0), 1, "guess", 0, 0, 0.25, 2000, Numerics(), None)
    assert not len(result.events)
    assert result.values[[0, -1], 0].tolist() == [15.0, 40.0]
    assert np.abs(result.multipliers - 1).min(axis=1).max() < 1e-8


def test_the_only_hit_of_an_orbit_may_vanish():
    """Both ways from resonance the response leaves the wall where its amplitude is the wall's distance."""
    zeta, wall = 0.1, 1.2
    system = build("impact-oscillator", {"wall": wall, "zeta": zeta, "omega": 0.7}, {})
    result = follow(system, "omega", (0.3, 3.0), doublings=1)
    h = 1 - 2 * zeta**2
    exact = [math.sqrt(h + sign * math.sqrt(h * h - 1 + 1 / wall**2)) for sign in (-1, 1)]
    grazing = [e for e in result.events if e.code == Special.GRAZING and result.branch[e.point] == 0]
    assert len(grazing) == 2
    assert np.abs(np.sort([e.values[0] for e in grazing]) - exact).max() < 1e-9
    first = result.branch == 0
    assert result.values[first, 0].min() == 0.3
    assert result.values[first, 0].max() == 3.0
    # an orbit that is told as one of twice the period is none of the period itself
    doubled = (result.period == 2) & (result.special == Special.REGULAR)
    assert np.abs(result.section[doubled, 0] - result.section[doubled, 1]).max(axis=1).min() > 1e-6


def test_one_state_is_enough():
    k = sympy.Symbol("k", real=True)
    fire = cd.Transition("fire", "m", "m", guard=y - 1, direction=1, reset={y: 0})
    system = cd.HybridSystem(
        name="integrate-and-fire", states=(y,), parameters={"k": 2.0}, modes={"m": {y: k - y}}, transitions=[fire]
    )
    result = follow(system, "k", (1.5, 3.0))
    assert result.values[[0, -1], 0].tolist() == [1.5, 3.0]
    assert not len(result.events)

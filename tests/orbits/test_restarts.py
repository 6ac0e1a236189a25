"""Orbits that go on beyond their own guards are found wherever on them the search begins."""

import math

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.orbits.find import find_orbit

FINE = Numerics(tolerance=1e-13)


def clock_of(*states):
    """x'' = -c x' - x, kicked by L in its direction whenever x = 0 upward: what it meets, it goes through."""
    x, v, c, size = sympy.symbols("x v c L", real=True)
    kick = cd.Transition("kick", "swing", "swing", guard=x, direction=1, reset={v: v + size})
    return cd.HybridSystem(
        name="clock", states=[{"x": x, "v": v}[name] for name in states], parameters={"c": 0.2, "L": 1.0},
        modes={"swing": {x: v, v: -x - c * v}}, transitions=[kick], initial={"mode": "swing", x: -1.0, v: 0.0},
    )  # fmt: skip


@pytest.fixture(scope="module")
def clock():
    return clock_of("x", "v")


def turn(c):
    """Duration of a turn, and by what a deviation shrinks over it."""
    duration = 2 * math.pi / math.sqrt(1 - c**2 / 4)
    return duration, np.exp(-c / 2 * duration)


def is_the_cycle(found, c=0.2, size=1.0):
    duration, shrinks = turn(c)
    assert found.outcome == Outcome.PERIODIC, found.message
    assert found.duration == pytest.approx(duration, abs=1e-13)
    np.testing.assert_allclose(found.multipliers, [1, shrinks], atol=1e-12)
    # after the kick v = L + v exp(-c T/2)
    assert np.abs(found.event_states_after[0]).max() == pytest.approx(size / (1 - shrinks), rel=1e-12)
    assert found.checks.consistent, found.checks.disagreements


@pytest.mark.parametrize("transient", range(60, 80))
def test_the_clock_from_any_place(clock, transient):
    is_the_cycle(find_orbit(clock, 1, "attractor", transient, FINE))


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_the_clock_of_any_size(clock, size):
    changed = clock.with_parameters(L=size).with_initial(x=-size)
    is_the_cycle(find_orbit(changed, 1, "attractor", 70, FINE), size=size)


def test_the_clock_with_its_states_in_another_order():
    is_the_cycle(find_orbit(clock_of("v", "x"), 1, "attractor", 67, FINE))


def test_a_branch_of_clocks(clock):
    result = branches(clock, "c", (0.1, 0.4), 1, "attractor", 61, 0, 0.01, 200, FINE, None)
    assert result.message == ""
    assert not result.events
    assert (result.values[0, 0], result.values[-1, 0]) == (0.1, 0.4)
    expected = [turn(c)[1] for c in result.values[:, 0]]
    np.testing.assert_allclose(result.multipliers, np.column_stack([np.ones(len(expected)), expected]), atol=1e-12)
    assert result.stable.all()


@pytest.fixture(scope="module")
def walker():
    """The simplest walker: stance angle th, swing angle ph; the foot scuffs at mid-stance, through its own guard.

    Garcia, Chatterjee, Ruina and Coleman 1998, doi:10.1115/1.2798313.
    """
    th, om, ph, ps, slope = sympy.symbols("th om ph ps slope", real=True)
    stance = sympy.sin(th - slope)
    swing = stance + om**2 * sympy.sin(ph) - sympy.cos(th - slope) * sympy.sin(ph)
    turned = sympy.cos(2 * th)
    strike = cd.Transition(
        "strike", "swing", "swing", guard=ph - 2 * th, direction=1, condition=th < -0.05,
        reset={th: -th, om: turned * om, ph: -2 * th, ps: turned * (1 - turned) * om},
    )  # fmt: skip
    return cd.HybridSystem(
        name="walker", states=(th, om, ph, ps), parameters={"slope": 0.009},
        modes={"swing": {th: om, om: stance, ph: ps, ps: swing}}, transitions=[strike],
        initial={"mode": "swing", th: 0.2, om: -0.2, ph: 0.4, ps: -0.0158},
    )  # fmt: skip


@pytest.mark.parametrize("transient", range(20, 26))
def test_the_walker_from_any_place(walker, transient):
    found = find_orbit(walker, 1, "attractor", transient, FINE)
    assert found.outcome == Outcome.PERIODIC, found.message
    assert found.checks.consistent, found.checks.disagreements
    # the gait of period one at this slope, as widely published for this model
    gait = [0.200310900544287, -0.199832473004977, 0.400621801088574, -0.015822999948318]
    np.testing.assert_allclose(found.event_states_after[0], gait, atol=1e-9)
    assert found.rank == 3
    assert found.multipliers[3] == 0
    assert found.multipliers[0] == pytest.approx(1, abs=1e-10)
    assert abs(found.multipliers[1]) < 1

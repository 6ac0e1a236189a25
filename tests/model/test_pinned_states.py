"""Which states a mode pins: rate zero, and every way in sets them to a constant."""

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.model.derive import pinned_states

X, V, T, K = sympy.symbols("x v t k", real=True)


def system(reset, stuck=None, more=()):
    return cd.HybridSystem(
        name="stick",
        states=(X, V),
        time=T,
        parameters={"k": 1.0},
        modes={"slip": {X: V, V: -X}, "stick": stuck or {X: K, V: 0}},
        transitions=[
            cd.Transition("stick", "slip", "stick", guard=V, direction=-1, reset=reset),
            cd.Transition("release", "stick", "slip", guard=X - 1, direction=+1),
            *more,
        ],
    )


@pytest.mark.parametrize(
    ("reset", "pinned"),
    [({V: 0}, (1,)), ({V: K}, (1,)), ({}, ()), ({V: -V}, ()), ({V: T}, ()), ({V: 0, X: 0}, (1,))],
    ids=str,
)
def test_a_frozen_state_is_pinned_by_a_constant_only(reset, pinned):
    assert pinned_states(system(reset), "stick") == pinned


def test_a_state_that_moves_is_not_pinned():
    assert pinned_states(system({V: 0}, stuck={X: 0, V: 1}), "stick") == ()
    assert pinned_states(system({V: 0}), "slip") == ()


def test_a_mode_that_nothing_leads_into_pins_nothing():
    assert pinned_states(system({V: 0}, stuck={X: 1, V: 0}), "slip") == ()
    lonely = cd.HybridSystem(name="rest", states=(X,), parameters={}, modes={"rest": {X: 0}})
    assert pinned_states(lonely, "rest") == ()


@pytest.mark.parametrize(("inner", "pinned"), [({X: 0}, (1,)), ({V: V + 1}, ()), ({V: 2}, (1,))], ids=str)
def test_an_event_within_the_mode_may_move_it(inner, pinned):
    knock = cd.Transition("knock", "stick", "stick", guard=X, direction=+1, reset=inner)
    assert pinned_states(system({V: 0}, more=[knock]), "stick") == pinned

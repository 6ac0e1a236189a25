"""Transitions of one source, guard and direction are the outcomes of one event, tried in the order of declaration."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.events import mode_events
from chaosdrill.codegen.signatures import event_places

X, V, LIMIT = sympy.symbols("x v limit", real=True)


def outcome(name, target="a", **more):
    return cd.Transition(name, **{"source": "a", "target": target, "guard": X, "direction": +1, **more})


def outcome_of(system, c, speed):
    event = np.empty(event_places(2).size)
    return kernels_of(system).functions.event_map(0, 0, 0.0, c, np.array([0.0, speed]), 0, np.ones(2), 0.0, event)


@pytest.fixture(scope="module")
def system():
    return cd.HybridSystem(
        name="outcomes",
        states=(X, V),
        parameters={"limit": 2.0},
        modes={"a": {X: V, V: 0}, "b": {X: V, V: 0}},
        transitions=[
            outcome("slow", condition=V < LIMIT / 2),
            outcome("other-way", direction=-1, condition=sympy.Eq(V, 5)),
            outcome("middling", target="b", condition=sympy.And(V < LIMIT, sympy.Ne(V, 1.5))),
            outcome("exact", condition=sympy.Or(sympy.Eq(V, 1.5), V > 100)),
            outcome("fast", target="b", condition=sympy.Not(V >= 50)),
            cd.Transition("else", ("a", "b"), "b", guard=V - 9, direction=0),
        ],
    )


@pytest.mark.parametrize(
    ("speed", "taken"),
    [(0.5, "slow"), (1.0, "middling"), (1.5, "exact"), (2.0, "fast"), (49.0, "fast"), (60.0, None), (101.0, "exact")],
)
def test_the_first_condition_that_holds_decides(system, speed, taken):
    c = kernels_of(system).constants(system.parameters)
    assert outcome_of(system, c, speed) == ([t.name for t in system.transitions].index(taken) if taken else -1)


def test_the_limit_is_the_parameter_of_the_run(system):
    assert outcome_of(system, kernels_of(system).constants({"limit": 20.0}), 5.0) == 0


def test_events_are_grouped_by_guard_and_direction(system):
    first, second = (mode_events(system, mode) for mode in ("a", "b"))
    assert [e.outcomes for e in first] == [(0, 2, 3, 4), (1,), (5,)]
    assert [e.direction for e in first] == [1, -1, 0]
    assert [e.outcomes for e in second] == [(5,)]


def test_larger_priority_comes_first_then_declaration():
    names = [("first", 0), ("second", 3), ("third", 1), ("fourth", 3)]
    system = cd.HybridSystem(
        name="priorities",
        states=(X,),
        parameters={},
        modes={"a": {X: 1}},
        transitions=[
            cd.Transition(n, "a", "a", guard=X - i - 1, direction=1, priority=p) for i, (n, p) in enumerate(names)
        ],
    )
    assert [e.outcomes for e in mode_events(system, "a")] == [(1,), (3,), (2,), (0,)]


def test_tables_hold_directions_and_targets(system):
    np.testing.assert_array_equal(kernels_of(system).mode_table, [[3, 1, -1, 0], [1, 0, 0, 0]])
    np.testing.assert_array_equal(
        kernels_of(system).transition_table[:, :2], [[0, 1], [0, 1], [1, 0], [0, 1], [1, 0], [1, 0]]
    )

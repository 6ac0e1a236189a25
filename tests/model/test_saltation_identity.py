"""S F- = F+ as a symbolic identity, once time is a state: moving guards and resets, parameters, jumps of mode."""

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.model.derive import guard_gradient, jacobian, reset_jacobian, saltation

X, V, T, A, E, OMEGA = sympy.symbols("x v t a e omega", real=True)
FLOOR = A * sympy.sin(OMEGA * T)

CASES = {
    "moving floor": {"guard": X - FLOOR, "target": "flight", "reset": {V: (1 + E) * sympy.diff(FLOOR, T) - E * V}},
    "change of mode": {"guard": V - FLOOR, "target": "held", "reset": {}},
    "reset that names time": {"guard": X - V * T, "target": "held", "reset": {X: sympy.cos(T) * V, V: E * X**2}},
    "reset to a constant": {"guard": T - A, "target": "flight", "reset": {X: 0, V: 1}},
    "fold of the state": {"guard": X - 1, "target": "flight", "reset": {X: sympy.Mod(3 * V, 1)}},
}


def system(guard, target, reset):
    return cd.HybridSystem(
        name="case",
        states=(X, V),
        time=T,
        parameters={"a": 0.3, "e": 0.7, "omega": 2.0},
        modes={"flight": {X: V, V: -sympy.sin(X) + A * sympy.cos(OMEGA * T)}, "held": {X: sympy.exp(-X), V: -E * V}},
        transitions=[cd.Transition("event", "flight", target, guard=guard, direction=+1, reset=reset)],
    )


@pytest.mark.parametrize("parameters", [(), ("a",), ("a", "e")])
@pytest.mark.parametrize("case", CASES)
def test_the_flow_direction_survives(case, parameters):
    wide = system(**CASES[case]).augmented(time=True, parameters=parameters)
    (event,) = wide.transitions
    before = sympy.Matrix([wide.modes["flight"][s] for s in wide.states])
    image = {s: event.reset.get(s, s) for s in wide.states}
    after = sympy.Matrix([wide.modes[event.target][s] for s in wide.states]).xreplace(image)
    matrix = saltation(wide, event)
    assert matrix.shape == (2 + 1 + len(parameters),) * 2
    assert (matrix * before - after).applyfunc(sympy.simplify).is_zero_matrix


def test_explicit_time_is_in_the_saltation_of_the_narrow_system():
    """The block of the narrow system is that of the augmented one: S_narrow = S_wide[:n, :n]."""
    narrow = system(**CASES["moving floor"])
    wide = narrow.augmented(time=True)
    block = saltation(wide, wide.transitions[0])[:2, :2]
    assert (saltation(narrow, narrow.transitions[0]) - block).applyfunc(sympy.simplify).is_zero_matrix


def test_impact_on_a_wall_at_rest_has_its_textbook_form():
    """S = [[-e, 0], [(a+ + e a-)/v, -e]] for x = 0, v := -e v (di Bernardo et al. 2008, section 2.5)."""
    still = system(X, "flight", {V: -E * V})
    acceleration = still.modes["flight"][V].subs(X, 0)
    expected = sympy.Matrix([[-E, 0], [(1 + E) * acceleration / V, -E]])
    found = saltation(still, still.transitions[0]).subs(X, 0)
    assert (found - expected).applyfunc(sympy.simplify).is_zero_matrix


def test_no_jump_of_field_and_no_reset_leave_the_identity():
    calm = cd.HybridSystem(
        name="calm",
        states=(X, V),
        parameters={},
        modes={"one": {X: V, V: -X}, "two": {X: V, V: -X + (V - 1) ** 2}},
        transitions=[cd.Transition("break", "one", "two", guard=V - 1, direction=+1)],
    )
    assert saltation(calm, calm.transitions[0]).subs(V, 1) == sympy.eye(2)


def test_the_source_may_be_named_where_there_are_several():
    two = cd.HybridSystem(
        name="two",
        states=(X,),
        parameters={},
        modes={"slow": {X: 1}, "fast": {X: 3}, "end": {X: 6}},
        transitions=[cd.Transition("stop", ("slow", "fast"), "end", guard=X, direction=+1)],
    )
    assert saltation(two, two.transitions[0]) == sympy.Matrix([[6]])
    assert saltation(two, two.transitions[0], "fast") == sympy.Matrix([[2]])


def test_shapes_of_the_pieces():
    narrow = system(**CASES["reset that names time"])
    (event,) = narrow.transitions
    assert jacobian(narrow, "flight") == sympy.Matrix([[0, 1], [-sympy.cos(X), 0]])
    assert guard_gradient(narrow, event.guard) == [1, -T, -V]
    assert reset_jacobian(narrow, event) == [[0, sympy.cos(T), -sympy.sin(T) * V], [2 * E * X, 0, 0]]

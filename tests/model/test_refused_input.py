"""What is no system at all is refused when it is written down: the place, what was given, what is allowed."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.declared import reserved
from chaosdrill.model.special import hunt_crossley_exit

X, V, T, K = sympy.symbols("x v t k", real=True)
OMEGA = sympy.Symbol("omega", real=True)


def build(**changes):
    given = {
        "name": "mass",
        "states": (X, V),
        "time": T,
        "parameters": {"k": 2.0, "omega": 3.0},
        "modes": {"free": {X: V, V: -K * X + sympy.cos(OMEGA * T)}},
        "period": 2 * sympy.pi / OMEGA,
    }
    return cd.HybridSystem(**{**given, **changes})


def hit(**changes):
    given = {"source": "free", "target": "free", "guard": X - 1, "direction": +1, "reset": {V: -V}}
    return cd.Transition(**{"name": "hit", **given, **changes})


def rate(expression):
    return {"modes": {"free": {X: V, V: expression}}}


INPUT = {
    "one state of two letters": ({"states": "xv"}, "modes.free: gives no rate for 'xv'"),
    "one bare state": ({"states": X}, "states: received x; expected names in order, as in 'x v'"),
    "states in no order": ({"states": {X, V}}, "expected names in order"),
    "state that is a function": ({"states": (X, sympy.Function("v")(T))}, "states.1: received v(t); expected a name"),
    "time that is a number": ({"time": 3}, "time: received 3; expected a name"),
    "name that is a number": ({"name": 3}, "name: expected text in quotes, received 3"),
    "parameters in a list": (
        {"parameters": ["k", "omega"]},
        "parameters: expected a table of names (a dict in Python)",
    ),
    "modes in a list": ({"modes": [{X: V}]}, "modes: expected a table of names (a dict in Python), received [{x: v}]"),
    "field in a list": ({"modes": {"free": [V, -X]}}, "modes.free: expected a table of names (a dict in Python)"),
    "mode without a name": ({"modes": {"": {X: V, V: -X}}}, "modes.: expected text in quotes, received ''"),
    "state named twice": ({"modes": {"free": {X: V, V: -X, "v": X}}}, "modes.free: expected a table of names"),
    "initial in a list": (
        {"initial": [0.1, 0.2]},
        "initial: expected numbers by name, as in {'x': 0.1}, received [0",
    ),
    "quadratures in a list": ({"quadratures": [V**2]}, "quadratures: expected a table of names"),
    "bounds in a list": ({"bounds": [(-1, 1)]}, "bounds: expected a table of names"),
    "labels in a list": ({"labels": ["speed"]}, "labels: expected a table of names"),
    "no transitions": (
        {"transitions": None},
        "transitions: expected a list of transitions, [] for none, received None",
    ),
    "names of transitions": (
        {"transitions": ["hit"]},
        "transitions.0: expected a Transition, or a table, received 'hit'",
    ),
    "one bound": (
        {"bounds": {X: 3.0}},
        "bounds.x: expected [low, high], doubles or inf, with low < high, received 3.0",
    ),
    "three bounds": ({"bounds": {X: (1, 2, 3)}}, "low < high, received (1, 2, 3)"),
    "bounds as text": ({"bounds": {X: "12"}}, "low < high, received '12'"),
    "bounds the wrong way": ({"bounds": {X: (1, -1)}}, "low < high, received (1, -1)"),
    "bounds without width": ({"bounds": {X: (1, 1)}}, "low < high"),
    "bound that is no number": ({"bounds": {X: (float("nan"), 1)}}, "bounds.x: expected [low, high]"),
    "rate that is a list": (
        rate([1]),
        "modes.free.v: expected an expression, as text in quotes or of sympy, received [1]",
    ),
    "rate that is text": (rate("x +* v"), "modes.free.v: '*' cannot stand at letter 4 of 'x +* v'"),
    "rate that is None": (
        rate(None),
        "modes.free.v: expected an expression, as text in quotes or of sympy, received None",
    ),
    "rate that is a truth": (rate(True), "modes.free.v: True must be a number"),
    "rate that is a matrix": (rate(sympy.Matrix([X])), "v: expected one number or expression, received Matrix([[x]])"),
    "rate that is complex": (rate(sympy.sqrt(-1) * X), "modes.free.v: I*x is complex"),
    "rate that is a relation": (rate(X > 0), "modes.free.v: x > 0 must be a number, not a comparison"),
    "rate with an integral": (rate(sympy.Integral(X, (X, 0, V))), "is not carried out; write its value"),
    "rate with a derivative": (rate(sympy.Derivative(X**2, X)), "is not carried out"),
    "rate with a sum": (rate(sympy.Sum(K, (K, 1, 3)) * X), "is not carried out"),
    "period that is 0": ({"period": 0}, "period: the period 0 is not a positive number; leave it out"),
    "period below 0": ({"period": -2 * sympy.pi / OMEGA}, "is not a positive number at {'omega': 3.0}"),
    "period that is infinite here": ({"parameters": {"k": 2.0, "omega": 0.0}}, "2*pi/omega is not a positive number"),
    "128 modes": ({"modes": {f"m{i}": {X: V, V: -X} for i in range(128)}}, "there are 128 modes; at most 127 fit"),
    "state of a reserved name": (
        {"states": (sympy.Symbol("mode"),), "modes": {"free": {"mode": 1}}},
        "'mode' is reserved for the initial mode; rename the state",
    ),
    "state without a name": (
        {"states": ("",), "modes": {"free": {"": 1}}},
        "states.0: received ''; a name must not be empty",
    ),
    "parameter with a slash": (
        {"parameters": {"k": 1, "omega": 3, "a/b": 1}},
        "parameters.a/b: received 'a/b'; a name must not",
    ),
    "quadrature of a blank": ({"quadratures": {" ": V}}, "quadratures. : received ' '; a name must not"),
    "drift in a quadrature": ({"quadratures": {"work": T * V}}, "t*v does not repeat after the declared period"),
}


@pytest.mark.parametrize("fault", INPUT)
def test_what_is_no_part_of_a_system(fault):
    changes, words = INPUT[fault]
    with pytest.raises(cd.ModelError) as caught:
        build(**changes)
    assert words in str(caught.value)
    assert "zoo" not in str(caught.value)


TRANSITIONS = {
    "guard that cannot be read": ({"guard": "x - "}, "transition 'hit': guard: 'x - ' ends where a number, a name"),
    "guard that is a relation": ({"guard": sympy.Eq(X, 1)}, "guard: Eq(x, 1) is a comparison; a guard is a number"),
    "guard that is complex": ({"guard": X - sympy.I}, "guard: x - I is complex"),
    "reset in a list": ({"reset": [V, -V]}, "reset: expected a table of names (a dict in Python), received [v, -v]"),
    "reset to a relation": ({"reset": {V: X < V}}, "reset.v: x < v must be a number, not a comparison"),
    "reset to an integral": ({"reset": {V: sympy.Integral(V, V)}}, "is not carried out"),
    "condition that cannot be read": ({"condition": "v >"}, "condition: 'v >' ends where a number, a name"),
    "condition that is a number": ({"condition": V - 1}, "condition: v - 1 must be a comparison, such as x > 0"),
    "condition that is a symbol": ({"condition": V}, "condition: v must be a comparison, such as x > 0"),
    "condition of another mode": ({"condition": {"free": "v > 0", "held": "v > 1"}}, "condition.held: unknown mode"),
    "condition of no mode": ({"condition": {}}, "condition: gives nothing for mode 'free'; every source needs its own"),
    "priority of a fraction": ({"priority": 0.5}, "priority: expected a whole number, received 0.5"),
    "priority in words": ({"priority": "first"}, "priority: expected a whole number, received 'first'"),
    "no source": ({"source": ()}, "source: is empty; name the mode, or modes"),
    "source that is a number": ({"source": 3}, "source: expected text in quotes, received 3"),
    "target that is a list": ({"target": ["free"]}, "target: expected text in quotes, received ['free']"),
    "empty name": ({"name": ""}, "name: expected text in quotes, received ''"),
    "kind that is a number": ({"kind": 3}, "kind: expected text in quotes, received 3"),
}


@pytest.mark.parametrize("fault", TRANSITIONS)
def test_what_is_no_transition(fault):
    changes, words = TRANSITIONS[fault]
    with pytest.raises(cd.ModelError) as caught:
        hit(**changes)
    assert words in str(caught.value)


def test_a_bare_transition_is_no_list_of_them():
    with pytest.raises(cd.ModelError, match="expected a list of transitions"):
        build(transitions=hit())


def test_more_transitions_than_a_byte_counts():
    with pytest.raises(cd.ModelError, match="there are 128 transitions; at most 127 fit"):
        build(transitions=[hit(name=f"hit {i}", guard=X - 1 - i) for i in range(128)])
    assert len(build(transitions=[hit(name=f"hit {i}", guard=X - 1 - i) for i in range(127)]).transitions) == 127


def test_a_condition_that_drifts():
    with pytest.raises(cd.ModelError, match=r"does not repeat after the declared period 2\*pi/omega"):
        build(transitions=[hit(condition=V > T)])
    assert build(transitions=[hit(condition=sympy.sin(OMEGA * T) < V)]).transitions[0].condition is not None


@pytest.mark.parametrize(("phase", "part"), [(0, 1e-9), (0, -1e-7), (0, 0.0), (1e9, 0.0)])
def test_a_period_is_told_from_its_neighbours(phase, part):
    """Rounding of a large phase is no drift: the expressions say so."""
    given = {
        "modes": {"free": {X: V, V: sympy.cos(OMEGA * T + phase)}},
        "period": 2 * sympy.pi / OMEGA * (1 + sympy.Rational(part)),
    }
    if not part:
        assert build(**given).period is not None
        return
    with pytest.raises(cd.ModelError, match="does not repeat after the declared period"):
        build(**given)


@pytest.mark.parametrize(("entry", "repeats"), [(V + sympy.sin(OMEGA * T), True), (V + T, False)])
def test_a_special_function_repeats_if_its_arguments_do(entry, repeats):
    kick = hit(reset={V: -hunt_crossley_exit(entry, K)})
    if repeats:
        assert build(transitions=[kick]).transitions[0].reset
        return
    with pytest.raises(cd.ModelError, match="does not repeat after the declared period"):
        build(transitions=[kick])


@pytest.mark.parametrize(
    "name", ["mode", "state", "time", "outcome", "event_time", "event", "forcing_period", "section"]
)
def test_a_quadrature_never_takes_the_place_of_a_result(name):
    assert name in reserved()
    system = build(quadratures={name: V})
    with pytest.raises(cd.ModelError, match=rf"quadrature '{name}' has a name that is reserved for results; rename it"):
        cd.trajectory(system, periods=1)


@pytest.mark.parametrize("name", ["<b>", "&#47;", '"""', "{0}", "#", "-o", "a" * 201, "😀" * 51, "e\u0301"])
def test_what_cannot_be_the_name_of_a_variable_of_an_archive_is_refused_before_anything_runs(name):
    system = build(quadratures={name: V})
    with pytest.raises(cd.ModelError, match=r"quadrature .* has a name that .*; rename it"):
        cd.trajectory(system, periods=1)
    system = build(parameters={"k": 2.0, "omega": 3.0, name: 1.0})
    calls = (cd.bifurcation_diagram, {name: [1.0, 2.0]}), (cd.continue_orbit, {name: (1.0, 2.0)})
    for function, sweep in calls:
        lengths = {"transient": 1, "periods": 2} if function is cd.bifurcation_diagram else {}
        with pytest.raises(cd.SettingsError, match=r"(?s)sweep\..*; rename the parameter"):
            function(system, sweep, **lengths)


@pytest.mark.parametrize("name", ["period", "outcome", "seed", "iterate", "exponent"])
def test_a_parameter_of_a_reserved_name_can_be_set_but_not_swept(name):
    system = build(parameters={"k": 2.0, "omega": 3.0, name: 1.0})
    assert system.with_parameters(**{name: 2.0}).parameters[name] == 2.0
    with pytest.raises(cd.SettingsError, match=f"sweep.{name}: is reserved for results, and cannot be swept"):
        cd.bifurcation_diagram(system, {name: [1.0, 2.0]}, transient=1, periods=2)


@pytest.mark.parametrize("value", ["2.0", True, None, [2.0], 10**400])
def test_numbers_of_the_wrong_type(value):
    with pytest.raises(cd.SettingsError, match=r"parameter 'k' is .*; it must be a finite number"):
        build(parameters={"k": value, "omega": 3.0})
    with pytest.raises(cd.SettingsError, match=r"initial 'x' is .*; it must be a finite number"):
        build(initial={X: value})


def test_a_mode_that_is_no_text():
    with pytest.raises(cd.SettingsError, match=r"initial mode \['free'\]; modes are \['free'\]"):
        build(initial={"mode": ["free"]})


def test_a_period_that_a_parameter_takes_away():
    with pytest.raises(cd.SettingsError, match=r"the period 2\*pi/omega is not a positive number at {'omega': 0.0}"):
        build().with_parameters(omega=0.0).forcing_period()


def test_names_may_stand_for_symbols_and_texts_for_expressions():
    written = build(
        states=("x", "v"),
        time="t",
        modes={"free": {"x": "v", "v": "-k*x + cos(omega*t)"}},
        transitions=[hit(guard="x - 1", reset={"v": "-v"})],
    )
    meant = build(transitions=[hit()])
    assert (written.states, written.modes, written.transitions) == (meant.states, meant.modes, meant.transitions)


MASKED = np.ma.masked


@pytest.mark.parametrize(
    "wrong",
    [
        lambda system: system.with_parameters(k=MASKED),
        lambda system: system.with_initial(x=MASKED),
        lambda _: cd.HybridSystem(states="x", modes={"m": {"x": MASKED}}),
        lambda _: cd.HybridSystem(states="x", modes={"m": {"x": "1"}}, bounds={"x": (0, MASKED)}),
        lambda _: cd.Map("x", images={"x": MASKED}),
        lambda _: cd.Transition("hit", "m", "m", guard="x", direction=1, reset={"x": MASKED}),
        lambda system: cd.driven(system, "k", table=[0, MASKED, 1], period=1),
        lambda system: cd.trajectory(system, duration=MASKED),
    ],
)
def test_a_masked_number_is_no_number(wrong):
    # numpy makes NaN of it with a warning, and sympy zero without one
    system = cd.HybridSystem(states="x", parameters={"k": 1.0}, modes={"m": {"x": "-k*x"}})
    with pytest.raises(cd.errors.ChaosdrillError, match="masked"):
        wrong(system)

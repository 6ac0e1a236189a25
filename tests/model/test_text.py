"""A system by text, the same in sympy, and the same in a scene are one system: fields, code and numbers, to the bit."""

import numpy as np
import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.codegen.kernels import write
from chaosdrill.model.definition import build_defined, write_definition

X, V, T, A, B = sympy.symbols("x v t a b", real=True)
LENGTHS = {"periods": 3, "samples": 7}


def by_text(**changes):
    given = {
        "name": "impact-oscillator",
        "states": "x v",
        "parameters": {"zeta": 0.05, "omega": 2.5, "e": 0.8},
        "modes": {"free": {"x": "v", "v": "-x - 2*zeta*v + cos(omega*t)"}},
        "transitions": [cd.Transition("impact", "free", "free", guard="x - 0.3", direction=+1, reset={"v": "-e*v"})],
        "period": "2*pi/omega",
        "initial": {"v": 0.3},
    }
    return cd.HybridSystem(**{**given, **changes})


def by_sympy():
    zeta, omega, e = sympy.symbols("zeta omega e")
    return cd.HybridSystem(
        name="impact-oscillator",
        states=(X, V),
        time=T,
        parameters={"zeta": 0.05, "omega": 2.5, "e": 0.8},
        modes={"free": {X: V, V: -X - 2 * zeta * V + sympy.cos(omega * T)}},
        transitions=[cd.Transition("impact", "free", "free", guard=X - 0.3, direction=+1, reset={V: -e * V})],
        period=2 * sympy.pi / omega,
        initial={"mode": "free", X: 0.0, V: 0.3},
    )


def in_a_scene(system, tmp_path):
    path = cd.save_scene(tmp_path / "own.toml", system, {"motion": {"kind": "trajectory", **LENGTHS}})
    return cd.load_scene(path).system


def test_three_ways_to_one_system(tmp_path):
    systems = (by_text(), by_sympy(), in_a_scene(by_text(), tmp_path))
    one, *others = [(write(s.placed).single, write(s.placed).lanes(), write_definition(s)) for s in systems]
    assert others == [one, one]
    one, *others = [cd.trajectory(s, **LENGTHS) for s in systems]
    for other in others:
        assert all(np.array_equal(one[name], other[name]) for name in one.variables)


@pytest.mark.parametrize("states", ["x, v", " x  v ", ["x", "v"], (X, "v"), np.array(["x", "v"]), iter("xv")])
def test_states_are_names_in_order(states):
    assert by_text(states=states).states == (X, V)


@pytest.mark.parametrize(
    ("make", "given"),
    [
        (cd.HybridSystem, {"modes": {"on": {"x": "-x"}}}),
        (cd.filippov, {"surface": "x", "above": {"x": "-1"}, "below": {"x": "1"}}),
        (cd.equivalent_control, {"surface": "x", "field": {"x": "u"}, "control": {"u": (1, -1)}}),
        (cd.in_modes, {"field": {"x": "-sign(x)"}}),
    ],
)
def test_a_name_and_parameters_are_no_need(make, given):
    system = make(states="x", **given)
    assert (system.name, system.parameters) == ("own-system", {})


@pytest.mark.parametrize("rate", ["-x + t", -X + T])
def test_the_time_is_t_unless_something_is_called_so(rate):
    modes = {"on": {"x": rate}}
    assert cd.HybridSystem(states="x", modes=modes).time == T
    assert cd.HybridSystem(states="x", parameters={"t": 1.0}, modes=modes).time is None
    assert cd.HybridSystem(states="x t", modes={"on": {"x": rate, "t": 0}}).time is None
    assert cd.HybridSystem(states="x", time="s", parameters={"t": 1.0}, modes=modes).time.name == "s"
    with pytest.raises(cd.ModelError, match=r"modes.on.x: unknown name 't'; the time is called 's'"):
        cd.HybridSystem(states="x", time="s", modes=modes)
    with pytest.raises(cd.ModelError, match=r"quadratures.t: 't' is the name of the time too"):
        cd.HybridSystem(states="x", modes=modes, quadratures={"t": "x"})


def test_every_fault_is_told_with_its_place():
    modes = {"free": {"x": "v", "v": "-k*x", "w": 0}, "held": {"x": 0}}
    hit = [cd.Transition("hit", "fre", "free", guard="0.3", direction=1, reset={"v": "Max(v, 0)"}), {"name": "hot"}]
    with pytest.raises(cd.ModelError) as caught:
        by_text(modes=modes, transitions=hit, bounds={"y": (0, 1)}, labels={"omga": "frequency"}, period="v")
    assert str(caught.value).splitlines() == [
        "impact-oscillator: period: names 'v'; it must be a number made of parameters",
        "impact-oscillator: modes.free.v: unknown name 'k'; known here: zeta, omega, e, x, v, t, pi",
        "impact-oscillator: modes.free.w: unknown state; known here: x, v",
        "impact-oscillator: modes.held: gives no rate for 'v'; write 0 if the mode holds it",
        "impact-oscillator: transitions.hit.source: unknown mode 'fre'; did you mean 'free'?",
        "impact-oscillator: transitions.hit.guard: depends on no state and not on time",
        "impact-oscillator: transitions.hit.reset.v: Max(0, v) has no derivative, and can stand in conditions only; "
        "write its branches as transitions of their own with a condition each",
        *(
            f"impact-oscillator: transitions.hot.{key}: missing; each transition has name, source, target, guard, "
            "direction"
            for key in ("source", "target", "guard", "direction")
        ),
        "impact-oscillator: labels.omga: names no state, parameter, quadrature or time; did you mean 'omega'?",
        "impact-oscillator: bounds.y: unknown state; known here: x, v",
    ]


def delayed(name, time):
    return sympy.Function(name)(sympy.Symbol(time) - sympy.Symbol("tau"))


@pytest.mark.parametrize("write", [lambda name, time: f"{name}({time} - tau) - {name}", delayed])
@pytest.mark.parametrize("time", ["t", "s"])
def test_a_delay_is_refused_as_one(write, time):
    with pytest.raises(cd.ModelError, match=r"modes.on.x: 'x' is written as a function of time: .*a delay, cannot be"):
        cd.HybridSystem(states="x", time=time, parameters={"tau": 1.0}, modes={"on": {"x": write("x", time)}})


def test_a_product_without_its_sign_is_no_delay():
    with pytest.raises(cd.ModelError, match=r"'k' is no function; write k\*\(\.\.\.\) for a product"):
        cd.HybridSystem(states="x", parameters={"k": 1.0}, modes={"on": {"x": "k(x - 1)"}})


def test_a_transition_may_be_a_table():
    table = {"name": "impact", "source": "free", "target": "free", "guard": "x - 0.3", "direction": 1}
    assert by_text(transitions=[table | {"reset": {"v": "-e*v"}}]).transitions == by_text().transitions


@pytest.mark.parametrize("number", [0.1, 1, np.float64(0.1), np.int64(3), sympy.Rational(1, 3), 1e300, 10**20])
def test_numbers_stand_for_themselves(number):
    system = by_text(modes={"free": {"x": "v", "v": number}})
    assert system.modes["free"][V] == sympy.sympify(number if not isinstance(number, np.generic) else number.item())


LEAVES = st.sampled_from([X, V, T, A, B]) | st.integers(-3, 9).map(sympy.Integer) | st.floats(0.1, 9).map(sympy.Float)
RATES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, min_size=2, max_size=3).map(lambda parts: sympy.Add(*parts)),
        st.lists(inner, min_size=2, max_size=3).map(lambda parts: sympy.Mul(*parts)),
        st.tuples(inner, st.integers(2, 3)).map(lambda pair: pair[0] ** pair[1]),
        st.tuples(st.sampled_from([sympy.sin, sympy.tanh, sympy.cos]), inner).map(lambda pair: pair[0](pair[1])),
    ),
    max_leaves=5,
)


@settings(max_examples=3, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(RATES, min_size=6, max_size=6), st.lists(LEAVES, min_size=2, max_size=2))
def test_any_small_system_by_text_and_by_sympy_has_the_same_code(rates, sides):
    """A scene and an archive hold the definition, whose code is the same again."""

    def build(put):
        one, two, three, four, reset, integrand = map(put, rates)
        comparison = sides[0] > sides[1]
        return cd.HybridSystem(
            states="x v",
            parameters={"a": 1.5, "b": 0.5},
            modes={"on": {"x": one, "v": two}, "off": {"x": three, "v": four}},
            transitions=[
                cd.Transition(
                    "go", ("on", "off"), "off", put(X - V / 3), 1, {"v": reset}, {"on": put(comparison), "off": "v > a"}
                )
            ],
            quadratures={"work": {"on": integrand, "off": put(V**2)}},
        )

    one, other = build(lambda e: e), build(lambda e: cd.model.text.write_text(e))
    again = build_defined(write_definition(one), one.parameters, one.initial)
    assert write_definition(one) == write_definition(other) == write_definition(again)
    codes = [write(s.placed).single for s in (one, other, again)]
    assert codes[0] == codes[1] == codes[2]

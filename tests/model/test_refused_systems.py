"""A system that cannot be compiled is refused, and the text names the place, the thing at fault and what is allowed."""

import pytest
import sympy

import chaosdrill as cd

X, V, T, K = sympy.symbols("x v t k", real=True)
STRANGER = sympy.Symbol("stranger")


def build(**changes):
    given = {
        "name": "mass",
        "states": (X, V),
        "time": T,
        "parameters": {"k": 2.0, "omega": 3.0},
        "modes": {"free": {X: V, V: -K * X + sympy.cos(sympy.Symbol("omega") * T)}},
        "transitions": [cd.Transition("hit", "free", "free", guard=X - 1, direction=+1, reset={V: -V})],
        "period": 2 * sympy.pi / sympy.Symbol("omega"),
    }
    return cd.HybridSystem(**{**given, **changes})


def hit(**changes):
    given = {"source": "free", "target": "free", "guard": X - 1, "direction": +1, "reset": {V: -V}}
    return [cd.Transition("hit", **{**given, **changes})]


def rests(*changes):
    """The hit, and transitions that complete it, with these changes."""
    given = {"source": "free", "target": "held", "guard": X - 1, "direction": +1, "reset": {V: 0}, "completes": "hit"}
    rest = [cd.Transition(f"rest{i}", **{**given, **change}) for i, change in enumerate(changes)]
    modes = {"free": {X: V, V: -K * X}, "held": {X: 0, V: 0}}
    return {"modes": modes, "transitions": [*hit(), *rest], "time": None, "period": None}


def test_the_system_that_all_faults_are_made_of_is_accepted():
    assert build().state_names == ("x", "v")


FAULTS = {
    "region of no mode": ({"regions": {"slip": V > 0}}, ["regions.slip: unknown mode 'slip'", "free"]),
    "region in time": ({"regions": {"free": sympy.cos(T) < V}}, ["regions.free: names the time 't'", "at time 0"]),
    "region without a comparison": ({"regions": {"free": V}}, ["regions.free", "comparison"]),
    "completes nothing": (rests({"completes": "hop"}), ["transitions.rest0.completes: unknown transition", "hit"]),
    "completes itself": (
        rests({"completes": "rest0"}),
        ["transitions.rest0.completes: completes 'rest0'", "leave one out"],
    ),
    "completes twice": (rests({}, {}), ["completes 'hit'", "leave one out"]),
    "completes within the mode": (rests({"target": "free"}), ["transitions.rest0.completes", "another mode"]),
    "completes at another guard": (rests({"guard": X - 2}), ["transitions.rest0.completes", "same guard"]),
    "symbol in a rate": (
        {"modes": {"free": {X: V, V: -STRANGER * X}}},
        ["modes.free.v: unknown name 'stranger'", "known here: k"],
    ),
    "symbol in a guard": (
        {"transitions": hit(guard=X - STRANGER)},
        ["transitions.hit.guard: unknown name 'stranger'", "omega"],
    ),
    "symbol in a reset": (
        {"transitions": hit(reset={V: STRANGER})},
        ["transitions.hit.reset.v: unknown name 'stranger'", "x"],
    ),
    "symbol in a condition": (
        {"transitions": hit(condition=V > STRANGER)},
        ["transitions.hit.condition: unknown name 'stranger'"],
    ),
    "symbol in a quadrature": ({"quadratures": {"work": STRANGER * V}}, ["quadratures.work: unknown name 'stranger'"]),
    "state in the period": ({"period": X}, ["period: names 'x'", "made of parameters"]),
    "time of another name": ({"time": "tau"}, ["modes.free.v: unknown name 't'", "the time is called 'tau'"]),
    "rate that is missing": ({"modes": {"free": {X: V}}}, ["modes.free: gives no rate for 'v'", "write 0"]),
    "rate of a stranger": ({"modes": {"free": {X: V, V: 0, K: 1}}}, ["modes.free.k: unknown state", "x, v"]),
    "no state": ({"states": (), "modes": {"free": {}}, "transitions": []}, ["states: received ()", "'x v'"]),
    "no mode": ({"modes": {}, "transitions": []}, ["modes: missing"]),
    "source": ({"transitions": hit(source=("free", "stuck"))}, ["transitions.hit.", "unknown mode 'stuck'", "free"]),
    "target": ({"transitions": hit(target="stuck")}, ["transitions.hit.", "unknown mode 'stuck'", "free"]),
    "guard that is a number": ({"transitions": hit(guard=sympy.Integer(1))}, ["transitions.hit.guard", "no state"]),
    "reset of a stranger": ({"transitions": hit(reset={K: V})}, ["transitions.hit.reset.k: unknown state", "x, v"]),
    "two transitions of one name": (
        {"transitions": hit() + hit(direction=-1)},
        ["transitions.hit.name: two transitions", "'hit'"],
    ),
    "state twice": ({"states": (X, V, X)}, ["states.2: 'x' is named twice"]),
    "parameter that is a state": (
        {"parameters": {"k": 2.0, "omega": 3.0, "v": 1.0}},
        ["states: 'v' is the name of a parameter too"],
    ),
    "quadrature that is a state": ({"quadratures": {"x": V}}, ["quadratures.x: 'x' is the name of a state too"]),
    "time that is a parameter": (
        {"parameters": {"k": 2.0, "omega": 3.0, "t": 1.0}},
        ["time: 't' is the name of a parameter too"],
    ),
    "rate that is infinite": ({"modes": {"free": {X: V, V: sympy.oo}}}, ["modes.free.v", "not finite"]),
    "division by zero": ({"modes": {"free": {X: V, V: sympy.zoo * X}}}, ["modes.free.v", "not finite"]),
    "bound of a stranger": ({"bounds": {K: (0, 1)}}, ["bounds.k: unknown state", "x, v"]),
    "wrong period": ({"period": sympy.pi / 3}, ["does not repeat", "declared period pi/3", "correct the period"]),
    "drift in a periodic rate": ({"modes": {"free": {X: V, V: T}}}, ["t does not repeat", "leave it out"]),
    "drift in a guard": ({"transitions": hit(guard=X - T)}, ["-t + x does not repeat", "period"]),
    "drift in a reset": ({"transitions": hit(reset={V: T})}, ["t does not repeat", "period"]),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named(fault):
    changes, words = FAULTS[fault]
    with pytest.raises(cd.ModelError) as caught:
        build(**changes)
    text = str(caught.value)
    assert text.startswith("mass: ")
    for word in words:
        assert word in text


NUMBERS = {
    "parameter that is not finite": ({"parameters": {"k": float("nan"), "omega": 3.0}}, ["parameter 'k'", "nan"]),
    "parameter that is infinite": ({"parameters": {"k": float("inf"), "omega": 3.0}}, ["parameter 'k'", "inf"]),
    "parameter that is a word": ({"parameters": {"k": "stiff", "omega": 3.0}}, ["parameter 'k'", "'stiff'"]),
    "start that is not finite": ({"initial": {X: float("nan")}}, ["initial 'x'", "finite number"]),
    "start of a stranger": ({"initial": {"y": 0.0}}, ["'y'", "mode, x, v"]),
    "start in a mode that is not there": ({"initial": {"mode": "stuck"}}, ["initial mode 'stuck'", "['free']"]),
}


@pytest.mark.parametrize("fault", NUMBERS)
def test_a_number_that_cannot_be_used_is_named(fault):
    changes, words = NUMBERS[fault]
    with pytest.raises(cd.SettingsError) as caught:
        build(**changes)
    for word in ["mass", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize("direction", [2, -3, 0.5, None, "up"])
def test_a_direction_is_up_down_or_both(direction):
    with pytest.raises(cd.ModelError, match=r"'hit': direction: must be 1 .*, -1 .* or 0 .*, received"):
        hit(direction=direction)


def test_a_system_in_time_without_declared_period_may_drift():
    assert build(modes={"free": {X: V, V: T}}, period=None).forcing_period() is None


def test_symbols_are_matched_by_name_whatever_their_assumptions():
    plain = sympy.Symbol("x")
    positive = sympy.Symbol("k", positive=True)
    system = build(modes={"free": {plain: sympy.Symbol("v", complex=True), V: -positive * plain}})
    assert system.modes["free"] == {X: V, V: -K * X}


def test_one_mistake_is_one_fault():
    """A state that is not declared is reported where it has its rate; its other places follow from that."""
    with pytest.raises(cd.ModelError) as caught:
        build(modes={"free": {"x": "v", "w": "-k*x"}})
    assert str(caught.value).splitlines() == ["mass: modes.free.w: unknown state; known here: x, v"]
    with pytest.raises(cd.ModelError) as caught:
        build(states="x", bounds={"v": (-1, 1)}, transitions=hit(reset={"v": "-v"}))
    assert len(str(caught.value).splitlines()) == 1
    assert "modes.free.v: unknown state" in str(caught.value)
    with pytest.raises(cd.ModelError) as caught:
        build(transitions=hit() + hit(direction=-1) + hit(guard="v"))
    assert str(caught.value).splitlines() == ["mass: transitions.hit.name: two transitions are named 'hit'"]

"""A whole exponent is whole however it is written or held; what is left out leaves no trace."""

import re

import numpy as np
import pytest
import sympy
from support.drills import WITH_EVERY_OPTION, WITH_EVERY_PAIR, built, label

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.contacts import hunt_crossley_duration
from chaosdrill.codegen.events import mode_events
from chaosdrill.codegen.kernels import write
from chaosdrill.codegen.signatures import event_places
from chaosdrill.codegen.special import positive_power as numeric_power
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.model.exponents import exponent_parameters, specialise
from chaosdrill.model.special import positive_power

X, D, V, K, N = sympy.symbols("x d v k n", real=True)


# A whole exponent is whole however it is written: x**2.0 has a series at x = 0, x**1.5 has none, x**0.0 is 1.


ORDER = 8


@pytest.mark.parametrize("power", [sympy.Pow, positive_power])
@pytest.mark.parametrize("exponent", [2, 2.0, 3.0, 1.0, 0, 0.0])
def test_series_at_zero(power, exponent):
    """x' = 1 + x^m from 0: x = s + s^(m + 1)/(m + 1) + ... (x = e^s - 1 for m = 1, 2 s for m = 0)."""
    system = cd.HybridSystem(name="power", states=(X,), parameters={}, modes={"on": {X: 1 + power(X, exponent)}})
    ws = np.zeros((kernels_of(system).layout.rows, COLUMNS))
    kernels_of(system).functions.jet(0, ORDER, 0.0, np.zeros(1), np.array([0.0]), ws)
    m = int(exponent)
    found = ws[0, : m + 2]
    expected = np.zeros(m + 2)
    expected[1] = 1.0
    expected[m + 1] += 1 / (m + 1)
    np.testing.assert_allclose(found, expected, rtol=1e-15)


@pytest.mark.parametrize("exponent", [0, 0.0, 1, 1.0, 2.0, 1.5, -1, -1.0])
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_tangents_of_a_literal_exponent(method, exponent):
    """x' = -x^m: a tangent grows as x' does, by m ln(x1/x0) over a time of 1."""
    field = {X: -positive_power(X, exponent)}
    system = cd.HybridSystem(
        name="decay", states=(X,), parameters={}, modes={"on": field}, initial={"mode": "on", X: 2.0}
    )
    end = {0.0: 1.0, 1.0: 2 * np.exp(-1), 2.0: 2 / 3, 1.5: (2**-0.5 + 0.5) ** -2, -1.0: 2**0.5}[float(exponent)]
    found = cd.lyapunov_spectrum(system, duration=1.0, transient=0.0, method=method)["lyapunov_exponent"].values
    assert found == pytest.approx([exponent * np.log(end / 2.0)], abs=1e-9)


# A parameter in an exponent is the whole number that it holds; other systems' code does not change for it.


def contact(n, force=D**N):
    """An elastic contact that begins at d = 0, where a power that is not whole has no series."""
    return cd.HybridSystem(
        name="contact",
        states=(D, V),
        parameters={"k": 1e6, "n": n},
        modes={"touch": {D: V, V: -K * force}, "apart": {D: V, V: 0}},
        transitions=[cd.Transition("part", "touch", "apart", guard=D, direction=-1)],
        initial={"mode": "touch", V: 1.0},
    )


@pytest.mark.parametrize("force", [D**N, positive_power(D, N)], ids=str)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_contact_of_whole_exponent_starts_at_no_depth(n, force):
    run = cd.trajectory(contact(n, force), duration=1.0, tolerance=1e-13)
    assert run["event_time"].values == pytest.approx([hunt_crossley_duration(1.0, 0.0, float(n), 1e6)], rel=1e-12)
    assert run["event_state_before"].values[0, 1] == pytest.approx(-1.0, rel=1e-12)


@pytest.mark.parametrize("force", [D**N, positive_power(D, N)], ids=str)
def test_another_exponent_ends_the_taylor_method_with_advice(force):
    run = cd.trajectory(contact(1.5, force), duration=1.0)
    assert cd.Outcome(int(run["outcome"])) is cd.Outcome.SINGULAR
    assert "dop853" in cd.Outcome.SINGULAR.advice


def test_where_it_is_analytic_any_exponent_has_a_series():
    system = contact(1.5, positive_power(D, N)).with_initial(d=1e-3, v=0.0)
    run = cd.trajectory(system, duration=1e-3)
    speed, depth = run["states"].values[-1, 1], run["states"].values[-1, 0]
    assert speed**2 / 2 == pytest.approx(1e6 * (1e-3**2.5 - depth**2.5) / 2.5, rel=1e-12)


def test_copies_with_another_whole_exponent_have_kernels_of_their_own():
    linear = contact(1.0)
    square = linear.with_parameters(n=2.0)
    assert kernels_of(linear.with_parameters(k=3.0)) is kernels_of(linear)
    assert kernels_of(square) is not kernels_of(linear)
    assert kernels_of(square.with_parameters(n=1)) is kernels_of(linear)
    assert kernels_of(linear.with_parameters(n=1.5)) is kernels_of(linear.with_parameters(n=1.25))


def test_exponents_are_found_where_they_stand_alone_or_in_a_sum():
    assert exponent_parameters(contact(1.0, D ** (2 * N - 1))) == ("n",)
    assert exponent_parameters(contact(1.0, positive_power(D, N))) == ("n",)
    assert exponent_parameters(contact(1.0, D * sympy.exp(-N * D) * 2**N)) == ()


def test_only_the_exponent_becomes_a_number():
    system = specialise(contact(1.0, N * D**N), {"n": 3})
    assert system.modes["touch"][V] == -K * N * D**3


def test_the_code_of_a_linear_contact_is_that_of_a_spring():
    special = write(specialise(contact(1.0, positive_power(D, N)), {"n": 1}))
    assert special.single == write(contact(1.0, D)).single


def test_the_power_of_what_is_not_positive_is_zero():
    assert numeric_power(-0.5, 1.5) == 0.0
    assert numeric_power(0.25, 1.5) == pytest.approx(0.125, rel=1e-15)
    slope = sympy.lambdify((D, N), sympy.diff(positive_power(D, N), D), [{"positive_power": numeric_power}])
    assert slope(0.25, 1.5) == pytest.approx(0.75, rel=1e-15)
    assert slope(0.0, 1.5) == 0.0
    assert sympy.diff(positive_power(D, N), N) == positive_power(D, N) * sympy.log(D)


# An effect that a drill leaves out leaves no trace in the generated code: no number, no function, no guard.


@pytest.fixture(scope="module")
def systems():
    """Drills whose exponents are not whole: a whole one would be no parameter of the code."""
    drills = {label(e): built(e) for e in (*WITH_EVERY_PAIR, *WITH_EVERY_OPTION)}
    return {name: d.with_parameters(**dict.fromkeys(d.exponent_parameters, 1.5)) for name, d in drills.items()}


def text_of(written):
    return "".join(code.text for code in written.single)


def places(text, array):
    """Places of an array that the code reads."""
    return {int(i) for i in re.findall(rf'%"{array}", i64 (\d+)', text)}


def functions_of(system):
    """Names of the functions in everything that a system computes."""
    fields = (rate for field in system.modes.values() for rate in field.values())
    at_events = (e for t in system.transitions for e in (t.guard, *t.reset.values(), *t.conditions.values()))
    return {type(f).__name__ for e in (*fields, *at_events) for f in sympy.sympify(e).atoms(sympy.Function)}


@pytest.mark.parametrize("effects", WITH_EVERY_PAIR, ids=label)
def test_drills_use_the_functions_of_their_effects(systems, effects):
    """Every drill is written with the functions of its effects and with no others."""
    law = {"hunt_crossley_exit", "hunt_crossley_peak"}
    contact = {
        "hunt-crossley": law,
        "hunt-crossley-timed": law | {"hunt_crossley_duration"},
        "compliant": {"positive_power"},
    }
    expected = {"cos"} if effects["drive"] != "none" else set()
    expected |= {"exp"} if effects["friction"].startswith("stribeck") else set()
    assert functions_of(systems[label(effects)]) == expected | contact.get(effects["contact"], set())


@pytest.mark.parametrize("effects", WITH_EVERY_OPTION, ids=label)
def test_machine_code_calls_them_and_no_others(systems, effects):
    system = systems[label(effects)]
    text = text_of(kernels_of(system).written)
    assert ("llvm.cos" in text) == ("llvm.sin" in text) == (effects["drive"] != "none")
    hit = effects["contact"]
    law = hit in ("hunt-crossley", "hunt-crossley-timed")
    assert ("llvm.exp" in text) == effects["friction"].startswith("stribeck")
    assert ("hunt_crossley_exit" in text) == ("hunt_crossley_peak" in text) == law
    assert ("hunt_crossley_duration" in text) == (hit == "hunt-crossley-timed")
    assert ("llvm.pow" in text) >= (hit == "compliant")
    completed = event_places(len(system.states)).complete in places(text, "event")
    assert completed == (hit == "newton")
    states = 2 + (effects["rock"] == "moving") + (hit in ("hunt-crossley-timed", "compliant"))
    assert places(text, "x") == set(range(states))
    assert text.count('define internal void @"jet_') == len(system.modes)


@pytest.mark.parametrize("effects", WITH_EVERY_PAIR, ids=label)
def test_modes_watch_what_can_end_them(systems, effects):
    """Every mode watches what can end it: friction's threshold or standstill, the stop, the force of a held contact."""
    held, ways = effects["friction"] != "none", 1 + effects["friction"].endswith("two-sided")
    driven, law = effects["drive"] != "none", effects["contact"] not in ("none", "compliant")
    timed = effects["contact"] == "hunt-crossley-timed"
    system = systems[label(effects)]
    expected = {}
    for mode in ("stick", "slip", "slip-back"):
        friction = held * (ways if mode == "stick" else 1)
        expected[mode] = friction + (effects["contact"] != "none")
        expected[f"{mode}-contact"] = 1 if timed else friction + 1
        # what never changes is watched by no guard
        moving = driven or (mode != "stick" and effects["friction"].startswith("stribeck"))
        expected[f"{mode}-held"] = friction * (driven or mode != "stick") + (law and moving)
    assert {mode: len(mode_events(system, mode)) for mode in system.modes} == {m: expected[m] for m in system.modes}


@pytest.mark.parametrize("effects", WITH_EVERY_OPTION, ids=label)
def test_every_parameter_is_read(systems, effects):
    """By the kernels, or by an expression of parameters that they read."""
    system = systems[label(effects)]
    kernels = kernels_of(system)
    read = places(text_of(kernels.written), "c")
    numbers = {name: 0.3 + 0.1 * i for i, name in enumerate(system.parameters)}
    before = kernels.constants(numbers)
    for parameter in numbers:
        changed = np.flatnonzero(kernels.constants({**numbers, parameter: 0.77}) != before)
        assert set(changed) & read, parameter
    assert not read - set(range(kernels.layout.constants))


def test_the_force_of_a_hit_is_computed_only_where_the_masses_are_pressed_together():
    """A comparison of numbers decides first; what costs a Newton iteration comes last."""
    text = text_of(
        kernels_of(cd.drill(drive="harmonic", friction="stribeck", rock="moving", contact="hunt-crossley")).written
    )
    blocks = re.split(r"\n(?=\S+:\n)", text)
    calls = [block for block in blocks if re.search(r'call double @"chaosdrill_hunt_crossley_peak"', block)]
    # the third is the test of a hit that is too weak, of which nothing else decides
    assert [block.startswith("then") for block in calls].count(True) == len(calls) - 1 == 2


def test_the_plainest_drill_is_a_linear_oscillator():
    source = write(cd.drill(drive="none", friction="none", rock="fixed", contact="none"))
    assert not re.search(r"llvm\.(sin|cos|exp|log|pow|sqrt)", text_of(source))
    assert source.layout.rows == 2
    assert source.events == ((),)

"""Every system of the registry keeps the same contract."""

import importlib

import pytest
import sympy

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.errors import ModelError

NAMES = sorted(systems.REGISTRY)


def expressions(system):
    """Everything that the system was written with."""
    found = [rate for field in system.modes.values() for rate in field.values()]
    for transition in system.transitions:
        found += [transition.guard, *transition.reset.values()]
        found += transition.conditions.values()
    found += [rate for rates in system.quadratures.values() for rate in rates.values()]
    return [*found, *([] if system.period is None else [system.period])]


@pytest.mark.parametrize("name", NAMES)
def test_states_and_parameters_are_known_before_building(name):
    system = systems.build(name)
    assert systems.states(name) == system.state_names
    assert systems.parameters(name) == system.parameters


@pytest.mark.parametrize("name", NAMES)
def test_every_parameter_is_used(name):
    system = systems.build(name)
    used = {s.name for e in expressions(system) for s in e.free_symbols}
    assert set(system.parameters) <= used


@pytest.mark.parametrize("name", NAMES)
def test_every_state_parameter_and_quadrature_has_a_long_name(name):
    system = systems.build(name)
    assert set(system.labels) == {*system.state_names, *system.parameters, *system.quadratures}
    assert all(label != key for key, label in system.labels.items())


@pytest.mark.parametrize("name", NAMES)
def test_the_start_lies_before_every_guard(name, number):
    system = systems.build(name)
    here = {**system.parameters, **system.initial, "t": 0.0}
    for transition in system.transitions:
        if system.initial["mode"] in transition.source:
            assert transition.direction * number(transition.guard, here) <= 0


@pytest.mark.parametrize("name", NAMES)
def test_every_mode_can_be_entered_and_belongs_to_some_transition(name):
    system = systems.build(name)
    reached = {system.initial["mode"], *(t.target for t in system.transitions)}
    assert reached == set(system.modes)


@pytest.mark.parametrize("name", NAMES)
def test_the_file_tells_equations_and_summary(name):
    entry = systems.REGISTRY[name]
    text = importlib.import_module(entry.module).__doc__
    assert text
    assert entry.summary
    assert entry.effects or " = " in text


@pytest.mark.parametrize("name", NAMES)
def test_values_and_start_can_be_replaced(name):
    default = systems.build(name)
    state = default.state_names[0]
    # a restitution stays below 1
    others = {key: value * (0.98 if key == "e" else 1.25) for key, value in default.parameters.items()}
    system = systems.build(name, others, initial={state: 0.125})
    assert system.parameters == others
    assert system.initial[state] == 0.125
    assert default.initial == systems.build(name).initial


def test_an_unknown_parameter_is_refused_with_the_likely_one():
    with pytest.raises(cd.ModelError, match="unknown parameter 'omga'; did you mean 'omega'"):
        systems.build("impact-oscillator", {"omga": 1.0})


def test_an_unknown_system_is_refused_with_the_likely_one():
    with pytest.raises(cd.ModelError, match="did you mean 'rimless-wheel'"):
        systems.build("rimles-wheel")


def test_effects_are_refused_where_there_are_none():
    with pytest.raises(cd.ModelError, match="lorenz is not assembled from effects"):
        systems.build("lorenz", effects={"drive": "none"})


def test_the_piecewise_linear_field_of_chua_is_continuous(number):
    system = systems.build("chua")
    x = sympy.Symbol("x", real=True)
    for transition in system.transitions:
        edge = sympy.solve(transition.guard, x)[0]
        for state in system.states:
            gap = system.modes[transition.target][state] - system.modes[transition.source[0]][state]
            assert sympy.simplify(gap.subs(x, edge)) == 0


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("duffing oscillator", "duffing"),
        ("chua circuit", "chua"),
        ("lorentz", "lorenz"),
        ("lorenz 96", "lorenz-96"),
        ("gear", "gear-rattle"),
    ],
)
def test_a_name_that_is_nearly_right(given, meant):
    with pytest.raises(ModelError, match=f"did you mean '{meant}'"):
        systems.build(given)

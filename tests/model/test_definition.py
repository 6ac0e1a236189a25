"""A system written as plain data and read back is the same system, in every field."""

import json

import pytest
import sympy
from support.drills import WITH_EVERY_PAIR, built

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.codegen.kernels import write
from chaosdrill.errors import ModelError
from chaosdrill.model.definition import build_defined, write_definition

X, V, T, K = sympy.symbols("x v t k", real=True)
FIELDS = ("name", "description", "states", "time", "parameters", "modes", "transitions", "period", "initial")
FIELDS += ("quadratures", "bounds", "labels", "exponent_parameters")


def through_text(system):
    definition = json.loads(json.dumps(write_definition(system), allow_nan=False))
    return build_defined(definition, system.parameters, system.initial)


def differing(one, other):
    """Names of the fields that differ, the order of tables and the kinds of numbers among them."""
    return [name for name in FIELDS if repr_of(getattr(one, name)) != repr_of(getattr(other, name))]


def repr_of(value):
    if isinstance(value, dict):
        return [(repr_of(key), repr_of(entry)) for key, entry in value.items()]
    if isinstance(value, tuple):
        return [repr_of(entry) for entry in value]
    if isinstance(value, cd.Transition):
        return [repr_of(entry) for entry in vars(value).values()]
    return sympy.srepr(value) if isinstance(value, sympy.Basic) else repr(value)


@pytest.mark.parametrize("name", [name for name, entry in systems.REGISTRY.items() if not entry.effects])
def test_systems_of_the_shelf(name):
    system = systems.build(name)
    assert differing(system.built, through_text(system)) == []


def test_drills_of_all_effects():
    for effects in WITH_EVERY_PAIR:
        system = built(effects)
        assert differing(system.built, through_text(system)) == [], effects


@pytest.mark.parametrize("effects", [{"drive": "lobes", "contact": "hunt-crossley-timed"}])
def test_kernels_are_the_same_letter_by_letter(effects):
    system = cd.drill(**effects)
    one, other = write(system), write(through_text(system))
    assert (one.single, one.lanes()) == (other.single, other.lanes())


def test_a_copy_with_another_field_shares_no_definition():
    neuron = systems.build("izhikevich")
    write_definition(neuron.changed(bounds={**neuron.bounds, "v": (-100.0, 1e5)}))
    assert differing(neuron.built, through_text(neuron)) == []


def own(**changed):
    fields = {
        "name": "a name of my own",
        "states": (X, V),
        "time": T,
        "parameters": {"k": 0.1, "lambda": 2.0, "mass 1": 3.0},
        "modes": {"free": {X: V, V: -K * X}, "held": {X: 0, V: 0}},
        "transitions": [
            cd.Transition(
                "hit", ("free", "held"), "free", guard=X - 1, direction=1, reset={V: -V / 2}, priority=2, kind="z"
            ),
            cd.Transition(
                "stop", "free", "held", guard=X - 1, direction=1, condition=(V > 1) & (X < 2), completes="hit"
            ),
        ],
        "period": 2 * sympy.pi / K,
        "initial": {"mode": "held", X: 0.1 + 0.2},
        "regions": {"held": (X > 0.1 + 0.2) & sympy.Eq(V, 0), "free": ~(V < K) | (X <= 1)},
        "quadratures": {"work": V**2},
        "bounds": {X: None, V: (-1, sympy.oo)},
        "description": 'quotes " and\nlines',
        "labels": {"x": "Weg"},
    }
    return cd.HybridSystem(**fields | changed)


def test_every_field_is_read_back():
    assert differing(own(), through_text(own())) == []
    assert through_text(own()).initial["x"] == 0.30000000000000004


def test_names_that_are_no_identifiers():
    masses = sympy.Symbol("mass 1", real=True) * sympy.Symbol("lambda", real=True) / sympy.Symbol("µ", real=True)
    system = own(parameters={"k": 1, "mass 1": 2, "lambda": 3, "µ": 4}, quadratures={"work": masses})
    assert differing(system.built, through_text(system)) == []


@pytest.mark.parametrize(
    ("rate", "reason"),
    [
        (sympy.Float("0.1", 30) * X, "would be read as"),
        (sympy.Add(1, 2, evaluate=False) * X, "would be read as"),
        (X**1001, "exponents up to 1000"),
        (sympy.Rational(1, 10**400) * X + 1, "larger than any double"),
        (sympy.Symbol("`", real=True) * X, "cannot stand"),
        (sympy.pi * sympy.Symbol("pi", real=True) * X, "would be read as"),
        (sympy.exp(sympy.Add(*(sympy.sin((10**15 + i) * X) for i in range(450)))), "letters long"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_what_no_text_can_hold_is_said(rate, reason):
    parameters = {"k": 1.0, "`": 1.0, "pi": 1.0} if rate.free_symbols - {X} else {"k": 1.0}
    with pytest.raises(ModelError, match=reason):
        write_definition(own(parameters=parameters, modes={"free": {X: V, V: rate}, "held": {X: 0, V: 0}}))


def test_a_condition_that_no_text_can_hold_is_said():
    stop = cd.Transition("stop", "free", "held", guard=X - 1, direction=1, condition=sympy.gamma(X) > 1)
    with pytest.raises(ModelError, match=r"definition: transitions.stop.condition: unknown function 'gamma'"):
        write_definition(own(transitions=[stop]))


def test_copies_share_what_was_written():
    system = own()
    assert write_definition(system.with_parameters(k=7.0)) == write_definition(system)
    assert "parameters" not in write_definition(system)


def test_copies_of_it_are_nobody_elses():
    system = own()
    write_definition(system)["name"] = "other"
    assert write_definition(system)["name"] == "a name of my own"

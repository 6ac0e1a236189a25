"""One system, one law: what a scene refuses of a parameter Python refuses, in the same words, and the other way."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.systems.drill.effects import OPTIONS, PAPER

RUN = '[analysis.a]\nkind = "trajectory"\n'
LIMITED = [(name, parameter) for name in systems.REGISTRY for parameter in systems.limits(name)]
SYSTEMS = {name: systems.build(name) for name in systems.REGISTRY}


def by_scene(name, parameter, value):
    """What a scene says of a parameter; None if it takes it."""
    length = "duration = 1" if SYSTEMS[name].period is None else "periods = 1"
    text = f'[system]\nmodel = "{name}"\n'
    if systems.REGISTRY[name].effects:
        text += "[system.effects]\n" + "".join(f'{effect} = "{option}"\n' for effect, option in PAPER.items())
    text += f"[system.parameters]\n{parameter} = {value!r}\n{RUN}{length}\n"
    try:
        cd.parse_scene(text)
    except cd.SceneError as fault:
        return re.search(rf"system.parameters.{parameter}: (.*)", str(fault))[1]
    return None


def by_python(make):
    """What Python says of it; None if it takes it."""
    try:
        make()
    except cd.SettingsError as fault:
        return re.search(r"parameter '\w+': (.*)", str(fault))[1]
    return None


def edges(limit):
    """Values at the ends of a range and beyond, each with whether it is allowed."""
    yield limit.low, not limit.open_below
    yield limit.low - 1e-9, False
    yield limit.low + 1e-9, True
    if limit.high < math.inf:
        yield limit.high, True
        yield limit.high + 1e-9, False


@pytest.mark.parametrize(("name", "parameter"), LIMITED)
def test_both_doors_have_the_same_law(name, parameter):
    limit = systems.limits(name)[parameter]
    for value, allowed in edges(limit):
        ways = {
            "scene": by_scene(name, parameter, value),
            "copy": by_python(lambda value=value: SYSTEMS[name].with_parameters(**{parameter: value})),
        }
        assert {told is None for told in ways.values()} == {allowed}, (value, ways)
        assert len(set(ways.values())) == 1, ways
    told = by_python(lambda: systems.build(name, {parameter: limit.low - 1}))
    assert told == limit.refuses(limit.low - 1)


@pytest.mark.parametrize("name", systems.REGISTRY)
def test_defaults_are_allowed_and_limits_are_of_parameters(name):
    limits, defaults = systems.limits(name), systems.parameters(name)
    assert limits.keys() <= defaults.keys()
    assert [key for key, one in limits.items() if one.refuses(defaults[key])] == []
    assert SYSTEMS[name].limits == limits
    assert all(one.quantity for one in limits.values())


@settings(max_examples=20)
@given(
    st.fixed_dictionaries({name: st.sampled_from(list(options)) for name, options in OPTIONS.items()}),
    st.data(),
)
def test_the_drill_with_any_effects(effects, data):
    try:
        known = systems.parameters("percussive-drill", effects)
    except cd.ModelError:
        return
    limits = systems.limits("percussive-drill", effects)
    assert limits.keys() <= known.keys()
    name = data.draw(st.sampled_from(sorted(limits)))
    value = data.draw(st.floats(-3, 3))
    told = by_python(lambda: cd.drill(**effects, **{name: value}))
    assert told == limits[name].refuses(value)
    assert (told is None) == (by_python(lambda: systems.build("percussive-drill", {name: value}, effects)) is None)


@pytest.mark.parametrize(("name", "value"), [("mu", 2), ("xi", -0.1), ("eps", 0)])
def test_the_drill_refuses_what_its_scene_refuses(name, value):
    with pytest.raises(cd.SettingsError, match=f"percussive-drill: parameter {name!r}: the .* must be .*received"):
        cd.drill(**{name: value})


def test_sweeps_and_branches_stay_within_the_limits():
    drill = cd.drill()
    for sweep in ({"mu": [0.5, 1.5]}, {"mu": {"start": 0.5, "stop": 1.5, "num": 3}}, {"eta": np.array([-1.0, 1.0])}):
        with pytest.raises(cd.SettingsError, match=r"sweep\.(mu|eta).*the (friction|frequency) ratio.* must be"):
            cd.bifurcation_diagram(drill, sweep, transient=1, periods=2)
    with pytest.raises(cd.SettingsError, match=r"sweep\.mu.*the friction ratio"):
        cd.continue_orbit(drill, {"mu": (0.5, 1.5)})


def test_a_branch_ends_at_the_limit_and_not_before():
    oscillator = cd.build("impact-oscillator", {"e": 0.98, "omega": 2.8})
    found = cd.continue_orbit(oscillator, {"e": (0.97, 1.0)}, max_points=200)
    assert found["e"].values.max() == 1.0


def test_what_is_made_of_a_system_keeps_its_limits():
    for made in (cd.drill(), cd.drill().augmented(time=True), cd.driven(cd.drill(), "a", "square")):
        with pytest.raises(cd.SettingsError, match="the friction ratio"):
            made.with_parameters(mu=2)
    # one that became a state is free
    assert cd.drill().augmented(parameters=["mu"]).with_initial(mu=2).initial["mu"] == 2

"""An effect that a drill leaves out leaves no trace in the generated code: no number, no function, no guard."""

import itertools
import re

import pytest

import chaosdrill as cd
from chaosdrill.codegen.source import write_source
from chaosdrill.systems.drill.effects import OPTIONS

DRILLS = [
    dict(zip(OPTIONS, chosen, strict=True))
    for chosen in itertools.product(*OPTIONS.values())
    if not (dict(zip(OPTIONS, chosen, strict=True))["rock"] == "fixed" and chosen[1] != "none")
]


def name_of(effects):
    return " ".join(effects.values())


@pytest.fixture(scope="module")
def sources():
    return {name_of(e): (cd.drill(**e), write_source(cd.drill(**e))) for e in DRILLS}


def used(text):
    """Indices of the constants that the code reads outside of the function that fills them."""
    body = text[: text.index("def constants(")]
    return {int(i) for i in re.findall(r"c\[(\d+)\]", body)}


@pytest.mark.parametrize("effects", DRILLS, ids=name_of)
def test_traces(sources, effects):
    system, source = sources[name_of(effects)]
    text = source.text
    assert ("math.cos" in text) == ("math.sin" in text) == (effects["drive"] != "none")
    hit = effects["contact"]
    law = hit in ("hunt-crossley", "hunt-crossley-timed")
    assert ("math.exp" in text) == effects["friction"].startswith("stribeck")
    assert ("hunt_crossley_exit" in text) == ("hunt_crossley_peak" in text) == law
    assert ("hunt_crossley_duration" in text) == (hit == "hunt-crossley-timed")
    assert ("positive_power" in text) == (hit == "compliant")
    assert ("tolerance <" in text or "<= tolerance" in text) == (hit == "newton")
    states = 2 + (effects["rock"] == "moving") + (hit in ("hunt-crossley-timed", "compliant"))
    assert all((f"x{i}" in text) == (i < states) for i in range(6))
    assert text.count("@helper\ndef _jet_") == len(system.modes)


@pytest.mark.parametrize("effects", DRILLS, ids=name_of)
def test_guards(sources, effects):
    """Every mode watches what can end it: friction's threshold or standstill, the stop, the force of a held contact."""
    held, ways = effects["friction"] != "none", 1 + effects["friction"].endswith("two-sided")
    driven, law = effects["drive"] != "none", effects["contact"] not in ("none", "compliant")
    timed = effects["contact"] == "hunt-crossley-timed"
    system, source = sources[name_of(effects)]
    expected = {}
    for mode in ("stick", "slip", "slip-back"):
        friction = held * (ways if mode == "stick" else 1)
        expected[mode] = friction + (effects["contact"] != "none")
        expected[f"{mode}-contact"] = 1 if timed else friction + 1
        # what never changes is watched by no guard
        moving = driven or (mode != "stick" and effects["friction"].startswith("stribeck"))
        expected[f"{mode}-held"] = friction * (driven or mode != "stick") + (law and moving)
    assert [len(e) for e in source.events] == [expected[mode] for mode in system.modes]


@pytest.mark.parametrize("effects", DRILLS, ids=name_of)
def test_every_parameter_is_read(sources, effects):
    """By the kernels, or by an expression of parameters that they read."""
    system, source = sources[name_of(effects)]
    read = used(source.text)
    filling = source.text[source.text.index("def constants(") :]
    for index, parameter in enumerate(system.parameters):
        derived = [int(left) for left, right in re.findall(r"c\[(\d+)\] = (.*)", filling) if f"c[{index}]" in right]
        assert index in read or set(derived) & read, parameter
    assert not read - set(range(source.constants))


def test_the_force_of_a_hit_is_computed_only_where_the_masses_are_pressed_together(sources):
    """A comparison of numbers decides first; what costs a Newton iteration comes last."""
    text = sources["harmonic stribeck moving hunt-crossley"][1].text
    lines = [line for line in text.splitlines() if "hunt_crossley_peak" in line and " and " in line]
    assert len(lines) == 2
    assert all("hunt_crossley_peak" not in line.split(" and ")[0] for line in lines)


def test_the_plainest_drill_is_a_linear_oscillator():
    source = write_source(cd.drill(drive="none", friction="none", rock="fixed", contact="none"))
    assert "math." not in source.text.replace("import math", "")
    assert source.rows == 2
    assert source.events == ((),)

"""An effect that a drill leaves out leaves no trace in the generated code: no number, no function, no guard."""

import itertools
import re

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kernels import write
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
    return {name_of(e): (cd.drill(**e), write(cd.drill(**e))) for e in DRILLS}


def text_of(written):
    return "".join(code.text for code in written.single)


def places(text, array):
    """Places of an array that the code reads."""
    return {int(i) for i in re.findall(rf'%"{array}", i64 (\d+)', text)}


@pytest.mark.parametrize("effects", DRILLS, ids=name_of)
def test_traces(sources, effects):
    system, source = sources[name_of(effects)]
    text = text_of(source)
    assert ("llvm.cos" in text) == ("llvm.sin" in text) == (effects["drive"] != "none")
    hit = effects["contact"]
    law = hit in ("hunt-crossley", "hunt-crossley-timed")
    assert ("llvm.exp" in text) == effects["friction"].startswith("stribeck")
    assert ("hunt_crossley_exit" in text) == ("hunt_crossley_peak" in text) == law
    assert ("hunt_crossley_duration" in text) == (hit == "hunt-crossley-timed")
    assert ("llvm.pow" in text) >= (hit == "compliant")
    completed = re.search(r'fcmp ole double \S+, %"tolerance"', text) is not None
    assert completed == (hit == "newton")
    states = 2 + (effects["rock"] == "moving") + (hit in ("hunt-crossley-timed", "compliant"))
    assert places(text, "x") == set(range(states))
    assert text.count('define internal void @"jet_') == len(system.modes)


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
    read = places(text_of(source), "c")
    kernels = kernels_of(system)
    numbers = {name: 0.3 + 0.1 * i for i, name in enumerate(system.parameters)}
    before = kernels.constants(numbers)
    for parameter in numbers:
        changed = np.flatnonzero(kernels.constants({**numbers, parameter: 0.77}) != before)
        assert set(changed) & read, parameter
    assert not read - set(range(source.constants))


def test_the_force_of_a_hit_is_computed_only_where_the_masses_are_pressed_together(sources):
    """A comparison of numbers decides first; what costs a Newton iteration comes last."""
    text = text_of(sources["harmonic stribeck moving hunt-crossley"][1])
    blocks = re.split(r"\n(?=\S+:\n)", text)
    calls = [block for block in blocks if re.search(r'call double @"chaosdrill_hunt_crossley_peak"', block)]
    # the third is the test of a hit that is too weak, of which nothing else decides
    assert [block.startswith("then") for block in calls].count(True) == len(calls) - 1 == 2


def test_the_plainest_drill_is_a_linear_oscillator():
    source = write(cd.drill(drive="none", friction="none", rock="fixed", contact="none"))
    assert not re.search(r"llvm\.(sin|cos|exp|log|pow|sqrt)", text_of(source))
    assert source.rows == 2
    assert source.events == ((),)

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
    assert ("math.exp" in text) == (effects["friction"] == "stribeck")
    assert ("hunt_crossley_exit" in text) == (effects["contact"] == "hunt-crossley")
    assert ("hunt_crossley_peak" in text) == (effects["contact"] == "hunt-crossley" and effects["friction"] != "none")
    assert ("x2" in text) == (effects["rock"] == "moving")
    assert text.count("@helper\ndef _jet_") == len(system.modes)


@pytest.mark.parametrize("effects", DRILLS, ids=name_of)
def test_guards(sources, effects):
    """Stick watches release and stop, slip watches standstill and stop, as far as there are any."""
    held, stop = effects["friction"] != "none", effects["contact"] != "none"
    system, source = sources[name_of(effects)]
    expected = {"stick": held + stop, "slip": held + stop}
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


def test_the_plainest_drill_is_a_linear_oscillator():
    source = write_source(cd.drill(drive="none", friction="none", rock="fixed", contact="none"))
    assert "math." not in source.text.replace("import math", "")
    assert source.rows == 2
    assert source.events == ((),)

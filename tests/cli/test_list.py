"""``list`` names what a scene may name."""

import json

import pytest

from chaosdrill.analysis.registry import analyses
from chaosdrill.scene import parse_scene
from chaosdrill.systems import REGISTRY, build


@pytest.mark.parametrize("topic", ["systems", "effects", "analyses", "methods"])
def test_a_line_each(call, topic):
    answer = call("list", topic)
    assert answer.code == 0
    for line in answer.out.splitlines():
        if topic == "systems" and line.endswith(":"):
            continue
        name, summary = line.strip().split("  ", 1)
        assert name.strip()
        assert summary.strip(), line


def test_every_system_listed_can_be_a_scene(call):
    systems = json.loads(call("list", "systems", "--json").out)
    assert "percussive-drill" in systems
    for name in systems:
        assert parse_scene(f'[system]\nmodel = "{name}"\n').model == name


def test_effects_with_their_options(call):
    effects = json.loads(call("list", "effects", "--json").out)
    assert {"drive", "friction", "rock", "contact"} <= effects.keys()
    assert {"none", "newton", "hunt-crossley"} <= effects["contact"].keys()


def test_methods(call):
    assert {"taylor", "dop853", "rk4"} <= json.loads(call("list", "methods", "--json").out).keys()


def test_systems_are_listed_in_groups(call):
    lines = call("list", "systems").out.splitlines()
    assert lines.index("neurons:") < lines.index("walkers:")
    (izhikevich,) = [k for k, line in enumerate(lines) if line.strip().startswith("izhikevich ")]
    assert lines.index("neurons:") < izhikevich < lines.index("walkers:")


@pytest.mark.parametrize("kind", list(analyses()))
def test_settings_of_an_analysis(call, kind):
    found = json.loads(call("list", "analyses", kind, "--json").out)
    assert tuple(found) == analyses()[kind].told()
    assert all(": " in line and "As in" not in line for line in found.values())


def test_settings_of_what_has_none(call):
    assert "did you mean 'basins'" in call("list", "analyses", "basin").err
    assert "only analyses have settings" in call("list", "systems", "basins").err


@pytest.mark.parametrize("name", sorted(REGISTRY))
def test_a_new_scene_is_the_system_as_it_is(call, name):
    scene = parse_scene(call("new", name).out)
    system = build(name)
    assert scene.system.parameters == system.parameters
    assert scene.system.initial == system.initial
    assert list(scene.analyses) == ["run", "spectrum"]

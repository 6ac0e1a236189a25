"""``list`` names what a scene may name."""

import json

import pytest

from chaosdrill.scene import parse_scene


@pytest.mark.parametrize("topic", ["systems", "effects", "analyses", "methods"])
def test_a_line_each(call, topic):
    answer = call("list", topic)
    assert answer.code == 0
    for line in answer.out.splitlines():
        name, summary = line.split("  ", 1)
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

"""``check`` prints what a scene simulates and what it leaves out."""

import json


def test_equations_of_what_is_simulated(call, scene):
    answer = call("check", scene)
    assert answer.code == 0
    lines = [" ".join(line.split()) for line in answer.out.splitlines()]
    assert lines[0] == "Drill without a stop"
    assert "dy/dt = u - w" in lines
    assert "dw/dt = 0" in lines
    assert "event release (slip, stick -> slip)" in lines
    assert "eta = 0.8 forcing frequency over natural frequency" in lines
    assert "b = 0.7 (default) static load over the static friction force" in lines
    assert "period 2*pi/eta" in lines
    assert "periods 3" in lines


def test_what_is_left_out(call, scene):
    text = call("check", scene).out
    block = text[text.index("left out") : text.index("states")]
    offered = "newton, hunt-crossley, hunt-crossley-timed, compliant"
    assert block.split() == ["left", "out", "contact", "choose", "from", *offered.split()]
    assert "impact" not in text
    assert " r " not in text


def test_json(call, scene):
    answer = call("check", scene, "--json")
    described = json.loads(answer.out)
    assert described["valid"] is True
    assert list(described["states"]) == ["y", "u", "w"]
    assert described["modes"]["stick"]["dw/dt"] == "0"
    assert described["events"]["stick"]["direction"] == -1
    assert described["left_out"] == {"contact": "choose from newton, hunt-crossley, hunt-crossley-timed, compliant"}
    assert described["analyses"] == {"motion": {"kind": "trajectory", "periods": 3}}


def test_json_of_a_wrong_scene(call, scene):
    scene.write_text(scene.read_text().replace("eta = 0.8", "etta = 0.8").replace("periods = 3", "periods = 0"))
    answer = call("check", scene, "--json")
    assert answer.code == 2
    document = json.loads(answer.out)
    assert document["valid"] is False
    assert document["error"]["kind"] == "SceneError"
    assert document["error"]["message"] == answer.err.strip()
    assert document["problems"] == [
        {"line": 9, "field": "system.parameters.etta", "message": "unknown parameter; did you mean 'eta'?"},
        {"line": 12, "field": "analysis.motion.periods", "message": "must be at least 1, received 0"},
    ]


def test_a_system_without_effects(call, scene):
    scene.write_text('[system]\nmodel = "lorenz"\n')
    lines = call("check", scene).out.splitlines()
    assert lines[:2] == ["scene", "system     lorenz"]
    assert not any(line.startswith(("left out", "simulated", "event")) for line in lines)

"""A parameter that takes the forcing period away is refused with its line, before anything runs."""

import json

import pytest

SCENE = """\
[system]
model = "impact-oscillator"
[system.parameters]
omega = OMEGA
[analysis.motion]
kind = "trajectory"
periods = 2
"""


@pytest.fixture
def still(tmp_path):
    """Function that writes the scene at a frequency."""

    def write(omega):
        path = tmp_path / "still.toml"
        path.write_text(SCENE.replace("OMEGA", omega))
        return path

    return write


@pytest.mark.parametrize("omega", ["0.0", "0", "-1.5"])
@pytest.mark.parametrize("command", ["run", "check"])
def test_the_line_of_the_frequency_is_told(call, still, monkeypatch, tmp_path, command, omega):
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    answer = call(command, still(omega), *(["-o", tmp_path / "out.nc"] if command == "run" else []))
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("still.toml:4: system.parameters.omega: impact-oscillator: the period 2*pi/omega is")
    assert f"not a positive number at {{'omega': {float(omega)}}}; it must be > 0" in answer.err
    assert "zoo" not in answer.err


def test_check_lists_it_as_json(call, still):
    answer = call("check", still("0.0"), "--json")
    assert answer.code == 2
    assert [fault["line"] for fault in json.loads(answer.out)["problems"]] == [4]


def test_a_frequency_above_zero_passes(call, still):
    assert call("check", still("1e-3")).code == 0

"""Modes, events and periods that only the built system knows are checked before anything runs."""

import pytest

from chaosdrill.errors import SceneError
from chaosdrill.scene import parse_scene

WITHOUT_FORCING = '[system]\nmodel = "lorenz"\n[analysis.a]\n'


def refusal(text):
    scene = parse_scene(text)
    with pytest.raises(SceneError) as caught:
        _ = scene.system
    return str(caught.value)


def test_mode(sound):
    told = refusal(sound.replace("y = 0.0", 'mode = "stik"'))
    assert told == "scene.toml:12: system.initial.mode: unknown mode 'stik'; did you mean 'stick'?"


def test_mode_of_a_seed(sound):
    told = refusal(sound + 'seeds = [{ y = 0.0 }, { mode = "slipp" }]\n')
    assert told == "scene.toml:25: analysis.diagram.seeds[1].mode: unknown mode 'slipp'; did you mean 'slip'?"


def test_event_of_a_section(sound):
    told = refusal(sound + 'at = "hitt"\n')
    assert told.startswith("scene.toml:25: analysis.diagram.at: unknown event 'hitt'; did you mean ")
    told = refusal(sound + 'at = "yy > 0"\n')
    assert told.startswith("scene.toml:25: analysis.diagram.at: unknown name 'yy'; did you mean 'y'?")
    told = refusal(sound + 'at = "eta > 0"\n')
    assert told.startswith("scene.toml:25: analysis.diagram.at: a section is one comparison of states by < or >")
    assert parse_scene(sound + 'at = "y > 0"\n').system


def test_periods_without_a_forcing():
    told = refusal(WITHOUT_FORCING + 'kind = "lyapunov-spectrum"\nperiods = 10\n')
    assert told.startswith("scene.toml:5: analysis.a.periods: lorenz has no forcing period; give duration")


def test_duration_with_a_forcing(sound):
    told = refusal(sound.replace("periods = 20", "duration = 20"))
    assert told == "scene.toml:19: analysis.spectrum.duration: percussive-drill has a forcing period; give periods"


def test_part_of_a_period(sound):
    told = refusal(sound.replace("transient = 10", "transient = 10.5"))
    assert told == "scene.toml:18: analysis.spectrum.transient: expected whole forcing periods, received 10.5"


def test_section_at_a_class_of_events(sound):
    scene = parse_scene(sound + 'at = "impact"\n')
    assert {event.kind for event in scene.system.transitions} >= {"impact"}


def test_strobe_without_a_forcing():
    told = refusal(WITHOUT_FORCING + 'kind = "poincare-section"\nduration = 10\n')
    assert told.startswith(
        "scene.toml:4: analysis.a.kind: lorenz has no forcing period, and so no strobe; give at = 'x > 0'"
    )


def test_diagram_without_a_forcing():
    told = refusal(WITHOUT_FORCING + 'kind = "bifurcation-diagram"\nsweep.rho = [28]\ntransient = 0\nperiods = 9\n')
    assert "scene.toml:4: analysis.a.kind: lorenz has no forcing period, and so no strobe; give at = 'x > 0'" in told


def test_values_reach_the_system(sound):
    text = sound.replace("y = 0.0", 'y = 0.25\nmode = "slip"').replace("eta = 0.448", "eta = 0.5\nxi = 0.12")
    system = parse_scene(text).system
    assert system.initial == {"mode": "slip", "y": 0.25, "u": 0.0, "w": 0.0}
    assert (system.parameters["eta"], system.parameters["xi"], system.parameters["b"]) == (0.5, 0.12, 0.7)


def test_what_is_left_out_is_not_in_the_system(sound):
    text = sound.replace('contact = "hunt-crossley"\n', "").replace('drive = "harmonic"\n', "")
    text = text[: text.index("[system.parameters]")]
    system = parse_scene(text).system
    assert not {"a", "eta", "r", "lam", "k", "n"} & system.parameters.keys()
    assert {transition.kind for transition in system.transitions} == {"slip", "stick"}

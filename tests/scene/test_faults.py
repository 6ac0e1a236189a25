"""A wrong scene of each kind is told with its line, its field and the remedy."""

import pytest

from chaosdrill.scene import parse_scene

# (what stands in the sound scene, what takes its place, the message)
CASES = [
    ('title = "A sound scene"', "titel = 1", "1: titel: unknown key; did you mean 'title'?"),
    ('title = "A sound scene"', "title = 1", "1: title: expected text in quotes, received 1"),
    ('"percussive-drill"', '"percusive-drill"', "3: system.model: unknown model 'percusive-drill'; did you mean"),
    ('drive = "harmonic"', 'drivel = "none"', "5: system.effects.drivel: unknown effect; did you mean 'drive'?"),
    ('"stribeck"', '"stribek"', "6: system.effects.friction: unknown option 'stribek'; did you mean 'stribeck'?"),
    ('"stribeck"', "3", "6: system.effects.friction: expected text in quotes, received 3"),
    ('rock = "moving"', 'rock = "fixed"', "4: system.effects: friction 'stribeck' acts on a moving rock"),
    ("eta = 0.448", "etta = 0.448", "10: system.parameters.etta: unknown parameter; did you mean 'eta'?"),
    ("eta = 0.448", 'eta = "0.448"', "10: system.parameters.eta: expected a number, received '0.448'"),
    ("eta = 0.448", "eta = true", "10: system.parameters.eta: expected a number, received True"),
    ("eta = 0.448", "eta = nan", "10: system.parameters.eta: must be finite, received nan"),
    ("eta = 0.448", "eps = -1", "10: system.parameters.eps: the mass ratio m1/m2 must be greater than 0, received -1"),
    ("eta = 0.448", "k = -12e5", "10: system.parameters.k: the contact's stiffness must be greater than 0"),
    ("y = 0.0", "z = 0.0", "12: system.initial.z: unknown state; known here: mode, y, u, w"),
    ("y = 0.0", 'y = "up"', "12: system.initial.y: expected a number, received 'up'"),
    ("y = 0.0", "mode = 1", "12: system.initial.mode: expected the name of a mode, received 1"),
    ('"taylor"', '"tailor"', "14: numerics.method: unknown method 'tailor'; did you mean 'taylor'?"),
    ('"taylor"', "{ a = 1 }", "14: numerics.method: expected text in quotes"),
    ("tolerance = 1e-12", "tolerance = 0", "15: numerics.tolerance: must be at least 1e-16, received 0"),
    ("tolerance = 1e-12", "tolerance = -1e-9", "15: numerics.tolerance: must be at least 1e-16"),
    ("tolerance = 1e-12", "tolerance = 0.1", "15: numerics.tolerance: must be at most 0.01, received 0.1"),
    ("tolerance = 1e-12", "max_stalls = 0", "15: numerics.max_stalls: must be at least 1, received 0"),
    ("tolerance = 1e-12", "steps = 200", "15: numerics.steps: taylor chooses its own steps; leave it out"),
    ('"lyapunov-spectrum"', '"lyapunov"', "17: analysis.spectrum.kind: unknown kind 'lyapunov'; did you mean"),
    ("transient = 10", "transient = -1", "18: analysis.spectrum.transient: must be at least 0, received -1"),
    ("periods = 20", "periods = 0", "19: analysis.spectrum.periods: must be at least 1, received 0"),
    ("periods = 20", f"periods = 1{'0' * 30}", "19: analysis.spectrum.periods: must be at most 1e+10"),
    ("periods = 20", "periods = 2.5", "19: analysis.spectrum.periods: expected a whole number, received 2.5"),
    ("periods = 20", "duration = inf", "19: analysis.spectrum.duration: must be finite, received inf"),
    ("periods = 20", "", "16: analysis.spectrum: give either periods (points of the section) or duration (time units)"),
    ("periods = 20", "periods = 2\nexponents = 4", "20: analysis.spectrum.exponents: the system has 3 states"),
    ("num = 3", "num = 0", "22: analysis.diagram.sweep.eta.num: must be at least 1, received 0"),
    ("num = 3", "num = 3, step = 1", "22: analysis.diagram.sweep.eta.step: unknown key; leave it out"),
    (", num = 3", "", "22: analysis.diagram.sweep.eta.num: missing"),
    ("sweep.eta", "sweep.etta", "22: analysis.diagram.sweep.etta: unknown parameter; did you mean 'eta'?"),
    ("start = 0.4", "start = -0.4", "22: analysis.diagram.sweep.eta: the frequency ratio must be greater than 0"),
    ("{ start = 0.4, stop = 0.9, num = 3 }", "[]", "22: analysis.diagram.sweep.eta: must not be empty, received []"),
    ("{ start = 0.4, stop = 0.9, num = 3 }", '[1, "2"]', "22: analysis.diagram.sweep.eta[1]: expected a number"),
    ("sweep.eta = { start = 0.4, stop = 0.9, num = 3 }", "", "20: analysis.diagram.sweep: missing"),
    ("transient = 3", "transient = 3\nseeds = [\n{y = 1},\n{v = 1}]", "26: analysis.diagram.seeds[1].v: unknown state"),
    ("{ start = 0.4, stop = 0.9, num = 3 }", "[1, 2, 1]", "22: analysis.diagram.sweep.eta: contains a value twice"),
    ("start = 0.4", "start = 0.9", "22: analysis.diagram.sweep.eta: start and stop are equal; give num = 1"),
    ("periods = 8", "periods = 1", "24: analysis.diagram.periods: must be at least 2, received 1"),
    (
        "[analysis.diagram]",
        '[analysis."a/b"]',
        '20: analysis."a/b": the name must consist of at most 64 letters, digits',
    ),
]


@pytest.mark.parametrize(("old", "new", "message"), CASES, ids=[case[1][:30] or case[0] for case in CASES])
def test_fault(sound, faults, old, new, message):
    assert old in sound
    told = faults(sound.replace(old, new, 1))
    assert len(told) == 1, told
    assert told[0].startswith(f"scene.toml:{message}")


def test_a_sound_scene_has_none(sound):
    scene = parse_scene(sound)
    assert scene.title == "A sound scene"
    assert list(scene.analyses) == ["spectrum", "diagram"]
    assert scene.parameters == {"eta": 0.448}


def test_effects_of_a_system_that_has_none(faults):
    text = '[system]\nmodel = "lorenz"\neffects.drive = "harmonic"\n'
    assert faults(text) == ["scene.toml:3: system.effects.drive: lorenz is not assembled from effects; leave them out"]


def test_a_setting_that_another_one_excludes_is_told_with_all_other_faults(sound, faults):
    told = faults(sound.replace("tolerance = 1e-12", "tolerance = 0\nsteps = 200"))
    assert [line.split(":")[2].strip() for line in told] == ["numerics.tolerance", "numerics.steps"]


def test_a_swept_name_and_its_values_are_both_told(sound, faults):
    told = faults(sound.replace("sweep.eta = { start = 0.4, stop = 0.9, num = 3 }", "sweep.etta = 3"))
    assert len(told) == 2
    assert all("analysis.diagram.sweep.etta: " in line for line in told)

"""Faults of scenes: every one at once, each with its line, its field and its remedy."""

import inspect
import re

import numpy as np
import pytest

import chaosdrill as cd
import chaosdrill.analysis
from chaosdrill.analysis.base import NumericsSettings
from chaosdrill.declared import ANALYSES, METHODS
from chaosdrill.errors import SceneError
from chaosdrill.names import brief, remedy
from chaosdrill.scene import parse_scene

# A wrong scene of each kind is reported with its line, its field and the remedy.


# (what stands in the sound scene, what takes its place, the message)
CASES = [
    ('title = "A sound scene"', "titel = 1", "1: titel: unknown key; did you mean 'title'?"),
    (
        'title = "A sound scene"',
        "parameters.eta = 1",
        "1: parameters: belongs in [system], as system.",
    ),
    ('title = "A sound scene"', "eta = 1", "1: eta: belongs in [system.parameters], as system.parameters.eta"),
    ('title = "A sound scene"', "y = 1", "1: y: belongs in [system.initial], as system.initial.y"),
    ('title = "A sound scene"', "tolerance = 1", "1: tolerance: belongs in [numerics], as numerics.tolerance"),
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
    ("periods = 20", f"periods = 1{'0' * 18}", "19: analysis.spectrum.periods: must be at most 1e+10"),
    ("periods = 20", "periods = 2.5", "19: analysis.spectrum.periods: expected a whole number, received 2.5"),
    ("periods = 20", "duration = inf", "19: analysis.spectrum.duration: must be finite, received inf"),
    ("periods = 20", "", "16: analysis.spectrum: give either periods (of the forcing,"),
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
    ("[analysis.diagram]", "[analysis.Spectrum]", "20: analysis.Spectrum: differs from 'spectrum' by case alone"),
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


def test_a_parameter_of_an_effect_that_is_not_chosen(faults):
    """It is told with the effects that use it, like that of a system from Python; in a sweep as well."""
    text = (
        '[system]\nmodel = "percussive-drill"\nparameters = { mu = 0.2 }\n'
        '[analysis.a]\nkind = "bifurcation-diagram"\nsweep.eta = [0.5, 0.6]\nduration = 8\n'
    )
    shown = "\n".join(faults(text))
    assert (
        "3: system.parameters.mu: not used with friction='none', rock='fixed'; "
        "leave it out, or choose friction='coulomb', rock='moving'"
    ) in shown
    assert "6: analysis.a.sweep.eta: not used with drive='none'; leave it out, or choose drive='harmonic'" in shown


def test_a_setting_that_another_one_excludes_is_told_with_all_other_faults(sound, faults):
    told = faults(sound.replace("tolerance = 1e-12", "tolerance = 0\nsteps = 200"))
    assert [line.split(":")[2].strip() for line in told] == ["numerics.tolerance", "numerics.steps"]


def test_a_swept_name_and_its_values_are_both_told(sound, faults):
    told = faults(sound.replace("sweep.eta = { start = 0.4, stop = 0.9, num = 3 }", "sweep.etta = 3"))
    assert len(told) == 2
    assert all("analysis.diagram.sweep.etta: " in line for line in told)


# Scenes that ask for periodic orbits and branches of them: every key is checked, with its line.


ORBITS_SCENE = """\
[system]
model = "impact-oscillator"
parameters = { omega = 2.5, wall = 0.2 }
[analysis.orbit]
kind = "periodic-orbit"
period = 2
start = "guess"
[analysis.all]
kind = "periodic-orbit"
start = "search"
max_period = 4
random = { count = 20, seed = 1, x = [-1, 0.2] }
[analysis.branch]
kind = "continuation"
sweep.omega = { start = 2.6, stop = 2.4 }
doublings = 3
step = 1e-3
[analysis.curve]
kind = "continuation"
sweep.omega = { start = 2.4, stop = 2.6 }
sweep.wall = { start = 0.0, stop = 0.5 }
follow = "grazing"
"""

ORBITS_CASES = [
    ("period = 2", "period = 0", "6: analysis.orbit.period: must be at least 1, received 0"),
    ("period = 2", "max_period = 2", '6: analysis.orbit.max_period: applies with start = "search" only; leave it'),
    ('"guess"', '"rest"', "7: analysis.orbit.start: expected one of ['attractor', 'guess', 'search'], received 'rest'"),
    ("max_period = 4", "", '8: analysis.all.max_period: missing; start = "search" needs the longest period'),
    ("max_period = 4", "max_period = 4\nperiod = 1", '12: analysis.all.period: start = "search" looks for all up'),
    ("x = [-1, 0.2]", "z = [-1, 0.2]", "12: analysis.all.random.z: unknown state; known here: x, v"),
    ("sweep.omega = { start = 2.6", "sweep.omeg = { start = 2.6", "15: analysis.branch.sweep.omeg: unknown parameter"),
    ("stop = 2.4 }", "stop = 2.6 }", "15: analysis.branch.sweep.omega: start and stop are equal"),
    (
        "stop = 2.4 }",
        "stop = 2.55 }",
        "15: analysis.branch.sweep.omega: the branch starts at the value of the system, omega",
    ),
    ("stop = 2.4 }", "stop = 2.4, num = 9 }", "15: analysis.branch.sweep.omega.num: unknown key; leave it out"),
    (
        "{ start = 2.6, stop = 2.4 }",
        "[2.6, 2.4]",
        "15: analysis.branch.sweep.omega: expected two limits",
    ),
    *(
        (
            "{ start = 2.6, stop = 2.4 }",
            value,
            "15: analysis.branch.sweep.omega: expected two limits, start",
        )
        for value in ("3", "[]", "[1]", "true", "nan", "'x'", "1979-05-27")
    ),
    ("doublings = 3", "doublings = 40", "16: analysis.branch.doublings: must be at most 12, received 40"),
    ("step = 1e-3", "step = 0.0", "17: analysis.branch.step: must be greater than 0, received 0.0"),
    ("step = 1e-3", "step = 0.25", "17: analysis.branch.step: is longer than the whole range of 'omega'"),
    ("step = 1e-3", 'follow = "fold"', "17: analysis.branch.follow: sweep names only 'omega'; name the second"),
    ('follow = "grazing"', "", "18: analysis.curve.follow: missing, though sweep names two parameters"),
    (
        'follow = "grazing"',
        'follow = "fold"\ndoublings = 1',
        "23: analysis.curve.doublings: a curve in two",
    ),
    (
        '"grazing"',
        '"torus"',
        "22: analysis.curve.follow: expected one of ['fold', 'period_doubling', 'neimark_sacker', 'grazing', ",
    ),
    ("step = 1e-3", "functions.f = 3", "17: analysis.branch.functions.f: expected a table"),
    ("step = 1e-3", "levels.f = [1]", "17: analysis.branch.levels.f: there is no such function"),
    ('follow = "grazing"', 'follow = "level"', '18: analysis.curve.levels: follow = "level" needs one level'),
]


def test_the_keywords_reach_the_functions():
    analyses = parse_scene(ORBITS_SCENE).analyses
    assert analyses["orbit"].keywords() == {"period": 2, "start": "guess"}
    assert analyses["all"].keywords()["max_period"] == 4
    assert analyses["branch"].keywords() == {"sweep": {"omega": (2.6, 2.4)}, "doublings": 3, "step": 1e-3}
    assert list(analyses["curve"].keywords()["sweep"]) == ["omega", "wall"]


@pytest.mark.parametrize(("old", "new", "message"), ORBITS_CASES)
def test_faults_of_orbits(faults, old, new, message):
    found = faults(ORBITS_SCENE.replace(old, new, 1))
    assert len(found) == 1, found
    assert found[0].startswith(f"scene.toml:{message}")


def test_periods_are_not_counted_without_forcing():
    text = ORBITS_SCENE[: ORBITS_SCENE.index("[analysis.all]")].replace("impact-oscillator", "roessler")
    text = text.replace("parameters = { omega = 2.5, wall = 0.2 }", "")
    with pytest.raises(SceneError, match=r"6: analysis\.orbit\.period: roessler has no forcing period"):
        _ = parse_scene(text).system
    assert parse_scene(text.replace("period = 2\n", "transient = 12.5\n")).system.name == "roessler"


# Charts, basins and seeds in scenes: what reaches the function, and faults are reported with line and remedy.


HEAD = """\
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[analysis.a]
transient = 10
periods = 20
"""

DIAGRAM = HEAD + 'kind = "bifurcation-diagram"\nsweep.eta = [0.5, 0.6]\n'
CHART = HEAD + 'kind = "parameter-chart"\nsweep.eta = [0.5, 0.6]\n'
BASINS = HEAD + 'kind = "basins"\n'


def keywords(text):
    return parse_scene(text, "scene.toml").analyses["a"].keywords()


def test_a_chart_sweeps_two_parameters_in_their_order():
    given = keywords(CHART + "sweep.b = { start = 0.5, stop = 0.9, num = 5 }\nexponents = 2\nmax_extension = 4\n")
    assert list(given["sweep"]) == ["eta", "b"]
    np.testing.assert_array_equal(given["sweep"]["b"], np.linspace(0.5, 0.9, 5))
    assert {key: given[key] for key in ("transient", "periods", "exponents", "max_extension")} == {
        "transient": 10,
        "periods": 20,
        "exponents": 2,
        "max_extension": 4,
    }


def test_basins_have_a_grid_of_two_states():
    given = keywords(BASINS + "grid.y = { start = -1, stop = 1, num = 3 }\ngrid.u = [0.0, 0.5]\n")
    assert list(given["grid"]) == ["y", "u"]
    np.testing.assert_array_equal(given["grid"]["y"], [-1.0, 0.0, 1.0])
    assert "sweep" not in given


def test_seeds_of_every_kind():
    given = keywords(
        DIAGRAM
        + 'seeds = [{ y = 0.1 }, { u = 0.2, mode = "slip" }]\n'
        + 'random = { count = 4, seed = 1, mode = "slip", y = [-1, 1], w = [0, 1.5] }\nfollow = "both"\n'
    )
    assert given["seeds"] == [{"y": 0.1}, {"u": 0.2, "mode": "slip"}]
    assert given["random"] == {"count": 4, "seed": 1, "mode": "slip", "y": [-1, 1], "w": [0, 1.5]}
    assert given["follow"] == "both"


SWEEPS_FAULTS = [
    (CHART, "8: analysis.a.sweep: names ['eta']; a parameter"),
    (
        CHART + "sweep.b = [1.0]\nsweep.a = [1.0]\n",
        "8: analysis.a.sweep: names ['a', 'b', 'eta']; a",
    ),
    (DIAGRAM + "sweep.b = [1.0]\n", "8: analysis.a.sweep: names ['b', 'eta']; a bifurcation diagram"),
    (CHART + "sweep.bb = [1.0]\n", "9: analysis.a.sweep.bb: unknown parameter; did you mean 'b'?"),
    (CHART + 'sweep.b = [1.0]\nfollow = "both"\n', "10: analysis.a.follow: unknown key"),
    (BASINS + "grid.y = [0.0]\ngrid.ww = [0.0]\n", "9: analysis.a.grid.ww: unknown state; did you mean 'w'?"),
    (BASINS + "grid.y = [0.0]\n", "8: analysis.a.grid: names ['y']; basins are drawn over two states"),
    (BASINS + "grid.y = [0.0, 0.0]\ngrid.u = [0.0]\n", "8: analysis.a.grid.y: contains a value twice"),
    (BASINS, "4: analysis.a.grid: missing"),
    (BASINS + "grid.y = [0.0]\ngrid.u = [0.0]\nseeds = [{}]\n", "10: analysis.a.seeds: unknown key"),
    (
        DIAGRAM + 'follow = "up"\n',
        "9: analysis.a.follow: expected one of ['forward', 'backward', 'both'], or leave it out, received 'up'",
    ),
    (DIAGRAM + "random = { seed = 1, y = [0, 1] }\n", "9: analysis.a.random.count: missing"),
    (DIAGRAM + "random = { count = 2, y = [0, 1] }\n", "9: analysis.a.random.seed: missing"),
    (DIAGRAM + "random = { count = 0, seed = 1, y = [0, 1] }\n", "9: analysis.a.random.count: must be at least 1"),
    (DIAGRAM + "random = { count = 2, seed = 1 }\n", "9: analysis.a.random: names no state; give the range"),
    (DIAGRAM + "random = { count = 2, seed = 1, y = [1, 0] }\n", "9: analysis.a.random.y: must increase: [low, high]"),
    (DIAGRAM + "random = { count = 2, seed = 1, y = 3 }\n", "9: analysis.a.random.y: expected a list, received 3"),
    (DIAGRAM + "random = { count = 2, seed = 1, y = [0, 1, 2] }\n", "9: analysis.a.random.y: must have at most 2"),
    (DIAGRAM + "random = { count = 2, seed = 1, z = [0, 1] }\n", "9: analysis.a.random.z: unknown state; known here: "),
    (DIAGRAM + "max_extension = -1\n", "9: analysis.a.max_extension: must be at least 0, received -1"),
]


@pytest.mark.parametrize(("text", "expected"), SWEEPS_FAULTS, ids=[expected for _, expected in SWEEPS_FAULTS])
def test_faults_of_sweeps(faults, text, expected):
    (line,) = faults(text)
    assert line.startswith(f"scene.toml:{expected}"), line


def test_an_unknown_mode_of_random_seeds_is_told():
    scene = parse_scene(DIAGRAM + 'random = { count = 2, seed = 1, mode = "slipp", y = [0, 1] }\n', "scene.toml")
    with pytest.raises(
        Exception, match=r"scene.toml:9: analysis.a.random.mode: unknown mode 'slipp'; did you mean 'slip'"
    ):
        _ = scene.system


DECAY = """\
[system.definition]
name = "decay"
states = ["x", "{state}"]
period = 1
[system.definition.modes.all]
x = "-{parameter}*x"
"{state}" = "-{parameter}*{state}"
[system.parameters]
"{parameter}" = 0.5
[analysis.a]
transient = 1
periods = 2
"""


@pytest.mark.parametrize(
    ("names", "asked", "told"),
    [
        (
            {"state": "y", "parameter": "period"},
            'kind = "bifurcation-diagram"\nsweep.period = [0.5, 0.6]\n',
            "14: analysis.a.sweep.period: is reserved for results, and cannot be swept; rename the parameter",
        ),
        (
            {"state": "outcome", "parameter": "k"},
            'kind = "basins"\ngrid.x = [0.0]\ngrid.outcome = [0.0]\n',
            "15: analysis.a.grid.outcome: is reserved for results, and cannot span a grid; rename the state",
        ),
    ],
)
def test_what_spans_results_is_called_as_a_variable_of_an_archive_can_be(faults, names, asked, told):
    assert faults(DECAY.format(**names) + asked) == [f"scene.toml:{told}"]


# Scenes that ask for work-precision: every key is checked, with its line.


WORK_PRECISION_SCENE = """\
[system]
model = "impact-oscillator"
[analysis.cost]
kind = "work-precision"
periods = 100
transient = 10
methods = ["taylor", "rk4"]
tolerances = [1e-4, 1e-8]
steps = [100, 1000]
repeats = 3
"""

WORK_PRECISION_CASES = [
    ('"taylor", "rk4"', '"taylor", "rk5"', "7: analysis.cost.methods[1]: unknown method 'rk5'; did you mean 'rk4'?"),
    ('"taylor", "rk4"', '"taylor", "taylor"', "7: analysis.cost.methods: contains a value twice"),
    ('"taylor", "rk4"', "", "7: analysis.cost.methods: must not be empty"),
    ('"taylor", "rk4"', "1", "7: analysis.cost.methods[0]: expected text in quotes, received 1"),
    ("[1e-4, 1e-8]", "[1e-4, 1e-18]", "8: analysis.cost.tolerances[1]: must be at least 1e-16, received 1e-18"),
    ("[1e-4, 1e-8]", "[1e-4, 1]", "8: analysis.cost.tolerances[1]: must be at most 0.01, received 1"),
    ("[1e-4, 1e-8]", "[1e-4, 1e-4]", "8: analysis.cost.tolerances: contains a value twice"),
    ("[100, 1000]", "[100]", "9: analysis.cost.steps: expected a list of 2 counts, one for each of tolerances"),
    ("[100, 1000]", "[100, 2]", "9: analysis.cost.steps[1]: must be at least 4, received 2"),
    ("repeats = 3", "repeats = 0", "10: analysis.cost.repeats: must be at least 1, received 0"),
    ("repeats = 3", "repeat = 3", "10: analysis.cost.repeat: unknown key; did you mean 'repeats'?"),
    ("repeats = 3", 'method = "rk4"', "10: analysis.cost.method: unknown key; did you mean 'methods'?"),
    ("periods = 100", "", "3: analysis.cost: give either periods (of the forcing,"),
]


def test_the_keywords_reach_the_function():
    analysis = parse_scene(WORK_PRECISION_SCENE).analyses["cost"]
    assert analysis.keywords() == {
        "periods": 100,
        "transient": 10,
        "methods": ["taylor", "rk4"],
        "tolerances": [1e-4, 1e-8],
        "steps": [100, 1000],
        "repeats": 3,
    }


@pytest.mark.parametrize(("old", "new", "message"), WORK_PRECISION_CASES)
def test_faults_of_work_precision(faults, old, new, message):
    found = faults(WORK_PRECISION_SCENE.replace(old, new))
    assert len(found) == 1, found
    assert found[0].startswith(f"scene.toml:{message}")


# Modes, events and periods that only the built system knows are checked before anything runs.


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
    fault = "percussive-drill has a forcing period; give periods instead (about 1), received 20"
    assert told == f"scene.toml:19: analysis.spectrum.duration: {fault}"


def test_part_of_a_period(sound):
    told = refusal(sound.replace("transient = 10", "transient = 10.5"))
    assert told == "scene.toml:18: analysis.spectrum.transient: expected whole forcing periods, received 10.5"


def test_section_at_a_class_of_events(sound):
    scene = parse_scene(sound + 'at = "impact"\n')
    assert {event.kind for event in scene.system.transitions} >= {"impact"}


def test_strobe_without_a_forcing():
    told = refusal(WITHOUT_FORCING + 'kind = "poincare-section"\nduration = 10\n')
    assert told.startswith(
        "scene.toml:3: analysis.a: lorenz has no forcing period, and so no strobe; name a section, as in at='x > 0'"
    )


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("lyapunov-spectrum", {}),
        ("lyapunov-spectrum", {"periods": 5}),
        ("lyapunov-spectrum", {"periods": 5, "duration": 2.5}),
        ("lyapunov-spectrum", {"periods": 5, "at": "strobe"}),
        ("lyapunov-spectrum", {"duration": -1}),
        ("trajectory", {"periods": 5, "at": "x > 0", "transient": 0.5}),
        ("trajectory", {"at": "x > 0", "times": [1.0, 2.0]}),
        ("poincare-section", {"duration": 5.0, "at": "x0 > 0"}),
        ("periodic-orbit", {"period": 2}),
        ("periodic-orbit", {"transient": 0.5, "at": "x > 0"}),
    ],
)
def test_lengths_are_refused_alike_in_python_and_in_scenes(kind, given):
    text = WITHOUT_FORCING + f'kind = "{kind}"\n' + "".join(f"{key} = {value!r}\n" for key, value in given.items())
    with pytest.raises(SceneError) as of_scene:
        _ = parse_scene(text).system
    with pytest.raises(cd.SettingsError) as of_python:
        getattr(cd, kind.replace("-", "_"))(cd.build("lorenz"), **given)
    words = str(of_python.value).partition("; ")[2] or str(of_python.value)
    assert words in str(of_scene.value)


def test_diagram_without_a_forcing():
    told = refusal(WITHOUT_FORCING + 'kind = "bifurcation-diagram"\nsweep.rho = [28]\ntransient = 0\nperiods = 9\n')
    assert "scene.toml:3: analysis.a: lorenz has no forcing period, and so no strobe; name a section" in told


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


# No fault hides another, and they come in the order of their lines.


ALL_FAULTS_AT_ONCE_SCENE = """\
titel = "x"
[system]
model = "percussive-drill"
[system.effects]
friction = "stribek"
rock = "moving"
[system.parameters]
etta = 0.448
eps = -1
xi = true
[system.initial]
q = 1.0
[numerics]
method = "tailor"
tolerance = 0
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = -3
periods = 2.0
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.eta = []
transient = 1
[analysis.other]
kind = "bifurcation"
"""


def test_all_faults_at_once(faults):
    told = [re.match(r"scene\.toml:(\d+): ([^:]+): ", line).groups() for line in faults(ALL_FAULTS_AT_ONCE_SCENE)]
    assert told == [
        ("1", "titel"),
        ("5", "system.effects.friction"),
        ("8", "system.parameters.etta"),
        ("9", "system.parameters.eps"),
        ("10", "system.parameters.xi"),
        ("12", "system.initial.q"),
        ("14", "numerics.method"),
        ("15", "numerics.tolerance"),
        ("18", "analysis.spectrum.transient"),
        ("19", "analysis.spectrum.periods"),
        ("20", "analysis.diagram"),
        ("22", "analysis.diagram.sweep.eta"),
        ("25", "analysis.other.kind"),
    ]


def test_a_flood_of_faults_is_cut(faults, sound):
    told = faults(sound + "".join(f"unknown{i} = 1\n" for i in range(5000)))
    assert len(told) == 51
    assert told[-1] == "scene.toml: and 4950 more"


# What a scene may say of an analysis is what the analysis function takes.


# what comes from elsewhere: the system, the table numerics, the command line
ELSEWHERE = {"progress", "workers", "scheduler", "store"}
NUMERICS = set(NumericsSettings.values())


def parameters(kind):
    found = inspect.signature(getattr(chaosdrill.analysis, ANALYSES[kind].function)).parameters
    return dict(list(found.items())[1:])


def elsewhere(kind):
    return ELSEWHERE if ANALYSES[kind].settings.own_numerics else ELSEWHERE | NUMERICS


@pytest.mark.parametrize("kind", ANALYSES)
def test_same_names(kind):
    assert ANALYSES[kind].settings.values().keys() == parameters(kind).keys() - elsewhere(kind)


@pytest.mark.parametrize("kind", ANALYSES)
def test_same_names_are_required(kind):
    empty = inspect.Parameter.empty
    required = {name for name, parameter in parameters(kind).items() if parameter.default is empty}
    faults = dict(ANALYSES[kind].settings.faults({}, also=()))
    assert {path[0] for path, text in faults.items() if text.startswith("missing; expected")} == required


@pytest.mark.parametrize("kind", ANALYSES)
def test_workers_go_to_those_that_take_them(kind):
    assert ANALYSES[kind].settings.parallel == ("workers" in parameters(kind))


@pytest.mark.parametrize("kind", [kind for kind in ANALYSES if not ANALYSES[kind].settings.own_numerics])
def test_numerics_go_to_all_that_do_not_choose_their_own(kind):
    assert parameters(kind).keys() >= NUMERICS


def test_settings_that_the_scene_leaves_out_are_not_passed_on():
    scene = parse_scene(
        '[system]\nmodel = "lorenz"\n[numerics]\ntolerance = 1e-9\n[analysis.a]\nkind = "trajectory"\nduration = 3\n'
    )
    assert scene.numerics == {"tolerance": 1e-9}
    assert scene.analyses["a"].keywords() == {"duration": 3}


def test_methods_with_a_fixed_step_exist():
    assert {name for name, method in METHODS.items() if method.fixed_step} < METHODS.keys()


def test_an_argument_that_there_is_not_is_refused_as_python_does():
    with pytest.raises(TypeError, match=r"trajectory\(\) got an unexpected keyword argument 'period'"):
        cd.trajectory(cd.build("lorenz"), period=3)
    with pytest.raises(TypeError, match=r"parameter_chart\(\) missing a required argument: 'sweep'"):
        cd.parameter_chart(cd.build("lorenz"))


@pytest.mark.parametrize(
    ("given", "known", "meant"),
    [
        ("newton contact", ("newton", "new-contact"), "newton"),
        ("shear force", ("force", "shear-forces"), "shear-forces"),
    ],
)
def test_a_known_name_among_other_words_is_meant_unless_all_of_them_are_nearly_one(given, known, meant):
    assert remedy(given, known) == f"did you mean {meant!r}?"


@pytest.mark.parametrize(("given", "known"), [("points", "exponents"), ("scale", "cases")])
def test_a_name_that_begins_otherwise_is_meant_only_if_it_is_close(given, known):
    assert remedy(given, [known]) == f"known here: {known}"
    assert remedy(known[1:], [known]) == f"did you mean {known!r}?"


def test_names_that_contain_the_given_one_are_meant():
    known = ["duffing", "drill-string", "percussive-drill-5d"]
    assert remedy("drill", known) == "did you mean 'drill-string' or 'percussive-drill-5d'?"
    assert remedy("5d", known) == "known here: duffing, drill-string, percussive-drill-5d"


def test_a_message_shows_the_beginning_of_what_is_long_or_has_several_lines():
    assert brief("a" * 58) == repr("a" * 58)
    assert brief("a" * 59) == f"'{'a' * 56}..."
    assert brief(np.eye(2)) == "array([[1., 0.], [0., 1.]])"
    assert brief(np.eye(9)) == "array([[1., 0., 0., 0., 0., 0., 0., 0., 0.], [0., 1., 0.,..."

"""Scenes that ask for periodic orbits and branches of them: every key is checked, with its line."""

import pytest

from chaosdrill.errors import SceneError
from chaosdrill.scene import parse_scene

SCENE = """\
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

CASES = [
    ("period = 2", "period = 0", "6: analysis.orbit.period: must be at least 1, received 0"),
    ("period = 2", "max_period = 2", '4: analysis.orbit: max_period applies only with start = "search"'),
    ('"guess"', '"rest"', "7: analysis.orbit.start: Input should be 'attractor', 'guess' or 'search', received 'rest'"),
    ("max_period = 4", "", '8: analysis.all: start = "search" needs max_period'),
    ("max_period = 4", "max_period = 4\nperiod = 1", '8: analysis.all: start = "search" looks for all periods'),
    ("x = [-1, 0.2]", "z = [-1, 0.2]", "12: analysis.all.random.z: unknown state; known here: x, v"),
    ("sweep.omega = { start = 2.6", "sweep.omeg = { start = 2.6", "15: analysis.branch.sweep.omeg: unknown parameter"),
    ("stop = 2.4 }", "stop = 2.6 }", "15: analysis.branch.sweep.omega: start and stop are equal"),
    (
        "stop = 2.4 }",
        "stop = 2.55 }",
        "15: analysis.branch.sweep.omega: the branch starts at the value of the system, omega",
    ),
    ("stop = 2.4 }", "stop = 2.4, num = 9 }", "15: analysis.branch.sweep.omega.num: unknown key; leave it out"),
    ("{ start = 2.6, stop = 2.4 }", "[2.6, 2.4]", "15: analysis.branch.sweep.omega: expected a table"),
    *(
        ("{ start = 2.6, stop = 2.4 }", value, "15: analysis.branch.sweep.omega: expected a table, received")
        for value in ("3", "[]", "[1]", "true", "nan", "'x'", "1979-05-27")
    ),
    ("doublings = 3", "doublings = 40", "16: analysis.branch.doublings: must be at most 12, received 40"),
    ("step = 1e-3", "step = 0.0", "17: analysis.branch.step: must be greater than 0, received 0.0"),
    ("step = 1e-3", "step = 0.25", "13: analysis.branch: step exceeds the range"),
    ("step = 1e-3", 'follow = "fold"', "13: analysis.branch: follow needs a second parameter"),
    ('follow = "grazing"', "", "18: analysis.curve: sweep names two parameters: set follow"),
    ('follow = "grazing"', 'follow = "fold"\ndoublings = 1', "18: analysis.curve: a curve in two parameters has no"),
    ('"grazing"', '"torus"', "22: analysis.curve.follow: Input should be 'fold', 'period_doubling' or 'grazing'"),
]


def test_the_keywords_reach_the_functions():
    analyses = parse_scene(SCENE).analyses
    assert analyses["orbit"].keywords() == {"period": 2, "start": "guess"}
    assert analyses["all"].keywords()["max_period"] == 4
    assert analyses["branch"].keywords() == {"sweep": {"omega": (2.6, 2.4)}, "doublings": 3, "step": 1e-3}
    assert list(analyses["curve"].keywords()["sweep"]) == ["omega", "wall"]


@pytest.mark.parametrize(("old", "new", "message"), CASES)
def test_faults(faults, old, new, message):
    found = faults(SCENE.replace(old, new, 1))
    assert len(found) == 1, found
    assert found[0].startswith(f"scene.toml:{message}")


def test_periods_are_not_counted_without_forcing():
    text = SCENE[: SCENE.index("[analysis.all]")].replace("impact-oscillator", "roessler")
    text = text.replace("parameters = { omega = 2.5, wall = 0.2 }", "")
    with pytest.raises(SceneError, match=r"6: analysis\.orbit\.period: roessler has no forcing period"):
        _ = parse_scene(text).system
    assert parse_scene(text.replace("period = 2\n", "transient = 12.5\n")).system.name == "roessler"

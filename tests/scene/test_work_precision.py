"""Scenes that ask for work-precision: every key is checked, with its line."""

import pytest

from chaosdrill.scene import parse_scene

SCENE = """\
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

CASES = [
    ('"taylor", "rk4"', '"taylor", "rk5"', "7: analysis.cost.methods[1]: unknown method 'rk5'; did you mean 'rk4'?"),
    ('"taylor", "rk4"', '"taylor", "taylor"', "7: analysis.cost.methods: contains a value twice"),
    ('"taylor", "rk4"', "", "7: analysis.cost.methods: must not be empty"),
    ('"taylor", "rk4"', "1", "7: analysis.cost.methods[0]: expected text in quotes, received 1"),
    ("[1e-4, 1e-8]", "[1e-4, 1e-18]", "8: analysis.cost.tolerances[1]: must be at least 1e-16, received 1e-18"),
    ("[1e-4, 1e-8]", "[1e-4, 1]", "8: analysis.cost.tolerances[1]: must be at most 0.01, received 1"),
    ("[1e-4, 1e-8]", "[1e-4, 1e-4]", "8: analysis.cost.tolerances: contains a value twice"),
    ("[100, 1000]", "[100]", "9: analysis.cost.steps: give tolerances too, one for each entry of steps"),
    ("[100, 1000]", "[100, 2]", "9: analysis.cost.steps[1]: must be at least 4, received 2"),
    ("repeats = 3", "repeats = 0", "10: analysis.cost.repeats: must be at least 1, received 0"),
    ("repeats = 3", "repeat = 3", "10: analysis.cost.repeat: unknown key; did you mean 'repeats'?"),
    ("repeats = 3", 'method = "rk4"', "10: analysis.cost.method: unknown key; did you mean 'methods'?"),
    ("periods = 100", "", "3: analysis.cost: give either periods (points of the section) or duration (time units)"),
]


def test_the_keywords_reach_the_function():
    analysis = parse_scene(SCENE).analyses["cost"]
    assert analysis.keywords() == {
        "periods": 100,
        "transient": 10,
        "methods": ["taylor", "rk4"],
        "tolerances": [1e-4, 1e-8],
        "steps": [100, 1000],
        "repeats": 3,
    }


@pytest.mark.parametrize(("old", "new", "message"), CASES)
def test_faults(faults, old, new, message):
    found = faults(SCENE.replace(old, new))
    assert len(found) == 1, found
    assert found[0].startswith(f"scene.toml:{message}")

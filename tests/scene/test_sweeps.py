"""Charts, basins and seeds in scenes: what reaches the function, and what is wrong is told with line and remedy."""

import numpy as np
import pytest

from chaosdrill.scene import parse_scene

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
    given = keywords(CHART + "sweep.b = { start = 0.5, stop = 0.9, num = 5 }\nexponents = 2\npatience = 4\n")
    assert list(given["sweep"]) == ["eta", "b"]
    np.testing.assert_array_equal(given["sweep"]["b"], np.linspace(0.5, 0.9, 5))
    assert {key: given[key] for key in ("transient", "periods", "exponents", "patience")} == {
        "transient": 10,
        "periods": 20,
        "exponents": 2,
        "patience": 4,
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


FAULTS = [
    (CHART, "8: analysis.a.sweep: must have at least 2 entries"),
    (CHART + "sweep.b = [1.0]\nsweep.a = [1.0]\n", "8: analysis.a.sweep: must have at most 2 entries"),
    (DIAGRAM + "sweep.b = [1.0]\n", "8: analysis.a.sweep: must have at most 1 entries"),
    (CHART + "sweep.bb = [1.0]\n", "9: analysis.a.sweep.bb: unknown parameter; did you mean 'b'?"),
    (CHART + 'sweep.b = [1.0]\nfollow = "both"\n', "10: analysis.a.follow: unknown key"),
    (BASINS + "grid.y = [0.0]\ngrid.ww = [0.0]\n", "9: analysis.a.grid.ww: unknown state; did you mean 'w'?"),
    (BASINS + "grid.y = [0.0]\n", "8: analysis.a.grid: must have at least 2 entries"),
    (BASINS + "grid.y = [0.0, 0.0]\ngrid.u = [0.0]\n", "8: analysis.a.grid.y: contains a value twice"),
    (BASINS, "4: analysis.a.grid: missing"),
    (BASINS + "grid.y = [0.0]\ngrid.u = [0.0]\nseeds = [{}]\n", "10: analysis.a.seeds: unknown key"),
    (
        DIAGRAM + 'follow = "up"\n',
        "9: analysis.a.follow: Input should be 'forward', 'backward' or 'both', received 'up'",
    ),
    (DIAGRAM + "random = { seed = 1, y = [0, 1] }\n", "9: analysis.a.random.count: missing"),
    (DIAGRAM + "random = { count = 2, y = [0, 1] }\n", "9: analysis.a.random.seed: missing"),
    (DIAGRAM + "random = { count = 0, seed = 1, y = [0, 1] }\n", "9: analysis.a.random.count: must be at least 1"),
    (DIAGRAM + "random = { count = 2, seed = 1 }\n", "9: analysis.a.random: names no state; give the range"),
    (DIAGRAM + "random = { count = 2, seed = 1, y = [1, 0] }\n", "9: analysis.a.random: the range of y must increase"),
    (DIAGRAM + "random = { count = 2, seed = 1, y = 3 }\n", "9: analysis.a.random.y: expected a list, received 3"),
    (DIAGRAM + "random = { count = 2, seed = 1, y = [0, 1, 2] }\n", "9: analysis.a.random.y: must have at most 2"),
    (DIAGRAM + "random = { count = 2, seed = 1, z = [0, 1] }\n", "9: analysis.a.random.z: unknown state; known here: "),
    (DIAGRAM + "patience = -1\n", "9: analysis.a.patience: must be at least 0, received -1"),
]


@pytest.mark.parametrize(("text", "expected"), FAULTS, ids=[expected for _, expected in FAULTS])
def test_faults(faults, text, expected):
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

"""The archive of a scene in SI units holds its quantities, what became of them, and results in SI units."""

import json
import math

import numpy as np
import pytest

from chaosdrill.archive import open as open_archive
from chaosdrill.scene import check, parse_scene
from chaosdrill.workflow import run

ANALYSES = """
[analysis.motion]
kind = "trajectory"
periods = 3
samples = 20
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 20
periods = 64
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.b = [0.7, 0.72]
transient = 50
periods = 8
[analysis.chart]
kind = "parameter-chart"
sweep.b = [0.7, 0.72]
sweep.eta = [0.79, 0.8]
transient = 50
periods = 8
[analysis.starts]
kind = "basins"
grid.y = [0.0, 0.1]
grid.u = [0.0, 0.1]
transient = 50
periods = 8
"""
# equation (8) by hand, from the quantities of the scene: 250 kg, 4 MN/m, static friction 8 kN
SECOND, METRE, NEWTON = math.sqrt(250 / 4e6), 8e3 / 4e6, 8e3


@pytest.fixture(scope="module")
def tree(tmp_path_factory, in_si):
    folder = tmp_path_factory.mktemp("si")
    (folder / "scene.toml").write_text(in_si + ANALYSES)
    run(folder / "scene.toml", folder / "out.nc")
    return open_archive(folder / "out.nc")


@pytest.mark.parametrize(
    ("name", "value", "units"),
    [
        ("m1", 250.0, "kg"),
        ("m2", 125.0, "kg"),
        ("K", 4e6, "N m-1"),
        ("C", 3800.0, "N s m-1"),
        ("R", 2e-3, "m"),
        ("omega", 100.0, "rad s-1"),
        ("F_N", 10e3, "N"),
        ("mu_d", 0.48, "1"),
        ("lambda", 2.4, "s m-1"),
        ("k_c", 4.8e12, "N"),
        ("unit_of_time", SECOND, "s"),
        ("unit_of_length", METRE, "m"),
        ("unit_of_force", NEWTON, "N"),
    ],
)
def test_quantities_as_they_were_given(tree, name, value, units):
    variable = tree[f"si_{name}"]
    assert float(variable) == pytest.approx(value, rel=1e-14)
    assert variable.attrs["units"] == units
    assert variable.attrs["long_name"]


@pytest.mark.parametrize(
    ("name", "value"),
    [("eps", 2.0), ("a", 0.25), ("b", 0.7), ("r", 1.0), ("mu", 0.6), ("eta", 100 * SECOND), ("k", 4.8e12 / 4e6)],
)
def test_what_became_of_them(tree, name, value):
    variable = tree[f"dimensionless_{name}"]
    assert float(variable) == pytest.approx(value, rel=1e-12)
    assert variable.attrs["units"] == "1"
    assert variable.attrs["long_name"]
    # what the runs had
    assert float(variable) == json.loads(tree["motion"].attrs["parameters"])[name]


@pytest.mark.parametrize("group", ["spectrum", "diagram", "chart"])
@pytest.mark.parametrize("name", ["progression_rate", "progression_error"])
def test_progression(tree, group, name):
    if name not in tree[group]:
        assert f"{name}_si" not in tree[group]
        return
    found = tree[group][f"{name}_si"]
    assert found.attrs["units"] == "m h-1"
    np.testing.assert_allclose(found, tree[group][name] * METRE / SECOND * 3600, rtol=1e-12)


def test_progression_of_an_attractor(tree):
    found = tree["starts/attractor_rate_si"]
    np.testing.assert_allclose(found, tree["starts/attractor_rate"] * METRE / SECOND * 3600, rtol=1e-12)


def test_penetration_and_times_of_a_trajectory(tree):
    motion = tree["motion"]
    np.testing.assert_allclose(motion["time_si"], motion["time"] * SECOND, rtol=1e-12)
    np.testing.assert_allclose(motion["event_time_si"], motion["event_time"] * SECOND, rtol=1e-12)
    np.testing.assert_allclose(motion["penetration_si"], motion["penetration"] * METRE, rtol=1e-12)
    assert (motion["time_si"].attrs["units"], motion["penetration_si"].attrs["units"]) == ("s", "m")


def test_force_along_a_trajectory(tree):
    # in SI units all the way: stretch and speeds in m and m/s, spring and damper of the scene
    state = tree["motion/states"].values * [METRE, METRE / SECOND, METRE / SECOND]
    expected = 4e6 * state[:, 0] + 3800 * (state[:, 1] - state[:, 2])
    np.testing.assert_allclose(tree["motion/force_si"], expected, rtol=1e-10, atol=1e-8)
    assert tree["motion/force_si"].attrs["units"] == "N"


def test_the_period_of_the_load(tree):
    assert float(tree["spectrum/forcing_period_si"]) == pytest.approx(2 * math.pi / 100, rel=1e-12)


def test_a_fixed_rock(in_si):
    text = in_si.replace('rock = "moving"', 'rock = "fixed"').replace('"stribeck"', '"none"')
    for name in ("m2", "mu_d", "gamma"):
        text = "".join(line for line in text.splitlines(keepends=True) if not line.startswith(f"{name} "))
    motion = run(parse_scene(text + ANALYSES[: ANALYSES.index("[analysis.spectrum]")]))["motion"]
    state = motion["states"].values * [METRE, METRE / SECOND]
    np.testing.assert_allclose(motion["force_si"], 4e6 * state[:, 0] + 3800 * state[:, 1], rtol=1e-10, atol=1e-8)


def test_a_contact_of_another_exponent_keeps_a_unit(in_si):
    scene = parse_scene(in_si.replace("n = 1", "n = 1.5").replace("4.8e12 N/m", "4.8e12 N/m^1.5"))
    assert check(scene)["si"]["k_c"] == {
        "label": "force of the contact at a depth of 1 m",
        "value": 4.8e12,
        "units": "N",
    }


def test_a_dimensionless_scene_has_none(sound):
    scene = parse_scene(sound)
    assert check(scene)["si"] == {}
    text = sound[: sound.index("[analysis.spectrum]")] + '[analysis.motion]\nkind = "trajectory"\nperiods = 1\n'
    tree = run(parse_scene(text))
    assert not tree.to_dataset().data_vars
    assert not [name for name in tree["motion"].data_vars if name.endswith("_si")]

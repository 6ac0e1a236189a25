"""Noise in a scene: the system of Python, told in check, info and report; faults at their lines."""

import json

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.codegen import record
from chaosdrill.model import system as model

SCENE = """\
title = "noise"
[system]
model = "impact-oscillator"
[system.noise]
seed = 3
[system.noise.e]
distribution = "uniform"
low = 0.7
high = 0.9
at = "impact"
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.e_low = { start = 0.5, stop = 0.9, num = 9 }
periods = 40
transient = 20
max_period = 16
"""


def faults(text: str) -> list[str]:
    with pytest.raises(cd.SceneError) as fault:
        assert cd.parse_scene(text, "s.toml").system
    return str(fault.value).splitlines()


def test_a_scene_has_the_noise_of_python() -> None:
    plain = cd.build("impact-oscillator")
    expected = plain.with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=3)
    found = cd.parse_scene(SCENE).system
    assert found.noise == expected.noise
    assert found.parameters == expected.parameters
    assert found.transitions == expected.transitions
    clocked = SCENE.replace('at = "impact"', 'at = ["period", "impact"]').replace("seed = 3\n", "")
    expected = plain.with_noise({"e": cd.Uniform(0.7, 0.9)}, at=["period", "impact"])
    assert cd.parse_scene(clocked).system.transitions == expected.transitions


def test_a_map_draws_at_every_iterate() -> None:
    text = '[system.map]\nstates = ["x"]\nimages = { x = "a*x*(1 - x)" }\n[system.parameters]\na = 3.9\n'
    text += '[system.noise.a]\ndistribution = "choice"\nvalues = [3.8, 3.9]\nweights = [1, 3]\n'
    found = cd.parse_scene(text).system
    logistic = cd.Map("x", {"a": 3.9}, {"x": "a*x*(1 - x)"})
    assert found.parameters == logistic.with_noise({"a": cd.Choice([3.8, 3.9], [1, 3])}).parameters
    assert found.noise["a"]["at"] == ["iterate"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("seed = 3", "seed = 3.5", "s.toml:5: system.noise.seed: must be a whole number"),
        ("[system.noise.e]", "[system.noise.ee]", "s.toml:6: system.noise.ee: there is no parameter 'ee' to draw"),
        (
            '"uniform"',
            '"unifrom"',
            "s.toml:7: system.noise.e.distribution: unknown distribution 'unifrom'; did you mean",
        ),
        ("low = 0.7", "lo = 0.7", "s.toml:8: system.noise.e.lo: unknown key; did you mean 'low'?"),
        ("low = 0.7", 'low = "x"', "s.toml:6: system.noise.e: uniform: low is 'x'; it must be a finite number"),
        ("low = 0.7\n", "", "s.toml:6: system.noise.e.low: missing; uniform has low, high"),
        ("low = 0.7", "low = 0.95", "s.toml:6: system.noise.e: uniform: low is 0.95 and high 0.9"),
        ("high = 0.9", "high = 1.9", "s.toml:4: system.noise: impact-oscillator: 'e' cannot have uniform values: "),
        ('at = "impact"', 'at = "hit"', "s.toml:4: system.noise: impact-oscillator: at is 'hit' for 'e'; it has"),
        ('at = "impact"', "", "s.toml:4: system.noise: impact-oscillator: at is None for 'e'; give the name"),
        ("start = 0.5, stop", "start = -0.5, stop", "s.toml:13: analysis.diagram.sweep.e_low"),
        ("sweep.e_low", "sweep.e", "s.toml:13: analysis.diagram.sweep.e: unknown parameter"),
        (
            '"bifurcation-diagram"\nsweep.e_low = { start = 0.5, stop = 0.9, num = 9 }',
            '"regularity"',
            "s.toml:11: analysis.diagram: impact-oscillator draws 'e' anew, which this analysis does not",
        ),
    ],
)
def test_every_fault_stands_at_its_line(old: str, new: str, told: str) -> None:
    assert old in SCENE
    text = SCENE.replace(old, new)
    if "regularity" in new:
        text = text.replace("transient = 20\nmax_period = 16\n", "")
    found = faults(text)
    assert any(line.startswith(told) for line in found), found


def test_noise_is_told_wherever_a_system_is(tmp_path, capsys) -> None:
    scene = tmp_path / "s.toml"
    scene.write_text(SCENE)
    words = {"e": "uniform, drawn anew at impact"}
    told = cd.check(scene)
    assert told["noise"] == words
    assert told["parameters"]["e_low"]["given"]
    archive = cd.run(scene, tmp_path / "s.nc")
    assert cd.info(tmp_path / "s.nc")["groups"]["/diagram"]["noise"] == words
    assert json.loads(archive["diagram"].attrs["definition"])["noise"]["e"]["at"] == ["impact"]
    cd.report(tmp_path / "s.nc", tmp_path / "s.html")
    assert words["e"] in (tmp_path / "s.html").read_text()
    assert cd.verify(tmp_path / "s.nc").equal


def test_a_saved_scene_is_the_same_noise(tmp_path) -> None:
    system = cd.build("impact-oscillator").with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=5)
    run = {"kind": "lyapunov-spectrum", "periods": 30}
    found = cd.load_scene(cd.save_scene(tmp_path / "s.toml", system, {"spectrum": run})).system
    assert found.noise == system.noise
    one, other = (cd.lyapunov_spectrum(one, periods=30)["lyapunov_history"] for one in (system, found))
    assert np.array_equal(one, other)


def test_a_scene_that_another_process_has_run_is_the_same_noise(tmp_path, monkeypatch) -> None:
    system = cd.build("impact-oscillator").with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=5)
    path = cd.save_scene(tmp_path / "s.toml", system, {"spectrum": {"kind": "lyapunov-spectrum", "periods": 30}})
    monkeypatch.setattr(record, "cache_folder", lambda: tmp_path)
    for known in (False, True):
        monkeypatch.setattr(model, "_listed", type(model._listed)())
        scene = cd.load_scene(path)
        assert ("whole" in vars(scene.system)) == known
        assert scene.system.noise == system.noise
        assert cd.run(scene, tmp_path / f"{known}.nc")["spectrum"].sizes["exponent"] == 2
        with pytest.raises(cd.SettingsError, match="draws 'e' anew"):
            cd.periodic_orbit(scene.system)


def test_an_altered_definition_is_refused(tmp_path) -> None:
    system = cd.build("impact-oscillator").with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact")
    found = cd.trajectory(system, periods=2)
    definition = json.loads(found.attrs["definition"])
    for noise, told in (
        ({"x": definition["noise"]["e"]}, "the last states must be x_draw, x_count"),
        ({"e": {"distribution": "uniform", "at": "impact"}}, "expected names of events"),
        ({"e": {"distribution": 3, "at": ["impact"]}}, "expected text"),
        ({"e": {"at": ["impact"], "every": 2}}, "unknown key"),
    ):
        altered = found.assign_attrs(definition=json.dumps({**definition, "noise": noise}))
        with pytest.raises(cd.ArchiveError, match=told):
            cd.system(altered)

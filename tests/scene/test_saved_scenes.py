"""A scene written from Python defines the same system and asks for the same analyses."""

import os
import tomllib

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill import systems

X, V, T = sympy.symbols("x v t", real=True)
FIELDS = ("name", "states", "time", "parameters", "modes", "transitions", "period", "initial", "bounds", "labels")
MOTION = {"motion": {"kind": "trajectory", "periods": 2, "samples": 4}}


def odd():
    """A system whose names and numbers need care."""
    rate = sympy.Symbol("the rate", real=True)
    return cd.HybridSystem(
        name='quotes " and\nlines',
        states=(X, V),
        time=T,
        parameters={"the rate": 1 / 3, "lambda": 1e-300},
        modes={"in the air": {X: V, V: -rate * X + sympy.Symbol("lambda", real=True)}, "down": {X: 0, V: 0}},
        transitions=[
            cd.Transition("hit", ("in the air", "down"), "down", X - 1, 1, reset={V: -V}, condition=V > 0, kind="z"),
            cd.Transition("not hit", "in the air", "in the air", X - 1, 1, priority=3),
        ],
        period=2 * sympy.pi / rate,
        initial={"mode": "in the air", "x": 0.1 + 0.2},
        bounds={"x": None, "v": (-5, sympy.oo)},
        quadratures={"work done": V**2},
        labels={"x": "Weg ]"},
    )


@pytest.mark.parametrize("system", [odd(), cd.drill(eta=0.7), systems.build("lorenz")], ids=lambda s: s.name[:6])
def test_it_is_the_same_system(system, tmp_path):
    length = {"periods": 2} if system.period is not None else {"duration": 2.0}
    path = cd.save_scene(tmp_path / "own.toml", system, {"motion": {"kind": "trajectory", **length}})
    again = cd.load_scene(path).system
    for name in (
        "name",
        "states",
        "time",
        "parameters",
        "modes",
        "transitions",
        "period",
        "initial",
        "bounds",
        "labels",
    ):
        assert getattr(again, name) == getattr(system, name), name


def test_its_results_are_the_same_to_the_last_bit(tmp_path):
    system = systems.build("impact-oscillator").with_parameters(e=0.7)
    analyses = {"diagram": {"kind": "bifurcation-diagram", "sweep": {"omega": np.linspace(2.4, 2.5, 2)}}}
    analyses["diagram"] |= {"transient": 5, "periods": 8}
    path = cd.save_scene(tmp_path / "own.toml", system, analyses, title="Mine", numerics={"tolerance": 1e-10})
    tree = cd.run(path, tmp_path / "own.nc")
    keywords = {name: value for name, value in analyses["diagram"].items() if name != "kind"}
    expected = cd.bifurcation_diagram(system, **keywords, tolerance=1e-10)
    assert tree.attrs["title"] == "Mine"
    assert np.isfinite(expected["section"].values).any()
    assert np.array_equal(tree["diagram/section"].values, expected["section"].values, equal_nan=True)


def test_it_is_laid_out_as_people_write_it(tmp_path):
    text = cd.save_scene(tmp_path / "own.toml", systems.build("impact-oscillator"), MOTION).read_text()
    headers = [line for line in text.splitlines() if line.startswith("[")]
    assert headers == [
        "[system.definition]",
        "[system.definition.modes.free]",
        "[[system.definition.transitions]]",
        "[system.definition.labels]",
        "[system.parameters]",
        "[system.initial]",
        "[analysis.motion]",
    ]
    assert tomllib.loads(text)["analysis"] == MOTION


def test_faults_are_told_and_the_earlier_file_stays(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("earlier")
    with pytest.raises(cd.SceneError, match=r"analysis.motion.kind: unknown kind 'trajektory'; did you mean"):
        cd.save_scene(path, odd(), {"motion": {"kind": "trajektory"}})
    mark = cd.Transition("mark", "m", "m", X, 1, condition=sympy.gamma(X) > 1)
    with pytest.raises(cd.ModelError, match="unknown function 'gamma'"):
        cd.save_scene(path, cd.HybridSystem(states=(X,), modes={"m": {X: 1}}, transitions=[mark]), {})
    with pytest.raises(cd.SettingsError, match=r"analysis.motion.periods: expected a number"):
        cd.save_scene(path, odd(), {"motion": {"kind": "trajectory", "periods": object()}})
    assert path.read_text() == "earlier"
    assert [p.name for p in tmp_path.iterdir()] == ["own.toml"]


def test_a_link_is_followed_and_what_is_no_file_is_refused(tmp_path):
    system, analyses = cd.build("impact-oscillator"), {"motion": {"kind": "trajectory", "periods": 1}}
    link, pipe = tmp_path / "link.toml", tmp_path / "pipe"
    link.symlink_to(tmp_path / "scene.toml")
    cd.save_scene(link, system, analyses)
    assert link.is_symlink()
    assert cd.load_scene(tmp_path / "scene.toml").title == "impact-oscillator"
    os.mkfifo(pipe)
    with pytest.raises(cd.SceneError, match="not an ordinary file"):
        cd.save_scene(pipe, system, analyses)
    assert pipe.is_fifo()


@pytest.mark.parametrize("place", ["none/a.nc", ".", "a\0b.nc", "pipe.nc"])
def test_it_is_refused_where_an_archive_is_and_in_the_same_words(place, tmp_path):
    system, target = cd.build("lorenz"), tmp_path / place
    os.mkfifo(tmp_path / "pipe.nc")
    with pytest.raises(cd.ArchiveError) as archive:
        cd.save(cd.trajectory(system, duration=1.0, samples=1), target)
    with pytest.raises(cd.SceneError) as scene:
        cd.save_scene(target, system, {"motion": {"kind": "trajectory", "duration": 1.0}})
    assert str(scene.value).replace("result.toml", "result.nc") == str(archive.value)

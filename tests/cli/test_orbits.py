"""Orbits and branches from a scene to an archive, whose words ``run`` prints, and back again."""

import json

import pytest

SCENE = """\
[system]
model = "impact-oscillator"
parameters = { wall = 0.0, zeta = 0.0, omega = 2.6 }
[analysis.orbit]
kind = "periodic-orbit"
period = 2
[analysis.all]
kind = "periodic-orbit"
start = "search"
max_period = 1
[analysis.branch]
kind = "continuation"
sweep.omega = { start = 2.62, stop = 2.68 }
doublings = 1
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "orbits.toml"
    path.write_text(SCENE.replace("2.62", "2.58"))
    return path


@pytest.fixture
def archive(call, scene, tmp_path):
    path = tmp_path / "orbits.nc"
    return path, call("run", scene, "-o", path)


def test_what_happens_is_printed(archive):
    _, answer = archive
    assert answer.code == 0, answer.err
    lines = answer.out.splitlines()
    assert "orbit: period 1" in lines
    assert "orbit: stable yes" in lines
    assert any(line.startswith("all: orbit 1: period 1, stable, (") for line in lines)
    assert any(line.startswith("branch: branch 0: period 1, ") for line in lines)
    assert any(line.startswith("branch:   period doubling at omega = 2.65334772786 ") for line in lines)
    assert any(line.startswith("branch: branch 1: period 2, ") for line in lines)
    assert any(line.startswith("branch:   end: the parameter reached its limit") for line in lines)
    assert "orbit: its period is 1, not 2" in answer.err.splitlines()


def test_the_archive_is_verified(call, archive):
    answer = call("verify", archive[0])
    assert answer.code == 0
    assert answer.out.strip().endswith("equal, bit for bit")


def test_special_points_are_counted(call, archive):
    answer = call("info", archive[0], "--json")
    described = json.loads(answer.out)["groups"]
    assert described["/branch"]["special_points"] == {"period_doubling": 1}
    assert described["/orbit"]["outcomes"] == {"periodic": 1}


def test_the_default_tolerance_is_that_of_the_function(archive, call):
    described = json.loads(call("info", archive[0], "--json").out)["groups"]
    assert described["/branch"]["tolerance"] == 1e-13


def test_where_the_branch_starts_is_checked(call, tmp_path):
    path = tmp_path / "outside.toml"
    path.write_text(SCENE)
    answer = call("check", path)
    assert answer.code == 2
    assert "outside.toml:13: analysis.branch.sweep.omega: the branch starts at the value of the system" in answer.err

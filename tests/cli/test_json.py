"""With ``--json`` standard output is one JSON document, whatever happens; codes and messages are those without it."""

import json

import netCDF4
import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.cli.output import strict
from chaosdrill.workflow import Difference, Verification


def document(text):
    """The one document of a text, by a reader that knows neither NaN nor Infinity."""

    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture
def archive(scene):
    """An archive of the short scene."""
    from chaosdrill.workflow import run

    output = scene.with_name("out.nc")
    run(scene, output)
    return output


def test_run(call, scene, tmp_path):
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--json")
    assert answer.code == 0
    found = document(answer.out)
    tree = open_archive(tmp_path / "out.nc")
    assert found["archive"] == str(tmp_path / "out.nc")
    assert (found["title"], found["scene_sha256"]) == (tree.attrs["title"], tree.attrs["scene_sha256"])
    motion = found["groups"]["motion"]
    assert (motion["kind"], motion["outcomes"], motion["advice"]) == ("trajectory", {"ok": 1}, [])
    assert motion["values"]["forcing_period"] == float(tree["motion/forcing_period"])
    assert "motion: 100 %" in answer.err


def test_run_with_an_outcome_that_needs_advice(call, scene, tmp_path):
    scene.write_text(scene.read_text().replace("eta = 0.8", "eta = 0.8\nb = 1e9"))
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--json")
    assert answer.code == 0
    motion = document(answer.out)["groups"]["motion"]
    assert list(motion["outcomes"]) == ["escaped"]
    assert "runs away" in motion["advice"][0]


def test_info(call, archive):
    assert document(call("info", archive, "--json").out)["groups"]["/motion"]["kind"] == "trajectory"


def test_plot(call, archive):
    found = document(call("plot", archive, "--json").out)
    assert found["archive"] == str(archive)
    assert [path.endswith(".png") for path in found["pictures"]] == [True] * len(found["pictures"])
    assert len(found["pictures"]) > 0


def test_verify(call, archive):
    assert document(call("verify", archive, "--json").out)["equal"] is True


def test_verify_of_an_altered_archive(call, archive):
    with netCDF4.Dataset(archive, "a") as file:
        file["motion/state"][1, 0] = np.nan
    answer = call("verify", archive, "--json")
    assert answer.code == 1
    found = document(answer.out)
    assert found["equal"] is False
    assert [(item["variable"], item["max_abs"]) for item in found["differences"]] == [("state", "inf")]


@pytest.mark.parametrize(
    ("arguments", "code", "kind", "message"),
    [
        (["run", "scene.toml"], 2, "UsageError", "Missing option '-o' / '--output'."),
        (["run", "none.toml", "-o", "a.nc"], 2, "SceneError", "none.toml: cannot read the scene: No such file"),
        (["run", "scene.toml", "-o", "a/b.nc"], 1, "ArchiveError", "a/b.nc: the folder a does not exist"),
        (["run", "scene.toml", "-o", "-"], 2, "SettingsError", "--output is '-', but an archive is a file"),
        (["check", "none.toml"], 2, "SceneError", "none.toml: cannot read the scene"),
        (["plot", "none.nc"], 1, "ArchiveError", "none.nc: cannot read the archive"),
        (["plot", "none.nc", "-o", "-"], 2, "SettingsError", "output is '-', but pictures are files"),
        (["report", "none.nc"], 1, "ArchiveError", "none.nc: cannot read the archive"),
        (["report", "none.nc", "-o", "-"], 2, "SettingsError", "output is '-', but a report is a file"),
        (["info", "scene.toml"], 1, "ArchiveError", "scene.toml: not a NetCDF-4 file"),
        (["verify", "none.nc"], 1, "ArchiveError", "none.nc: cannot read the archive"),
        (["list", "colours"], 2, "UsageError", "'colours' is not one of"),
        (["rum"], 2, "UsageError", "No such command 'rum'"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_fault(call, scene, monkeypatch, arguments, code, kind, message):
    monkeypatch.chdir(scene.parent)
    answer = call(*arguments, "--json")
    error = document(answer.out)["error"]
    assert (answer.code, error["exit_code"], error["kind"]) == (code, code, kind)
    assert message in error["message"]
    # the same for people
    assert message in answer.err
    assert call(*arguments).code == code


def test_interrupt(call, scene, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", interrupted)
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--json")
    assert answer.code == 130
    assert document(answer.out)["error"] == {"exit_code": 130, "kind": "KeyboardInterrupt", "message": "interrupted"}


def test_numbers_that_json_does_not_know():
    given = {"a": [1.5, np.nan, -np.inf], "b": np.array([np.inf, 2.0]), 3: np.int8(4), "c": (np.float64("nan"), "nan")}
    assert strict(given) == {"a": [1.5, None, "-inf"], "b": ["inf", 2.0], "3": 4, "c": [None, "nan"]}


def test_an_infinite_exponent(call, tmp_path, scene, monkeypatch):
    spectrum = xr.Dataset({"lyapunov_exponent": ("exponent", [0.1, -np.inf])}, attrs={"kind": "lyapunov-spectrum"})
    root = xr.Dataset(attrs={"title": "", "scene_sha256": "", "wall_time_s": 0.0})
    tree = xr.DataTree.from_dict({"/": root, "spectrum": spectrum})
    monkeypatch.setattr("chaosdrill.workflow.run", lambda *_, **__: tree)
    answer = call("run", scene, "-o", tmp_path / "out.nc", "--json")
    assert document(answer.out)["groups"]["spectrum"]["values"] == {"lyapunov_exponent": [0.1, "-inf"]}


def test_a_difference_without_a_number(call, archive, monkeypatch):
    result = Verification(archive, (Difference("/motion", "time", "is missing"),), ())
    monkeypatch.setattr("chaosdrill.workflow.verify", lambda *_, **__: result)
    answer = call("verify", archive, "--json")
    assert document(answer.out)["differences"][0]["max_abs"] is None


def test_info_of_a_strange_archive(call, tmp_path):
    path = save(xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory", "tolerance": np.nan}), tmp_path / "a.nc")
    assert document(call("info", path, "--json").out)["groups"]["/"]["tolerance"] is None

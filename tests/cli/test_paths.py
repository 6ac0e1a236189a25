"""Whatever name a file is given: one clear error and, with --json, one document; never a traceback."""

import json
from pathlib import Path

import pytest
import xarray as xr

import chaosdrill as cd

LONG = "n" * 300
NO_NAME = ["", ".", "..", "/"]


@pytest.fixture(scope="module")
def motion():
    """A short trajectory."""
    return cd.trajectory(cd.build("impact-oscillator"), periods=2, samples=10)


@pytest.fixture
def folder(tmp_path, monkeypatch, scene, motion):
    """The working folder, with an archive and a scene in it."""
    monkeypatch.chdir(tmp_path)
    cd.save(motion, "own.nc")
    return tmp_path


def told(call, *arguments, code=1):
    """The one error of a command, which is also what it says without --json."""
    answer = call(*arguments, "--json")
    error = json.loads(answer.out)["error"]
    assert (answer.code, error["exit_code"]) == (code, code)
    assert answer.err.strip().endswith(error["message"])
    assert "Traceback" not in answer.err
    return error


@pytest.mark.parametrize("name", [*NO_NAME, LONG, f"{LONG}.nc", f"{LONG}/a.nc"])
@pytest.mark.parametrize("command", ["info", "cite", "verify", "plot", "report"])
def test_archives_that_cannot_be_read(call, folder, command, name):
    error = told(call, command, name)
    assert error["kind"] == "ArchiveError"
    assert "cannot read the archive" in error["message"]


@pytest.mark.parametrize(
    ("arguments", "ending"),
    [(["run", "scene.toml"], ".nc"), (["plot", "own.nc"], ".png"), (["report", "own.nc"], ".html")],
    ids=["run", "plot", "report"],
)
@pytest.mark.parametrize("place", [LONG, f"{LONG}/a", "none/a", "file/a"])
def test_files_that_cannot_be_written(call, folder, arguments, ending, place):
    Path("file").touch()
    before = sorted(folder.iterdir())
    error = told(call, *arguments, "-o", f"{place}{ending}")
    assert error["kind"] == "ArchiveError"
    assert any(remedy in error["message"] for remedy in ("name another file", "create it first"))
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("name", NO_NAME)
@pytest.mark.parametrize(
    ("command", "given", "code"), [("run", "scene.toml", 1), ("plot", "own.nc", 2), ("report", "own.nc", 2)]
)
def test_names_of_no_file(call, folder, command, given, code, name):
    assert told(call, command, given, "-o", name, code=code)["kind"] in ("ArchiveError", "SettingsError")


@pytest.mark.parametrize("command", ["plot", "report"])
def test_a_folder_that_must_not_be_written_into(call, folder, monkeypatch, command):
    def refused(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "touch", refused)
    message = told(call, command, "own.nc")["message"]
    assert "Permission denied; name a file in another folder" in message


@pytest.mark.parametrize("command", ["plot", "report"])
def test_a_disk_that_is_full_leaves_what_was_there(call, folder, monkeypatch, command):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    Path("own.html").write_text("earlier")
    Path("own-time-history.png").write_text("earlier")
    monkeypatch.setattr("chaosdrill.files.os.replace", full)
    before = sorted(folder.iterdir())
    assert "No space left on device; an earlier one is as it was" in told(call, command, "own.nc")["message"]
    assert sorted(folder.iterdir()) == before
    assert Path("own.html").read_text() == Path("own-time-history.png").read_text() == "earlier"


@pytest.mark.parametrize("name", [*NO_NAME, f"{LONG}.nc", "a\0b.nc"])
def test_python_functions_raise_errors_of_this_package(folder, name):
    tree = cd.open("own.nc")
    for function in (cd.open, cd.info, cd.cite, cd.verify, cd.plot_archive, cd.report):
        with pytest.raises(cd.ArchiveError, match="cannot read the archive"):
            function(name)
    with pytest.raises(cd.ArchiveError):
        cd.save(tree, name)
    with pytest.raises(cd.SceneError):
        cd.save_scene(name, cd.build("impact-oscillator"), {"motion": {"kind": "trajectory", "periods": 1}})
    with pytest.raises(cd.ChaosdrillError):
        cd.plot_archive("own.nc", name.replace(".nc", ".png"))
    with pytest.raises(cd.ChaosdrillError):
        cd.report("own.nc", name.replace(".nc", ".html"))


def test_any_other_fault_of_a_file_is_told_too(call, folder, monkeypatch):
    def lost(*_, **__):
        raise OSError(5, "Input/output error", "own.nc")

    monkeypatch.setattr("chaosdrill.workflow.describe.altered", lost)
    assert told(call, "info", "own.nc") == {"exit_code": 1, "kind": "OSError", "message": "own.nc: Input/output error"}


def test_groups_are_named_in_their_own_letters(call, tmp_path, motion):
    path = cd.save(xr.DataTree.from_dict({"сверло": motion}), tmp_path / "a.nc")
    answer = call("info", path, "--json")
    assert "/сверло" in answer.out
    assert list(json.loads(answer.out)["groups"]) == ["/сверло"]


def test_letters_that_the_output_does_not_have_are_written_as_json_knows_them(monkeypatch):
    import io

    from chaosdrill.cli.output import emit

    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    emit({"group": "сверло", "path": "\udcff.nc"})
    stream.flush()
    assert json.loads(stream.buffer.getvalue()) == {"group": "сверло", "path": "\udcff.nc"}


def test_what_has_changed_is_told_in_its_own_letters():
    from chaosdrill.sweep.fingerprint import changes

    assert changes({"name": "сверло"}, {"name": "бур"}) == ['name: "сверло" before, "бур" now']

"""Files may have any name that the system allows, in any locale."""

import json
import os
import subprocess
import sys

import pytest

import chaosdrill as cd

SCENE = '[system]\nmodel = "impact-oscillator"\n[analysis.motion]\nkind = "trajectory"\nperiods = 2\n'
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
UTF8 = {"LC_ALL": "C.UTF-8"}
NAME = "a\udcff"
"""As Python has the bytes ``a\\xff``."""

CASES = [(UTF8, b"a\xff", r"a\xff"), (ASCII, "ö".encode(), "ö"), (ASCII, b"a\xff", r"a\xff")]


@pytest.fixture
def motion():
    """A short trajectory."""
    return cd.trajectory(cd.build("impact-oscillator"), periods=2, samples=10)


@pytest.mark.parametrize(("locale", "name", "text"), CASES)
def test_every_command(tmp_path, locale, name, text):
    folder = os.path.join(os.fsencode(tmp_path), name)
    os.mkdir(folder)

    def call(*arguments):
        command = [sys.executable, "-m", "chaosdrill", *arguments, "--json"]
        done = subprocess.run(command, cwd=folder, capture_output=True, env=os.environ | locale, check=False)
        assert (done.returncode, b"Traceback" in done.stderr) == (0, False), done.stderr[-2000:]
        return json.loads(done.stdout)

    scene, archive = name + b".toml", name + b".nc"
    with open(os.path.join(folder, scene), "w") as file:
        file.write(SCENE)
    set_title = ["--set", f"title={text}"]
    assert call("check", scene, *set_title)["title"] == text
    # the folder of finished parts, the archive, and a name of the whole path
    call("run", os.path.join(folder, scene), "-o", os.path.join(folder, archive))
    assert call("info", archive)["title"] == text
    assert f"run {text}.toml -o " in call("info", archive)["history"].replace("'", "")
    call("cite", archive)
    assert call("verify", archive)["equal"]
    assert len(call("plot", archive, "-o", name + b".svg")["pictures"]) == 2
    call("report", archive)
    with open(os.path.join(folder, name + b".html"), encoding="utf-8") as page:
        assert f"{text}.nc" in page.read()


def test_an_archive_without_its_seal_is_tried_under_its_name(tmp_path, motion):
    from chaosdrill.archive.seal import LENGTH

    path = cd.save(motion, tmp_path / f"{NAME}.nc")
    os.truncate(path, path.stat().st_size - LENGTH)
    assert cd.open(path).attrs["kind"] == "trajectory"


def test_what_was_finished_is_found_again(tmp_path, monkeypatch):
    (tmp_path / "scene.toml").write_text(SCENE)
    output = tmp_path / f"{NAME}.nc"

    def full(*_):
        raise cd.ArchiveError("the disk is full")

    with monkeypatch.context() as patched:
        patched.setattr(sys.modules["chaosdrill.workflow.run_scene"], "save", full)
        with pytest.raises(cd.ArchiveError, match="full"):
            cd.run(tmp_path / "scene.toml", output)
    told = []
    cd.run(tmp_path / "scene.toml", output, resume=True, tell=told.append)
    assert told == ["motion: finished before"]
    assert cd.verify(output).equal


@pytest.mark.parametrize("name", ["\ud800.nc", "a/\ud800/b.nc"])
def test_a_name_that_no_file_can_have(tmp_path, monkeypatch, motion, name):
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(cd.ArchiveError, match=r"letters that names of files do not have here \(utf-8\)"):
        cd.run(tmp_path / "scene.toml", tmp_path / name)
    with pytest.raises(cd.ArchiveError, match="letters that names of files do not have"):
        cd.save(motion, tmp_path / name)
    with pytest.raises(cd.ArchiveError, match="cannot read the archive"):
        cd.open(tmp_path / name)
    with pytest.raises(cd.SceneError, match="cannot read the scene"):
        cd.load_scene(tmp_path / name)


def test_the_folder_of_a_links_target_is_tried(tmp_path, motion):
    link = tmp_path / "link.nc"
    link.symlink_to(tmp_path / "none" / "far.nc")
    with pytest.raises(cd.ArchiveError, match=r"the folder .*none does not exist; create it first"):
        cd.save(motion, link)
    link.unlink()
    link.symlink_to(link)
    with pytest.raises(cd.ArchiveError, match="a broken link"):
        cd.save(motion, link)
    assert link.is_symlink()

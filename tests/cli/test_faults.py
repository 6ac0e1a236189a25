"""Whatever a command is given: an exit code, a clear error, and never a traceback."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from support.archives import diagram

import chaosdrill as cd
from chaosdrill.archive import save
from chaosdrill.errors import SettingsError

# 0 done, 1 failed or different, 2 a wrong scene or command line; never a traceback.


def test_wrong_scene(call, scene, tmp_path):
    scene.write_text(scene.read_text().replace("eta = 0.8", "etta = 0.8"))
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 2
    assert answer.err == "scene.toml:9: system.parameters.etta: unknown parameter; did you mean 'eta'?\n"
    assert answer.out == ""
    assert not (tmp_path / "out.nc").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ["rum"],
        ["run"],
        ["run", "scene.toml"],
        ["run", "scene.toml", "-o", "a.nc", "--workers", "0"],
        ["run", "scene.toml", "-o", "a.nc", "--scheduler"],
        ["list", "colours"],
        ["verify"],
        ["warm", ""],
        ["warm", "a\0b"],
        ["warm", __file__],
    ],
    ids=" ".join,
)
def test_wrong_command_line(call, arguments):
    answer = call(*arguments)
    assert answer.code == 2
    assert "Error: " in answer.err


@pytest.mark.parametrize("command", ["check", "run"])
def test_missing_scene(call, tmp_path, command):
    output = ["-o", tmp_path / "out.nc"] if command == "run" else []
    answer = call(command, tmp_path / "none.toml", *output)
    assert (answer.code, answer.out) == (2, "")
    assert "cannot read the scene: No such file or directory" in answer.err


@pytest.mark.parametrize("command", ["verify", "info", "plot"])
def test_missing_archive(call, tmp_path, command):
    answer = call(command, tmp_path / "none.nc")
    assert (answer.code, answer.out) == (1, "")
    assert "No such file or directory" in answer.err


PACKED = "to be unpacked first"
TEXT_FILE = "name a small text file, as 'chaosdrill new' prints one"


@pytest.mark.parametrize(
    ("start", "scene_says", "archive_says"),
    [
        (b"\x89HDF\r\n\x1a\n\xff", "NetCDF-4 or HDF5, not a scene; the attribute 'scene'", "truncated or damaged"),
        (b"CDF\x01\xff", f"NetCDF-3, not a scene; {TEXT_FILE}", "but NetCDF-3; chaosdrill writes NetCDF-4"),
        (b"\x89PNG\r\n", f"a PNG picture, not a scene; {TEXT_FILE}", "but a PNG picture; name an archive"),
        (b"PK\x03\x04\xff", PACKED, PACKED),
        (b"\x1f\x8b\x08\xff", PACKED, PACKED),
        ("[system]\n".encode("utf-16"), ":1: not UTF-8 text; save the scene as UTF-8", "but text in UTF-16"),
        ("# Poincaré\n".encode() * 50, "system: missing", "but text; run a scene by 'chaosdrill run"),
        (bytes(600), "invalid TOML", "not a NetCDF-4 file; name an archive"),
        (b"\xc3\xff\x00", "not UTF-8 text", "If this was one, copy or download it once more"),
    ],
    ids=["hdf5", "netcdf3", "png", "zip", "gzip", "utf-16", "text", "zeros", "noise"],
)
def test_a_file_of_another_kind_is_called_by_its_name(call, tmp_path, start, scene_says, archive_says):
    path = tmp_path / "file"
    path.write_bytes(start)
    answer = call("check", path)
    assert answer.code == 2
    assert scene_says in answer.err
    answer = call("info", path)
    assert answer.code == 1
    assert archive_says in answer.err


@pytest.mark.parametrize("backend", ["agg", "none"])
def test_settings_that_matplotlib_cannot_read_are_told(tmp_path, backend):
    archive = save(diagram(5), tmp_path / "diagram.nc")
    if backend == "agg":
        (tmp_path / "matplotlibrc").write_bytes(b"\xf4\x00\xff")
    # matplotlib reads them at its import
    command = [sys.executable, "-m", "chaosdrill", "plot", archive, "-o", "a.png"]
    environment = {**os.environ, "MPLBACKEND": backend}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "the variable MPLBACKEND, or a file 'matplotlibrc' in the working directory" in done.stderr
    assert "Traceback" not in done.stderr


def test_output_folder_that_does_not_exist_is_told_before_the_run(call, scene, monkeypatch, tmp_path):
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    answer = call("run", scene, "-o", tmp_path / "none" / "out.nc")
    assert answer.code == 1
    assert "does not exist; create it first" in answer.err


def test_archive_without_a_scene_cannot_be_verified(call, tmp_path):
    import xarray as xr

    path = save(xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory"}), tmp_path / "a.nc")
    answer = call("verify", path)
    assert answer.code == 1
    assert "contains no scene" in answer.err


def test_scene_without_analyses_cannot_be_run(call, scene, tmp_path):
    text = scene.read_text()
    scene.write_text(text[: text.index("[analysis.motion]")])
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 2
    assert "contains no analysis" in answer.err


def test_a_result_that_no_memory_holds(call, scene, tmp_path):
    scene.write_text(scene.read_text().replace("periods = 3", "periods = 10_000_000_000\nsamples = 1_000_000"))
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 2
    assert "give fewer periods or samples" in answer.err


def test_archive_whose_scene_is_wrong_cannot_be_verified(call, tmp_path):
    import xarray as xr

    dataset = xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory", "scene": "[system]\nmodel = 'os.system'"})
    answer = call("verify", save(dataset, tmp_path / "a.nc"))
    assert answer.code == 1
    assert "scene.toml:2: system.model: unknown model 'os.system'" in answer.err


def test_interrupt_leaves_the_earlier_archive(call, scene, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    (tmp_path / "out.nc").write_bytes(b"the earlier archive")
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", interrupted)
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 130
    assert answer.err.strip() == "interrupted"
    assert (tmp_path / "out.nc").read_bytes() == b"the earlier archive"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.nc", "scene.toml"]


# Whatever name a file is given: one clear error and, with --json, one document; never a traceback.


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
    assert "No space left on device; an earlier file is unchanged" in told(call, command, "own.nc")["message"]
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

    from chaosdrill.cli.streams import emit

    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    emit({"group": "сверло", "path": "\udcff.nc"})
    stream.flush()
    assert json.loads(stream.buffer.getvalue()) == {"group": "сверло", "path": "\udcff.nc"}


def test_what_has_changed_is_told_in_its_own_letters():
    from chaosdrill.sweep.fingerprint import changes

    assert changes({"name": "сверло"}, {"name": "бур"}) == ['name: "сверло" before, "бур" now']


def test_a_constant_that_differs_in_its_last_digit_has_changed():
    from chaosdrill.sweep.fingerprint import changes, of_system, plain

    one, other = (
        plain(of_system(cd.HybridSystem(states="x", modes={"on": {"x": f"-{rate}*x"}})))
        for rate in ("0.1", "0.10000000000000002")
    )
    assert changes(one, other) == ['modes.on.x: "-0.1*x" before, "-0.10000000000000002*x" now']


# Files may have any name that the system allows, in any locale.


SCENE = '[system]\nmodel = "impact-oscillator"\n[analysis.motion]\nkind = "trajectory"\nperiods = 2\n'

ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}

UTF8 = {"LC_ALL": "C.UTF-8"}

NAME = "a\udcff"
"""As Python has the bytes ``a\\xff``."""

CASES = [(UTF8, b"a\xff", r"a\xff"), (ASCII, "ö".encode(), "ö")]


# one process for all commands of a locale: arguments and streams are those of the process, as of a single command
COMMANDS = """
import sys
from chaosdrill.cli import main
given = sys.argv[1:]
while given:
    end = given.index(";")
    code = main([*given[:end], "--json"])
    given = given[end + 1:]
    print("\\0", flush=True)
    if code:
        sys.exit(code)
"""


@pytest.mark.parametrize(("locale", "name", "text"), CASES)
def test_every_command_takes_files_of_any_name_in_any_locale(tmp_path, locale, name, text):
    folder = os.path.join(os.fsencode(tmp_path), name)
    os.mkdir(folder)
    scene, archive = name + b".toml", name + b".nc"
    with open(os.path.join(folder, scene), "w") as file:
        file.write(SCENE)
    commands = (
        ("check", scene, "--set", f"title={text}"),
        # the folder of finished parts, the archive, and a name of the whole path
        ("run", os.path.join(folder, scene), "-o", os.path.join(folder, archive)),
        ("info", archive),
        ("cite", archive),
        ("verify", archive),
        ("plot", archive, "-o", name + b".svg"),
        ("report", archive),
    )
    process = [sys.executable, "-c", COMMANDS, *(part for command in commands for part in (*command, ";"))]
    done = subprocess.run(process, cwd=folder, capture_output=True, env=os.environ | locale, check=False)
    assert (done.returncode, b"Traceback" in done.stderr) == (0, False), done.stderr[-2000:]
    checked, _, described, _, verified, drawn, _ = (json.loads(told) for told in done.stdout.split(b"\0\n")[:-1])
    assert checked["title"] == described["title"] == text
    assert f"run {text}.toml -o " in described["history"].replace("'", "")
    assert verified["equal"]
    assert len(drawn["pictures"]) == 2
    with open(os.path.join(folder, name + b".html"), encoding="utf-8") as page:
        assert f"{text}.nc" in page.read()


def test_an_archive_without_its_seal_is_tried_under_its_name(tmp_path, motion):
    from chaosdrill.archive.digest import LENGTH

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
    assert told == ["motion: found finished"]
    assert cd.verify(output).equal


@pytest.mark.parametrize("seconds", ["abc", "", "-5", "1e9", "253402300800", "9" * 5000])
def test_a_time_of_files_that_is_no_number(call, monkeypatch, seconds):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", seconds)
    answer = call("list", "methods")
    assert answer.code == 2
    assert "SOURCE_DATE_EPOCH" in answer.err
    assert "unset" in answer.err
    assert answer.err.count("\n") == 1
    with pytest.raises(SettingsError, match="SOURCE_DATE_EPOCH"):
        cd.open  # noqa: B018
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "253402300799")
    assert call("list", "methods").code == 0


def test_a_name_too_long_for_the_folder_of_parts(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(cd.ArchiveError, match=r"\.nc\.parts: cannot be used for finished parts: File name too long$"):
        cd.run(tmp_path / "scene.toml", tmp_path / f"{250 * 'f'}.nc")


@pytest.mark.parametrize("name", ["\ud800.nc", "a/\ud800/b.nc"])
def test_a_name_that_no_file_can_have(tmp_path, monkeypatch, motion, name):
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(cd.ArchiveError, match=r"characters that file names cannot have here \(utf-8\)"):
        cd.run(tmp_path / "scene.toml", tmp_path / name)
    with pytest.raises(cd.ArchiveError, match="characters that file names cannot have"):
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
    with pytest.raises(cd.ArchiveError, match="the name leads in a circle"):
        cd.save(motion, link)
    assert link.is_symlink()

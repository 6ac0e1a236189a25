"""Standard input, output and error: texts, documents, and who listens."""

import json
import os
import shlex
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.cli.streams import strict
from chaosdrill.workflow import Difference, Verification

# With ``--json`` standard output is one JSON document, whatever happens; codes and messages are those without it.


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
    assert "beyond bounds" in motion["advice"][0]


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
        file["motion/states"][1, 0] = np.nan
    answer = call("verify", archive, "--json")
    assert answer.code == 1
    found = document(answer.out)
    assert found["equal"] is False
    assert [(item["variable"], item["max_abs"]) for item in found["differences"]] == [("states", "inf")]


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


def test_an_interrupt_is_an_error_in_json(call, scene, tmp_path, monkeypatch):
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


# Whether anybody listens, and to which letters, changes nothing of what a command does.


SCENE = """\
title = "Öl − ζ"
[system]
model = "impact-oscillator"
[analysis.motion]
kind = "trajectory"
periods = 3
"""

COMMAND = shlex.join([sys.executable, "-m", "chaosdrill"])

LOCALE = {"LC_ALL": "C.UTF-8"}


@pytest.fixture
def shell(tmp_path):
    """Function that runs a line of a shell in a folder with a scene."""
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")

    def run(line, **environment):
        line = line.replace("chaosdrill", COMMAND)
        return subprocess.run(
            ["bash", "-c", line],
            cwd=tmp_path,
            capture_output=True,
            env=os.environ | LOCALE | environment,
            timeout=120,
            check=False,
        )

    return run


@pytest.mark.parametrize("where", [">&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full", "> >(true) 2>&1"])
def test_the_archive_is_written_whoever_listens(shell, tmp_path, where):
    done = shell(f"chaosdrill run scene.toml -o out.nc {where}")
    assert (done.returncode, b"Traceback" in done.stderr) == (0, False)
    assert {path.name for path in tmp_path.iterdir()} == {"scene.toml", "out.nc"}
    assert list(cd.open(tmp_path / "out.nc").children) == ["motion"]


@pytest.mark.parametrize("command", ["check scene.toml", "check scene.toml --json", "list effects", "--help"])
def test_standard_output_that_is_closed(shell, command):
    done = shell(f"chaosdrill {command} >&-")
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("json", ["", " --json"])
def test_the_exit_code_is_the_commands_where_the_reader_has_left(shell, json):
    # the reader ends before the command, which imports more
    for scene, code in (("scene.toml", 0), ("none.toml", 2)):
        assert shell(f"chaosdrill check {scene}{json} 2>&1 | true; exit ${{PIPESTATUS[0]}}").returncode == code


@pytest.mark.parametrize("json", ["", " --json"])
def test_a_full_disk_behind_standard_output_is_a_fault(shell, json):
    done = shell(f"chaosdrill check scene.toml{json} > /dev/full")
    assert (done.returncode, done.stderr) == (1, b"standard output: No space left on device\n")


@pytest.mark.parametrize("encoding", ["ascii", "ascii:strict", "latin-1", "cp1252", "utf-8"])
def test_letters_that_the_output_does_not_have(shell, encoding):
    done = shell("chaosdrill check scene.toml", PYTHONIOENCODING=encoding)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"system     impact-oscillator" in done.stdout


def test_standard_output_is_as_before(monkeypatch, capsys):
    from chaosdrill.cli import main

    before = sys.stdout.errors
    assert main(["list", "effects"]) == 0
    assert sys.stdout.errors == before


# Help comes at once, since nothing heavy is imported for it.


HEAVY = ("numba", "xarray", "matplotlib", "sympy", "netCDF4", "pydantic", "numpy", "dask", "scipy", "jinja2")

SHOW_IMPORTS = f"""
import sys
from chaosdrill.cli import main
code = main(sys.argv[1:])
print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)
sys.exit(code)
"""


def imported(*arguments):
    command = [sys.executable, "-c", SHOW_IMPORTS, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    return done.stderr.strip()


@pytest.mark.parametrize(
    "arguments",
    [
        "--help",
        "--version",
        "run --help",
        "verify --help",
        "plot --help",
        "report --help",
        "list systems",
        "list effects",
        "list analyses",
        "list methods",
    ],
)
def test_nothing_heavy_is_imported(arguments):
    assert imported(*arguments.split()) == "[]"


def test_check_imports_no_compiler_and_no_arrays(scene):
    assert imported("check", str(scene)) == "['sympy']"

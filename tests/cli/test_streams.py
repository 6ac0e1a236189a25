"""Whether anybody listens, and to which letters, changes nothing of what a command does."""

import os
import shlex
import subprocess
import sys

import pytest

import chaosdrill as cd

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


@pytest.mark.parametrize(
    "where", [">&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full", "> >(true)", "> >(true) 2>&1", "2> >(true)"]
)
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

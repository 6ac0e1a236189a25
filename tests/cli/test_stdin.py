"""A scene from standard input, and an archive that is never a stream."""

import io
import subprocess
import sys

import pytest

from chaosdrill.archive import open as open_archive


@pytest.fixture
def pipe(monkeypatch):
    """Function that puts bytes into standard input."""

    def put(data):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))

    return put


def test_run(call, scene, tmp_path, pipe):
    pipe(scene.read_bytes())
    assert call("run", "-", "--set", "system.parameters.eta=0.9", "-o", tmp_path / "out.nc").code == 0
    attributes = open_archive(tmp_path / "out.nc").attrs
    assert attributes["scene"] == scene.read_text().replace("eta = 0.8", "eta = 0.9")
    assert f": run - --set system.parameters.eta=0.9 -o {tmp_path / 'out.nc'}" in attributes["history"]


def test_faults_have_their_lines(call, scene, pipe):
    pipe(scene.read_bytes().replace(b"eta = 0.8", b"etta = 0.8"))
    answer = call("check", "-")
    assert answer.code == 2
    assert answer.err == "stdin:9: system.parameters.etta: unknown parameter; did you mean 'eta'?\n"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "stdin:1: system: missing"),
        (b"\xff\xfe", "stdin:1: not UTF-8"),
        (b"# \n" * 400_000, "stdin: larger than 1000000 bytes"),
    ],
)
def test_no_scene(call, pipe, data, message):
    pipe(data)
    answer = call("check", "-")
    assert answer.code == 2
    assert message in answer.err


def test_standard_input_that_is_closed():
    command = [sys.executable, "-c", "import sys; sys.stdin = None; from chaosdrill.cli import main; sys.exit(main())"]
    done = subprocess.run([*command, "check", "-"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "stdin: cannot read the scene: standard input is closed\n"


@pytest.mark.parametrize("command", [["run", "scene.toml"], ["plot", "out.nc"]])
def test_no_file_goes_to_standard_output(call, scene, monkeypatch, command):
    monkeypatch.chdir(scene.parent)
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    answer = call(*command, "-o", "-")
    assert (answer.code, answer.out) == (2, "")
    assert len(answer.err.splitlines()) == 1
    assert "output is '-'" in answer.err
    assert sorted(path.name for path in scene.parent.iterdir()) == ["scene.toml"]

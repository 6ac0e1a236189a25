"""Where a scene comes from and what is set in it; what is wrong is refused before anything runs."""

import io
import json
import os
import subprocess
import sys

import pytest

from chaosdrill.archive import open as open_archive
from chaosdrill.workflow import run

# ``--set`` changes the scene that is run, and the archive holds that scene and the command.


def test_the_archive_holds_the_scene_that_was_run(call, scene, tmp_path):
    output = tmp_path / "out.nc"
    sets = [
        "--set",
        "system.parameters.eta=0.5",
        "--set",
        "numerics.method=dop853",
        "--set",
        "analysis.motion.periods=2",
    ]
    assert call("run", scene, *sets, "-o", output).code == 0
    tree = open_archive(output)
    text = scene.read_text().replace("eta = 0.8", "eta = 0.5").replace("periods = 3", "periods = 2")
    assert tree.attrs["scene"] == text + '\n[numerics]\nmethod = "dop853"\n'
    assert tree["motion"].attrs["method"] == "dop853"
    assert json.loads(tree["motion"].attrs["parameters"])["eta"] == 0.5
    assert tree.attrs["history"].endswith(
        ": run scene.toml --set system.parameters.eta=0.5 --set 'numerics.method=\"dop853\"' "
        f"--set analysis.motion.periods=2 -o {output}"
    )
    assert call("verify", output).code == 0


def test_the_file_stays_as_it_is(call, scene):
    text = scene.read_text()
    assert call("check", scene, "--set", "system.parameters.eta=0.5").code == 0
    assert scene.read_text() == text


def test_the_same_from_python(scene, tmp_path):
    tree = run(scene, tmp_path / "out.nc", changes={"system.parameters.eta": 0.5})
    assert json.loads(tree["motion"].attrs["parameters"])["eta"] == 0.5
    assert open_archive(tmp_path / "out.nc").attrs["scene"] == tree.attrs["scene"]


def test_a_changed_scene_is_not_gone_on_with(call, scene, tmp_path, monkeypatch):
    scene.write_text(scene.read_text() + '[analysis.more]\nkind = "trajectory"\nperiods = 2\n')
    output = tmp_path / "out.nc"

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(sys.modules["chaosdrill.workflow.run_scene"], "save", full_disk)
        with pytest.raises(OSError, match="No space left"):
            run(scene, output, changes={"system.parameters.eta": 0.5})
    answer = call("run", scene, "-o", output, "--resume", "--set", "system.parameters.eta=0.6")
    assert answer.code == 2
    assert "system.parameters.eta" in answer.err
    assert call("run", scene, "-o", output, "--resume", "--set", "system.parameters.eta=0.5").code == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("system.parameters.etta=1", "--set: system.parameters.etta: unknown parameter; did you mean 'eta'?"),
        ("system.parameters.eta=fast", "--set: system.parameters.eta: expected a number, received 'fast'"),
        ("system.parameters.eta=-1", "--set: system.parameters.eta: the frequency ratio must be greater than 0"),
        ("analysis.motion.perods=4", "--set: analysis.motion.perods: unknown key; did you mean 'periods'?"),
        ("analysis.new.kind=trajectory", "--set: analysis.new: give either periods"),
        ("numerics.metod=rk4", "--set: numerics.metod: unknown key; did you mean 'method'?"),
        ("numerics.method=rk5", "--set: numerics.method: unknown method 'rk5'; did you mean 'rk4'?"),
        ("titel=x", "--set: titel: unknown key; did you mean 'title'?"),
        ("system.parameters=1", "--set system.parameters: is a table; set the keys in it"),
        ("system.model.x=1", "--set system.model.x: system.model is not a table but 'percussive-drill'"),
        ("eta", "--set 'eta': expected KEY=VALUE"),
        ("=1", "--set '=1': expected KEY=VALUE"),
        ("a..b=1", "--set 'a..b=1': expected KEY=VALUE"),
        ("title=", "is not a TOML value"),
        ("title='a", "is not a TOML value"),
        ("title=[1", "is not a TOML value"),
        ("title={a", "is not a TOML value"),
        ("title=a\x1bb", "is not a TOML value"),
        ("system.parameters.eta=5e-2000", "5e-2000 is nearer to 0 than any double"),
        ("title=1\nother=2", "contains more than one value"),
    ],
)
def test_fault(call, scene, change, message):
    answer = call("check", scene, "--set", change)
    assert (answer.code, answer.out) == (2, "")
    assert message in answer.err
    assert len(answer.err.splitlines()) == 1


def test_faults_of_the_file_keep_their_lines(call, scene):
    scene.write_text(scene.read_text().replace("periods = 3", "periods = 0"))
    answer = call("check", scene, "--set", "system.parameters.b=0.6", "--set", "title=x", "--json")
    assert json.loads(answer.out)["problems"] == [
        {"line": 12, "field": "analysis.motion.periods", "message": "must be at least 1, received 0"}
    ]


def test_a_fault_that_is_mended(call, scene):
    scene.write_text(scene.read_text().replace("periods = 3", "periods = 0"))
    assert call("check", scene, "--set", "analysis.motion.periods=3").code == 0


def test_the_last_of_two_counts(call, scene):
    answer = call("check", scene, "--json", "--set", "system.parameters.b=1", "--set", "system.parameters.b=0.5")
    assert json.loads(answer.out)["parameters"]["b"]["value"] == 0.5
    assert json.loads(answer.out)["changes"] == {"system.parameters.b": "0.5"}


# A scene from standard input, and an archive that is never a stream.


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


# The archive never takes the place of the scene that it is made from.


def link(scene, kind):
    other = scene.with_name("out.nc")
    {
        "same": lambda: None,
        "symbolic link": lambda: other.symlink_to(scene),
        "hard link": lambda: os.link(scene, other),
    }[kind]()
    return scene if kind == "same" else other


@pytest.mark.parametrize("kind", ["same", "symbolic link", "hard link"])
def test_an_output_that_is_the_scene_is_refused_before_the_run(call, scene, monkeypatch, kind):
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    text, output = scene.read_text(), link(scene, kind)
    answer = call("run", scene, "-o", output)
    assert (answer.code, answer.out) == (2, "")
    assert f"--output is {str(output)!r}, which is the scene itself; name another file" in answer.err
    assert scene.read_text() == text


def test_the_way_that_the_output_is_written_does_not_matter(call, scene, monkeypatch):
    monkeypatch.chdir(scene.parent)
    text = scene.read_text()
    assert call("run", "scene.toml", "-o", f"../{scene.parent.name}/./scene.toml").code == 2
    assert scene.read_text() == text


# A parameter that takes the forcing period away is refused with its line, before anything runs.


SCENE = """\
[system]
model = "impact-oscillator"
[system.parameters]
omega = OMEGA
[analysis.motion]
kind = "trajectory"
periods = 2
"""


@pytest.fixture
def still(tmp_path):
    """Function that writes the scene at a frequency."""

    def write(omega):
        path = tmp_path / "still.toml"
        path.write_text(SCENE.replace("OMEGA", omega))
        return path

    return write


@pytest.mark.parametrize("omega", ["0.0", "0", "-1.5"])
@pytest.mark.parametrize("command", ["run", "check"])
def test_the_line_of_the_frequency_is_told(call, still, monkeypatch, tmp_path, command, omega):
    monkeypatch.setattr("chaosdrill.workflow.run_scene.compute", lambda *_, **__: pytest.fail("it ran"))
    answer = call(command, still(omega), *(["-o", tmp_path / "out.nc"] if command == "run" else []))
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("still.toml:4: system.parameters.omega: the forcing frequency over natural frequency")
    assert f"must be greater than 0, received {omega}\n" in answer.err
    assert "zoo" not in answer.err


def test_check_lists_it_as_json(call, still):
    answer = call("check", still("0.0"), "--json")
    assert answer.code == 2
    assert [fault["line"] for fault in json.loads(answer.out)["problems"]] == [4]


def test_a_frequency_above_zero_passes(call, still):
    assert call("check", still("1e-3")).code == 0

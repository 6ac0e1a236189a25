"""``--set`` changes the scene that is run, and the archive holds that scene and the command."""

import json
import sys

import pytest

from chaosdrill.archive import open as open_archive
from chaosdrill.workflow import run


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

"""0 done, 1 failed or different, 2 a wrong scene or command line; never a traceback."""

import pytest

from chaosdrill.archive import save


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
    assert "asks for no analysis" in answer.err


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

"""The archive never takes the place of the scene that it is made from."""

import os

import pytest


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

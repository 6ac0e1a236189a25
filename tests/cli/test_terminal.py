"""What a stranger has written reaches a terminal with its codes made visible; in JSON it says what it said."""

import json

import pytest

import chaosdrill as cd
from chaosdrill.errors import SceneError
from chaosdrill.names import visible

LETTERS = {
    "\x1b]0;owned\x07\x1b[2J": r"\x1b]0;owned\x07\x1b[2J",
    "\x9b31m": r"\x9b31m",
    "\u202etxt.cod\u202c": r"\u202etxt.cod\u202c",
    "a\u2066b\u200fc\u2028d\x7f": r"a\u2066b\u200fc\u2028d\x7f",
    "Fréchet – Δη\tx": "Fréchet – Δη\tx",
}


@pytest.fixture(params=LETTERS, ids=range(len(LETTERS)))
def told(request):
    return request.param


def harmless(text):
    return visible(text) == text


@pytest.fixture
def scene(tmp_path, told):
    path = tmp_path / "scene.toml"
    quoted = json.dumps(told, ensure_ascii=True)
    path.write_text(
        f'title = {quoted}\n[system.definition]\nname = "spring"\nstates = ["x", "v"]\ndescription = {quoted}\n'
        f'labels.x = {quoted}\nmodes.only = {{x = "v", v = "-x"}}\n[system.initial]\nx = 1.0\n'
        '[analysis.run]\nkind = "trajectory"\nduration = 1.0\nsamples = 3\n'
    )
    return path


def test_check_run_and_info(call, scene, told, tmp_path):
    output = tmp_path / "out.nc"
    for arguments in (("check", scene), ("run", scene, "-o", output), ("info", output)):
        answer = call(*arguments)
        assert answer.code == 0, answer.err
        assert harmless(answer.out)
        assert harmless(answer.err)
        if arguments[0] in ("check", "info"):
            assert LETTERS[told] in answer.out


def test_a_text_makes_no_line_of_the_program(call, tmp_path):
    """What stands at the beginning of a line, or two letters into it, is the program's own."""
    forged = r"a\n  altered       nothing\nsystem     other"
    scene, output = tmp_path / "scene.toml", tmp_path / "out.nc"
    scene.write_text(
        f'title = "{forged}"\n[system.definition]\nname = "spring"\nstates = ["x"]\nlabels.x = "{forged}"\n'
        'modes.only = {x = "-x"}\n[analysis.run]\nkind = "trajectory"\nduration = 1.0\nsamples = 3\n'
    )
    assert call("run", scene, "-o", output).code == 0
    for arguments in (("check", scene), ("info", output)):
        lines = call(*arguments).out.splitlines()
        assert sum(line.strip() == "altered       nothing" for line in lines) >= 1
        assert not [line for line in lines if line.startswith(("  altered", "system     other"))]


def test_json_says_what_it_said(call, scene, told):
    answer = call("check", scene, "--json")
    assert harmless(answer.out)
    assert json.loads(answer.out)["title"] == told


def test_errors(call, told, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(f"[system]\nmodel = {json.dumps(told)}\n")
    answer = call("check", path)
    assert answer.code == 2
    assert harmless(answer.err)
    with pytest.raises(SceneError) as caught:
        cd.load_scene(path)
    assert harmless(str(caught.value))
    for arguments in (("info", f"{told}.nc"), ("check", "x.toml", "--set", told), (told,)):
        answer = call(*arguments)
        assert answer.code
        assert harmless(answer.out + answer.err)

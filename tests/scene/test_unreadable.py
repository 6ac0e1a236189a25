"""Files that are no scenes are refused quickly and in one line."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from support.effort import Effort

from chaosdrill.errors import SceneError
from chaosdrill.scene import load, load_scene


def refusal(path):
    with Effort() as effort, pytest.raises(SceneError) as caught:
        load_scene(path)
    assert effort.calls < 3_000_000
    assert "\n" not in str(caught.value)
    return str(caught.value)


def written(tmp_path, content):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    return path


def test_a_scene_of_ten_megabytes_is_refused(tmp_path):
    assert "larger than 1000000 bytes" in refusal(written(tmp_path, b"# \n" * 3_500_000))


def test_a_device_without_end():
    assert "larger than" in refusal("/dev/zero")


def test_a_pipe_is_a_scene_unless_nothing_writes_into_it(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    assert refusal(tmp_path / "pipe.toml").endswith(
        "a pipe into which nothing writes; name a file, or '-' for standard input"
    )
    reading, writing = os.pipe()
    # more than a pipe holds, which comes after the scene is asked for
    scene = '[system]\nmodel = "duffing"\n[analysis.motion]\nkind = "trajectory"\nperiods = 1\n#' + "#" * 200_000

    def write():
        with open(writing, "w") as pipe:
            time.sleep(0.05)
            pipe.write(scene)

    with ThreadPoolExecutor(1) as other:
        other.submit(write)
        assert load_scene(f"/dev/fd/{reading}").text == scene
    os.close(reading)


def test_a_writer_that_says_nothing_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(load, "TUNING", replace(load.TUNING, silence_s=0.05))
    reading, writing = os.pipe()
    for sent in (b"", b"[system]"):
        os.write(writing, sent)
        assert "a pipe whose writer has sent nothing for" in refusal(f"/dev/fd/{reading}")
    os.close(writing)
    os.close(reading)


def test_a_missing_file_is_told(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.toml")


def test_the_text_of_a_scene_is_no_name_of_one():
    told = refusal("title = 'x'\n[system]\n")
    assert told.startswith("title = 'x': cannot read the scene: No such file or directory; ")
    assert "write it to a file" in told


def test_a_folder_is_no_scene(tmp_path):
    assert "directory" in refusal(tmp_path)


def test_a_name_with_a_null_is_refused():
    assert "null" in refusal("a\0b.toml")


def test_bytes_that_are_no_text_are_told_with_their_line(tmp_path):
    assert refusal(written(tmp_path, b"a = 1\nb = '\xff'\n")).startswith("scene.toml:2: not UTF-8")


def test_invalid_toml_is_told_with_line_and_column(tmp_path):
    assert refusal(written(tmp_path, b"a = 1\nb = = 2\n")) == (
        "scene.toml:2: invalid TOML: Invalid value (column 5); text stands in quotes"
    )


@pytest.mark.parametrize("mark", ["", "\u2028", "\u0085"])
def test_a_number_with_a_point_is_two_keys(tmp_path, mark):
    told = refusal(written(tmp_path, f"# {mark}\npieces = {{ 0 = 1, 0.5 = 2 }}\n".encode()))
    assert told.startswith("scene.toml:2: invalid TOML: Cannot overwrite a value (column ")
    assert told.endswith("); a number with a point stands in quotes as a key")


def test_an_end_in_mid_value_is_told_with_its_line(tmp_path):
    assert refusal(written(tmp_path, b"a = 1\nb =")).startswith("scene.toml:2: invalid TOML: ")


def test_a_key_given_twice_is_refused(tmp_path):
    assert refusal(written(tmp_path, b"a = 1\na = 2\n")).startswith("scene.toml:2: invalid TOML: Cannot overwrite")


def test_a_text_of_escaped_quotes_that_nothing_closes(tmp_path):
    # at every quote a reader could begin anew
    text = b'a = "' + b'\\"' * 400_000
    assert "invalid TOML" in refusal(written(tmp_path, text))


@pytest.mark.parametrize("opening", [b"[", b"{ a = "])
def test_deep_nesting_is_refused(tmp_path, opening):
    assert "nested too deeply" in refusal(written(tmp_path, b"a = " + opening * 50_000))


@pytest.mark.parametrize("form", ["{} = 1", "[{}]", "x = {{ {} = 1 }}"])
def test_a_key_of_many_parts_is_refused(tmp_path, form):
    text = form.format(".".join(["a"] * 100_000))
    assert "a key of more than 64 parts" in refusal(written(tmp_path, text.encode()))


def test_points_that_stand_in_no_key(tmp_path):
    """A fitted polynomial has one in every coefficient; so may a title, a comment and a list of times."""
    fit = " + ".join(f"{k}.25*x" for k in range(200))
    dots = ".".join("abcd" * 60)
    texts = f'title = "{dots}"\n# {dots}\n'
    flow = f'modes.only.x = "1 - ({fit})" # {dots}\nlabels.x = \'{dots}\'\ndescription = """{dots}\n{dots}"""\n'
    times = f"times = [{', '.join(f'{k}.5' for k in range(100))}]"
    scene = f"[system.definition]\nname = 'fit'\nstates = ['x']\n{flow}[analysis.run]\nkind = 'trajectory'\n"
    found = load_scene(written(tmp_path, f"{texts}{scene}duration = 100\n{times}\n".encode()))
    assert found.title == dots


SPRING = """[system]
model = "impact-oscillator"
[system.parameters]
zeta = {}
"""


@pytest.mark.parametrize("number", ["1" * 10_000, "-" + "9" * 5_000, "0x" + "f" * 10_000, "0b" + "1" * 20_000])
def test_a_number_of_many_digits_is_refused(tmp_path, number):
    told = refusal(written(tmp_path, SPRING.format(number).encode()))
    assert told.startswith(f"scene.toml:4: a number of {len(number)} digits; write it as a double with an exponent")


@pytest.mark.parametrize("number", [str(2**63), str(-(2**63) - 1), "0x" + "f" * 17, "0x" + "f" * 390, "9" * 300])
def test_an_integer_that_no_machine_has_is_refused(tmp_path, number):
    told = refusal(written(tmp_path, SPRING.format(number).encode()))
    assert told.startswith("scene.toml:4: system.parameters.zeta: an integer of ")
    assert "such as 1e20" in told


@pytest.mark.parametrize("number", ["5e-2000", "-0.1e-324", "5_0e-1_000"])
def test_a_number_that_would_become_zero_is_refused(tmp_path, number):
    told = refusal(written(tmp_path, SPRING.format(number).encode()))
    assert told.startswith(f"scene.toml:4: system.parameters.zeta: {number} is nearer to 0 than any double")


def test_an_empty_scene_lacks_its_system(tmp_path):
    assert refusal(written(tmp_path, b"")) == (
        "scene.toml:1: system: missing; expected a table, as [system] with model = 'lorenz'; chaosdrill list systems"
    )


def test_byte_order_mark_is_no_fault(tmp_path):
    path = written(tmp_path, b'\xef\xbb\xbf[system]\nmodel = "lorenz"\n')
    assert load_scene(path).model == "lorenz"


def test_an_analysis_without_a_name(tmp_path):
    told = refusal(written(tmp_path, b'[system]\nmodel = "lorenz"\n[analysis]\nperiods = 20\n'))
    assert told == (
        "scene.toml:4: analysis.periods: expected a table, as [analysis.spectrum] with kind = 'lyapunov-spectrum', "
        "received 20"
    )

"""The study of versions divides into parts that a short session can run, and together they are the whole."""

import argparse
import importlib.util
from pathlib import Path

import pytest

FILE = Path(__file__).parents[2] / "studies" / "versions" / "make.py"


@pytest.fixture(scope="module")
def make():
    found = importlib.util.spec_from_file_location("versions_make", FILE)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


@pytest.mark.parametrize("n", [1, 3, 7])
def test_parts_are_the_whole_once(make, n):
    files = [file for k in range(1, n + 1) for file in make.part(f"{k}/{n}")]
    assert sorted(files) == sorted(make.CORE)
    assert make.part(f"0/{n}") == ()


@pytest.mark.parametrize("text", ["", "2", "3/2", "1/0", "-1/2", "1/14", "x/2", "1/2/3"])
def test_what_is_no_part(make, text):
    with pytest.raises(argparse.ArgumentTypeError, match="expected K/N"):
        make.part(text)


def test_one_set_alone(make, monkeypatch):
    made, ran = [], []
    monkeypatch.setattr(make, "environment", lambda name, interpreter, _: made.append((name, interpreter)) or "python")
    monkeypatch.setattr(make.subprocess, "call", lambda command, **_: ran.append(command) or 0)
    assert make.main(["a", "b", "--only", "newest", "--part", "2/13"]) == 0
    assert made == [("newest-0", "a"), ("newest-1", "b")]
    assert [command[-1] for command in ran if "pytest" in command] == [make.CORE[1]] * 2


def test_no_part_compiles_and_tests_nothing(make, monkeypatch):
    """Pytest without files would take the whole suite."""
    ran = []
    monkeypatch.setattr(make, "environment", lambda *_: "python")
    monkeypatch.setattr(make.subprocess, "call", lambda command, **_: ran.append(command) or 0)
    assert make.main(["a", "--only", "lowest", "--part", "0/4"]) == 0
    assert not any("pytest" in command for command in ran)
    assert ran[-1][1:] == ["-m", "chaosdrill", "warm"]

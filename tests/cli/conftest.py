from dataclasses import dataclass

import pytest

from chaosdrill.cli import main

SCENE = """\
title = "Drill without a stop"
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "coulomb"
rock = "moving"
[system.parameters]
eta = 0.8
[analysis.motion]
kind = "trajectory"
periods = 3
"""


@dataclass
class Answer:
    """What a command gave back."""

    code: int
    out: str
    err: str


@pytest.fixture
def call(capsys):
    """Function that runs a command and returns its exit code and its texts."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return run


@pytest.fixture
def scene(tmp_path):
    """File of a short scene."""
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path

"""The engine compiled beforehand is what a process finds that can write nothing."""

import errno
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import chaosdrill
import chaosdrill.engine.warm as engine_warm
from chaosdrill.cli import main
from chaosdrill.codegen import cache, kept
from chaosdrill.progress import COLD, tell_of_compilation

PACKAGE = Path(chaosdrill.__file__).parent
FLOW = "chaosdrill.engine.flow"


@pytest.fixture
def named(tmp_path, monkeypatch):
    """A folder for code, named by the variable, and one for all else."""
    monkeypatch.setenv("CHAOSDRILL_WARM_DIR", str(tmp_path / "warm"))
    monkeypatch.setattr(kept, "cache_folder", lambda: tmp_path / "cache")
    monkeypatch.setattr(kept.os, "access", lambda *_: False)
    (tmp_path / "warm").mkdir(mode=0o755)
    cache.warm_folder.cache_clear()
    tell_of_compilation.cache_clear()
    yield tmp_path / "warm"
    cache.warm_folder.cache_clear()


def none():
    raise AssertionError("it is there")


def test_code_of_the_named_folder_is_used(named):
    path = kept.engine_path(FLOW, "one")
    cache.put(named / path.name, b"code")
    assert kept.engine_code(FLOW, "one", none) == b"code"
    assert not path.exists()


def test_a_folder_where_others_write_is_not(named):
    path = kept.engine_path(FLOW, "one")
    cache.put(named / path.name, b"code")
    named.chmod(0o777)
    with pytest.warns(UserWarning, match="not used for compiled code"):
        assert kept.engine_code(FLOW, "one", lambda: b"own") == b"own"


def test_compilation_is_told_once_in_one_line(named, capsys):
    for name in ("one", "two"):
        kept.engine_code(FLOW, name, lambda: b"own")
    assert capsys.readouterr().err == COLD + "\n"
    kept.engine_code(FLOW, "one", none)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("folder", [None, "full"])
def test_what_cannot_be_kept_is_said_with_its_folder(tmp_path, monkeypatch, capsys, folder):
    def full(named, elsewhere):
        if named is None:
            return [tmp_path / "lost.code"]
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(engine_warm, "warm", full)
    assert main(["warm", "--json", *filter(None, [folder])]) == 1
    told = f"{folder}: No space left on device" if folder else f"{tmp_path}: 1 of 1 functions cannot be kept there"
    said = capsys.readouterr()
    assert said.err.startswith(told)
    assert json.loads(said.out)["error"]["kind"] == "OSError"


SPECTRUM = """
import chaosdrill as cd
print(cd.__file__, float(cd.lyapunov_spectrum(cd.build("lorenz"), duration=2.0)["lyapunov_exponent"][0]))
"""


def test_an_installation_that_cannot_be_written_brings_its_engine(tmp_path):
    """A zip file has no folder for code beside its modules."""
    warm = [sys.executable, "-m", "chaosdrill", "warm", str(tmp_path / "warm")]
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    made = subprocess.run(warm, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert f"in {tmp_path / 'warm'}" in made.stdout
    # what systems call by name
    assert list((tmp_path / "warm").glob("special.positive_power.*"))
    compiled = {file.stem for file in PACKAGE.rglob("*.py") if "\n@compiled(" in file.read_text()}
    assert compiled <= {file.name.split(".")[0] for file in (tmp_path / "warm").iterdir()}
    packed = tmp_path / "packed.zip"
    with zipfile.ZipFile(packed, "w") as archive:
        for file in PACKAGE.rglob("*"):
            if file.is_file() and "__pycache__" not in file.parts:
                archive.write(file, file.relative_to(PACKAGE.parent))
    environment |= {"PYTHONPATH": str(packed), "CHAOSDRILL_CACHE_DIR": str(tmp_path / "cache")}
    environment |= {"CHAOSDRILL_WARM_DIR": str(tmp_path / "warm")}
    command = [sys.executable, "-c", SPECTRUM]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.startswith(str(packed))
    assert done.stderr == ""
    assert not (tmp_path / "cache" / "engine").exists()

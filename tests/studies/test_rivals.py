"""The table of rivals says what its single measurements do, and which program is missing."""

import csv
import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "studies" / "rivals"


@pytest.fixture(scope="module")
def make():
    sys.path.insert(0, str(FOLDER))
    sys.modules.pop("make", None)
    yield importlib.import_module("make")
    sys.modules.pop("make", None)
    sys.path.remove(str(FOLDER))


def test_the_table_is_that_of_the_measurements(make):
    with (FOLDER / "rivals.csv").open(encoding="utf-8", newline="") as file:
        rows = [
            row | {"seconds": float(row["seconds"]), "value": [float(v) for v in row["value"].split()]}
            for row in csv.DictReader(file)
        ]
    made = make.table(rows, {}).splitlines()
    kept = (FOLDER / "rivals.md").read_text(encoding="utf-8").splitlines()
    lines = [line for line in made if line.startswith("|")]
    assert lines == [line for line in kept if line.startswith("|")]
    assert len(lines) == 2 + 2 * len(make.works())
    assert "nolds is missing: no network" in make.table(rows, {"nolds": "no network"})


def test_what_fails_there_is_told():
    task = {"program": "no such program", "work": "state", "length": 1.0, "setting": 0.0}
    done = subprocess.run(
        [sys.executable, str(FOLDER / "theirs.py")], input=json.dumps(task) + "\n", capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert "KeyError" in json.loads(done.stdout)["error"]

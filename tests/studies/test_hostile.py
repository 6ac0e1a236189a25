"""Archives that are built to do harm are opened or refused; the study tries thousands of them."""

from dataclasses import replace
from pathlib import Path

import pytest

from chaosdrill.archive import save, trial

STUDY = Path(__file__).parents[2] / "studies" / "fuzz"


@pytest.fixture
def hostile(monkeypatch):
    monkeypatch.syspath_prepend(str(STUDY))
    import hostile

    return hostile


@pytest.mark.filterwarnings("ignore")
def test_a_few_hostile_files(tmp_path, hostile):
    found = hostile.run(tmp_path, files=20, seconds=None, seed=1, keep=tmp_path)
    assert found["wrong"] == []
    assert found["files"] == 20
    assert found["slowest"] < hostile.MOST_S
    # the study is worth nothing where files are not hostile
    assert sum(number for outcome, number in found["outcomes"].items() if outcome.startswith("refused")) > 10


def test_a_process_that_waits_is_wrong(tmp_path, hostile, monkeypatch):
    path = save(hostile.small(), tmp_path / "a.nc")
    monkeypatch.setattr(trial, "_spare", [])
    monkeypatch.setattr(trial, "TUNING", replace(trial.TUNING, patience_s=0.0))
    assert hostile._opened(path) == "WRONG: the process that reads it waits"

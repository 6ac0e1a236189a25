"""Archives that are built to do harm are opened or refused; the study tries thousands of them."""

import time
from itertools import repeat
from pathlib import Path

import pytest

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
    assert found["slowest"] < hostile.opener.MOST_S
    # the study is worth nothing where files are not hostile
    assert sum(number for outcome, number in found["outcomes"].items() if outcome.startswith("refused")) > 10


@pytest.mark.parametrize(
    ("wait", "outcome"),
    [(time.sleep, "WRONG: has waited for 2 s"), (None, "WRONG: no answer after 2 s of processor time")],
)
def test_a_process_that_waits_or_works_too_long_is_wrong(tmp_path, hostile, monkeypatch, wait, outcome):
    monkeypatch.setattr(hostile.opener, "MOST_S", 1.5)
    monkeypatch.setattr(hostile.opener, "_opened", lambda _: wait(60) if wait else sum(repeat(1)))
    assert hostile.opener.Opener().open(tmp_path)[0] == outcome


def test_a_process_that_waits_for_a_processor_is_not(tmp_path, hostile, monkeypatch):
    monkeypatch.setattr(hostile.opener, "MOST_S", 0.2)
    monkeypatch.setattr(hostile.opener, "_opened", lambda _: time.sleep(1.2) or "opened")
    monkeypatch.setattr(hostile.opener, "_status", lambda _: ["R", *"0" * 20])
    assert hostile.opener.Opener().open(tmp_path)[0] == "opened"

"""Spoilt scenes: no traceback, no code run, no file lost, memory bounded. All 500 are run by the script itself."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("mutations.py")
COUNT = 60


@pytest.fixture(scope="module")
def report():
    done = subprocess.run([sys.executable, SCRIPT, str(COUNT)], capture_output=True, text=True, timeout=500)
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def test_no_fault(report):
    assert report["faults"] == []


def test_every_one_was_checked_and_run(report):
    for counts in report["codes"].values():
        assert sum(counts.values()) == COUNT
        # some are found to be wrong, and some are not
        assert counts["2"] > 10
        assert counts["0"] > 0
    assert set(report["codes"]["check"]) <= {"0", "2"}

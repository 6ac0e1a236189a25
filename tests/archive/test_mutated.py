"""Mutated archives: no traceback, no code run, no file lost, memory bounded, whatever is done with them.

CHAOSDRILL_MUTATIONS=500 in the environment tries so many; the suite itself only some.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

COUNT = int(os.environ.get("CHAOSDRILL_MUTATIONS", "11"))
BATCH = 25
# the compiler alone takes 1500 where nothing is in the cache yet
MEGABYTES = 2500


@pytest.mark.parametrize("first", range(0, COUNT, BATCH))
def test_mutated(every_kind, tmp_path, first):
    driver = Path(__file__).with_name("mutations.py")
    command = [sys.executable, "-W", "ignore", driver, every_kind, tmp_path, first, min(first + BATCH, COUNT)]
    ran = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    lines = [json.loads(line) for line in ran.stdout.splitlines()]
    assert ran.returncode == 0, f"{lines[-1:]}: {ran.stderr[-2000:]}"
    found = [line for line in lines if "codes" in line]
    assert len(found) == min(BATCH, COUNT - first)
    for line in found:
        assert set(line["codes"].values()) <= {0, 1}, line
        assert not line["lost"], line
        assert not line["trapped"], line
        assert line["others"] == [], line
        assert line["memory"] < MEGABYTES, line

"""Spoilt scenes, definitions, archives and folders of parts: no traceback, no code run, no file lost, all bounded.

The corpus holds every fault that was found, and comes first. ``studies/run.py fuzz`` goes on for hours.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

FUZZER = Path(__file__).with_name("fuzzer.py")
SECONDS = 35
SEED = 20260101
KINDS = {"scene": {"0", "2"}, "definition": {"built"}, "archive": {"0 0 0", "0 0 1"}, "parts": {"0", "1", "2"}}
"""By kind, outcomes that the corpus has: some inputs are found to be wrong, and some are not."""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    keep = tmp_path_factory.mktemp("wrong")
    command = [sys.executable, "-W", "ignore", FUZZER, "--seconds", SECONDS, "--seed", SEED, "--keep", keep]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=600)
    assert done.stdout, done.stderr[-5000:]
    return json.loads(done.stdout)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_wrong(report, kind):
    faults = report[kind]["faults"]
    told = "\n".join(f"{fault['number']}: {fault['wrong'][0][-800:]}" for fault in faults)
    files = " ".join(fault["input"] for fault in faults)
    assert not faults, f"seed {SEED}\n{told}\npython {FUZZER} --replay {files}"


@pytest.mark.parametrize("kind", KINDS)
def test_the_corpus_was_tried_and_spoilt(report, kind):
    corpus = list((FUZZER.parent / "corpus" / kind).iterdir())
    assert report[kind]["of the corpus"] >= len(corpus)
    assert report[kind]["inputs"] >= report[kind]["of the corpus"] + 10
    assert KINDS[kind] <= set(report[kind]["outcomes"])
    assert report[kind]["lines reached"] > 500

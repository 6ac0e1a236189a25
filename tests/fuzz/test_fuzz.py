"""Spoilt scenes, definitions, archives and folders of parts: no traceback, no code run, no file lost, all bounded.

The corpus holds every fault that was found, and comes first. ``studies/run.py fuzz`` goes on for hours.
"""

import json
import subprocess
import sys
from pathlib import Path

FUZZER = Path(__file__).with_name("fuzzer.py")
SECONDS = 5
SEED = 20260101
KINDS = {"scene": {"0", "2"}, "definition": {"built"}, "archive": {"0 0 0", "0 0 1"}, "parts": {"0", "1", "2"}}
"""By kind, outcomes that the corpus has: some inputs are found to be wrong, and some are not."""


def test_the_corpus_and_what_it_is_spoilt_to(tmp_path):
    """One test, so that workers of the suite do not fuzz beside each other."""
    command = [sys.executable, "-W", "ignore", FUZZER, "--seconds", SECONDS, "--seed", SEED, "--keep", tmp_path]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=600)
    assert done.stdout, done.stderr[-5000:]
    report = json.loads(done.stdout)
    assert set(report) == set(KINDS)
    for kind, found in report.items():
        told = "\n".join(f"{fault['number']}: {fault['wrong'][0][-800:]}" for fault in found["faults"])
        files = " ".join(fault["input"] for fault in found["faults"])
        assert not found["faults"], f"{kind}, seed {SEED}\n{told}\npython {FUZZER} --replay {files}"
        corpus = list((FUZZER.parent / "corpus" / kind).iterdir())
        assert found["of the corpus"] >= len(corpus)
        assert found["inputs"] >= found["of the corpus"] + 10
        assert KINDS[kind] <= set(found["outcomes"])
        assert found["lines reached"] > 500

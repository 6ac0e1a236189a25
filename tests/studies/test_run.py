"""The bootstrap needs only the standard library, and refuses what it does not know before it installs anything."""

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

RUN = Path(__file__).parents[2] / "studies" / "run.py"


def _run(*arguments):
    # -I and -S hide every installed package
    return subprocess.run([sys.executable, "-I", "-S", RUN, *arguments], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize(("arguments", "code"), [((), 2), (("papers",), 2), (("--help",), 0)])
def test_usage_names_every_job(arguments, code):
    result = _run(*arguments)
    assert result.returncode == code
    for job in runpy.run_path(str(RUN))["JOBS"]:
        assert f"studies/run.py {job}" in result.stderr


def test_every_job_runs_a_file_that_exists():
    jobs = runpy.run_path(str(RUN))["JOBS"]
    scripts = [RUN.parent.parent / command[0] for _, command in jobs.values() if command[0] != "-m"]
    assert len(scripts) == len(jobs) - len({"docs", "tests", "coverage", "lines"})
    assert all(script.is_file() for script in scripts)

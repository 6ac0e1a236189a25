"""The compliance checker in a process of its own, since its libraries and ours bring two copies of HDF5.

Run as a program it reads lines of JSON, a file and a convention each, and answers each with what failed, as weights
and messages, and which of its checks stopped with an exception.
"""

import contextlib
import importlib.util
import json
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

Checked = tuple[list[tuple[int, str]], set[str]]

INSTALLED = importlib.util.find_spec("compliance_checker") is not None


@contextlib.contextmanager
def checker() -> Iterator[Callable[[Path, str], Checked]]:
    """A function of a file and a convention that gives what failed and which checks stopped."""
    command = [sys.executable, "-W", "ignore", __file__]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdin is not None
        assert child.stdout is not None

        def check(path: Path, convention: str) -> Checked:
            child.stdin.write(json.dumps([str(path), convention]) + "\n")
            child.stdin.flush()
            failed, stopped = json.loads(child.stdout.readline())
            return [(weight, message) for weight, message in failed], set(stopped)

        yield check
        child.stdin.close()


def in_numbers(ds: Any) -> Any:
    """The dataset with another name for each index of texts, which is no coordinate variable to the checker."""
    names = {name: f"{name}_name" for name in ds.indexes if ds[name].dtype.kind in "OUT"}
    return ds.reset_index(list(names)).rename_vars(names)


def _failures(result: Any) -> list[tuple[int, str]]:
    if result.children:
        return [failure for child in result.children for failure in _failures(child)]
    passed = result.value[0] == result.value[1] if isinstance(result.value, tuple) else result.value
    return [] if passed else [(result.weight, message) for message in result.msgs or [result.name]]


def _serve() -> None:
    warnings.simplefilter("ignore")
    # the checker prints on its own account
    answers, sys.stdout = sys.stdout, sys.stderr
    from compliance_checker.runner import CheckSuite

    CheckSuite.load_all_available_checkers()
    for line in sys.stdin:
        path, convention = json.loads(line)
        suite = CheckSuite()
        results, stopped = suite.run_all(suite.load_dataset(path), [convention])[convention]
        failed = [failure for result in results for failure in _failures(result)]
        print(json.dumps([failed, list(stopped)]), file=answers, flush=True)


if __name__ == "__main__":
    _serve()

"""A function is the same machine code whatever was compiled before it; else a rerun may differ in the last bit."""

import math
import os
import re
import subprocess
import sys

import numba
import pytest
from numba import float64

from chaosdrill.engine import jit
from chaosdrill.engine.jit import compiled, inner

MATRIX = float64[:, ::1]


@pytest.fixture(autouse=True)
def fresh(monkeypatch):
    """Nothing comes from the disk."""

    def none(function):
        raise RuntimeError(f"{function} cannot be cached")

    monkeypatch.setattr(jit, "CodeCache", none)


def caller_of(helper):
    def total(matrix):
        result = 0.0
        for row in range(matrix.shape[0]):
            result += helper(matrix[row]) * helper(matrix[row - 1]) + helper(matrix[row // 2])
        return result + helper(matrix[0]) / helper(matrix[1])

    return total


def weigh(values):
    result = 0.0
    for k in range(values.size // 4):
        a, b, c, d = values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3]
        values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3] = a * a, b * b, c * c, d * d
        result += a + b + c + d
        for other in range(k):
            result += math.sin(values[other] * a) - math.cos(values[other] * b) + math.exp(c) * math.atan2(d, a)
            values[other] = math.tanh(result) - math.log1p(a * a) + math.hypot(b, c)
        if result > 1e3:
            result = weigh_again(result, a)
    return result


@inner
def weigh_again(total, value):
    return total / (1.0 + value * value)


def machine_code(dispatcher):
    """The instructions, with the names that number every function of a process replaced."""
    text = dispatcher.overloads[(MATRIX,)].library.get_asm_str()
    lines = [line.split("#")[0].strip() for line in text.splitlines()]
    instructions = [line for line in lines if line and not line.startswith(".")]
    return [re.sub(r"\S*(?:_ZN|numba|\.const|NumbaEnv)\S*", "name", line) for line in instructions]


def other_caller_of(helper):
    def total(matrix):
        return helper(matrix[0]) - helper(matrix[1])

    return total


def test_the_same_helper_after_another_caller():
    first = compiled(float64(MATRIX))(caller_of(inner(weigh)))
    shared = inner(weigh)
    compiled(float64(MATRIX))(other_caller_of(shared))
    second = compiled(float64(MATRIX))(caller_of(shared))
    assert machine_code(first) == machine_code(second)
    assert len(machine_code(first)) > 20


@inner
def kept_apart(values):
    """No compiler can put all calls of this one into its caller."""
    if values[0] < 1.0:
        return values[0]
    values[0] -= 1.0
    return 2.0 + kept_apart(values) * kept_apart(values)


def test_what_is_linked_into_a_function_is_seen_by_no_other():
    function = compiled(float64(MATRIX))(caller_of(kept_apart))
    module = function.overloads[(MATRIX,)].library._final_module
    shown = [f.name for f in module.functions if not f.is_declaration and f.linkage.name != "internal"]
    assert len(shown) == 3  # for compiled callers, for Python, for C
    assert all("total" in name for name in shown)


def test_the_compiler_is_left_as_it_was():
    before = numba.config.SLP_VECTORIZE, numba.core.codegen.CPUCodeLibrary._optimize_final_module
    compiled(float64(MATRIX))(caller_of(inner(weigh)))
    assert (numba.config.SLP_VECTORIZE, numba.core.codegen.CPUCodeLibrary._optimize_final_module) == before


CALLS = """
from numba import float64

from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.special import hunt_crossley_exit, hunt_crossley_exit_lam, hunt_crossley_peak

@inner
def part(v, lam):
    return hunt_crossley_exit(v, lam) + hunt_crossley_exit_lam(v, lam) + hunt_crossley_peak(v, lam, 1.0, 2.0)

@compiled(float64(float64, float64))
def whole(v, lam):
    return part(v, lam)

print(whole(1.0, 0.5), hunt_crossley_exit(1.0, 0.5) + hunt_crossley_exit_lam(1.0, 0.5)
      + hunt_crossley_peak(1.0, 0.5, 1.0, 2.0))
"""


def test_what_was_linked_into_another_function_can_still_be_called(tmp_path):
    """Compiled, and from the cache: a search for its code must not end at the copy that another function keeps."""
    (tmp_path / "calls.py").write_text(CALLS)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    for _ in range(2):
        command = [sys.executable, tmp_path / "calls.py"]
        told = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=120).stdout
        together, apart = map(float, told.split())
        assert together == pytest.approx(apart, rel=1e-14)

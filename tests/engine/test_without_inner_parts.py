"""A numba whose inner parts are gone or changed: its public parts make code that does the same."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from chaosdrill.codegen.kinds import Tuple, float64, int64, void
from chaosdrill.codegen.signatures import matrix, vector
from chaosdrill.engine import front_end
from chaosdrill.engine.jit import compiled, inner, unit

inner_parts = front_end.inner_parts


@inner
def pull(x, k):
    return -k * x


def _hit(v, e):
    return -(e**1.5) * v


hit = unit(_hit, float64(float64, float64))


def bounce(x, k, table, stride):
    """A spring over a wall at 0, by steps of Euler and Cromer: the number of hits and the greatest height.

    Of a stride of zero numba would tell Python.
    """
    hits, height = 0, x[0]
    for step in range(0, table.shape[0], stride):
        x[1] += 0.01 * pull(x[0] + 1.0, k)
        x[0] += 0.01 * x[1]
        if x[0] < 0.0 and x[1] < 0.0:
            x[1] = hit(x[1], 0.8)
            hits += 1
        height = max(height, x[0])
        table[step, 0], table[step, 1] = x[0], x[1]
    return hits, height


SIGNATURE = Tuple((int64, float64))(vector, float64, matrix, int64)


def halve(values):
    for i in range(values.size):
        values[i] = pull(values[i], -0.5)


def run(function):
    """What a function makes of a bounce, as numbers."""
    state, table = np.array([1.0, 0.0]), np.zeros((700, 2))
    hits, height = function(state, 1.0, table, 1)
    return [hits, height, *state.tolist(), table.sum()]


def in_python():
    """The same without any compiler."""
    return type(bounce)(bounce.__code__, bounce.__globals__ | {"pull": pull.py_func, "hit": _hit})


def _gone(*_):
    raise AttributeError("module 'numba.core.codegen' has no attribute 'JITCodeLibrary'")


@pytest.mark.parametrize("changed", ["_linked", "compiler", "lowered", None])
def test_functions_do_the_same(changed, monkeypatch):
    """What has changed shows before anything is compiled, or when all parts of a function are."""
    monkeypatch.setattr(front_end, "inner_parts", changed and inner_parts)
    if changed:
        monkeypatch.setattr(inner_parts, changed, _gone)
    found = run(compiled(SIGNATURE)(bounce))
    assert front_end.inner_parts is None
    assert found[0] > 3
    assert found == pytest.approx(run(in_python()), rel=1e-12)
    values = np.array([1.0, 3.0])
    assert compiled(void(vector))(halve)(values) is None
    assert values.tolist() == [0.5, 1.5]


def test_a_fault_of_the_function_is_told_as_such():
    def wrong(x):
        return x.no_such_part

    with pytest.raises(Exception, match="no_such_part"):
        compiled(float64(vector))(wrong)(np.zeros(2))
    assert front_end.inner_parts is inner_parts


WITHOUT = """
import sys
sys.path.insert(0, sys.argv[1])
sys.modules["chaosdrill.engine.inner_parts"] = None
import hashlib
import test_without_inner_parts as t
assert t.front_end.inner_parts is None
made = t.compiled(t.SIGNATURE)(t.bounce)
print(hashlib.sha256(made.code).hexdigest(), *t.run(made))
"""


def test_a_process_that_cannot_import_them_makes_code_that_others_can_keep():
    command = [sys.executable, "-c", WITHOUT, str(Path(__file__).parent)]
    told = [subprocess.check_output(command, text=True).split() for _ in range(2)]
    assert told[0] == told[1]
    assert list(map(float, told[0][1:])) == pytest.approx(run(in_python()), rel=1e-12)

"""The engine as Python runs it is the engine that is compiled: what covers its lines says something about both."""

import json
import operator
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.short_runs import RUNS

from chaosdrill.codegen.kinds import float64, int64, void
from chaosdrill.engine import lane_code as lanes
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.lanes import aligned
from chaosdrill.engine.uncompiled import UNCOMPILED, Row, Table, as_lanes

matrix = float64[:, ::1]

PAIRS = (lanes.larger, lanes.smaller)
SINGLE = (lanes.magnitude, lanes.floor, lanes.exponent, lanes.mantissa)
OPERATORS = (operator.add, operator.sub, operator.mul, operator.truediv)
COMPARISONS = (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne)
larger, smaller = PAIRS
magnitude, floor, exponent, mantissa = SINGLE


@compiled(void(matrix, matrix, matrix, int64[::1], int64[:, ::1]))
def machine(first, second, out, places, whole):
    """Every operation on lanes, as machine code: one a row."""
    a, b, target = lanes.row_of(first), lanes.row_of(second), lanes.row_of(out)
    for i in range(first.shape[0]):
        k = 20 * i
        x, y = a[i], b[i]
        target[k] = larger(x, y)
        target[k + 1] = smaller(x, y)
        target[k + 2] = x + y
        target[k + 3] = x - y
        target[k + 4] = x * y
        target[k + 5] = x / y
        target[k + 6] = magnitude(x)
        target[k + 7] = floor(x)
        orders = lanes.chosen(x < y, 1.0, 0.0) + lanes.chosen(x <= y, 2.0, 0.0) + lanes.chosen(x > y, 4.0, 0.0)
        orders = orders + lanes.chosen(x >= y, 8.0, 0.0) + lanes.chosen(x == y, 16.0, 0.0)
        target[k + 8] = orders + lanes.chosen(x != y, 32.0, 0.0)
        target[k + 9] = exponent(magnitude(x))
        target[k + 10] = mantissa(magnitude(x))
        target[k + 11] = lanes.power_of_two(floor(larger(smaller(x, 900.0), -900.0)))
        target[k + 12] = lanes.chosen((~(x < y) & (x <= 2.0)) | (y != y), x, y)
        target[k + 13] = -x
        target[k + 14] = 1.0 if lanes.some(x > 0.0) else 0.0
        target[k + 15] = lanes.gathered(first, places, i % 8) + lanes.gathered(whole, places, 0)
        target[k + 16] = lanes.part(first, i, 0)
        lanes.put(out, k + 17, 0, x + y)
        target[k + 18] = lanes.powers(first[i, 1])
        target[k + 19] = lanes.spread(lanes.total(y))


def in_python(first, second, places, whole):
    """The same by the twins."""
    for x, y, column in zip(first, second, range(len(first)), strict=True):
        x, y = as_lanes(x), as_lanes(y)
        yield from (pair.twin(x, y) for pair in PAIRS)
        yield from (symbol(x, y) for symbol in OPERATORS)
        yield from (single.twin(x) for single in SINGLE[:2])
        orders = (symbol(x, y) * 2.0**i for i, symbol in enumerate(COMPARISONS))
        yield as_lanes(sum(orders))
        yield from (single.twin(magnitude.twin(x)) for single in SINGLE[2:])
        yield lanes.power_of_two.twin(floor.twin(larger.twin(smaller.twin(x, 900.0), -900.0)))
        yield lanes.chosen.twin((~(x < y) & (x <= 2.0)) | (y != y), x, y)
        yield -x
        yield as_lanes(1.0 if lanes.some.twin(x > 0.0) else 0.0)
        yield lanes.gathered.twin(first, places, column % 8) + lanes.gathered.twin(whole, places, 0)
        yield lanes.part.twin(first, column, 0)
        sums = np.zeros((1, 8))
        lanes.put.twin(sums, 0, 0, x + y)
        yield sums[0]
        yield lanes.powers.twin(x[1])
        yield as_lanes(lanes.total.twin(y))


@pytest.mark.skipif(UNCOMPILED, reason="compares with machine code")
def test_twins_give_the_bits_of_the_machine_code():
    rng = np.random.default_rng(3)
    first, second = (aligned(12, 8) for _ in range(2))
    first[:] = rng.normal(size=(12, 8)) * 10.0 ** rng.integers(-300, 300, (12, 8))
    second[:] = rng.normal(size=(12, 8))
    first[0] = 0.0, -0.0, np.inf, -np.inf, np.nan, 1.0, -2.0, 5e-324
    second[0] = -0.0, 0.0, np.inf, np.nan, 1.0, np.nan, 0.0, 1.0
    first[1] = second[1]
    out, places = aligned(20 * 12, 8), np.array([3, 1, 4, 1, 5, 9, 2, 6])
    whole = np.arange(-6, 6).reshape(12, 1)
    machine(first, second, out, places, whole)
    with np.errstate(all="ignore"):
        expected = np.array(list(in_python(first, second, places, whole)))
    number = ~np.isnan(expected)
    np.testing.assert_array_equal(np.isnan(out), ~number)
    np.testing.assert_array_equal(out.view(np.int64)[number], expected.view(np.int64)[number])


def test_lanes_in_memory_are_copies_and_rows_are_not():
    block = aligned(3, 4, 8)
    table = Table(block)
    before = table[1][2]
    table[1][2] = 5.0
    assert (block[1, 2] == 5.0).all()
    assert (before == 0.0).all()
    line = Row(block[2])
    line[0] = value = line[1]
    value += 1.0
    assert (block[2] == 0.0).all()


@pytest.mark.skipif(not UNCOMPILED, reason="the job that counts the engine's lines runs it")
def test_runs_agree_whether_the_engine_is_compiled_or_not():
    """A fused multiplication is all that may differ, which tolerances of 1e-9 and the few periods keep small."""
    other = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    del other["NUMBA_DISABLE_JIT"]
    script = Path(__file__).parents[1] / "support" / "short_runs.py"
    asked = subprocess.run([sys.executable, str(script)], env=other, stdout=subprocess.PIPE, check=True)
    expected = json.loads(asked.stdout)
    assert expected.keys() == RUNS.keys()
    for name, (run, *given) in RUNS.items():
        np.testing.assert_allclose(run(*given), expected[name], rtol=1e-8, atol=1e-10, err_msg=name)

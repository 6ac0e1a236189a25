"""What compiled functions do with numbers, done with eight at once."""

import operator

import numba
import numpy as np
import pytest
from llvmlite import binding as llvm

from chaosdrill.codegen import machine
from chaosdrill.codegen.kinds import Array, RecordOf, float64, void
from chaosdrill.engine import polynomial, records, taylor
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.lane_code import chosen, larger, magnitude, row_of, table_of
from chaosdrill.engine.lanes import LANES, aligned, as_wide
from chaosdrill.engine.layout import COLUMNS, SETTINGS, WIDTH

matrix = float64[:, ::1]


def all_of_row(rows, s, out):
    """What polynomials of row 1 give at s, the terms from order 5 on last."""
    out[0] = polynomial.value(rows, 1, s)
    out[1] = polynomial.derivative(rows, 1, s)
    out[2] = polynomial.size(rows, 1, s)
    out[3] = 1.0 if polynomial.keeps_side(rows, 1, s, 1.0) else 0.0
    out[4] = polynomial.late_size(rows, 1, s, 5)


def applied(function, x):
    """The compiled function of every row of lanes of x, shape (rows, 8)."""

    @numba.njit(void(matrix, matrix).real, error_model="numpy")
    def over_rows(given, out):
        source, target = row_of(given), row_of(out)
        for i in range(given.shape[0]):
            target[i] = function(source[i])

    given, out = aligned(*x.shape), aligned(*x.shape)
    given[:] = x
    over_rows(given, out)
    return out


def random(low, high, rows=2000):
    return np.random.default_rng(5).uniform(low, high, (rows, LANES))


@pytest.mark.parametrize("symbol", [operator.add, operator.sub, operator.mul, operator.truediv])
def test_a_number_stands_for_eight(symbol):
    x = random(1.0, 2.0, 3)
    np.testing.assert_array_equal(applied(numba.njit(lambda v: symbol(v, 3)), x), symbol(x, 3.0))
    np.testing.assert_array_equal(applied(numba.njit(lambda v: symbol(0.5, v)), x), symbol(0.5, x))


def test_larger_magnitude_and_choice():
    x = random(-1.0, 1.0, 3)
    np.testing.assert_array_equal(applied(numba.njit(lambda v: larger(v, 0.25)), x), np.maximum(x, 0.25))
    np.testing.assert_array_equal(applied(numba.njit(lambda v: magnitude(-v)), x), np.abs(x))
    choice = applied(numba.njit(lambda v: chosen(v > 0.0, v, -1.0 * v)), x)
    np.testing.assert_array_equal(choice, np.abs(x))


@numba.njit(error_model="numpy")
def over(a, b, size):
    return a / size, b / size


def told(settings, series, scale, weights, metric, out, bounds, row):
    """A step of two states and a tangent, which stand in rows 0 to 3, of one run or of eight."""
    for i in range(2):
        metric[i] = as_wide(np.inf, out[0])
    h = taylor.length(over, series, 2, 1, 2, settings, out[0], scale, weights, metric, row)
    taylor.follow(series, 2, scale, h)
    sure = taylor._has_no_gap(series, 2, settings.order, h / settings.reach, weights)
    out[0] = h
    out[1] = chosen(sure, 1.0, 0.0)
    out[2] = chosen(records.within(scale, 2, bounds), 1.0, 0.0)


tell = numba.njit(told, error_model="numpy")


def of_one(settings, series, numbers, bounds, row):
    tell(settings[0], series, numbers[0], numbers[1], numbers[2], numbers[3], bounds, row)


def of_eight(settings, series, scale, weights, metric, out, bounds, row):
    rows = row_of(scale), row_of(weights), row_of(metric), row_of(out)
    tell(settings[0], table_of(series), rows[0], rows[1], rows[2], rows[3], bounds, row)


def test_a_step_of_eight_is_the_step_of_each():
    """Length, sizes, gaps and bounds of eight runs are those of each by itself, to the bit, whatever it meets."""
    random = np.random.default_rng(3)
    records_type, cube = Array(RecordOf(SETTINGS), 1), float64[:, :, ::1]
    one = compiled(void(records_type, matrix, matrix, matrix, float64[::1]))(of_one)
    eight = compiled(void(records_type, cube, *[matrix] * 5, float64[::1]))(of_eight)
    settings, row = np.zeros(1, SETTINGS), np.zeros(COLUMNS)
    settings["order"], settings["tolerance"], settings["reach"] = 19, 1e-10, 0.25
    bounds = np.array([[-1.0, -1.0], [3.0, 3.0]])
    gaps, beyond = set(), set()
    for _ in range(40):
        series = aligned(4, COLUMNS, LANES)
        falls = 0.6 ** np.arange(20)[:, None] * random.choice([1.0, 1e-9], (4, 20, LANES), p=[0.8, 0.2])
        series[:, :20] = random.normal(size=(4, 20, LANES)) * falls
        # states at rest, in motion from rest, and of which a term is no number
        series[0, :, 1] = series[1, 1:, 2] = series[1, 0, 3] = 0.0
        series[1, 19, 4], series[0, 19, 5] = np.nan, np.inf
        found = [aligned(2, LANES), aligned(2, LANES), aligned(2, LANES), aligned(3, LANES)]
        found[0][:] = random.choice([0.0, 1.0, 4.0], (2, LANES))
        found[3][0] = 2.0
        alone = np.zeros((LANES, 4, 3))
        for lane in range(LANES):
            alone[lane, 0, :2], alone[lane, 3, 0] = found[0][:, lane], 2.0
            one(settings, np.ascontiguousarray(series[:, :, lane]), alone[lane], bounds, row)
        eight(settings, series, *found, bounds, row)
        for i, numbers in enumerate(found):
            np.testing.assert_array_equal(numbers, alone[:, i, : len(numbers)].T)
        assert np.isnan(found[3][0]).tolist() == [False] * 4 + [True] * 2 + [False] * 2
        gaps |= set(found[3][1])
        beyond |= set(found[3][2])
    assert gaps == beyond == {0.0, 1.0}


def test_eight_coefficients_of_a_row_at_once():
    """Values and sums of sizes as numpy's Horner rule has them, in the row that is named and in no other."""
    rows = np.zeros((3, COLUMNS))
    rows[:, :WIDTH] = np.random.default_rng(6).uniform(-1.0, 1.0, (3, WIDTH))
    rows[:, WIDTH:] = np.nan
    row = rows[1, WIDTH - 1 :: -1]

    fill = compiled(void(matrix, float64, float64[::1]))(all_of_row)

    def found(rows, s):
        out = np.zeros(5)
        fill(rows, s, out)
        return out[[0, 2, 4, 3]]

    for s in (0.0, 1e-3, 0.7, 1.3):
        late = np.polyval(np.abs(rows[1, 5:13])[::-1], s)
        value, size = np.polyval(row, s), np.polyval(np.abs(row), s)
        np.testing.assert_allclose(found(rows, s)[:3], [value, size, late], rtol=0, atol=1e-14 * size)
    rows[1, 0] = -1.0
    for highest, keeps in ((0.99, 1.0), (1.01, 0.0)):
        rows[1, 1:WIDTH] = np.where(np.arange(1, WIDTH) == 17, highest, -1.0)
        assert found(rows, 1.0)[3] == keeps


@pytest.fixture
def shorter_registers(monkeypatch):
    """Code is compiled for this processor without its registers of eight doubles."""
    features = llvm.get_host_cpu_features()
    features.update({name: False for name in features if name.startswith(("avx512", "avx10", "evex"))})
    machine._target.cache_clear()
    monkeypatch.setattr(machine, "processor", lambda: ("x86-64", features.flatten()))
    yield
    monkeypatch.undo()
    machine._target.cache_clear()


def test_bits_do_not_tell_how_long_registers_are(request):
    """Products are rounded before the halves of a register are added, whether or not the halves are registers."""
    rows = np.random.default_rng(7).uniform(-1.0, 1.0, (3, COLUMNS))
    points = np.random.default_rng(8).uniform(0.1, 1.0, 200)

    def all_values():
        fill, out = compiled(void(matrix, float64, float64[::1]))(all_of_row), np.zeros((len(points), 5))
        for s, line in zip(points, out, strict=True):
            fill(rows, s, line)
        return out

    here = all_values()
    for s, late in zip(points, here[:, -1], strict=True):
        s2 = s * s
        powers = np.array([1.0, s, s2, s2 * s, s2 * s2, s * (s2 * s2), s2 * (s2 * s2), s * s2 * (s2 * s2)])
        terms = np.abs(rows[1, 5:13]) * powers
        while len(terms) > 1:
            terms = terms[: len(terms) // 2] + terms[len(terms) // 2 :]
        assert late == terms[0]
    request.getfixturevalue("shorter_registers")
    np.testing.assert_array_equal(all_values(), here)

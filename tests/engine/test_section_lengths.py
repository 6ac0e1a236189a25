"""Lengths that points of a section count: where each run ends, and that no run feels its neighbours or the stretches.

Beats whose intervals grow by a factor: their times, states and tangents are geometric series.
"""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.engine.batch import Batch, Returns
from chaosdrill.engine.numerics import Numerics

SLOWER = 0.9
UNIT, LONGEST = 0.37, 2.0
CELL = np.ceil(LONGEST / UNIT) * UNIT
TRANSIENT, ENDS = 4, np.array([0, 3, 3, 8])
RATES = np.linspace(0.31, 2.2, 43)
METHODS = ["taylor", "dop853"]


@pytest.fixture(scope="module")
def beats():
    """x goes from 0 to 1 at the rate z, which every beat lowers; ticks of y are no points."""
    return cd.HybridSystem(
        name="beats",
        states="x z y",
        parameters={"p": 1.0},
        modes={"on": {"x": "z", "z": "0", "y": "p*0.83"}},
        transitions=[
            cd.Transition("beat", "on", "on", guard="x - 1", direction=+1, reset={"x": "0", "z": f"{SLOWER}*z"}),
            cd.Transition("tick", "on", "on", guard="y - 1", direction=+1, reset={"y": "0"}),
        ],
        initial={"x": 0.0, "z": 1.0, "y": 0.0},
        quadratures={"travelled": "x"},
    )


def batch(beats, rates=RATES, method="taylor", after=False, window=6):
    starts = np.column_stack([np.zeros_like(rates), rates, np.zeros_like(rates)])
    return Batch(
        beats,
        {"p": rates},
        starts,
        np.zeros(len(rates), dtype=np.int64),
        Numerics(method, 1e-12),
        tangents=np.eye(3)[:2],
        section={0},
        window=window,
        unit=UNIT,
        returns=Returns(LONGEST, after=after),
    )


def beat_times(rate, count):
    return np.cumsum(SLOWER ** -np.arange(count) / rate)


def ends_early(times):
    """Whether a whole cell passes without a beat before the last of them."""
    met = np.unique(times // CELL)
    return not np.array_equal(met, np.arange(met.size))


def results(b, p):
    arrays = (b.x, b.mode, b.times, b.sums, b.window, b.counts, b.grazing, b.integrals, b.length, b.outcome)
    return [a[p].tobytes() for a in arrays]


@pytest.mark.parametrize("method", METHODS)
def test_a_run_ends_where_a_whole_cell_has_no_point(beats, method):
    count = TRANSIENT + ENDS[-1]
    expected = [ends_early(beat_times(rate, count)) for rate in RATES]
    assert 5 < sum(expected) < len(RATES) - 5
    in_transient = [ends_early(beat_times(rate, TRANSIENT)) for rate in RATES[expected]]
    assert any(in_transient)
    assert not all(in_transient)
    b = batch(beats, method=method)
    b.run(TRANSIENT, ENDS)
    np.testing.assert_array_equal(b.outcome == Outcome.NO_RETURN, expected)
    assert (b.outcome[~np.array(expected)] == Outcome.OK).all()
    for values in (b.times, b.length, b.sums, b.integrals, b.window):
        assert np.isnan(values[expected]).all()


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("method", METHODS)
def test_blocks_end_at_points(beats, method, after):
    b = batch(beats, method=method, after=after)
    b.run(TRANSIENT, ENDS)
    going = np.flatnonzero(b.outcome == Outcome.OK)
    count = TRANSIENT + ENDS[-1]
    times = np.array([beat_times(rate, count) for rate in RATES[going]])
    lengths = times[:, TRANSIENT - 1 + ENDS] - times[:, [TRANSIENT - 1]]
    np.testing.assert_allclose(b.times[going], lengths, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(b.length, b.times[:, -1])
    # of every interval the mean of x is a half, and both tangents shrink by the factor at its end
    np.testing.assert_allclose(b.integrals[going, :, 0], lengths / 2, rtol=0, atol=1e-11)
    np.testing.assert_allclose(
        b.sums[going].sum(axis=2), np.broadcast_to(2 * ENDS * np.log(SLOWER), lengths.shape), rtol=0, atol=1e-11
    )
    np.testing.assert_array_equal(b.counts[going, 0], ENDS[-1])
    points = np.arange(count - 6, count)
    np.testing.assert_allclose(b.window[going, :, 0], 0.0 if after else 1.0, rtol=0, atol=1e-13)
    lowered = np.outer(RATES[going], SLOWER ** (points + after))
    np.testing.assert_allclose(b.window[going, :, 1], lowered, rtol=1e-13)
    np.testing.assert_array_equal(b.window[going, :, 3], 0)
    np.testing.assert_array_equal(b.x[going, 0], 0.0)


@pytest.mark.parametrize("method", METHODS)
def test_no_run_feels_its_neighbours(beats, method):
    whole = batch(beats, method=method)
    whole.run(TRANSIENT, ENDS)
    for first in range(0, len(RATES), 5):
        part = batch(beats, RATES[first : first + 5], method)
        part.run(TRANSIENT, ENDS)
        for p in range(len(part.x)):
            assert results(part, p) == results(whole, first + p)
    backward = batch(beats, RATES[::-1], method)
    backward.run(TRANSIENT, ENDS)
    for p in range(len(RATES)):
        assert results(backward, len(RATES) - 1 - p) == results(whole, p)


@pytest.mark.parametrize("method", METHODS)
def test_no_step_depends_on_the_stretches(beats, method):
    whole, parts = batch(beats, method=method), batch(beats, method=method)
    whole.run(0, np.array([0, 12]))
    parts.run(3, np.array([0, 2, 5]))
    parts.proceed(np.flatnonzero(parts.outcome == Outcome.OK), 0, np.array([0, 1, 4]))
    np.testing.assert_array_equal(parts.outcome, whole.outcome)
    going = whole.outcome == Outcome.OK
    np.testing.assert_array_equal(parts.x[going], whole.x[going])
    np.testing.assert_array_equal(parts.window[going, :4], whole.window[going, 2:])


def test_points_may_be_counted_and_not_kept(beats):
    kept, bare = batch(beats), batch(beats, window=0)
    kept.run(TRANSIENT, ENDS)
    bare.run(TRANSIENT, ENDS)
    np.testing.assert_array_equal(bare.x, kept.x)
    np.testing.assert_array_equal(bare.times, kept.times)

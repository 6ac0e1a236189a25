"""Standard errors against closed forms: how often intervals hold the truth, and how wide they are."""

import numpy as np
import pytest
from scipy import stats

import chaosdrill as cd
from chaosdrill.analysis.judgement import statistics
from chaosdrill.analysis.judgement.statistics import standard_error

SERIES = 2000


def noise(blocks, correlation, series=SERIES, seed=1):
    """Gaussian noise of variance 1 whose correlation decays as exp(-k/correlation)."""
    generator = np.random.default_rng(seed)
    factor = np.exp(-1 / correlation) if correlation else 0.0
    values = generator.normal(size=(blocks, series))
    values[1:] *= np.sqrt(1 - factor**2)
    for k in range(1, blocks):
        values[k] += factor * values[k - 1]
    return values


def exact(blocks, correlation):
    """Standard deviation of the mean of that noise."""
    factor = np.exp(-1 / correlation) if correlation else 0.0
    k = np.arange(1, blocks)
    return np.sqrt((1 + 2 * np.sum((1 - k / blocks) * factor**k)) / blocks)


def coverage(values, truth=0.0):
    return np.mean(np.abs(values.mean(axis=0) - truth) <= 1.96 * standard_error(values))


@pytest.mark.parametrize("blocks", [32, 64, 256])
@pytest.mark.parametrize("correlation", [0, 0.2, 1, 5])
def test_intervals_cover(blocks, correlation):
    """Over 32 blocks, 5 of which are one correlation time, a bar that takes blocks for independent covers 44 %."""
    assert 0.9 <= coverage(noise(blocks, correlation)) <= 0.98


@pytest.mark.parametrize("blocks", [32, 64, 256])
@pytest.mark.parametrize(("correlation", "widest"), [(0, 1.4), (0.2, 1.4), (1, 1.4), (5, 1.8)])
def test_bars_are_not_much_wider_than_they_must_be(blocks, correlation, widest):
    bars = standard_error(noise(blocks, correlation, seed=2))
    assert 1 < np.median(bars) / exact(blocks, correlation) < widest


def test_a_correlation_of_a_third_of_the_record_makes_the_bar_grow():
    values = noise(32, 10, seed=3)
    plain = values.std(axis=0, ddof=1) / np.sqrt(32)
    assert np.mean(np.abs(values.mean(axis=0)) <= 1.96 * plain) < 0.4
    assert coverage(values) > 0.85


@pytest.mark.parametrize(("part", "correlation"), [(0.5, 10), (0.4, 20)])
def test_slow_motion_is_seen_beneath_faster_noise(part, correlation):
    """Neighbours are correlated by 0.2 at most, yet most of the variance of the mean comes from the slow motion."""
    values = part * noise(256, correlation, seed=4) + noise(256, 0, seed=5)
    assert 0.9 <= coverage(values) <= 0.98


@pytest.mark.parametrize("blocks", [16, 32, 256])
def test_blocks_that_cancel_each_other(blocks):
    """Growth that only goes up and down, as along a flow: the mean is that of the ends, over the length."""
    ends = np.random.default_rng(6).normal(size=(blocks + 1, SERIES))
    values = np.diff(ends, axis=0)
    assert coverage(values) >= 0.9
    assert np.median(standard_error(values)) < 2.7 * np.sqrt(2) / blocks


def test_blocks_of_alternating_sign():
    """First-order autoregression with the coefficient -0.6: the mean is four times as certain as of free blocks."""
    generator = np.random.default_rng(7)
    values = generator.normal(size=(256, SERIES))
    values[0] /= 0.8
    for k in range(1, 256):
        values[k] -= 0.6 * values[k - 1]
    assert 0.9 <= coverage(values) <= 0.98
    assert np.median(standard_error(values)) < 1.4 / 1.6 / 16


def test_intermittent_map():
    """x -> abs(1 - 2 sqrt(x)) keeps all of (0, 1) equally likely: exponent 1/2, laminar phases without a variance."""
    x = np.random.default_rng(8).uniform(size=1000)
    rates = np.zeros((256, 1000))
    for k in range(256 * 32):
        rates[k // 32] -= np.log(x) / 64
        x = np.abs(1 - 2 * np.sqrt(x))
    assert 0.9 <= coverage(rates, 0.5) <= 0.98


def test_a_transient_that_has_not_died_out_is_inside():
    """Its whole effect on the mean is its sum over the number of blocks."""
    for decay in (0.1, 0.5, 0.8):
        values = decay ** np.arange(64)
        assert abs(values.mean()) <= 1.96 * standard_error(values)


@pytest.mark.parametrize("blocks", range(2, 6))
def test_few_blocks_are_taken_for_independent(blocks):
    values = noise(blocks, 0, seed=9)
    plain = values.std(axis=0, ddof=1) / np.sqrt(blocks)
    ratio = stats.t.ppf(0.975, blocks - 1) / stats.norm.ppf(0.975)
    np.testing.assert_allclose(standard_error(values), ratio * plain, rtol=1e-6)
    assert 0.93 <= coverage(values) <= 0.97


def test_quantiles():
    freedom = np.arange(1, statistics._FREQUENCIES[1] + 1)
    np.testing.assert_allclose(statistics._STUDENT, stats.t.ppf(0.975, freedom), rtol=1e-6)
    assert pytest.approx(stats.norm.ppf(0.975), rel=1e-6) == statistics._NORMAL


@pytest.mark.parametrize("blocks", [2, 7, 33, 64, 100])
def test_scale_offset_order_and_company_do_not_matter(blocks):
    values = noise(blocks, 2, series=12, seed=10)
    bars = standard_error(values)
    np.testing.assert_allclose(standard_error(-1e6 * values), 1e6 * bars, rtol=1e-12)
    np.testing.assert_allclose(standard_error(values + 1e3), bars, rtol=1e-9)
    np.testing.assert_allclose(standard_error(values[::-1]), bars, rtol=1e-12)
    np.testing.assert_array_equal(standard_error(values.reshape(blocks, 3, 4)), bars.reshape(3, 4))
    np.testing.assert_array_equal([standard_error(column) for column in values.T], bars)


@pytest.mark.parametrize("blocks", [0, 1])
def test_fewer_than_two_blocks_have_no_error(blocks):
    assert np.isnan(standard_error(np.ones((blocks, 2)))).all()


@pytest.mark.parametrize("blocks", [2, 20, 256])
def test_equal_blocks_have_no_error_and_missing_ones_no_number(blocks):
    rates = np.tile([5.0, np.nan, 5.0], (blocks, 1))
    rates[0, 2] = np.nan
    np.testing.assert_array_equal(standard_error(rates), [0.0, np.nan, np.nan])


def test_errors_of_short_records_stay_with_their_exponents():
    """A clock makes one exponent 0 at every step; those of the circuit were given its error, 3e-9, in some records."""
    lengths = {"duration": 0.2, "transient": 0.2}
    found = cd.basins(cd.build("buck-converter"), {"v": [11.8, 12.0], "i": [0.5, 0.6]}, **lengths)
    exponents, errors = (found[name].values for name in ("attractor_exponent", "attractor_error"))
    assert len(exponents) > 1
    assert (errors < 1e-6).any()
    assert ((errors < 1e-6) == (abs(exponents) < 1e-6)).all()

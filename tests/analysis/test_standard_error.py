"""Standard errors against closed forms: white noise, and an autoregressive process whose blocks are correlated."""

import numpy as np
import pytest

from chaosdrill.analysis.statistics import standard_error


def autoregressive(phi, count, series, seed):
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(count, series))
    values = np.empty_like(noise)
    values[0] = noise[0] / np.sqrt(1 - phi**2)
    for k in range(1, count):
        values[k] = phi * values[k - 1] + noise[k]
    return values


def exact(phi, count):
    """Standard deviation of the mean of an AR(1) process with unit innovations."""
    variance = 1 / (1 - phi**2)
    k = np.arange(1, count)
    return np.sqrt(variance / count * (1 + 2 * np.sum((1 - k / count) * phi**k)))


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.8, 0.9])
def test_correlated_blocks(phi):
    """Near the truth on average: blocks of 64 miss a little of the slowest, the largest of several errs upward."""
    errors = standard_error(autoregressive(phi, 1024, 400, seed=3))
    assert 0.9 < errors.mean() / exact(phi, 1024) < 1.35


def test_the_naive_error_would_be_too_small():
    values = autoregressive(0.9, 1024, 400, seed=4)
    naive = (values.std(axis=0, ddof=1) / np.sqrt(1024)).mean()
    assert naive < exact(0.9, 1024) / 4
    assert standard_error(values).mean() > 0.9 * exact(0.9, 1024)


def test_three_errors_cover_the_mean():
    values = autoregressive(0.7, 512, 1000, seed=5)
    outside = np.abs(values.mean(axis=0)) > 3 * standard_error(values)
    assert outside.mean() < 0.01


def test_few_blocks_give_the_plain_error():
    rates = np.array([1.0, 2.0, 4.0, 9.0])
    assert standard_error(rates) == pytest.approx(np.sqrt(38 / 3 / 4), rel=1e-14)


def test_merging_stops_at_sixteen_blocks():
    """Blocks that alternate by pairs of 32: the error of length 2 is the largest, that of length 4 is zero."""
    rates = np.tile([1.0, 1.0, -1.0, -1.0], 16)
    assert standard_error(rates) == pytest.approx(np.sqrt(32 / 31 / 32), rel=1e-14)
    short = np.tile([1.0, 1.0, -1.0, -1.0], 4)[:15]
    assert standard_error(short) == pytest.approx(short.std(ddof=1) / np.sqrt(15), rel=1e-14)


@pytest.mark.parametrize("blocks", [0, 1])
def test_fewer_than_two_blocks_have_no_error(blocks):
    assert np.isnan(standard_error(np.ones((blocks, 2)))).all()


def test_each_column_has_its_own():
    rates = np.array([[1.0, 5.0], [3.0, 5.0]])
    np.testing.assert_allclose(standard_error(rates), [1.0, 0.0])

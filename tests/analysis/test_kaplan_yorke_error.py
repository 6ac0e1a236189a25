"""The error of the Kaplan-Yorke dimension, against maps whose exponents and dimension are known."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.judgement.statistics import kaplan_yorke, kaplan_yorke_error, standard_error

INF = float("inf")


def record(series, blocks=256):
    """Exponents and rates in blocks, of local rates of shape (length, m) in descending order of their means."""
    return series.mean(axis=0), series.reshape(blocks, -1, series.shape[1]).mean(axis=1)


def error_of(series, states=None):
    exponents, rates = record(series)
    return kaplan_yorke_error(exponents, rates, 0.0, float(len(series)), states or len(exponents))[0]


def bakers(rng, p, narrow, wide, length):
    """Local rates of a skew baker's map, whose two strips are visited independently, with chances p and 1 - p."""
    left = rng.random(length) < p
    return np.where(left[:, np.newaxis], [-np.log(p), np.log(narrow)], [-np.log(1 - p), np.log(wide)])


@pytest.mark.parametrize(("p", "narrow", "wide"), [(0.3, 0.2, 0.4), (0.45, 0.05, 0.5), (0.2, 0.1, 0.1)])
def test_intervals_cover_the_dimension_of_bakers_maps(p, narrow, wide):
    rng = np.random.default_rng(34)
    entropy = -p * np.log(p) - (1 - p) * np.log(1 - p)
    truth = 1 + entropy / -(p * np.log(narrow) + (1 - p) * np.log(wide))
    inside = 0
    for _ in range(400):
        series = bakers(rng, p, narrow, wide, 256 * 10)
        inside += abs(kaplan_yorke(series.mean(axis=0), 2) - truth) < 1.96 * error_of(series)
    assert 0.90 <= inside / 400 <= 0.98


def test_exponents_of_constant_sum_err_together():
    rng = np.random.default_rng(1)
    first = 0.42 + 0.5 * rng.normal(size=256 * 20)
    series = np.stack([first, np.log(0.3) - first], axis=1)
    mean, slope = first.mean(), -np.log(0.3) / (np.log(0.3) - first.mean()) ** 2
    alone = float(standard_error(first.reshape(256, -1).mean(axis=1)))
    assert mean > 0.3
    assert error_of(series) == pytest.approx(slope * alone, rel=1e-12)


def test_no_error_where_the_dimension_is_a_whole_number():
    rng = np.random.default_rng(2)
    noise = 0.1 * rng.normal(size=(256 * 20, 2))
    assert error_of(noise - [0.5, 0.8]) == 0.0
    assert error_of(noise + np.array([0.5, 0.2])) == 0.0
    for lost in (noise[:, :1] + 0.5, noise + np.array([0.5, -0.1])):
        exponents, rates = record(lost)
        rates = np.column_stack([rates, np.zeros(len(rates))])
        assert kaplan_yorke_error(np.append(exponents, -INF), rates, 0.0, 5120.0, 3) == (0.0, "")
    assert kaplan_yorke_error(np.array([-INF, -INF]), np.zeros((256, 2)), 0.0, 5120.0, 2) == (0.0, "")


def test_a_sum_that_may_have_either_sign_gives_the_larger_error():
    rng = np.random.default_rng(3)
    noise = rng.normal(size=256 * 20)
    series = np.stack([1.0 + noise, -1.0 - noise + 1e-3 * rng.normal(size=noise.size)], axis=1)
    # a conservative map: 2 on one side, 2 + (L1 + L2) / |L2| on the other
    total = float(standard_error(record(series)[1].sum(axis=1)))
    assert error_of(series) == pytest.approx(total, rel=0.1)
    assert np.isnan(error_of(series[:, :1], states=2))


def test_a_first_exponent_near_zero_has_no_error():
    rng = np.random.default_rng(4)
    assert np.isnan(error_of(0.1 * rng.normal(size=(256 * 20, 2)) - [0.0, 1.0]))
    for exponents, blocks in (([0.5, np.nan], 9), ([0.5, -1.0], 1)):
        error, reason = kaplan_yorke_error(np.array(exponents), np.zeros((blocks, 2)), 0.0, float(blocks), 2)
        assert np.isnan(error)
        assert reason


def test_the_method_counts_on_a_cycle_of_blocks():
    rates = np.tile([0.5, -1.0], (256, 1))
    found, _ = kaplan_yorke_error(np.array([0.5, -1.0]), rates, 1e-6, 1e4, 2)
    assert found == pytest.approx(1e-6 * (1 + 0.5), rel=1e-9)


@pytest.fixture(scope="module")
def henon():
    x, y = sympy.symbols("x y", real=True)
    return cd.Map((x, y), {"a": 1.4, "b": 0.3}, {x: 1 - sympy.Symbol("a") * x**2 + y, y: sympy.Symbol("b") * x})


def test_henon(henon):
    found = cd.lyapunov_spectrum(henon, periods=30_000, transient=1_000)
    first, error = float(found["lyapunov_exponent"][0]), float(found["lyapunov_error"][0])
    # the divergence is ln 0.3 everywhere, so that the dimension is a function of the first exponent alone
    slope = -np.log(0.3) / (np.log(0.3) - first) ** 2
    assert float(found["kaplan_yorke_error"]) == pytest.approx(slope * error, rel=1e-3)
    # from the exponents 0.41922 and -1.62319, Sprott 2003, Chaos and Time-Series Analysis, appendix A
    assert float(found["kaplan_yorke_dimension"]) == pytest.approx(1.25827, abs=4 * float(found["kaplan_yorke_error"]))

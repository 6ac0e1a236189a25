"""Dimension, period and class against sequences and spectra whose answer is known."""

import numpy as np
import pytest

from chaosdrill.analysis.judgement.recurrence import find_period, recurrence
from chaosdrill.analysis.judgement.statistics import free_exponents, kaplan_yorke, leading
from chaosdrill.analysis.judgement.words import Evidence, words
from chaosdrill.dataset import Outcome

INF = float("inf")


@pytest.mark.parametrize(
    ("spectrum", "dimension"),
    [
        ([0.9056, 0.0, -14.572], 2 + 0.9056 / 14.572),
        ([0.5, -1.0], 1.5),
        ([0.5, -0.25, -0.5], 2.5),
        ([-0.1, -0.2], 0.0),
        ([0.0, -1.0], 1.0),
        ([0.3, -INF], 1.0),
        ([0.3, 0.0, -INF, -INF], 2.0),
        ([0.015, -0.088, -INF], 1 + 0.015 / 0.088),
        ([-INF, -INF], 0.0),
        ([0.2, 0.1], 2.0),
        ([0.2, -0.2], 2.0),
        ([0.0, 0.0], 2.0),
    ],
)
def test_dimension_of_kaplan_and_yorke(spectrum, dimension):
    assert kaplan_yorke(np.array(spectrum), len(spectrum)) == pytest.approx(dimension, rel=1e-14)


def test_dimension_is_missing_where_exponents_are():
    assert np.isnan(kaplan_yorke(np.array([0.2]), 3))
    assert np.isnan(kaplan_yorke(np.array([0.2, np.nan]), 2))
    assert np.isnan(kaplan_yorke(np.array([]), 2))
    assert kaplan_yorke(np.array([0.2, -1.0]), 3) == pytest.approx(1.2)


def period_of(points, most):
    """Period of points of which nothing else is known."""
    return find_period(points, np.zeros(points.shape[1]), most)


@pytest.mark.parametrize("period", [1, 2, 3, 5, 8, 16])
def test_period_of_a_repeated_sequence(period):
    rng = np.random.default_rng(period)
    points = np.tile(rng.normal(size=(period, 3)), (200 // period + 1, 1))[:128]
    assert period_of(points, 64) == period


def test_a_period_longer_than_asked_for_is_not_found():
    points = np.tile(np.arange(8.0)[:, None], (16, 1))
    assert period_of(points, 7) == 0
    assert period_of(points, 8) == 8


def test_the_last_half_must_hold_two_periods():
    points = np.tile(np.arange(10.0)[:, None], (4, 1))
    assert period_of(points, 64) == 10
    assert period_of(points[:38], 64) == 0


def test_a_transient_in_the_first_half_does_no_harm():
    points = np.concatenate([np.linspace(5, 1, 50), np.ones(50)])[:, None]
    assert period_of(points, 10) == 1


@pytest.mark.parametrize(("noise", "found"), [(1e-9, 2), (1e-4, 0)])
def test_repetition_is_to_a_millionth(noise, found):
    points = np.tile([1.0, 2.0], 64)[:, None] + noise * np.random.default_rng(0).uniform(-1, 1, (128, 1))
    assert period_of(points, 64) == found


@pytest.mark.parametrize(
    "points", [np.zeros((0, 2)), np.zeros((1, 2)), np.full((10, 1), np.nan), [[0.0], [np.inf]] * 4]
)
def test_no_points_no_period(points):
    assert period_of(np.asarray(points), 4) == 0


@pytest.mark.parametrize("units", [(1.0, 1.0, 1.0), (1e9, 1e-9, 1.0), (1e-12, 1.0, 1e12)])
def test_a_period_does_not_depend_on_units(units):
    """A cycle of three points whose second state is nothing but round-off, and a decaying third."""
    rng, units = np.random.default_rng(3), np.array(units)
    points = np.stack(
        [np.tile([1.0, 2.0, 4.0], 40), 1e-15 * rng.normal(size=120), 1e-14 * 0.9 ** np.arange(120)], axis=1
    )
    window = np.concatenate([points * units, np.zeros((120, 1))], axis=1)[np.newaxis]
    assert recurrence(window, units[np.newaxis], 20).period == 3
    # a small state that moves by itself is no round-off
    window[0, :, 1] = np.tile([1e-12, 2e-12, 1e-12, 1e-12], 30) * units[1]
    assert recurrence(window, [1.0, 1e-12, 1.0] * units[np.newaxis], 20).period == 12


def test_a_chaotic_orbit_has_no_period():
    x = np.empty(400)
    x[0] = 0.3
    for k in range(399):
        x[k + 1] = 4 * x[k] * (1 - x[k])
    assert period_of(x[:, None], 64) == 0


LENGTH = 1000.0
NAN = float("nan")


@pytest.mark.parametrize(
    ("exponents", "errors", "neutral", "outcome"),
    [
        ([0.2, -1.0], [0.01, 0.01], 0, Outcome.CHAOTIC),
        ([0.2, -1.0], [0.1, 0.01], 0, Outcome.CHAOTIC),
        ([0.2, -1.0], [0.3, 0.01], 0, Outcome.UNDECIDED),
        ([0.05, -1.0], [0.04, 0.01], 0, Outcome.UNDECIDED),
        ([-0.2, -1.0], [0.01, 0.01], 0, Outcome.PERIODIC),
        ([1e-3, -1.0], [1e-4, 0.01], 0, Outcome.UNDECIDED),
        ([1e-5, -0.2], [1e-6, 0.01], 1, Outcome.PERIODIC),
        ([0.9, 1e-5, -14.5], [0.01, 1e-6, 0.1], 1, Outcome.CHAOTIC),
        ([1e-5, -1e-5, -0.3], [1e-6, 1e-6, 0.1], 1, Outcome.UNDECIDED),
        ([-0.1, -INF], [0.01, np.nan], 0, Outcome.PERIODIC),
        ([-INF, -INF], [np.nan, np.nan], 0, Outcome.PERIODIC),
        ([0.1, -INF], [np.nan, np.nan], 0, Outcome.CHAOTIC),
        ([NAN, NAN], [NAN, NAN], 0, Outcome.NONFINITE),
        ([0.3, NAN], [0.01, NAN], 1, Outcome.NONFINITE),
        ([INF, -1.0], [NAN, 0.1], 0, Outcome.NONFINITE),
    ],
)
def test_words_by_the_leading_exponent(exponents, errors, neutral, outcome):
    length = np.array([LENGTH])
    lead, margin, _ = leading(np.array([exponents]), np.array([errors]), neutral, length, complete=True)
    assert words(Evidence.of(1, lead=lead, margin=margin, length=length, late=lead)) == outcome


@pytest.mark.parametrize(
    ("exponents", "free"),
    [
        # Lorenz: the exponent that is zero was not among the one computed
        ([0.9], [0.9]),
        ([0.9, 1e-4], [0.9, -INF]),
        # something negative was computed, so the zero was, though it is large as yet
        ([0.9, 0.02, -3.0], [0.9, -3.0, -INF]),
        ([0.9, -0.02, -3.0], [0.9, -3.0, -INF]),
        # shear makes a pair, of which the negative one is no attraction
        ([0.02, -0.02, -3.0], [0.02, -3.0, -INF]),
    ],
)
def test_only_what_was_computed_is_left_out(exponents, free):
    margins = np.full((1, len(exponents)), 4 / LENGTH)
    found = free_exponents(np.array([exponents]), 1, margins, complete=False)
    np.testing.assert_array_equal(found, [free])

"""Measures of a series: maps whose exponents are known, and the message where nolds is missing."""

import math
import sys

import numpy as np
import pytest
from support.discrete import HENON

import chaosdrill as cd
from chaosdrill.analysis.measures.measured import package, parting


@pytest.fixture
def nolds():
    try:
        return package()
    except cd.SettingsError as fault:
        pytest.skip(str(fault))


def logistic(count):
    """A series at r = 4, whose exponent is ln 2 and whose dimension is 1."""
    values = [0.3]
    while len(values) < count:
        values.append(4 * values[-1] * (1 - values[-1]))
    return np.array(values)


@pytest.mark.usefixtures("nolds")
def test_a_series_of_the_logistic_map_has_its_exponent():
    found = cd.series_measures(logistic(1500), embedding=2, followed=6)
    assert float(found["largest_exponent"]) == pytest.approx(math.log(2), abs=0.05)
    # of two numbers of a map of one dimension one is true, the other twice that
    np.testing.assert_allclose(found["lyapunov_exponent"], [2 * math.log(2), math.log(2)], atol=0.02)
    assert float(found["k"]) > 0.9
    assert 0.8 < float(found["dimension"]) < 1.1


def skew_tent(start, count):
    values = [start]
    while len(values) < count:
        values.append(values[-1] / 0.3 if values[-1] < 0.3 else (1 - values[-1]) / 0.7)
    return np.array(values)


@pytest.mark.parametrize("followed", [20, 100, 200])
def test_the_error_of_the_largest_exponent_covers_however_long_neighbours_are_followed(followed):
    """Neighbours that are far apart part no further; a slope over all steps was too small by half, in no interval."""
    exact = -0.3 * math.log(0.3) - 0.7 * math.log(0.7)
    for start in np.linspace(0.1, 0.9, 12):
        series = skew_tent(start, 1000)
        value, error, _ = parting(np.column_stack([series[:-1], series[1:]]), 10, followed)
        assert abs(value - exact) <= 2 * error < 0.2


def test_neighbours_that_show_no_rate_are_told():
    cycle, noise = np.tile(np.eye(2), (300, 1)), np.random.default_rng(1).normal(size=(600, 6))
    for vectors, words in ((cycle, "neighbours coincide"), (noise, "near each other over 0 steps")):
        *numbers, reason = parting(vectors, 10, 20)
        assert np.isnan(numbers).all()
        assert words in reason


@pytest.mark.usefixtures("nolds")
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_exponents_are_not_told_without_their_errors():
    """Half of this series has no neighbours, and errors were NaN beside exponents."""
    found = cd.series_measures(np.append(henon(400), np.full(400, 0.5)), embedding=2)
    assert np.isnan([found["lyapunov_exponent"], found["lyapunov_error"]]).all()
    assert "lyapunov_exponent: no neighbours" in found.attrs["reason"]


@pytest.mark.usefixtures("nolds")
def test_errors_of_the_others_know_how_far_neighbours_are():
    found = cd.series_measures(henon(1000), embedding=2)
    value, error = (float(found[name][1]) for name in ("lyapunov_exponent", "lyapunov_error"))
    assert abs(value + 1.6232) <= 2 * error < 0.5


@pytest.mark.usefixtures("nolds")
def test_one_state_of_a_section_has_the_exponents_of_the_motion():
    henon = cd.Map(**HENON)
    section = cd.poincare_section(henon, transient=100, periods=2000)
    spectrum = cd.lyapunov_spectrum(henon, transient=100, periods=2000)
    found = cd.series_measures(section["section"].sel(state="x"), embedding=2, followed=6)
    np.testing.assert_allclose(found["lyapunov_exponent"], spectrum["lyapunov_exponent"], rtol=0.1)
    assert abs(float(found["dimension"]) - 1.22) <= 2 * float(found["dimension_error"])
    for step in (0.5, 1e-200):
        other = cd.series_measures(section["section"].sel(state="x"), embedding=2, followed=6, step=step)
        for name in ("largest_exponent", "largest_error", "lyapunov_exponent", "lyapunov_error"):
            np.testing.assert_allclose(step * other[name], found[name], rtol=1e-12)


@pytest.mark.usefixtures("nolds")
def test_a_rotation_shows_no_chaos():
    found = cd.series_measures(np.cos(2 * np.pi * 0.6180339887 * np.arange(1200)), embedding=3, lag=2)
    assert float(found["k"]) < 0.1
    assert abs(float(found["largest_exponent"])) < 0.02
    assert abs(float(found["dimension"]) - 1) <= 2 * float(found["dimension_error"])


def henon(count):
    values = [0.1, 0.1]
    while len(values) < count + 100:
        values.append(1 - 1.4 * values[-1] ** 2 + 0.3 * values[-2])
    return np.array(values[100:])


@pytest.mark.usefixtures("nolds")
@pytest.mark.parametrize("digits", [2, 3])
def test_rounded_values_have_no_dimension_of_their_steps(digits):
    """Neighbours at one step coincide, and a flat stretch of the sum had the dimension 0 with the error 0."""
    found = cd.series_measures(np.round(henon(2000), digits), embedding=2, followed=6)
    if np.isnan(found["dimension"]):
        assert found.attrs["reason"]
    else:
        assert abs(float(found["dimension"]) - 1.22) <= 3 * float(found["dimension_error"])


@pytest.mark.usefixtures("nolds")
@pytest.mark.parametrize("factor", [1e200, 1e-200])
def test_series_of_any_size(factor):
    plain, other = (cd.series_measures(henon(600) * by, embedding=2, followed=6) for by in (1.0, factor))
    for name in ("largest_exponent", "k", "dimension"):
        np.testing.assert_allclose(other[name], plain[name], rtol=1e-6)


@pytest.mark.usefixtures("nolds")
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_cycle_has_no_infinite_exponent():
    found = cd.series_measures(np.tile([0.0, 1.0], 400), embedding=2)
    assert not np.isinf([found["largest_exponent"], *found["lyapunov_exponent"]]).any()


@pytest.mark.parametrize(
    "values",
    [np.ma.masked_greater(henon(600), 0.9), henon(600) + 1j, henon(600).astype(str)],
    ids=["mask", "i", "text"],
)
def test_what_is_no_real_number_is_refused(values):
    with pytest.raises(cd.SettingsError, match="must be a series of numbers"):
        cd.series_measures(values)


def test_without_the_package_its_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "nolds", None)
    with pytest.raises(cd.SettingsError, match=r"pip install 'chaosdrill\[series\]'"):
        cd.series_measures(logistic(600))


def test_what_is_no_series():
    for values, words in (
        (np.zeros((600, 2)), r"values has the shape \(600, 2\)"),
        (logistic(499), r"values has the shape \(499,\)"),
        (np.full(600, 2.0), "or one number alone"),
        (np.append(logistic(600), np.nan), "not finite"),
        ("text", "values is 'text'"),
    ):
        with pytest.raises(cd.SettingsError, match=words):
            cd.series_measures(values)
    with pytest.raises(cd.SettingsError, match="compared beyond a window of 30, need 646"):
        cd.series_measures(logistic(600), window=30)
    with pytest.raises(cd.SettingsError, match="followed is 3"):
        cd.series_measures(logistic(600), followed=3)
    motion = cd.trajectory(cd.build("lorenz"), times=np.cumsum(np.linspace(0.01, 0.02, 600)), duration=10.0)
    with pytest.raises(cd.SettingsError, match="times at unequal steps"):
        cd.series_measures(motion["states"].sel(state="x"))

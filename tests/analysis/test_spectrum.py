"""Spectra: sum rules that hold exactly, block histories, rates, and what a run that fails leaves."""

from math import log

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.measures import blocks


@pytest.fixture(scope="module")
def impacting():
    return cd.lyapunov_spectrum(cd.build("impact-oscillator"), periods=600, transient=50, blocks=40)


def test_sum_rule_of_the_impact_oscillator(impacting):
    """The flow contracts by -2 zeta a unit of time, every hit by e^2."""
    counts = dict(zip(impacting["transition"].values, impacting["event_count"].values, strict=True))
    length = 600 * 2 * np.pi / 2.5
    expected = -0.1 + 2 * log(0.8) * counts["impact"] / length
    assert float(impacting["lyapunov_exponent"].sum()) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("method", [{"method": "taylor", "tolerance": 1e-8}, {"method": "rk4", "steps": 400}])
def test_sum_rule_at_other_settings(method):
    spectrum = cd.lyapunov_spectrum(cd.build("impact-oscillator", {"e": 0.6}), periods=100, **method)
    expected = -0.1 + 2 * log(0.6) * int(spectrum["event_count"].sum()) / (100 * 2 * np.pi / 2.5)
    assert float(spectrum["lyapunov_exponent"].sum()) == pytest.approx(expected, abs=1e-6)


def test_sum_rule_of_a_smooth_flow(duffing):
    spectrum = cd.lyapunov_spectrum(duffing, periods=200)
    assert float(spectrum["lyapunov_exponent"].sum()) == pytest.approx(-0.25, abs=1e-11)
    assert int(spectrum["event_count"].size) == 0
    assert np.isinf(spectrum["closest_grazing"])


def test_the_history_ends_at_the_exponents(impacting):
    np.testing.assert_array_equal(impacting["lyapunov_history"][-1], impacting["lyapunov_exponent"])
    np.testing.assert_allclose(impacting["block_time"].values, np.arange(15, 601, 15) * 2 * np.pi / 2.5, rtol=1e-13)
    assert np.all(np.diff(impacting["lyapunov_exponent"].values) < 0)


def test_rates_are_counts_over_length(impacting):
    hits = int(impacting["event_count"].sum())
    assert float(impacting["impacts_per_period"]) == pytest.approx(hits / 600, rel=1e-14)
    assert float(impacting["slips_per_period"]) == 0.0
    assert float(impacting["events_per_period"]) == pytest.approx(hits / 600, rel=1e-14)


def test_exponents_of_a_focus(circle):
    spectrum = cd.lyapunov_spectrum(circle.with_parameters(growth=-0.3), periods=100)
    np.testing.assert_allclose(spectrum["lyapunov_exponent"].values, [-0.3, -0.3], rtol=1e-11)
    assert int(spectrum["outcome"]) == cd.Outcome.PERIODIC
    assert float(spectrum["kaplan_yorke_dimension"]) == 0.0
    assert float(spectrum["events_per_period"]) == 0.0


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_exponents_than_states(duffing, count):
    part = cd.lyapunov_spectrum(duffing, periods=50, exponents=count)
    assert part.sizes["exponent"] == count
    whole = cd.lyapunov_spectrum(duffing, periods=50)
    if count:
        # the direction of the first tangent is not the same from the start
        assert float(part["lyapunov_exponent"][0]) == pytest.approx(float(whole["lyapunov_exponent"][0]), abs=0.05)
    assert np.isnan(part["kaplan_yorke_dimension"]) or count == 1


def test_progression_is_the_quadrature_over_the_length(duffing):
    spectrum = cd.lyapunov_spectrum(duffing, periods=7)
    section = cd.poincare_section(duffing, periods=7)
    moved = float(section["section"][-1, 0]) - 0.5
    assert float(spectrum["progression_rate"]) == pytest.approx(moved / (14 * np.pi), rel=1e-8)
    assert float(spectrum["progression_error"]) > 0


@pytest.mark.parametrize("transient", [0, 10])
def test_a_run_that_escapes_has_no_exponents(circle, transient):
    spectrum = cd.lyapunov_spectrum(circle.with_parameters(growth=1.0), periods=10, transient=transient)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED
    assert np.isnan(spectrum["lyapunov_exponent"].values).all()
    assert np.isnan(spectrum["kaplan_yorke_dimension"])
    assert spectrum.sizes["block"] == 10


def test_systems_without_a_period_count_by_time(bouncer):
    spectrum = cd.lyapunov_spectrum(bouncer, duration=10.0, transient=1.0)
    assert "events_per_period" not in spectrum
    hits = int(spectrum["event_count"].sel(transition="hit"))
    assert float(spectrum["impacts_per_time"]) == pytest.approx(hits / 10, rel=1e-12)
    assert float(spectrum["events_per_time"]) == pytest.approx(hits / 10, rel=1e-12)


def test_progress_is_told_at_ends_of_blocks(duffing):
    seen = []
    cd.lyapunov_spectrum(duffing, periods=20, blocks=5, progress=lambda *call: seen.append(call))
    done = [now for now, _, _ in seen]
    assert done == sorted({*done, 20})
    assert {*done} <= {4, 8, 12, 16, 20}
    assert {total for _, total, _ in seen} == {20}


def test_no_bit_depends_on_how_many_blocks_a_call_goes_on(bouncer, monkeypatch):
    at_once = cd.lyapunov_spectrum(bouncer, duration=30.0)
    monkeypatch.setattr(blocks, "HEARD", 0.0)
    one_by_one = cd.lyapunov_spectrum(bouncer, duration=30.0)
    assert one_by_one.equals(at_once)

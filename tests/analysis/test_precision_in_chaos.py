"""In chaos the numerical error of an exponent is apart from the statistical one, and a trajectory has its horizon."""

import numpy as np
import pytest

import chaosdrill as cd

TOLERANCES = np.array([1e-4, 1e-8, 1e-11])


@pytest.fixture(scope="module")
def measured():
    """The impact oscillator with its wall at 0.3: exponent 0.0914(3)."""
    return cd.work_precision(
        cd.build("impact-oscillator"),
        methods=["taylor", "dop853"],
        tolerances=TOLERANCES,
        periods=1000,
        transient=300,
        repeats=1,
    )


def test_the_exponent_and_its_statistical_error(measured):
    value, error = float(measured["lyapunov_exponent"]), float(measured["lyapunov_error"])
    assert 0.002 < error < 0.03
    assert abs(value - 0.0914) < 4 * error


def test_the_numerical_error_falls_with_the_tolerance_far_below(measured):
    error = measured["error"].sel(quantity="exponent").transpose("method", "tolerance").values
    assert np.all(error < 100 * TOLERANCES)
    assert np.all(error[:, 1] < 1e-3 * float(measured["lyapunov_error"]))
    spread = measured["exponent_error_spread"].transpose("method", "tolerance").values
    assert np.all(spread > 0)
    assert np.all(spread < 100 * TOLERANCES)


def test_the_horizon_is_that_of_the_exponent(measured):
    """ln(1e-6/tolerance)/exponent, within what local growth makes of it."""
    expected = np.log(1e-6 / TOLERANCES) / float(measured["lyapunov_exponent"])
    np.testing.assert_allclose(measured["horizon_expected"], expected, rtol=1e-12)
    horizon = measured["horizon"].transpose("method", "tolerance").values
    assert np.all(np.diff(horizon) > 0)
    assert np.all(horizon[:, 2] > 0.5 * expected[2])
    assert np.all(horizon[:, 2] < 2.5 * expected[2])
    # a tolerance wider than the target is lost within a few periods
    assert np.all(horizon[:, 0] < 10 * float(measured["forcing_period"]))


def test_there_is_no_cycle_and_no_multiplier(measured):
    assert int(measured["period"]) == 0
    assert np.isnan(measured["error"].sel(quantity="multiplier")).all()
    assert np.isfinite(measured["error"].sel(quantity="tangent")).all()


def test_advice_tells_of_both_limits(measured):
    lines = measured.attrs["recommendation"].splitlines()
    assert any("the length of the run limits its digits" in line for line in lines)
    assert any(line.startswith("a single trajectory can be trusted") for line in lines)

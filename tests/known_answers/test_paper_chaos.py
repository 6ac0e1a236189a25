"""The paper's chaos, eta = 0.448 at xi = 0.06, in the reduced and in the five-dimensional form."""

import numpy as np
import pytest

import chaosdrill as cd

KNOWN, ERRORS = [0.01510, -0.08792], [1e-5, 1e-5]


@pytest.fixture(scope="module")
def reduced():
    return cd.lyapunov_spectrum(cd.drill(eta=0.448), periods=300_000, transient=1000)


@pytest.fixture(scope="module")
def full():
    return cd.lyapunov_spectrum(cd.build("percussive-drill-5d", {"eta": 0.448}), periods=100_000, transient=1000)


def test_exponents(reduced):
    found, error = (reduced[name].values for name in ("lyapunov_exponent", "lyapunov_error"))
    np.testing.assert_array_less(np.abs(found[:2] - KNOWN), 3 * np.hypot(error[:2], ERRORS))
    assert found[2] == -np.inf
    assert error[0] < 1e-3
    assert int(reduced["outcome"]) == cd.Outcome.CHAOTIC


def test_events_and_progression(reduced):
    assert float(reduced["impacts_per_period"]) == pytest.approx(0.7742, abs=3e-3)
    assert float(reduced["events_per_period"]) == pytest.approx(2.351, abs=6e-3)
    assert float(reduced["progression_rate"]) == pytest.approx(0.0048, abs=2e-4)


def test_dimension_survives_minus_infinity(reduced):
    first, second = reduced["lyapunov_exponent"].values[:2]
    assert float(reduced["kaplan_yorke_dimension"]) == pytest.approx(1 + first / abs(second), rel=1e-12)


def test_five_dimensions_add_two_structural_zeros(full):
    found, error = (full[name].values for name in ("lyapunov_exponent", "lyapunov_error"))
    assert np.abs(found[1:3]).max() < 1e-9
    assert abs(found[0] - KNOWN[0]) < 3 * np.hypot(error[0], ERRORS[0])
    assert abs(found[3] - KNOWN[1]) < 3 * np.hypot(error[3], ERRORS[1])
    assert found[4] == -np.inf


@pytest.mark.parametrize("eta", [0.8, 0.6, 0.63])
def test_five_dimensions_keep_the_exponents_of_a_cycle(eta):
    small = cd.lyapunov_spectrum(cd.drill(eta=eta), periods=2000, transient=400)["lyapunov_exponent"].values
    large = cd.lyapunov_spectrum(cd.build("percussive-drill-5d", {"eta": eta}), periods=2000, transient=400)
    large = large["lyapunov_exponent"].values
    assert np.abs(large[:2]).max() < 1e-9
    # of a complex pair the run fixes the mean; how it splits depends on the frame in which it ends
    assert large[2:4].mean() == pytest.approx(small[:2].mean(), abs=1e-9)
    if eta == 0.63:
        np.testing.assert_allclose(large[2:4], small[:2], atol=1e-9)
    assert large[4] == small[2] == -np.inf

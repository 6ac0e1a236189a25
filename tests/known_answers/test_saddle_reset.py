"""Saddle with a tripling reset: the spectrum is ln 3, 0 and -0.7 per unit time."""

from math import log, sqrt

import numpy as np
import pytest

import chaosdrill as cd


@pytest.fixture(scope="module")
def spectrum():
    return cd.lyapunov_spectrum(cd.build("saddle-reset"), duration=200_000, transient=100)


def test_stretching_is_ln_3_within_its_error_bar(spectrum):
    value, error = (float(spectrum[name][0]) for name in ("lyapunov_exponent", "lyapunov_error"))
    assert abs(value - log(3)) < 3 * error
    # times between returns are -ln x, of mean 1; their variances and covariances under x := 3x mod 1 add up to 2.42
    right = log(3) * sqrt(2.42 / 200_000)
    assert right / 2 < error < 2 * right


def test_flow_direction_neither_grows_nor_decays(spectrum):
    # what is left is the change of |F| over the whole run, divided by its length
    assert abs(float(spectrum["lyapunov_exponent"][1])) < 1e-4


def test_driven_coordinate_decays_at_its_rate(spectrum):
    assert float(spectrum["lyapunov_exponent"][2]) == pytest.approx(-0.7, abs=1e-12)


def test_the_return_map_triples_in_time_minus_ln_x():
    run = cd.trajectory(cd.build("saddle-reset"), duration=2000, samples=2)
    x, times = run["event_state_after"].values[:, 0], run["event_time"].values
    assert len(x) > 1500
    np.testing.assert_allclose((x[1:] - 3 * x[:-1] + 0.5) % 1, 0.5, atol=1e-11)
    np.testing.assert_allclose(np.diff(times), -np.log(x[:-1]), atol=1e-11)

"""Impact oscillator with its wall at 0.3: exponents, and the sum rule that they must obey."""

from math import log, pi

import numpy as np
import pytest

import chaosdrill as cd


@pytest.fixture(scope="module")
def spectrum():
    return cd.lyapunov_spectrum(cd.build("impact-oscillator"), periods=300_000, transient=1000)


def test_exponents(spectrum, agrees):
    assert agrees(spectrum, [0.0914, -0.3190], [3e-4, 3e-4])
    assert float(spectrum["lyapunov_error"][0]) < 1e-3


def test_sum_is_damping_and_impacts(spectrum):
    impacts = float(spectrum["impacts_per_period"]) * 2.5 / (2 * pi)
    total = float(spectrum["lyapunov_exponent"].sum())
    assert total == pytest.approx(-0.1 + 2 * log(0.8) * impacts, abs=1e-9)


def test_outcome_is_chaos(spectrum):
    assert int(spectrum["outcome"]) == cd.Outcome.CHAOTIC


def test_fixed_steps_with_bisection_agree(agrees):
    # the paper's method: its exponents are only as good as its statistics here
    spectrum = cd.lyapunov_spectrum(
        cd.build("impact-oscillator"), periods=10_000, transient=500, method="rk4", steps=200, tolerance=1e-10
    )
    assert agrees(spectrum, [0.0914, -0.3190], [3e-4, 3e-4])
    assert np.all(spectrum["lyapunov_error"].values < 5e-3)

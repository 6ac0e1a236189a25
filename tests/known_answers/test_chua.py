"""Chua's circuit, piecewise linear: its field is continuous, so the breaks add nothing."""

import pytest

import chaosdrill as cd


@pytest.mark.parametrize(
    ("alpha", "beta", "known", "errors"),
    [
        (9.0, 100 / 7, [0.3268, 0.0, -2.523], [9e-4, 1e-3, 3e-3]),
        (15.6, 28.0, [0.4313, 0.0, -4.222], [1.2e-3, 1e-3, 2e-3]),
    ],
)
def test_exponents(alpha, beta, known, errors, agrees):
    system = cd.build("chua", {"alpha": alpha, "beta": beta})
    spectrum = cd.lyapunov_spectrum(system, duration=20_000, transient=500)
    assert agrees(spectrum, known, errors)
    assert float(spectrum["lyapunov_error"][0]) < 1e-2
    assert abs(float(spectrum["lyapunov_exponent"][1])) < 1e-3
    assert int(spectrum["outcome"]) == cd.Outcome.CHAOTIC

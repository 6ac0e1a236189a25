"""Lorenz and Rössler: smooth flows, the first of them with a constant divergence."""

import pytest

import chaosdrill as cd

CASES = [
    ("lorenz", [0.9056, 0.0, -14.572], [2e-4, 1e-4, 5e-4], 10_000),
    ("roessler", [0.0718, 0.0, -5.3945], [3e-4, 1e-4, 3e-3], 20_000),
]


@pytest.mark.parametrize(("name", "known", "errors", "duration"), CASES)
def test_exponents(name, known, errors, duration, agrees):
    spectrum = cd.lyapunov_spectrum(cd.build(name), duration=duration, transient=200)
    assert agrees(spectrum, known, errors)
    assert abs(float(spectrum["lyapunov_exponent"][1])) < 1e-3
    assert float(spectrum["lyapunov_error"][0]) < 5e-3


def test_sum_is_the_divergence_of_the_lorenz_flow():
    spectrum = cd.lyapunov_spectrum(cd.build("lorenz"), duration=200, transient=20)
    assert float(spectrum["lyapunov_exponent"].sum()) == pytest.approx(-(10 + 1 + 8 / 3), abs=1e-9)


def test_dimension_of_the_lorenz_attractor():
    spectrum = cd.lyapunov_spectrum(cd.build("lorenz"), duration=5000, transient=200)
    assert float(spectrum["kaplan_yorke_dimension"]) == pytest.approx(2.0621, abs=2e-3)

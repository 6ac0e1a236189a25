"""A whole exponent is whole however it is written: x**2.0 has a series at x = 0, x**1.5 has none, x**0.0 is 1."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.model.special import positive_power

X = sympy.Symbol("x", real=True)
ORDER = 8


@pytest.mark.parametrize("power", [sympy.Pow, positive_power])
@pytest.mark.parametrize("exponent", [2, 2.0, 3.0, 1.0, 0, 0.0])
def test_series_at_zero(power, exponent):
    """x' = 1 + x^m from 0: x = s + s^(m + 1)/(m + 1) + ... (x = e^s - 1 for m = 1, 2 s for m = 0)."""
    system = cd.HybridSystem(name="power", states=(X,), parameters={}, modes={"on": {X: 1 + power(X, exponent)}})
    ws = np.zeros((kernels_of(system).rows, COLUMNS))
    kernels_of(system).functions[0](0, ORDER, 0.0, np.zeros(1), np.array([0.0]), ws)
    m = int(exponent)
    found = ws[0, : m + 2]
    expected = np.zeros(m + 2)
    expected[1] = 1.0
    expected[m + 1] += 1 / (m + 1)
    np.testing.assert_allclose(found, expected, rtol=1e-15)


@pytest.mark.parametrize("exponent", [0, 0.0, 1, 1.0, 2.0, 1.5, -1, -1.0])
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_tangents_of_a_literal_exponent(method, exponent):
    """x' = -x^m: a tangent grows as x' does, by m ln(x1/x0) over a time of 1."""
    field = {X: -positive_power(X, exponent)}
    system = cd.HybridSystem(
        name="decay", states=(X,), parameters={}, modes={"on": field}, initial={"mode": "on", X: 2.0}
    )
    end = {0.0: 1.0, 1.0: 2 * np.exp(-1), 2.0: 2 / 3, 1.5: (2**-0.5 + 0.5) ** -2, -1.0: 2**0.5}[float(exponent)]
    found = cd.lyapunov_spectrum(system, duration=1.0, transient=0.0, method=method)["lyapunov_exponent"].values
    assert found == pytest.approx([exponent * np.log(end / 2.0)], abs=1e-9)

"""A whole exponent is whole however it is written: x**2.0 has a series at x = 0, where x**1.5 has none."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen.source import write_source
from chaosdrill.engine.layout import COLUMNS

X = sympy.Symbol("x", real=True)
ORDER = 8


@pytest.mark.parametrize("exponent", [2, 2.0, 3.0, 1.0])
def test_series_at_zero(interpreted, exponent):
    """x' = 1 + x^m from 0: x = s + s^(m + 1)/(m + 1) + ... (x = e^s - 1 for m = 1)."""
    system = cd.HybridSystem(name="power", states=(X,), parameters={}, modes={"on": {X: 1 + X**exponent}})
    source = write_source(system)
    ws = np.zeros((source.rows, COLUMNS))
    interpreted(source.text)["jet"](0, ORDER, 0.0, np.zeros(1), np.array([0.0]), ws)
    m = int(exponent)
    found = ws[0, : m + 2]
    expected = np.zeros(m + 2)
    expected[1], expected[m + 1] = 1.0, 1 / (m + 1)
    np.testing.assert_allclose(found, expected, rtol=1e-15)

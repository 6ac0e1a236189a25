"""Quadratures whose integrands are harder than the flow are as exact as the states."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd

X, V, T = sympy.symbols("x v t", real=True)


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_integrals_along_a_straight_line(method, tolerance):
    system = cd.HybridSystem(
        name="line",
        states=(X,),
        time=T,
        parameters={},
        modes={"on": {X: 1}},
        quadratures={"waves": sympy.cos(5 * X), "bell": 1 / (1 + X**2), "forced": sympy.sin(3 * T)},
    )
    run = cd.trajectory(system, duration=10.0, samples=10, method=method, tolerance=tolerance)
    expected = {"waves": np.sin(50) / 5, "bell": np.arctan(10), "forced": (1 - np.cos(30)) / 3}
    for name, value in expected.items():
        assert float(run[name][-1]) == pytest.approx(value, abs=50 * tolerance)


def test_an_integral_of_a_high_power_of_an_oscillation():
    system = cd.HybridSystem(
        name="oscillator",
        states=(X, V),
        parameters={},
        modes={"on": {X: V, V: -X}},
        quadratures={"power": V**8, "peaks": 1 / (1 + 30 * X**2)},
        initial={X: 1.0},
    )
    run = cd.trajectory(system, duration=8 * np.pi, samples=4)
    assert float(run["power"][-1]) == pytest.approx(8 * np.pi * 35 / 128, abs=1e-10)
    assert float(run["peaks"][-1]) == pytest.approx(8 * np.pi / np.sqrt(31), abs=1e-10)

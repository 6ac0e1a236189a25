"""Tangents of smooth arcs against two trajectories, and against solutions in closed form."""

import numpy as np
import pytest
import sympy
from scipy.linalg import expm

import chaosdrill as cd
from chaosdrill.engine.layout import METHOD_CODES
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, Y, Z, T, K = sympy.symbols("x y z t k", real=True)
MATRIX = np.array([[-0.2, 1.1, 0.0], [-1.0, -0.3, 0.4], [0.5, 0.0, -0.7]])


@pytest.fixture(scope="module")
def system():
    linear = sympy.Matrix(MATRIX.tolist()) * sympy.Matrix([X, Y, Z])
    return cd.HybridSystem(
        name="smooth",
        states=(X, Y, Z),
        time=T,
        parameters={"k": 1.3},
        modes={
            "linear": dict(zip((X, Y, Z), linear, strict=True)),
            "curved": {X: Y, Y: -sympy.sin(X) + sympy.exp(-(Z**2)) * sympy.cos(K * T), Z: X / (1 + Y**2) - Z},
        },
        period=2 * sympy.pi / K,
        initial={X: 0.4, Y: -0.3, Z: 0.2},
    )


def run_of(system, mode, length=3.0, method="taylor", tangents=None, **initial):
    run = Run(
        system.with_initial(mode=mode, **initial),
        length,
        Numerics(method, 1e-14, 3000 if method == "rk4" else None),
        tangents=tangents,
        orthonormalise=False,
    )
    assert run.advance(1)[0] == cd.Outcome.OK
    return run


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("method", METHOD_CODES)
def test_a_linear_flow_is_its_matrix_exponential(system, method, count):
    tangents = np.array([[1.0, 0, 0], [0.3, -0.5, 2.0], [0, 0, 1.0]])[:count]
    found = run_of(system, "linear", method=method, tangents=tangents)
    expected = tangents @ expm(3 * MATRIX).T
    np.testing.assert_allclose(found.vectors, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", METHOD_CODES)
def test_a_curved_flow_against_two_trajectories(system, method):
    here = run_of(system, "curved", method=method, tangents=np.eye(3))
    for j, name in enumerate(system.state_names):
        differences = []
        for h in (2e-3, 1e-3):
            ahead, behind = (
                run_of(system, "curved", method=method, **{name: system.initial[name] + s * h}).x for s in (1, -1)
            )
            differences.append((ahead - behind) / (2 * h))
        np.testing.assert_allclose(here.vectors[j], (4 * differences[1] - differences[0]) / 3, rtol=0, atol=1e-10)


def test_taylor_and_runge_kutta_agree(system):
    first, second = (run_of(system, "curved", method=m, tangents=np.eye(3)) for m in ("taylor", "rk4"))
    np.testing.assert_allclose(first.vectors, second.vectors, rtol=0, atol=1e-11)


def test_logarithms_of_orthonormalised_tangents_add_up_to_the_determinant(system):
    """Liouville: the sum of the logarithms is the trace times the time, for a linear flow."""
    run = Run(system.with_initial(mode="linear"), 3.0, Numerics(tolerance=1e-14), tangents=np.eye(3))
    run.advance(50)
    assert run.logs.sum() == pytest.approx(np.trace(MATRIX) * 150, rel=1e-12)
    np.testing.assert_allclose(run.vectors @ run.vectors.T, np.eye(3), atol=1e-14)


def test_exponents_of_a_linear_flow_are_real_parts_of_eigenvalues(system):
    run = Run(system.with_initial(mode="linear"), 3.0, Numerics(tolerance=1e-14), tangents=np.eye(3))
    run.advance(2000)
    expected = np.sort(np.linalg.eigvals(MATRIX).real)[::-1]
    np.testing.assert_allclose(run.logs / 6000, expected, atol=1e-3)


@pytest.mark.parametrize("time", [True, False])
def test_sensitivity_to_a_frequency(system, time):
    """The tangent along a parameter that became a state, against two runs at two values."""
    wide = system.augmented(time=time, parameters=["k"])
    unit = np.eye(len(wide.states))[-1:]
    run = Run(wide.with_initial(mode="curved"), 3.0, Numerics(tolerance=1e-14), tangents=unit, orthonormalise=False)
    run.advance(1)
    ends = [run_of(system.with_parameters(k=1.3 + s * 1e-4), "curved").x for s in (1, -1)]
    np.testing.assert_allclose(run.vectors[0, :3], (ends[0] - ends[1]) / 2e-4, rtol=0, atol=1e-7)
    assert run.vectors[0, -1] == 1.0

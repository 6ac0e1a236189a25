"""Errors follow the tolerance: states and event times, on arcs with a closed form, and order 4 for Runge-Kutta."""

import math

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, V = sympy.symbols("x v", real=True)
TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14]
LENGTH = 20.0


@pytest.fixture(scope="module")
def oscillators():
    """Harmonic oscillator and pendulum, as two modes of one system; the guard is at half of the amplitude."""
    return cd.HybridSystem(
        name="oscillators",
        states=(X, V),
        parameters={},
        modes={"harmonic": {X: V, V: -X}, "pendulum": {X: V, V: -sympy.sin(X)}},
        transitions=[
            cd.Transition(f"pass-{mode}", mode, mode, guard=X - sympy.Rational(1, 2), direction=-1)
            for mode in ("harmonic", "pendulum")
        ],
        initial={X: 1.0, V: 0.0},
    )


def pendulum(t):
    """Angle and speed from rest at 1 rad, by Jacobi's functions."""
    with mpmath.workdps(30):
        k = mpmath.sin(mpmath.mpf(1) / 2)
        u = mpmath.ellipk(k**2) - t
        sn, cn = mpmath.ellipfun("sn", u, k=k), mpmath.ellipfun("cn", u, k=k)
        return float(2 * mpmath.asin(k * sn)), float(-2 * k * cn)


def harmonic(t):
    return math.cos(t), -math.sin(t)


EXACT = {"harmonic": harmonic, "pendulum": pendulum}


def error(system, mode, numerics):
    run = Run(system.with_initial(mode=mode), LENGTH, numerics)
    assert run.advance(1)[0] == cd.Outcome.OK
    return max(abs(a - b) for a, b in zip(run.x, EXACT[mode](LENGTH), strict=True))


@pytest.mark.parametrize("mode", EXACT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_error_stays_near_the_tolerance(oscillators, mode, tolerance):
    assert error(oscillators, mode, Numerics("taylor", tolerance)) < max(20 * tolerance, 2e-14)


@pytest.mark.parametrize("mode", EXACT)
def test_error_falls_with_the_tolerance(oscillators, mode):
    errors = [error(oscillators, mode, Numerics("taylor", tolerance)) for tolerance in TOLERANCES]
    assert errors[0] > 100 * errors[2] > 1e4 * errors[4]


@pytest.mark.parametrize("mode", EXACT)
def test_runge_kutta_is_of_order_four(oscillators, mode):
    steps = np.array([400, 800, 1600, 3200])
    errors = [error(oscillators, mode, Numerics("rk4", 1e-12, int(n))) for n in steps]
    orders = np.diff(np.log(errors)) / np.diff(np.log(1 / steps))
    np.testing.assert_allclose(orders, 4, atol=0.25)


def pass_times(system, mode, **settings):
    run = cd.trajectory(system.with_initial(mode=mode), duration=LENGTH, samples=1, **settings)
    return run["event_time"].values


def exact_times(mode):
    if mode == "harmonic":
        return np.array([math.pi / 3 + 2 * math.pi * k for k in range(4)])[:4]
    with mpmath.workdps(30):
        k = mpmath.sin(mpmath.mpf(1) / 2)
        quarter = mpmath.ellipk(k**2)
        phase = mpmath.ellipf(mpmath.asin(mpmath.sin(mpmath.mpf(1) / 4) / k), k**2)
        return np.array([float(quarter - phase + 4 * quarter * j) for j in range(3)])


@pytest.mark.parametrize("mode", EXACT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_event_times_follow_the_tolerance(oscillators, mode, tolerance):
    times = pass_times(oscillators, mode, tolerance=tolerance)
    exact = exact_times(mode)
    exact = exact[exact < LENGTH]
    assert len(times) == len(exact)
    assert np.abs(times - exact).max() < max(40 * tolerance, 4e-14)


@pytest.mark.parametrize("mode", EXACT)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_bisection_follows_its_tolerance(oscillators, mode, tolerance):
    """With 4000 steps the arcs are good to 1e-10, so that the bisection is what is left; it ends late, never early."""
    late = pass_times(oscillators, mode, method="rk4", steps=4000, tolerance=tolerance)[0] - exact_times(mode)[0]
    assert -1e-9 < late < tolerance + 1e-9
    assert tolerance < 1e-8 or late > tolerance / 100


def test_order_grows_as_tolerance_falls():
    orders = [Numerics(tolerance=tolerance).order for tolerance in TOLERANCES]
    assert orders == sorted(orders)
    assert orders[0] < orders[-1] <= 38


FAULTS = [
    ({"method": "euler"}, "method is 'euler'; expected one of"),
    ({"tolerance": 0.0}, "tolerance is 0.0; it must lie between 1e-16 and 1e-2"),
    ({"tolerance": float("nan")}, "tolerance is nan"),
    ({"steps": 100}, "steps is 100, but method 'taylor' chooses its own"),
    ({"method": "rk4", "steps": 3}, "steps is 3; it must lie between 4 and"),
]


@pytest.mark.parametrize(("settings", "words"), FAULTS)
def test_numbers_that_cannot_be_used_are_refused(settings, words):
    with pytest.raises(cd.SettingsError, match=words):
        Numerics(**settings)

"""Through a contact whose force is not analytic, state and tangents follow the tolerance at any stiffness."""

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model.special import positive_power

X, V, K, B = sympy.symbols("x v k b", real=True)
START = ("-0.1", "1")
LOAD = 1


@pytest.fixture(scope="module")
def contact():
    """A mass pressed by a static load flies to x = 0, where it meets the force k x**(3/2), and leaves again."""
    return cd.HybridSystem(
        name="contact",
        states=(X, V),
        parameters={"k": 1e8, "b": LOAD},
        modes={
            "free": {X: V, V: B},
            "contact": {X: V, V: B - K * positive_power(X, sympy.Rational(3, 2))},
        },
        transitions=[
            cd.Transition("touch", "free", "contact", guard=X, direction=+1),
            cd.Transition("leave", "contact", "free", guard=X, direction=-1),
        ],
        initial={"mode": "free", X: float(START[0]), V: float(START[1])},
    )


def duration(k, v):
    """Time of the contact: both branches are the same, x = deepest (1 - u**2) takes the singularity away."""

    def square(x):
        return v * v + 2 * LOAD * x - mpmath.mpf("0.8") * k * x ** mpmath.mpf("2.5")

    def integrand(u):
        # near u = 0 the square is a difference of equals
        with mpmath.workdps(120):
            return 4 * u * deepest / mpmath.sqrt(square(deepest * (1 - u * u)))

    with mpmath.workdps(120):
        deepest = mpmath.findroot(square, (mpmath.mpf("1.25") * v * v / k) ** mpmath.mpf("0.4"))
    return mpmath.quad(integrand, [0, mpmath.mpf("0.5"), 1])


def closed_form(k):
    """Length of a run that ends after the contact, the state there, and the tangent map, one image a row.

    The energy is kept, so the mass leaves as fast as it came, and all that the contact does is to take its time.
    """
    with mpmath.workdps(30):
        h = mpmath.mpf(10) ** -8
        start = [mpmath.mpf(s) for s in START]

        def arrival(x, v):
            speed = mpmath.sqrt(v * v - 2 * LOAD * x)
            return speed, (speed - v) / LOAD

        speed, touch = arrival(*start)
        length = touch + duration(k, speed) + mpmath.mpf("0.05")

        def end(x, v):
            speed, touch = arrival(x, v)
            rest = length - touch - duration(k, speed)
            return [-speed * rest + LOAD * rest * rest / 2, -speed + LOAD * rest]

        rows = []
        for moved in ((h, 0), (0, h)):
            ahead = end(*(s + m for s, m in zip(start, moved, strict=True)))
            behind = end(*(s - m for s, m in zip(start, moved, strict=True)))
            rows.append([float((a - b) / (2 * h)) for a, b in zip(ahead, behind, strict=True)])
        return float(length), np.array(end(*start), dtype=float), np.array(rows)


@pytest.fixture(scope="module", params=[1e4, 1e8, 1e12])
def stiff(request, contact):
    """Stiffness, the system with it, and the solution."""
    return request.param, contact.with_parameters(k=request.param), closed_form(request.param)


def through(system, length, tolerance):
    run = Run(system, length, Numerics("dop853", tolerance), tangents=np.eye(2), orthonormalise=False)
    assert run.advance(1)[0] == cd.Outcome.OK
    assert list(run.counts) == [1, 1]
    return run


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_the_state_follows_the_tolerance(stiff, tolerance):
    _, system, (length, state, _) = stiff
    np.testing.assert_allclose(through(system, length, tolerance).x, state, atol=0.05 * tolerance + 5e-15)


def test_the_tangent_map_is_that_of_the_closed_form(stiff):
    """In between the tangents grow to sqrt(k) of their length, and lose that many digits when they come back."""
    k, system, (length, _, rows) = stiff
    for tolerance in (1e-8, 1e-10, 1e-12):
        found = through(system, length, tolerance).vectors
        np.testing.assert_allclose(found, rows, atol=tolerance * k**0.5)
    assert k > 1e8 or np.abs(found - rows).max() < 1e-9


def test_the_flow_direction_comes_through(stiff):
    k, system, (length, _, _) = stiff
    run = through(system, length, 1e-12)
    before = np.array([float(START[1]), LOAD])
    np.testing.assert_allclose(before @ run.vectors, [run.x[1], LOAD], atol=1e-12 * k**0.5)
    assert np.linalg.det(run.vectors) == pytest.approx(1, abs=1e-12 * k**0.5)


def test_a_start_where_no_series_exists_costs_a_few_rejected_steps(stiff):
    """Sixteen evaluations a step at least; what is beyond are events, the first step of each phase, and rejections."""
    _, system, (length, _, _) = stiff
    run = through(system, length, 1e-10)
    rejected = (run.evaluations - 16 * run.steps) / 11
    assert rejected < 0.3 * run.steps

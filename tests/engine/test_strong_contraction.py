"""Maps that contract by any factor in one image keep all their directions, in any units."""

from math import cos, exp, log, sin

import numpy as np
import pytest

import chaosdrill as cd

TURN = 0.7


def turned(unit):
    """Turned by an angle, then x times a, y times b, of which y is measured in another unit."""
    return cd.Map(
        name=f"turned {unit}",
        states=("x", "y"),
        parameters={"a": 1e-300, "b": 0.5, "c": cos(TURN), "s": sin(TURN)},
        images={"x": f"a*(c*x - s*y/{unit})", "y": f"b*{unit}*(s*x + c*y/{unit})"},
        initial={"x": 0.0, "y": 0.0},
    )


@pytest.mark.parametrize("unit", ["1", "1e6"])
@pytest.mark.parametrize("a", [1e-10, 1e-20, 1e-100, 1e-300])
def test_turned(a, unit):
    """Trace (a + b) c and determinant a b: eigenvalues b c and a/c, up to a/b."""
    found = cd.lyapunov_spectrum(turned(unit).with_parameters(a=a), periods=64, transient=64)
    exact = np.log(np.abs(np.roots([1.0, -(a + 0.5) * cos(TURN), 0.5 * a]))) if a == 1e-10 else 0.0
    exact = [log(0.5 * cos(TURN)), log(a / cos(TURN))] if a < 1e-15 else np.sort(exact)[::-1]
    np.testing.assert_allclose(found["lyapunov_exponent"], exact, rtol=1e-7)
    assert int(found["rank"]) == 2


def test_three_states():
    """The exponents add up to the logarithm of the determinant."""
    system = cd.Map(
        name="three",
        states=("x", "y", "z"),
        parameters={"a": 1e-20, "b": 1e-100, "d": 0.5, "c": cos(TURN), "s": sin(TURN)},
        images={"x": "a*(c*x - s*y)", "y": "b*(s*x + c*y)", "z": "d*(z + s*x + s*y)"},
        initial={"x": 0.0, "y": 0.0, "z": 0.0},
    )
    found = cd.lyapunov_spectrum(system, periods=64, transient=0)["lyapunov_exponent"]
    assert float(found.sum()) == pytest.approx(log(1e-20) + log(1e-100) + log(0.5), rel=1e-13)


def test_contraction_that_sets_in_late():
    """Every other image contracts, by exp(-690), after many that do not."""
    system = cd.Map(
        name="late",
        states=("x", "y", "u"),
        parameters={"b": 0.5, "c": cos(TURN), "s": sin(TURN)},
        images={"x": "exp(-345*(1 - sin(pi*u/2)))*(c*x - s*y)", "y": "b*(s*x + c*y)", "u": "-u"},
        initial={"x": 0.0, "y": 0.0, "u": 1.0},
    )
    found = cd.lyapunov_spectrum(system, periods=64, transient=0)["lyapunov_exponent"].values
    assert found.sum() == pytest.approx(-345.0 + log(0.5), rel=1e-13)
    assert exp(found[0]) == pytest.approx(1.0, rel=1e-13)

"""Exit speed of a Hunt-Crossley contact against Lambert's W at 50 digits."""

import mpmath
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from chaosdrill.codegen.contacts import hunt_crossley_exit, hunt_crossley_exit_lam
from chaosdrill.model.special import hunt_crossley_exit as symbolic_exit

V, LAM = sympy.symbols("v lam", real=True)
damping = st.floats(-2.0, 2.0).map(lambda u: 10.0**u)
# lam v over its whole range, densely where the two branches of the algorithm meet
product = st.one_of(st.floats(-12.0, 1.698).map(lambda u: 10.0**u), st.floats(0.5, 2.0))


def exact(v, lam):
    """s(v) by the closed form; the working precision pays for its cancellation."""
    with mpmath.workdps(100):
        v, lam = mpmath.mpf(v), mpmath.mpf(lam)
        base = 1 + lam * v
        return (1 + mpmath.lambertw(-base * mpmath.exp(-base)).real) / lam


def slope(v, lam):
    with mpmath.workdps(50):
        s, v, lam = exact(v, lam), mpmath.mpf(v), mpmath.mpf(lam)
        return v / (1 + lam * v) * (1 - lam * s) / s


@given(product, damping)
def test_value_is_good_to_the_last_place(x, lam):
    v = x / lam
    expected = exact(v, lam)
    assert abs(hunt_crossley_exit(v, lam) - expected) <= 4e-16 * expected


@given(product, damping)
def test_derivative_by_speed_follows_from_the_value(number, x, lam):
    derivative = sympy.diff(symbolic_exit(V, LAM), V)
    v = x / lam
    assert abs(number(derivative, {"v": v, "lam": lam}) - slope(v, lam)) <= 5e-16


@given(product, damping)
def test_derivative_by_damping_loses_no_digits_where_it_is_small(x, lam):
    v = x / lam
    with mpmath.workdps(50):
        expected = (mpmath.mpf(v) * slope(v, lam) - exact(v, lam)) / mpmath.mpf(lam)
        assert abs(hunt_crossley_exit_lam(v, lam) - expected) <= 3e-16 * (4 + x) * abs(expected)


def test_derivative_by_damping_is_that_of_the_value():
    v, lam, h = 1.3, 0.6, mpmath.mpf(10) ** -20
    with mpmath.workdps(60):
        difference = (exact(v, lam + h) - exact(v, lam - h)) / (2 * h)
    assert hunt_crossley_exit_lam(v, lam) == pytest.approx(float(difference), rel=1e-14)
    assert sympy.diff(symbolic_exit(V, LAM), LAM).func.__name__ == "hunt_crossley_exit_lam"


def test_exit_without_speed_damping_or_end():
    assert hunt_crossley_exit(0.0, 0.6) == 0.0
    assert hunt_crossley_exit(1.25, 0.0) == 1.25
    assert hunt_crossley_exit(1e9, 0.5) == 2.0
    assert hunt_crossley_exit_lam(1.5, 0.0) == pytest.approx(-1.5, rel=1e-15)

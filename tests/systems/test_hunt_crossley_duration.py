"""Duration of a Hunt-Crossley contact against its integral in 30 digits, velocities by Lambert's W."""

import math
from functools import cache

import mpmath
import pytest
import sympy

from chaosdrill.codegen.contacts import hunt_crossley_duration
from chaosdrill.model.special import hunt_crossley_duration as symbolic_duration
from tests.support import contact_durations

PRODUCTS = [1e-12, 1e-6, 0.01, 0.5, 1.0, 3.0, 12.0, 50.0]
EXPONENTS = [1.0, 1.5, 2.0]
ARGUMENTS = ("v", "lam", "n", "k")


@cache
def exact(v, lam, n, k):
    """The integral in as many digits as its differences need."""
    with mpmath.workdps(contact_durations.DIGITS + contact_durations.lost(v, lam)):
        return contact_durations.duration(*map(mpmath.mpf, (v, lam, n, k)))


@pytest.mark.parametrize("n", EXPONENTS)
@pytest.mark.parametrize("x", PRODUCTS)
def test_duration_is_that_of_many_digits(x, n):
    v, lam, k = x / 0.7, 0.7, 12e5
    assert hunt_crossley_duration(v, lam, n, k) == pytest.approx(float(exact(v, lam, n, k)), rel=1e-12)


@pytest.mark.parametrize("argument", ARGUMENTS)
@pytest.mark.parametrize(("x", "n"), [(1e-10, 1.5), (0.02, 1.0), (0.4, 2.0), (1.3, 1.5), (40.0, 1.0)])
def test_derivatives_are_differences(number, argument, x, n):
    here = {"v": x / 0.7, "lam": 0.7, "n": n, "k": 12e5}
    symbols = {name: sympy.Symbol(name, real=True) for name in ARGUMENTS}
    found = number(sympy.diff(symbolic_duration(*symbols.values()), symbols[argument]), here)
    with mpmath.workdps(50):
        h = mpmath.mpf(10) ** -12
        ahead, behind = ({**here, argument: mpmath.mpf(here[argument]) * (1 + sign * h)} for sign in (1, -1))
        expected = (exact(**ahead) - exact(**behind)) / (2 * h * here[argument])
        scale = exact(**here) / here[argument]
    assert found == pytest.approx(float(expected), rel=1e-10, abs=1e-12 * float(scale))


@pytest.mark.parametrize("pair", ["v v", "v lam", "lam lam", "lam n", "lam k"])
@pytest.mark.parametrize(("x", "n"), [(0.02, 1.0), (0.4, 2.0), (1.3, 1.5), (40.0, 1.5)])
def test_second_derivatives_are_differences(number, pair, x, n):
    here = {"v": x / 0.7, "lam": 0.7, "n": n, "k": 12e5}
    symbols = {name: sympy.Symbol(name, real=True) for name in ARGUMENTS}
    first, second = pair.split()
    found = number(sympy.diff(symbolic_duration(*symbols.values()), symbols[first], symbols[second]), here)
    with mpmath.workdps(contact_durations.DIGITS):
        h = mpmath.mpf(10) ** -8

        def moved(one, other):
            there = {name: mpmath.mpf(value) for name, value in here.items()}
            there[first] += one * h * here[first]
            there[second] += other * h * here[second]
            return contact_durations.duration(**there)

        corners = moved(1, 1) - moved(1, -1) - moved(-1, 1) + moved(-1, -1)
        expected = corners / (4 * h * h * here[first] * here[second])
        scale = contact_durations.duration(**here) / (here[first] * here[second])
    assert found == pytest.approx(float(expected), rel=1e-10, abs=1e-11 * float(scale))


@pytest.mark.parametrize("n", EXPONENTS)
def test_the_first_damping_prolongs_a_contact(number, n):
    """Of an elastic contact, in closed form: by v (n - 1)/(3 (n + 1)) times the duration."""
    here = {"v": 0.3, "lam": 0.0, "n": n, "k": 50.0}
    symbols = {name: sympy.Symbol(name, real=True) for name in ARGUMENTS}
    found = number(sympy.diff(symbolic_duration(*symbols.values()), symbols["lam"]), here)
    shape = 2 * ((n + 1) / 100) ** (1 / (n + 1)) * 0.3 ** ((1 - n) / (1 + n)) / (n + 1)
    whole = shape * float(mpmath.beta(1 / (mpmath.mpf(n) + 1), 0.5))
    assert found == pytest.approx(0.3 * (n - 1) / (3 * (n + 1)) * whole, rel=1e-13)


@pytest.mark.parametrize(("v", "lam"), [(-0.3, 0.0), (-0.3, 0.5), (-3.0, 2.0)])
def test_nothing_touches_at_a_speed_away_from_the_contact(v, lam):
    assert math.isnan(hunt_crossley_duration(v, lam, 1.5, 50.0))


def test_an_elastic_linear_contact_lasts_half_a_period():
    assert hunt_crossley_duration(0.3, 0.0, 1.0, 16.0) == pytest.approx(float(mpmath.pi) / 4, rel=1e-15)


def test_an_elastic_hertzian_contact_lasts_as_hertz_found():
    # 2.9432750594... = 2 * integral of dx/sqrt(1 - x^(5/2)) over 0 < x < 1, in units of depth over approach speed
    v, k = 0.3, 50.0
    shape = 2 * mpmath.beta(mpmath.mpf(2) / 5, mpmath.mpf(1) / 2) * 2 / 5
    deepest = (1.25 * v**2 / k) ** 0.4
    assert hunt_crossley_duration(v, 0.0, 1.5, k) == pytest.approx(float(shape) * deepest / v, rel=1e-12)

"""Orbits of systems without a clock are found whatever the unit of time is."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import find_orbit
from chaosdrill.orbits.guess import Place, characteristic_time
from chaosdrill.orbits.search import search

FINE = Numerics(tolerance=1e-13)


@pytest.fixture(scope="module")
def van_der_pol():
    x, v, mu, c = sympy.symbols("x v mu c", real=True)
    return cd.HybridSystem(
        name="van-der-pol",
        states=(x, v),
        parameters={"mu": 1.0, "c": 1.0},
        modes={"on": {x: c * v, v: c * (mu * (1 - x**2) * v - x)}},
        initial={"mode": "on", x: 1.0, v: 0.0},
    )


@pytest.mark.parametrize("c", [1e-5, 1.0, 1e5])
def test_any_unit_of_time(van_der_pol, c):
    found = find_orbit(van_der_pol.with_parameters(c=c), 1, "attractor", 50 / c, FINE)
    # the period known to many digits
    assert found.duration * c == pytest.approx(6.66328685932313, abs=1e-11)
    assert found.multipliers[0] == pytest.approx(1, abs=1e-11)
    assert found.checks.consistent, found.checks.disagreements


@pytest.mark.parametrize("c", [1e-5, 1e5])
def test_any_unit_of_time_in_a_search(van_der_pol, c):
    found = search(van_der_pol.with_parameters(c=c), 2, np.zeros((0, 2)), np.zeros(0, dtype=np.int64), FINE)
    assert [o.duration * c for o in found] == pytest.approx([6.66328685932313], abs=1e-11)


@pytest.mark.parametrize("mu", [0.1, 10.0, 100.0])
def test_weak_and_strong_relaxation(van_der_pol, mu):
    found = find_orbit(van_der_pol.with_parameters(mu=mu), 1, "attractor", 50 + 50 * mu, FINE)
    # averaging where it is weak (Hayashi), Dorodnicyn's series where it is strong
    known = 2 * np.pi * (1 + mu**2 / 16) if mu < 1 else (3 - 2 * np.log(2)) * mu + 3 * 2.338107410 / mu ** (1 / 3)
    assert found.duration == pytest.approx(known, rel=1e-5 if mu < 1 else 0.04)
    assert found.checks.consistent, found.checks.disagreements
    # no double holds the smaller multiplier of the strong one, its exponent is known all the same
    assert found.rank == 2
    assert np.isfinite(found.checks.exponents).all()


def test_the_characteristic_time_is_that_of_the_motion(van_der_pol):
    slow, fast = (characteristic_time(Place(van_der_pol.with_parameters(c=c)), FINE) for c in (1e-3, 1e3))
    assert slow / fast == pytest.approx(1e6, rel=1)

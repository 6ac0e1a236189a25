"""Case 6: a direction that is lost is lost exactly, and how many follows from the product of the maps."""

from math import cos, log, sin

import numpy as np
import sympy

import chaosdrill as cd

X, Y, Z = sympy.symbols("x y z", real=True)
FULL = 1000


def exponents(system):
    return cd.lyapunov_spectrum(system, duration=FULL, transient=10)["lyapunov_exponent"].values


def test_projection_and_rotation(case):
    c, s = cos(0.7), sin(0.7)
    found = exponents(case(6).every_unit((X, Y), {X: c * X, Y: s * X}))
    np.testing.assert_allclose(found[:2], [0.0, log(c)], atol=1e-10)
    assert found[2] == -np.inf


def test_the_same_direction_lost_again_counts_once(case):
    found = exponents(case(6).every_unit((X, Y, Z), {X: X / 2, Y: Y / 3, Z: 0}))
    np.testing.assert_allclose(found[:3], [0.0, -log(2), -log(3)], atol=1e-10)
    assert found[3] == -np.inf


def test_a_shift_loses_in_two_steps_what_one_step_keeps(case):
    # one step has rank 2, two steps have rank 1: (x, y, z) -> (x/2, z, 0)
    found = exponents(case(6).every_unit((X, Y, Z), {X: X / 2, Y: Z, Z: 0}))
    np.testing.assert_allclose(found[:2], [0.0, -log(2)], atol=1e-10)
    assert list(found[2:]) == [-np.inf, -np.inf]


def test_a_drill_that_sticks_has_one_exponent_less_however_often_it_sticks():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.448), periods=2000, transient=100)
    found = spectrum["lyapunov_exponent"].values
    assert np.isfinite(found[:2]).all()
    assert found[2] == -np.inf
    assert int(spectrum["rank"]) == 2
    counts = dict(zip(spectrum["transition_name"].values, spectrum["event_count"].values, strict=True))
    assert counts["stick"] > 1000


def test_a_drill_that_never_sticks_loses_nothing():
    spectrum = cd.lyapunov_spectrum(cd.drill(rock="fixed", friction="none"), periods=500, transient=100)
    assert np.isfinite(spectrum["lyapunov_exponent"].values).all()

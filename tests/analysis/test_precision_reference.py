"""The truth of 60 digits, held to closed forms."""

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.precision.reference import DIGITS, EXACT, NoReferenceError, find_truth
from chaosdrill.analysis.precision.start import TIGHT, find_place, itinerary, run_map, survey
from chaosdrill.analysis.spans import Span
from chaosdrill.engine.numerics import Numerics
from chaosdrill.model.special import SPECIAL


def free_fall(e=0.75, g=2.0):
    return cd.HybridSystem(
        name="ball",
        states="x v",
        parameters={"g": g, "e": e},
        modes={"flight": {"x": "v", "v": "-g"}},
        transitions=[cd.Transition("hit", "flight", "flight", "x", -1, reset={"v": "-e*v"})],
        initial={"x": 1.0, "v": 3.0},
    )


def truth_of(system, unit, count=1):
    mapped = run_map(system, unit, count, Numerics("taylor", TIGHT))
    start = [mpmath.mpf(system.initial[name]) for name in system.state_names]
    return find_truth(system, unit, np.ones(len(start)), start, itinerary(mapped.found), count)


def test_a_ball_to_fifty_digits():
    """From (1, 3) with g = 2 it lands after (3 + sqrt 13)/2 at speed sqrt 13; then it rises with 3/4 of it."""
    truth = truth_of(free_fall(), 4.0)
    with mpmath.workdps(DIGITS):
        speed = mpmath.sqrt(13)
        landing = (3 + speed) / 2
        rest = 4 - landing
        up = mpmath.mpf(3) / 4 * speed
        assert abs(truth.times[0] - landing) < mpmath.mpf(10) ** -50
        assert abs(truth.state[0] - (up * rest - rest**2)) < mpmath.mpf(10) ** -50
        assert abs(truth.state[1] - (up - 2 * rest)) < mpmath.mpf(10) ** -50


def test_the_tangents_of_a_ball():
    """With the energy h = x + v^2/4: landing at v0/2 + sqrt h, speed 2 sqrt h, all by differentiating the flight."""
    truth = truth_of(free_fall(), 4.0)
    x, v = sympy.symbols("x v", real=True)
    root = sympy.sqrt(x + v**2 / 4)
    rest, up = 4 - (v / 2 + root), sympy.Rational(3, 2) * root
    end = sympy.Matrix([up * rest - rest**2, up - 2 * rest])
    exact = end.jacobian([x, v]).subs({x: 1, v: 3}).evalf(40)
    with mpmath.workdps(40):
        for i in range(2):
            for j in range(2):
                assert abs(truth.tangent[i, j] - mpmath.mpf(str(exact[i, j]))) < 1e-23
    assert truth.errors["tangent"] < 1e-22


def test_the_orbit_of_an_impact_oscillator_at_a_wall_at_zero():
    """Determinant e^2, exactly; trace -2ec + (1+e)^2 (1-w^2)(1+c)/2, c = cos T, as far as T is exact as a double."""
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.5, "e": 0.8})
    plan = Span(system.forcing_period(), 32, 2000, True)
    place = find_place(survey(system, plan), plan)
    assert place.period == 1
    assert place.truth is not None
    tangent = place.truth.tangent
    with mpmath.workdps(DIGITS):
        e, w = mpmath.mpf(0.8), mpmath.mpf(2.5)
        c = mpmath.cos(2 * mpmath.pi / w)
        assert abs(mpmath.det(tangent) - e**2) < 1e-22
        trace = -2 * e * c + (1 + e) ** 2 * (1 - w**2) * (1 + c) / 2
        assert abs(tangent[0, 0] + tangent[1, 1] - trace) < 1e-14
        # the start was brought onto the cycle by one step of Newton's method from 15 digits
        assert max(abs(a - b) for a, b in zip(place.truth.state, place.truth.start, strict=True)) < 1e-25


def test_an_event_that_was_not_found_is_noticed():
    """The ball would fall through the floor; the guard is watched."""
    with pytest.raises(NoReferenceError, match="hit happens in extended precision only"):
        find_truth(free_fall(), 4.0, np.ones(2), [mpmath.mpf(1), mpmath.mpf(3)], [], 1)


def test_an_event_that_does_not_happen_is_noticed():
    """The ball is in the air at 0.5; the guard is not near zero."""
    with pytest.raises(NoReferenceError):
        find_truth(free_fall(), 1.0, np.ones(2), [mpmath.mpf(1), mpmath.mpf(3)], [(0, 0.5, 0)], 1)


@pytest.mark.parametrize("speed", ["1e-12", "1e-4", "1", "50"])
def test_exit_speed_keeps_the_potential(speed):
    """G(-s) = G(v) with G(v) = v/lam - ln(1 + lam v)/lam^2, relative to G(v)."""
    with mpmath.workdps(40):
        lam, v = mpmath.mpf("0.3"), mpmath.mpf(speed) / mpmath.mpf("0.3")
        s = EXACT["hunt_crossley_exit"](v, lam)
        with mpmath.workdps(100):
            before, after = (u / lam - mpmath.log(1 + lam * u) / lam**2 for u in (v, -s))
        assert 0 < s < v
        assert abs(after / before - 1) < mpmath.mpf(10) ** -20


def test_peak_force_of_a_contact():
    """m, k, n, lam, v0 = 1, 1e6, 1.5, 0.3, 1: 265.837."""
    with mpmath.workdps(30):
        found = EXACT["hunt_crossley_peak"](*(mpmath.mpf(a) for a in ("1", "0.3", "1.5", "1e6")))
        assert float(found) == pytest.approx(265.837, abs=5e-4)
        exit_speed = EXACT["hunt_crossley_exit"](mpmath.mpf(1), mpmath.mpf("0.3"))
        assert float(exit_speed) == pytest.approx(0.8328697922656, abs=1e-13)


@pytest.mark.parametrize(
    ("lam", "n", "k", "v", "duration"),
    [
        (0.3, 1.5, 1e6, 1.0, 0.01308784404082),
        (0.3, 1.0, 1e6, 1.0, 0.00315145331674),
        (1.7, 2.0, 2500.0, 2.5, 0.27125357342685),
        (0.0, 1.0, 16.0, 0.3, 0.78539816339745),
        # strong damping, by DOP853
        (50.0, 1.5, 10.0, 20.0, 19.929126897107),
    ],
)
def test_duration_of_a_contact(lam, n, k, v, duration):
    with mpmath.workdps(30):
        found = EXACT["hunt_crossley_duration"](*(mpmath.mpf(a) for a in (v, lam, n, k)))
    assert float(found) == pytest.approx(duration, rel=1e-12)


def test_every_function_of_a_flow_has_its_exact_evaluation():
    """Derivatives of special functions stand in saltation matrices only, which the truth does without, as noise."""
    derivatives = {name for name in SPECIAL if name.rpartition("_")[0] in SPECIAL}
    assert SPECIAL.keys() - EXACT.keys() <= {*derivatives, "random_uniform"}


def test_multipliers_of_the_paper():
    """eta = 0.8: 0.11672896840556 +- 0.65713468420972i and 0; no saltation matrix has been used."""
    system = cd.drill(eta=0.8).with_initial(
        mode="slip", y=0.5117707419326684, u=0.2579689590074009, w=0.3668787222623992
    )
    truth = truth_of(system, system.forcing_period())
    found = sorted(truth.multipliers, key=lambda value: (abs(value), value.imag))
    np.testing.assert_allclose(found[0], 0, atol=1e-20)
    np.testing.assert_allclose(
        found[1:], [0.11672896840556 - 0.65713468420972j, 0.11672896840556 + 0.65713468420972j], atol=1e-13
    )
    assert [round(float(t), 3) for t in truth.times] == [1.358, 6.252, 6.373]

"""Orbits in closed form, from outside: SciPy's motion returns in the time that they say, with their derivatives."""

from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp
from support import closed_autonomous as autonomous
from support import closed_bouncing_ball as ball
from support import closed_den_hartog as den_hartog
from support import closed_impact as impact
from support import wall_at_rest as wall
from support import wall_at_rest_cascade as cascade
from support.motion import arc, derivative

# One impact of the damped oscillator in closed form: SciPy's motion returns, with the same derivative.


CASES = [(1.9, 0.3, 0.05, 0.8, 1), (2.0, 0.3, 0.05, 0.8, 1), (1.8, 0.5, 0.05, 0.8, 1), (4.1, 0.02, 0.1, 0.6, 2)]


def motion_of(w, d, zeta, r):
    """The field, and the way from a flight to the wall and on to the same phase, n periods later."""

    def field(t, s):
        return [s[1], -s[0] - 2 * zeta * s[1] + cos(w * t)]

    def lap(start, period, begin):
        t, s = arc(field, begin, start, 2 * period, lambda _, s: s[0] - d)
        return arc(field, t, [d, -r * s[1]], begin + period - t)[1]

    return field, lap


@pytest.mark.parametrize(("w", "d", "zeta", "r", "n"), CASES)
def test_the_motion_returns_with_its_multipliers(w, d, zeta, r, n):
    found = impact.one_impact(w, d, zeta, r, n)
    assert found
    for orbit in found:
        assert orbit.highest < d
        field, lap = motion_of(w, d, zeta, r)
        period, hit = 2 * pi * n / w, orbit.phase / w
        t, begin = arc(field, hit, [d, -r * orbit.speed], period / 3)
        np.testing.assert_allclose(lap(begin, period, t), begin, atol=1e-10)
        if orbit.speed > 0.1:
            map_ = derivative(lambda s, t=t, lap=lap, period=period: lap(s, period, t), begin)
            assert np.trace(map_) == pytest.approx(orbit.trace, abs=1e-7)
            assert np.linalg.det(map_) == pytest.approx(orbit.determinant, abs=1e-7)


@pytest.mark.parametrize("d", [0.3, 0.5, 0.9])
def test_free_motion_grazes(d):
    w = impact.grazing_frequency(d, 0.05)
    assert impact.amplitude(w, 0.05) == pytest.approx(d, abs=1e-15)
    assert impact.amplitude(w + 0.1, 0.05) < d


@pytest.mark.parametrize(("d", "side"), [(0.3, -1), (0.5, 1)])
def test_on_which_side_of_grazing_the_slow_impact_exists(d, side):
    """With d = 0.3 the orbit goes on with an impact; with d = 0.5 it meets one that has it already, and both end."""
    w = impact.grazing_frequency(d, 0.05)
    there = [orbit.speed for orbit in impact.one_impact(w + side * 1e-6, d, 0.05, 0.8)]
    beyond = [orbit.speed for orbit in impact.one_impact(w - side * 1e-6, d, 0.05, 0.8)]
    assert len(there) == len(beyond) + 1
    assert there[0] < 1e-5
    slow, slower = (impact.one_impact(w + side * off, d, 0.05, 0.8)[0] for off in (1e-6, 1e-8))
    assert slow.trace * side > 1e4
    assert slower.trace * slower.speed == pytest.approx(slow.trace * slow.speed, rel=1e-4)


def test_impacting_orbits_meet_in_a_fold():
    w = impact.fold_frequency(0.5, 0.05, 0.8, 1.85, 1.9)
    slow, fast = impact.one_impact(w - 1e-10, 0.5, 0.05, 0.8)
    assert slow.speed == pytest.approx(fast.speed, abs=1e-3)
    for orbit in (slow, fast):
        assert orbit.trace == pytest.approx(1 + orbit.determinant, abs=1e-3)
    assert impact.one_impact(w + 1e-10, 0.5, 0.05, 0.8) == []


# One bounce in n periods in closed form: SciPy's motion returns, and doubles and is born where it should.


BALL_CASES = [(0.9, 1.0, 0.8, 1.0, 1), (0.4, 1.0, 0.8, 1.0, 1), (0.02, 11.0, 0.5, 2.0, 1), (0.75, 1.0, 0.8, 1.0, 2)]


@pytest.mark.parametrize(("a", "w", "e", "g", "n"), BALL_CASES)
def test_the_motion_returns_with_its_multipliers_of_ball(a, w, e, g, n):
    def field(t, s):
        return [s[1], -g]

    period = 2 * pi * n / w
    for orbit in ball.bounces(a, w, e, g, n):
        assert orbit.clearance > 0
        hit = orbit.phase / w
        begin = hit + period / 2

        def lap(start, begin=begin):
            t, s = arc(field, begin, start, period, lambda t, s: a * sin(w * t) - s[0])
            floor = a * w * cos(w * t)
            return arc(field, t, [a * sin(w * t), floor - e * (s[1] - floor)], begin + period - t)[1]

        top = arc(field, hit, [a * sin(w * hit), orbit.speed], period / 2)[1]
        np.testing.assert_allclose(lap(top), top, atol=1e-10)
        map_ = derivative(lap, top, 1e-4 * min(1.0, a))
        assert np.trace(map_) == pytest.approx(orbit.trace, rel=1e-6)
        assert np.linalg.det(map_) == pytest.approx(orbit.determinant, rel=1e-6)


@pytest.mark.parametrize(("w", "e", "g", "n"), [(1.0, 0.8, 1.0, 1), (3.0, 0.5, 9.81, 1), (1.0, 0.8, 1.0, 2)])
def test_birth_and_doubling(w, e, g, n):
    born = ball.fold_amplitude(w, e, g, n)
    assert ball.bounces(born * (1 - 1e-9), w, e, g, n) == []
    assert ball.bounces(born * (1 + 1e-12), w, e, g, n)[0].trace == pytest.approx(1 + e**2, abs=1e-4)
    doubles = ball.doubling_amplitude(w, e, g, n)
    assert ball.bounces(doubles, w, e, g, n)[0].trace == pytest.approx(-(1 + e**2), abs=1e-12)
    assert ball.doubling_frequency(doubles, e, g, n) == pytest.approx(w, rel=1e-14)


# Den Hartog's motion without sticking: SciPy's motion returns, and the limit is where acceleration ends at a stop.


DEN_HARTOG_CASES = [(0.8, 0.3), (0.6, 0.2), (1.4, 0.5), (0.45, 0.1)]


def lap_of(w, friction):
    def half(t, s, way):
        return arc(lambda t, s: [s[1], cos(w * t) - s[0] - way * friction], t, s, 3 * pi / w, lambda _, s: -way * s[1])

    def lap(begin, s):
        t, s = half(begin, s, 1.0)
        t, s = half(t, [s[0], 0.0], -1.0)
        return arc(lambda t, s: [s[1], cos(w * t) - s[0] - friction], t, [s[0], 0.0], begin + 2 * pi / w - t)[1]

    return lap


@pytest.mark.parametrize(("w", "friction"), DEN_HARTOG_CASES)
def test_the_motion_returns_with_its_multipliers_of_den_hartog(w, friction):
    known = den_hartog.sliding(w, friction)
    hit = known.phase / w
    # from the quarter before the maximum, where the mass moves forward
    begin, s = arc(lambda t, s: [s[1], cos(w * t) - s[0] - friction], hit - pi / w, [-known.amplitude, 0.0], pi / 2 / w)
    lap = lap_of(w, friction)
    np.testing.assert_allclose(lap(begin, s), s, atol=1e-10)
    map_ = derivative(lambda s: lap(begin, s), s)
    product, total = np.prod(known.multipliers).real, np.sum(known.multipliers).real
    assert np.linalg.det(map_) == pytest.approx(product, abs=1e-7)
    assert np.trace(map_) == pytest.approx(total, abs=1e-7)


@pytest.mark.parametrize("w", [0.6, 0.8, 1.5])
def test_it_begins_to_stick_where_the_mass_would_stay(w):
    """At the limit the demand cos(w t0) - x0 at a stop is as large as friction, and a multiplier vanishes."""
    limit = den_hartog.sticking_friction(w)
    known = den_hartog.sliding(w, limit * (1 - 1e-9))
    assert abs(cos(known.phase) - known.amplitude) == pytest.approx(limit, rel=1e-8)
    assert abs(known.multipliers[1]) < 1e-16
    assert den_hartog.sliding(w, limit * (1 + 1e-9)) is None


def test_at_low_frequency_it_sticks_on_its_way_first():
    assert den_hartog.slowest(0.4) > 1.2 / 0.4**2


# Cycles without a clock: SciPy's motion takes the time that the closed forms say, and returns.


@pytest.mark.parametrize(("speed", "static", "kinetic"), [(0.2, 1.0, 0.5), (0.1, 1.0, 0.6), (0.7, 1.5, 0.3)])
def test_slip_on_the_belt(speed, static, kinetic):
    known = autonomous.belt(speed, static, kinetic)
    t, s = arc(lambda t, s: [s[1], kinetic - s[0]], 0.0, known.release, 20.0, lambda _, s: s[1] - speed)
    assert t == pytest.approx(known.slip_time, abs=1e-10)
    np.testing.assert_allclose(s, known.stick, atol=1e-10)
    assert abs(known.stick[0]) < static
    assert (known.release[0] - known.stick[0]) / speed + known.slip_time == pytest.approx(known.period, rel=1e-14)


@pytest.mark.parametrize(("alpha", "gamma"), [(0.3, 0.15), (0.3, 0.05), (0.2, 0.4)])
def test_rolling(alpha, gamma):
    known = autonomous.gait(alpha, gamma)

    def step(speed):
        start = [gamma - alpha, speed]
        t, s = arc(lambda t, s: [s[1], np.sin(s[0])], 0.0, start, 20.0, lambda _, s: s[0] - gamma - alpha)
        return t, np.cos(2 * alpha) * s[1]

    assert step(known.after) == pytest.approx((known.period, known.after), abs=1e-10)
    faster, slower = step(known.after + 1e-5)[1], step(known.after - 1e-5)[1]
    assert (faster - slower) / 2e-5 == pytest.approx(known.multipliers[1], abs=1e-8)


def test_a_wheel_on_too_gentle_a_slope_does_not_roll():
    assert autonomous.gait(0.3, 0.02) is None


# The closed forms of the impact oscillator against Newton's method on its exact flow, and that flow against SciPy.


WALL_CASES = [("0.8", 1, "2.6"), ("0.8", 1, "1.3"), ("0.5", 1, "2.2"), ("0.6", 2, "4.3"), ("0.9", 3, "5.7")]


@pytest.mark.parametrize(("r", "n", "w"), WALL_CASES)
def test_newtons_method_finds_the_orbit_in_closed_form(digits, r, n, w):
    digits(40)
    known = wall.period_one(w, r, n)
    found = wall.orbit(w, r, [known.phase / mp.mpf(w) + mp.mpf("1e-3")], n)
    assert abs(found.times[0] - known.phase / mp.mpf(w)) < 1e-30
    assert abs(found.flights[0].end - known.speed) < 1e-30
    map_ = found.monodromy
    assert abs(map_[0, 0] + map_[1, 1] - known.trace) < 1e-30
    assert abs(mp.det(map_) - known.determinant) < 1e-30
    assert found.highest() < 0
    later = found.residuals[1:]
    assert all(b < 100 * a**2 or b < 1e-30 for a, b in pairwise(later))


@pytest.mark.parametrize(("r", "n", "w"), WALL_CASES)
def test_the_motion_as_scipy_computes_it_returns(digits, r, n, w):
    digits(20)
    known = wall.period_one(w, r, n)
    w = float(w)

    def meets(t, state):
        return state[0]

    meets.terminal, meets.direction = True, 1
    start, speed = float(known.phase) / w, float(known.speed)
    run = solve_ivp(
        lambda t, s: [s[1], np.cos(w * t) - s[0]],
        (start, start + 20 * n),
        [-1e-15, -float(r) * speed],
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
        events=meets,
    )
    assert run.t[-1] - start == pytest.approx(2 * np.pi * n / w, abs=1e-10)
    assert run.y[1, -1] == pytest.approx(speed, abs=1e-10)


@pytest.mark.parametrize(("r", "n", "guess"), [("0.8", 1, 2.65), ("0.5", 1, 2.5), ("0.7", 2, 3.3), ("0.8", 3, 6.6)])
def test_where_the_orbit_doubles(digits, r, n, guess):
    digits(40)
    w = wall.doubling(r, guess, n)
    known = wall.period_one(w, r, n)
    assert abs(known.trace + 1 + known.determinant) < 1e-35
    assert abs(wall.doubling_restitution(w, n) - mp.mpf(r)) < 1e-35


def test_the_cascade_finds_itself(digits):
    digits(24)
    for found, known in zip(cascade.cascade(4), cascade.DOUBLINGS, strict=False):
        assert abs(found.w - mp.mpf(known)) < 1e-16
        assert abs(mp.det(found.monodromy) - found.r ** (2 * len(found.times))) < 1e-16
        assert found.highest() == -mp.inf
        assert min(flight.end for flight in found.flights) > 0.37


def test_ratios_of_the_cascade():
    w = np.array([float(mp.mpf(known)) for known in cascade.DOUBLINGS])
    steps = np.diff(w)
    np.testing.assert_allclose(steps[:-1] / steps[1:], cascade.RATIOS, atol=1e-8)
    assert abs(cascade.RATIOS[-1] - 4.669201609) < 0.01


def test_a_flight_begins_to_touch_the_wall(digits):
    digits(30)
    w = wall.grazing("0.8", 3.14, 2)
    heights = []
    for there in (w - mp.mpf("1e-6"), w + mp.mpf("1e-6")):
        start = wall.period_one(there, "0.8", 2).phase / there
        (flight,) = wall.flights_of(there, [start], 2)
        heights.append(max(flight.state(flight.h * i / 4000)[0] for i in range(400, 3600)))
    assert heights[0] > 0 > heights[1]

"""The closed forms of the impact oscillator against Newton's method on its exact flow, and that flow against SciPy."""

from itertools import pairwise

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp
from support import wall_at_rest as wall
from support import wall_at_rest_cascade as cascade

CASES = [("0.8", 1, "2.6"), ("0.8", 1, "1.3"), ("0.5", 1, "2.2"), ("0.6", 2, "4.3"), ("0.9", 3, "5.7")]


@pytest.mark.parametrize(("r", "n", "w"), CASES)
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


@pytest.mark.parametrize(("r", "n", "w"), CASES)
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

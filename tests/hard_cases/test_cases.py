"""The hard cases of the documentation, by their numbers there."""

import math
from math import cos, exp, log, pi, sin, sqrt

import numpy as np
import pytest
import sympy

import chaosdrill as cd

X, V, E, Y, Z = sympy.symbols("x v e y z", real=True)


# Case 1: a slow hit stretches without bound; the tangent is not clipped and the smallest normal speed is reported.


def landing(depth):
    """State at time 2."""
    hit = (2 * depth) ** 0.5
    fall = 1 + hit
    return -0.8 * hit * fall - fall**2 / 2, -0.8 * hit - fall


@pytest.mark.parametrize(
    ("depth", "entry", "digits"), [(1e-4, -129.9, 0.05), (1e-6, -1275.4, 0.05), (1e-8, -12730.0, 1.0)]
)
def test_stretching_grows_as_the_inverse_speed(depth, entry, digits, tangent_entries, case):
    shrink = 0.5 / abs(entry)
    found = tangent_entries(case(1).thrown(depth), 2.0, landing(depth), [[shrink, 0], [0, 0]])
    stretch = min(found.real) / shrink
    assert stretch == pytest.approx(entry, abs=digits)
    # a position rounded to 1e-16 at the ceiling is a speed rounded to 1e-16 over itself
    assert stretch == pytest.approx(case(1).exact(depth), rel=max(1e-11, 2e-16 / depth))


@pytest.mark.parametrize("depth", [1e-4, 1e-6, 1e-8])
def test_the_tangent_of_the_start_has_six_digits_and_more(depth, tangent_map, case):
    state, matrix = tangent_map(case(1).thrown(depth), 2.0)
    assert matrix[0, 0] == pytest.approx(case(1).exact(depth), rel=max(1e-11, 2e-16 / depth))
    assert state == pytest.approx(landing(depth), abs=1e-13 / depth**0.5)


@pytest.mark.parametrize("depth", [1e-4, 1e-8])
def test_the_smallest_normal_speed_is_reported(depth, case):
    spectrum = cd.lyapunov_spectrum(case(1).thrown(depth), duration=2.0)
    assert float(spectrum["closest_grazing"]) == pytest.approx((2 * depth) ** 0.5, rel=1e-6)


def test_a_ball_that_stays_below_does_not_hit(case):
    run = cd.trajectory(case(1).thrown(-1e-8), duration=2.0)
    assert run.sizes["event"] == 0


def test_a_jump_at_exactly_no_speed_has_no_tangent_and_no_exponent():
    x, v = sympy.symbols("x v", real=True)
    kicked = cd.HybridSystem(
        name="kicked from rest",
        states=(x, v),
        parameters={},
        modes={"all": {x: v, v: 1 - x}},
        transitions=[cd.Transition("kick", "all", "all", guard=x, direction=+1, reset={v: -1})],
        initial={"mode": "all", x: 0.0, v: 0.0},
    )
    spectrum = cd.lyapunov_spectrum(kicked, duration=2.0)
    assert int(spectrum["outcome"]) == cd.Outcome.NONFINITE
    assert np.isnan(spectrum["lyapunov_exponent"].values).all()
    assert float(spectrum["closest_grazing"]) == 0.0
    # the motion itself is as good as any
    assert cd.trajectory(kicked, duration=2.0)["event_time"].values == pytest.approx([0.0, np.pi / 2], abs=1e-14)


# Case 2: infinitely many impacts in finite time end, and the contact is held until its force changes sign.


def ball(e, completed=True):
    landing = {"guard": X, "direction": -1}
    rest = [cd.Transition("rest", "flight", "contact", reset={X: 0, V: 0}, completes="impact", **landing)]
    return cd.HybridSystem(
        name="ball",
        states=(X, V),
        parameters={"e": e},
        modes={"flight": {X: V, V: -1}, "contact": {X: 0, V: 0}},
        transitions=[cd.Transition("impact", "flight", "flight", reset={V: -E * V}, **landing), *(rest * completed)],
        initial={"mode": "flight", X: 0.0, V: 1.0},
    )


def names(run):
    return run.cd.words("event_kind").values.tolist()


def events(run, name):
    return run.cd.words("event_kind").values == name


@pytest.mark.parametrize("e", [0.0, 0.1, 0.5, 0.9, 0.99])
def test_the_bounces_end_at_their_limit(e):
    run = cd.trajectory(ball(e), duration=2 / (1 - e) + 1, samples=10)
    rest = events(run, "rest")
    assert rest.sum() == 1
    assert run["event_time"].values[rest] == pytest.approx(2 / (1 - e), abs=1e-9)
    np.testing.assert_allclose(run["event_state_after"].values[rest], 0.0, atol=1e-12)
    assert int(run["outcome"]) == cd.Outcome.OK
    np.testing.assert_array_equal(run["states"].values[-1], [0.0, 0.0])


def test_a_held_contact_leaves_no_tangent():
    spectrum = cd.lyapunov_spectrum(ball(0.5), duration=10.0)
    assert spectrum["lyapunov_exponent"].values.tolist() == [-np.inf, -np.inf]
    assert int(spectrum["rank"]) == 0


def test_without_a_mode_that_holds_the_contact_the_run_says_so():
    assert int(cd.trajectory(ball(0.5, completed=False), duration=5.0)["outcome"]) == cd.Outcome.STALLED


@pytest.mark.parametrize("gamma", [1.05, 1.3, 1.6])
def test_the_ball_leaves_a_moving_table_where_its_force_vanishes(gamma):
    system = cd.build("bouncing-ball", {"amplitude": gamma, "e": 0.1}, initial={"x": gamma + 1.0, "v": 0.0})
    run = cd.trajectory(system, periods=12, samples=4)
    left = events(run, "lift-off")
    assert left.sum() > 5
    np.testing.assert_allclose(np.sin(run["event_time"].values[left]), 1 / gamma, atol=1e-13)
    assert np.all(np.cos(run["event_time"].values[left]) > 0)


def test_a_table_that_holds_the_ball_once_a_period_leaves_no_tangent():
    system = cd.build("bouncing-ball", {"amplitude": 1.3, "e": 0.1}, initial={"x": 2.3, "v": 0.0})
    spectrum = cd.lyapunov_spectrum(system, periods=200, transient=10)
    counts = dict(zip(spectrum["transition"].values, spectrum["event_count"].values, strict=True))
    assert counts["rest"] >= 199
    assert spectrum["lyapunov_exponent"].values.tolist() == [-np.inf, -np.inf]
    assert int(spectrum["rank"]) == 0
    assert int(spectrum["outcome"]) == cd.Outcome.PERIODIC


def test_a_ball_that_starts_at_rest_rests():
    run = cd.trajectory(ball(0.5).with_initial(x=0.0, v=0.0), duration=1.0)
    assert events(run, "rest").sum() == 1
    assert int(run["outcome"]) == cd.Outcome.OK


def test_a_hold_that_began_before_the_averages_leaves_no_tangent_either():
    system = cd.build("bouncing-ball", {"amplitude": 0.0, "e": 0.5}, initial={"x": 0.0, "v": 1.0})
    spectrum = cd.lyapunov_spectrum(system, periods=10, transient=10)
    assert spectrum["lyapunov_exponent"].values.tolist() == [-np.inf, -np.inf]


# Case 3: a ball that bounces ever lower never gets below the floor.


def test_bounces_come_at_their_times_until_they_cannot_be_told_apart(case):
    run = cd.trajectory(case(3).ball(0.5), duration=3.999999, samples=1000)
    times = run["event_time"].values
    # after n flights 4 (1 - 2^-n); the last digit of the time is what limits them
    expected = 4 * (1 - 0.5 ** np.arange(1, len(times) + 1))
    assert len(times) == 21
    np.testing.assert_allclose(times, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(-run["event_speed"].values, 0.5 ** np.arange(len(times)), rtol=1e-8)


def test_the_ball_is_never_below_the_floor_and_the_end_has_a_name(case):
    run = cd.trajectory(case(3).ball(0.5), duration=5.0, samples=1000)
    assert run.sizes["event"] >= 48
    heights = run["states"].values[:, 0]
    assert np.nanmin(heights) >= 0
    assert np.all(run["event_state_after"].values[:, 0] == 0)
    assert int(run["outcome"]) in (cd.Outcome.EVENT_LIMIT, cd.Outcome.STALLED)


def test_a_thousand_bounces_lose_no_height(case):
    run = cd.trajectory(case(3).ball(0.999), duration=1260.0, samples=10)
    speeds = -run["event_speed"].values
    assert len(speeds) > 900
    np.testing.assert_allclose(speeds, 0.999 ** np.arange(len(speeds)), rtol=1e-11)
    assert int(run["outcome"]) not in (cd.Outcome.EVENT_LIMIT, cd.Outcome.STALLED)


# Case 4: two crossings inside one step are both found.


@pytest.mark.parametrize("gap", [1e-2, 1e-6, 1e-10])
def test_both_crossings_are_found(gap, case):
    run = cd.trajectory(case(4).parabola(gap), duration=2.0, samples=2)
    half = np.sqrt(gap)
    # a start rounded to 1e-16 moves a crossing at speed 2 sqrt(gap) by this much
    slack = 1e-15 / half
    np.testing.assert_allclose(run["event_time"].values, [1 - half, 1 + half], rtol=0, atol=slack)


@pytest.mark.parametrize(("direction", "sign"), [(+1, -1), (-1, +1)])
def test_a_direction_picks_one_of_them(direction, sign, case):
    run = cd.trajectory(case(4).parabola(1e-6, direction), duration=2.0, samples=2)
    np.testing.assert_allclose(run["event_time"].values, [1 + sign * 1e-3], rtol=0, atol=1e-12)


def test_a_parabola_that_stays_below_crosses_nothing(case):
    assert cd.trajectory(case(4).parabola(-1e-10), duration=2.0, samples=2).sizes["event"] == 0


# Case 5: of two guards that are reached together the one with the larger priority acts first, and ties are counted.


ORDERS = [((1, 0), ["p-first", "q-last"], [[1, 0], [0.5, 0.5]]), ((0, 1), ["q-first", "p-last"], [[0.5, 0.5], [0, 1]])]


@pytest.mark.parametrize(("priorities", "order", "matrix"), ORDERS)
def test_priority_decides_the_order(priorities, order, matrix, case):
    run = cd.trajectory(case(5).corner(*priorities), duration=2.0, samples=4)
    assert names(run) == order
    np.testing.assert_allclose(run["event_time"].values, 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(run["states"].values[-1], [1.0, 1.0], atol=1e-13)


@pytest.mark.parametrize(("priorities", "order", "matrix"), ORDERS)
def test_the_order_decides_the_tangent(priorities, order, matrix, tangent_entries, case):
    probe = np.array([[0.3, 0.2], [0.1, 0.4]])
    found = tangent_entries(case(5).corner(*priorities), 2.0, (1.0, 1.0), probe.tolist())
    np.testing.assert_allclose(np.sort(found), np.sort(np.linalg.eigvals(probe @ matrix)), atol=1e-9)


def test_ties_are_counted(case):
    spectrum = cd.lyapunov_spectrum(case(5).corner(1, 0), duration=2.0)
    assert int(spectrum["tie_count"]) == 1


def test_a_drill_whose_release_and_hit_coincide_hits_first():
    # r = 1 and xi = 0: friction gives way where the stop is
    system = cd.drill(eta=0.8, xi=0.0, r=1.0)
    run = cd.trajectory(system, periods=50)
    happened = names(run)
    assert "strong-hit" in happened
    assert "release" not in happened
    assert run["states"].values[:, 0].max() <= 1 + 1e-12


def test_the_drill_counts_those_ties():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.8, xi=0.0, r=1.0), periods=50)
    counts = dict(zip(spectrum["transition"].values, spectrum["event_count"].values, strict=True))
    assert counts["strong-hit"] > 0
    assert int(spectrum["tie_count"]) == counts["strong-hit"]


# Case 6: a direction that is lost is lost exactly, and how many follows from the product of the maps.


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
    counts = dict(zip(spectrum["transition"].values, spectrum["event_count"].values, strict=True))
    assert counts["stick"] > 1000


def test_a_drill_that_never_sticks_loses_nothing():
    spectrum = cd.lyapunov_spectrum(cd.drill(rock="fixed", friction="none"), periods=500, transient=100)
    assert np.isfinite(spectrum["lyapunov_exponent"].values).all()


# Case 7: a resolved contact comes to the mapped one as k^(-1/(n+1)), no faster and no slower.


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_the_trace_approaches_with_the_slope_of_theory(n, case):
    found = case(7).traces(n, (1e6, 1e8, 1e10))
    slopes = [log(found[high] / found[low]) / log(high / low) for low, high in ((1e6, 1e8), (1e8, 1e10))]
    # what is left is of the next order in k^(-1/(n+1))
    assert slopes == pytest.approx([-1 / (n + 1)] * 2, abs=2e-3)
    assert abs(slopes[1] + 1 / (n + 1)) < abs(slopes[0] + 1 / (n + 1))


def test_multipliers_of_a_stiff_cycle_agree_between_methods(case):
    stop = case(7).resolved(1e8, 1.0)
    (_, taylor), (_, runge_kutta) = (case(7).cycle(stop, method) for method in ("taylor", "dop853"))
    np.testing.assert_allclose(np.sort_complex(taylor), np.sort_complex(runge_kutta), rtol=0, atol=1e-8)


def test_a_soft_stop_is_another_system(case):
    assert case(7).cycle(case(7).mapped())[0] == 1
    assert case(7).cycle(case(7).resolved(1e4, 1.0))[0] == 3


# Case 8: tangents through a stiff contact are as good as the state, and the flow direction comes through it.


@pytest.mark.parametrize(("k", "digits"), [(1e6, 1e-10), (1e8, 1e-9), (1e10, 1e-8), (1e12, 1e-7)])
def test_state_and_tangent_in_closed_form(k, digits, case, tangent_map):
    stiff = case(8)
    later = stiff.contact_time(k) + 1e-5
    state, matrix = tangent_map(stiff.pressed(k), later)
    assert state[1] == pytest.approx(-stiff.SPEED + stiff.LOAD * 1e-5, abs=1e-11)
    assert matrix[1, 0] == pytest.approx(stiff.entry(k), abs=digits)
    np.testing.assert_allclose(matrix @ [stiff.SPEED, stiff.LOAD], [state[1], stiff.LOAD], atol=digits)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=digits)


def test_a_contact_that_has_no_series(case, tangent_map):
    stiff = case(8)
    later = stiff.contact_time(1e8, 1.5) + 1e-5
    state, matrix = tangent_map(stiff.pressed(1e8, 1.5), later, method="dop853")
    # on the way tangents are as long as the contact's frequency at its deepest, and exact to a part of that
    error = 4e-12 * stiff.frequency(1e8, 1.5)
    assert matrix[1, 0] == pytest.approx(stiff.entry(1e8, 1.5), abs=error)
    np.testing.assert_allclose(matrix @ [stiff.SPEED, stiff.LOAD], [state[1], stiff.LOAD], atol=error)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=error)


@pytest.mark.parametrize(("k", "n"), [(1e12, 1.0), (1e8, 1.5)])
def test_a_fixed_step_that_is_good_to_four_digits_in_the_state_is_not_in_the_tangent(k, n, case):
    stiff = case(8)
    speed, derivative = stiff.runge_kutta(k, n)
    assert speed == pytest.approx(-stiff.SPEED, abs=1e-4)
    assert abs(derivative - stiff.entry(k, n)) > 1


@pytest.mark.parametrize(("tolerance", "digits"), [(1e-4, 1e-1), (1e-6, 1e-3), (1e-8, 1e-5)])
def test_the_tangent_follows_the_tolerance(tolerance, digits, case, tangent_map):
    stiff = case(8)
    _, matrix = tangent_map(stiff.pressed(1e8), stiff.contact_time(1e8) + 1e-5, tolerance=tolerance)
    assert matrix[1, 0] == pytest.approx(stiff.entry(1e8), abs=digits)


# Case 9: a million periods lose no digit of the state, and the advance is summed without loss.


POINT = (0.5117707419326684, 0.2579689590074009, 0.3668787222623992)

PROGRESSION = 0.1163908540290498

LONG = 1_000_000


@pytest.fixture(scope="module")
def late():
    return cd.poincare_section(cd.drill(eta=0.8), periods=4, transient=LONG)


def test_the_cycle_is_where_it_was(late):
    np.testing.assert_allclose(late["section"].values, [POINT] * late.sizes["iterate"], rtol=0, atol=1e-12)


def test_phase_is_kept(late):
    strobes = late["time"].values * 0.8 / (2 * np.pi)
    np.testing.assert_allclose(strobes, np.round(strobes), rtol=1e-14)
    assert round(strobes[-1]) >= LONG


def test_advance_is_summed_without_loss():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.8), periods=100_000, transient=200)
    assert float(spectrum["progression_rate"]) == pytest.approx(PROGRESSION, rel=1e-13)


# Case 10: where the force is exactly at friction, its rate decides, and nothing flickers.


TINY = 2.0**-20


@pytest.mark.parametrize("mode", ["stick", "slip"])
def test_at_rest_on_the_threshold_nothing_happens(mode, case):
    run = cd.trajectory(case(10).drill(0.0, mode), duration=100.0, samples=10)
    assert run.sizes["event"] == 0
    assert int(run["outcome"]) == cd.Outcome.OK
    np.testing.assert_array_equal(run["states"].values, [[1.0, 0.0, 0.0]] * 11)


@pytest.mark.parametrize("u", [0.25, TINY])
def test_a_rising_demand_lets_go_at_once(u, case):
    run = cd.trajectory(case(10).drill(u, "stick"), duration=3.0, samples=10)
    assert names(run) == ["release"]
    assert run["event_time"].values[0] == 0.0
    assert names(cd.trajectory(case(10).drill(u, "slip"), duration=3.0, samples=10)) == []


@pytest.mark.parametrize("u", [-0.25, -TINY])
def test_a_falling_demand_sticks_until_it_comes_back(u, case):
    # in stick the demand follows a damped oscillation, which is back at its threshold after half a turn
    back = pi / sqrt(1 - case(10).XI ** 2)
    run = cd.trajectory(case(10).drill(u, "stick"), duration=4.0, samples=10, tolerance=1e-14)
    assert names(run) == ["release"]
    assert run["event_time"].values[0] == pytest.approx(back, abs=1e-15 / abs(u) + 1e-13)
    run = cd.trajectory(case(10).drill(u, "slip"), duration=4.0, samples=10, tolerance=1e-14)
    assert names(run) == ["stick", "release"]
    assert run["event_time"].values == pytest.approx([0.0, back], abs=1e-15 / abs(u) + 1e-13)


@pytest.mark.parametrize("mode", ["stick", "slip"])
@pytest.mark.parametrize("u", [0.0, 0.25, -0.25])
def test_exponents_are_numbers_or_minus_infinity(mode, u, case):
    spectrum = cd.lyapunov_spectrum(case(10).drill(u, mode), duration=200.0, transient=100)
    assert not np.isnan(spectrum["lyapunov_exponent"].values).any()


# Case 11: sticking that is only just touched, and a cycle that begins to stick.


def test_smoothed_friction_has_the_exponents_of_its_equations(case):
    """Those that DOP853 of scipy finds with bounded steps, orthonormalising eight times a period."""
    found = case(11).smoothed(case(11).grazing_force() * (1 + 1e-10), 0.01)
    np.testing.assert_allclose(found, [-0.09841, -0.87252], rtol=0, atol=2e-5)


@pytest.mark.parametrize("excess", [1e-12, 1e-10, 1e-6, 1e-2])
def test_a_demand_that_only_just_exceeds_friction_lets_go(excess, case):
    run = cd.trajectory(case(11).block(1 + excess), periods=3, samples=2)
    release, stick = case(11).slipping(1 + excess)
    peaks = 1 + 2 * pi * np.arange(3)
    expected = np.ravel([peaks + release, peaks + stick], order="F")
    # the demand near its peak is flat: round-off moves a crossing of slope `release` by this much
    np.testing.assert_allclose(run["event_time"].values, expected, rtol=0, atol=1e-15 / abs(release) + 1e-14)


@pytest.mark.parametrize("excess", [-1e-14, -1e-10, -1e-6])
def test_a_demand_that_stays_below_does_not(excess, case):
    assert cd.trajectory(case(11).block(1 + excess), periods=3, samples=2).sizes["event"] == 0


@pytest.mark.parametrize("short", [-1e-2, -1e-6])
def test_below_the_belt_speed_both_exponents_are_the_damping(short, case):
    sliding = case(11)
    system = sliding.on_a_belt(sliding.grazing_force() * (1 + short))
    section = cd.poincare_section(system, periods=4, transient=1000)
    modulus = np.hypot(section["multiplier_real"].values, section["multiplier_imag"].values)
    assert modulus == pytest.approx([exp(-sliding.ZETA * 2 * pi / sliding.OMEGA)] * 2, rel=1e-10)
    spectrum = cd.lyapunov_spectrum(system, periods=500, transient=1000)
    assert spectrum["lyapunov_exponent"].values.sum() == pytest.approx(-2 * sliding.ZETA, abs=1e-12)
    assert int(spectrum["rank"]) == 2


@pytest.mark.parametrize("beyond", [1e-10, 1e-8, 1e-6])
def test_from_the_first_touch_on_one_exponent_is_minus_infinity(beyond, case):
    sliding = case(11)
    system = sliding.on_a_belt(sliding.grazing_force() * (1 + beyond))
    section = cd.poincare_section(system, periods=4, transient=1000)
    limit = sliding.multiplier_beyond()
    # the cycle leaves its limit as the square root of how far the force is beyond
    assert section["multiplier_real"].values[0] == pytest.approx(limit, abs=3 * beyond**0.5)
    assert section["multiplier_real"].values[1] == section["multiplier_imag"].values[1] == 0.0
    spectrum = cd.lyapunov_spectrum(system, periods=200, transient=1000)
    first, second = spectrum["lyapunov_exponent"].values
    assert first == pytest.approx(log(abs(limit)) * sliding.OMEGA / (2 * pi), abs=3 * beyond**0.5)
    assert second == -np.inf
    assert int(spectrum["rank"]) == 1


# Case 12: a period-1 orbit has one impact speed; without event location it shows hundreds.


@pytest.mark.parametrize(
    ("settings", "spread"),
    [
        ({"tolerance": 1e-12}, 1e-11),
        ({"tolerance": 1e-6}, 1e-5),
        ({"method": "rk4", "steps": 200, "tolerance": 1e-12}, 1e-10),
        ({"method": "rk4", "steps": 50, "tolerance": 1e-12}, 1e-10),
    ],
    ids=str,
)
def test_all_impacts_have_one_speed(settings, spread):
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6, "e": 0.8})
    run = cd.trajectory(system, periods=400, transient=2000, samples=2, **settings)
    speeds = run["event_speed"].values
    assert len(speeds) == 400
    assert np.ptp(speeds) < spread * speeds.mean()


# Case 13: a bit that runs away has escaped; its numbers are missing, not large.


def test_from_rest_the_bit_runs_away_between_two_frequencies():
    diagram = cd.bifurcation_diagram(cd.drill(), {"eta": np.array([0.448, 0.48, 0.49, 0.6])}, transient=300, periods=32)
    outcome = diagram["outcome"].values[:, 0]
    assert list(outcome == cd.Outcome.ESCAPED) == [False, True, True, False]
    lost = diagram.isel(eta=[1, 2], seed=0)
    assert np.isnan(lost["section"].values).all()
    assert np.isnan(lost["lyapunov_exponent"].values).all()
    assert np.isnan(lost["progression_rate"].values).all()
    assert (lost["period"].values == 0).all()
    assert np.isfinite(diagram["progression_rate"].isel(eta=[0, 3], seed=0).values).all()


@pytest.mark.parametrize("eta", [0.448, 0.6, 0.8])
def test_a_fast_bit_runs_away_at_any_frequency(eta):
    system = cd.drill(eta=eta, initial={"y": -1.0, "u": 2.0, "mode": "stick"})
    spectrum = cd.lyapunov_spectrum(system, periods=500, transient=100)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED
    assert np.isnan(spectrum["lyapunov_exponent"].values).all()


@pytest.mark.parametrize("transient", [0, 10])
def test_a_bit_that_runs_away_while_averages_are_taken_has_no_rates(transient):
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.48), periods=500, transient=transient)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED
    for name in ("progression_rate", "progression_error", "events_per_period", "impacts_per_period"):
        assert np.isnan(spectrum[name]), name


def test_the_last_point_of_a_trajectory_is_near_the_bound_that_it_left():
    run = cd.trajectory(cd.drill(eta=0.48), periods=500, samples=20)
    assert int(run["outcome"]) == cd.Outcome.ESCAPED
    rock = run["states"].values[:, 2]
    known = rock[np.isfinite(rock)]
    assert 24 < known[-1] < 27
    assert len(known) > 100


def test_kinetic_friction_above_the_load_lets_nothing_run_away():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.48, mu=0.75), periods=300, transient=100)
    assert int(spectrum["outcome"]) != cd.Outcome.ESCAPED
    assert np.isfinite(spectrum["progression_rate"])


def test_a_rock_that_nothing_holds_runs_away():
    spectrum = cd.lyapunov_spectrum(cd.drill(friction="none"), periods=500)
    assert int(spectrum["outcome"]) == cd.Outcome.ESCAPED


# Case 14: what the study compares with is right; the laws themselves are held by tests/engine.


def test_the_guard_beside_a_decay_rises_where_the_study_says(case):
    times = case(14).rises()
    assert len(times) == 32
    x, y = -np.cos(10 * times), 0.1 * np.cos(20 * times)
    np.testing.assert_allclose(x - y, 0.3, rtol=0, atol=1e-13)
    assert (10 * np.sin(10 * times) + 2 * np.sin(20 * times) > 0).all()


def test_the_energy_of_the_oscillator_has_its_size_and_rate_taken_out(case):
    x = np.array([2e-6, 1e-6])
    found = case(14).energy(x, 0 * x, 2e-6, 1e5)
    assert found[0] == pytest.approx(3 / 4)
    assert found[1] == pytest.approx(1 / 8 + 1 / 64)


def test_the_clock_escapement_is_damped_as_its_turn_says(case):
    """Its characteristic polynomial s**2 + s/5 + 1 has the frequency sqrt(0.99)."""
    assert max(np.roots([1, 0.2, 1]).imag) == pytest.approx(math.sqrt(0.99))
    assert [t.direction for t in case(14).escapement().transitions] == [1]

"""Case 2: infinitely many impacts in finite time end, and the contact is held until its force changes sign."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd

X, V, E = sympy.symbols("x v e", real=True)


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


def events(run, name):
    return run["event_kind"].values == run["event_kind"].attrs["flag_meanings"].split().index(name)


@pytest.mark.parametrize("e", [0.0, 0.1, 0.5, 0.9, 0.99])
def test_the_bounces_end_at_their_limit(e):
    run = cd.trajectory(ball(e), duration=2 / (1 - e) + 1, samples=10)
    rest = events(run, "rest")
    assert rest.sum() == 1
    assert run["event_time"].values[rest] == pytest.approx(2 / (1 - e), abs=1e-9)
    np.testing.assert_allclose(run["event_state_after"].values[rest], 0.0, atol=1e-12)
    assert int(run["outcome"]) == cd.Outcome.OK
    np.testing.assert_array_equal(run["state"].values[-1], [0.0, 0.0])


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
    counts = dict(zip(spectrum["transition_name"].values, spectrum["event_count"].values, strict=True))
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

"""Trajectories against scipy at a tight tolerance, and against the parabolas of a bouncing ball."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import chaosdrill as cd


def reference(times, start, begin=0.0):
    def field(t, y):
        x, v = y[:2]
        return [v, x - x**3 - 0.25 * v + 0.4 * np.cos(t), v * v, v]

    span = (begin, times[-1])
    return solve_ivp(field, span, [*start, 0, 0], method="DOP853", rtol=3e-14, atol=1e-15, t_eval=times).y


def test_smooth_forced_flow(duffing):
    run = cd.trajectory(duffing, periods=3, samples=40)
    times = np.arange(121) * 2 * np.pi / 40
    np.testing.assert_allclose(run["time"].values, times, rtol=1e-14)
    x, v, work, drift = reference(times, (0.5, -0.2))
    # the flow stretches by some hundred in three periods
    np.testing.assert_allclose(run["states"].values, np.array([x, v]).T, rtol=0, atol=1e-11)
    np.testing.assert_allclose(run["work"].values, work, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(run["penetration"].values, drift, rtol=0, atol=1e-11)
    assert int(run["outcome"]) == cd.Outcome.OK
    assert run.sizes["event"] == 0


def test_after_a_transient_phase_and_time_go_on(duffing):
    late = cd.trajectory(duffing, periods=1, transient=2, samples=10)
    whole = cd.trajectory(duffing, periods=3, samples=10)
    np.testing.assert_allclose(late["time"].values, whole["time"].values[20:], rtol=1e-14)
    x, v, _, _ = reference(np.arange(31) * 2 * np.pi / 10, (0.5, -0.2))
    np.testing.assert_allclose(late["states"].values, np.array([x, v]).T[20:], rtol=0, atol=1e-11)
    assert float(late["work"][0]) == 0.0


def test_runge_kutta_agrees(duffing):
    run = cd.trajectory(duffing, periods=1, samples=8, method="rk4", steps=4000)
    x, v, _, _ = reference(np.arange(9) * 2 * np.pi / 8, (0.5, -0.2))
    np.testing.assert_allclose(run["states"].values, np.array([x, v]).T, rtol=0, atol=1e-11)


G, E, X0, V0 = 2.0, 0.75, 1.0, 3.0


def bounces(count):
    """Times and approach speeds of the hits, by hand."""
    speed = np.sqrt(V0**2 + 2 * G * X0)
    time, times, speeds = (V0 + speed) / G, [], []
    for _ in range(count):
        times.append(time)
        speeds.append(speed)
        speed *= E
        time += 2 * speed / G
    return np.array(times), np.array(speeds)


def height(t):
    times, speeds = bounces(40)
    last = np.searchsorted(times, t) - 1
    if last < 0:
        return X0 + V0 * t - G * t * t / 2
    s = t - times[last]
    return E * speeds[last] * s - G * s * s / 2


@pytest.fixture(scope="module")
def bounced(bouncer):
    return cd.trajectory(bouncer, duration=10.0, samples=500)


def test_heights_are_parabolas(bounced):
    exact = [height(t) for t in bounced["time"].values]
    np.testing.assert_allclose(bounced["states"].values[:, 0], exact, rtol=0, atol=1e-12)


def test_events_are_all_there_in_order(bounced):
    kinds = bounced.cd.words("event_kind").values
    times, speeds = bounces(20)
    times, speeds = times[times <= 10], speeds[times <= 10]
    assert list(kinds) == (["apex", "hit"] * (len(times) + 1))[: len(kinds)]
    hits = kinds == "hit"
    np.testing.assert_allclose(bounced["event_time"].values[hits], times, rtol=0, atol=1e-12)
    np.testing.assert_allclose(bounced["event_speed"].values[hits], -speeds, rtol=1e-12)
    np.testing.assert_allclose(bounced["event_state_before"].values[hits, 1], -speeds, rtol=1e-12)
    np.testing.assert_allclose(bounced["event_state_after"].values[hits, 1], E * speeds, rtol=1e-12)
    assert np.all(np.diff(bounced["event_time"].values) > 0)
    # a mark changes nothing, and at the apex the guard v falls at the rate g
    marks = bounced.isel(event=~hits)
    np.testing.assert_array_equal(marks["event_state_before"].values, marks["event_state_after"].values)
    np.testing.assert_allclose(marks["event_speed"].values, -G, rtol=1e-12)


def test_events_of_a_late_record(bouncer):
    """The transient is a time here, and event times go on from it."""
    late = cd.trajectory(bouncer, duration=3.0, transient=5.0, samples=4)
    times, _ = bounces(20)
    hits = late["event_time"].values[late["event_kind"].values == 1]
    np.testing.assert_allclose(hits, times[(times > 5) & (times <= 8)], rtol=0, atol=1e-12)
    np.testing.assert_allclose(late["time"].values, 5 + 0.75 * np.arange(5), rtol=1e-14)


def test_a_run_that_ends_early_keeps_what_it_has(circle):
    run = cd.trajectory(circle.with_parameters(growth=1.0), periods=10, samples=10)
    assert int(run["outcome"]) == cd.Outcome.ESCAPED
    times = run["time"].values
    # the bound is met at ln 100, in a step of at most one period
    assert np.log(100) - 0.1 < times[-1] < np.log(100) + 1
    radius = np.hypot(*run["states"].values.T)
    np.testing.assert_allclose(radius, np.exp(times), rtol=1e-11)


def test_progress_goes_up_to_the_end(duffing):
    seen = []
    cd.trajectory(duffing, periods=5, transient=2, samples=3, progress=lambda *call: seen.append(call))
    assert seen[-1] == (5, 5, None)
    assert [done for done, _, _ in seen] == sorted(done for done, _, _ in seen)


def test_more_events_than_a_buffer_holds(circle):
    """One mark a turn, 0.2 a period: 6000 events need two buffers, none is lost or doubled at the seam."""
    run = cd.trajectory(circle.with_initial(x=0.8, y=-0.6), periods=30_000, samples=1)
    times = run["event_time"].values
    np.testing.assert_allclose(np.diff(times), 5.0, rtol=0, atol=1e-8)
    assert len(times) == 6000


def test_tangents_that_a_method_loses_are_told():
    """Where the root has a kink its derivative is 0/0; `radau` passes it with the state alone."""
    system = cd.HybridSystem(states="x y", modes={"all": {"x": "-1", "y": "sqrt(x - log(1 + x))"}}, initial={"x": 0.5})
    run = cd.trajectory(system, duration=0.8, tangents=True, method="radau")
    assert np.isfinite(run["states"]).all()
    assert float(run["time"][-1]) == 0.8
    assert np.isnan(run["final_tangent"]).all()
    (lost,) = re.findall("the tangents are lost at time ([^;]*)", run.attrs["message"])
    assert float(lost) == pytest.approx(0.5, abs=1e-6)

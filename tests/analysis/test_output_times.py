"""States at given times: those of the motion, whatever the times, and the run is the same to the bit without them."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.errors import SceneError, SettingsError

METHODS = ("taylor", "dop853", "rk4")


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator")


@pytest.fixture(scope="module")
def decay():
    """x' = -x from 1, with a mark where x falls through a half."""
    x = sympy.Symbol("x", real=True)
    mark = cd.Transition("half", source="all", target="all", guard=x - sympy.Rational(1, 2), direction=-1)
    return cd.HybridSystem(
        name="decay", states=(x,), parameters={}, modes={"all": {x: -x}}, transitions=[mark], initial={"x": 1.0}
    )


@pytest.mark.parametrize("method", METHODS)
def test_nothing_of_the_run_depends_on_the_times(oscillator, method):
    plain = cd.trajectory(oscillator, periods=40, transient=3, samples=1, method=method)
    start, end = plain["time"].values[[0, -1]]
    rng = np.random.default_rng(1)
    times = np.sort(np.concatenate([[start, end], rng.uniform(start, end, 500)]))
    timed = cd.trajectory(oscillator, periods=40, transient=3, times=times, method=method)
    for name in plain.data_vars:
        if "event" in plain[name].dims or not plain[name].dims:
            np.testing.assert_array_equal(timed[name].values, plain[name].values, err_msg=name)
    np.testing.assert_array_equal(timed["time"].values, times)
    np.testing.assert_array_equal(timed["states"].values[[0, -1]], plain["states"].values[[0, -1]])


@pytest.mark.parametrize("method", METHODS)
def test_a_closed_form_is_met(decay, method):
    times = np.array([0.0, 1e-9, 0.1, np.log(2) - 1e-6, 1.5, 2.75, 3.0])
    run = cd.trajectory(decay, times=times, method=method)
    # the steps of rk4 are fixed: it is off by t h^4 / 120 of the state
    bound = 1.01 * 3.0 * (3.0 / 200) ** 4 / 120 if method == "rk4" else 1e-12
    np.testing.assert_allclose(run["states"].sel(state="x"), np.exp(-times), rtol=bound)
    assert run.cd.events["time"].to_numpy() == pytest.approx([np.log(2)], rel=1e-9)


def test_each_time_stands_for_itself(oscillator):
    times = np.sort(np.random.default_rng(2).uniform(0, 20, 60))
    all_of_them = cd.trajectory(oscillator, periods=8, times=times)
    some = cd.trajectory(oscillator, periods=8, times=times[::7])
    np.testing.assert_array_equal(some["states"].values, all_of_them["states"].values[::7])
    np.testing.assert_array_equal(some["mode"].values, all_of_them["mode"].values[::7])


def test_a_time_at_an_event_shows_the_state_before(oscillator):
    run = cd.trajectory(oscillator, periods=30, samples=1)
    hits = run["event_time"].values
    here = cd.trajectory(oscillator, periods=30, times=hits)
    np.testing.assert_allclose(here["states"].values, run["event_state_before"].values, rtol=0, atol=1e-12)
    later = cd.trajectory(oscillator, periods=30, times=hits + 1e-9)
    np.testing.assert_allclose(later["states"].values, run["event_state_after"].values, rtol=0, atol=1e-8)


def test_samples_are_among_them(oscillator):
    sampled = cd.trajectory(oscillator, periods=5, transient=100, samples=20)
    timed = cd.trajectory(oscillator, times=sampled["time"].values, transient=100)
    np.testing.assert_allclose(timed["states"], sampled["states"], rtol=0, atol=1e-12)
    for name in ("event_time", "event_state_after"):
        np.testing.assert_array_equal(timed[name].values, sampled[name].values)


def test_quadratures_are_given_too():
    drill = cd.drill()
    sampled = cd.trajectory(drill, periods=4, samples=8)
    timed = cd.trajectory(drill, times=sampled["time"].values)
    np.testing.assert_allclose(timed["penetration"], sampled["penetration"], rtol=0, atol=1e-12)


SCENE = """
[system]
model = "impact-oscillator"
[analysis.motion]
kind = "trajectory"
times = {times}
"""


@pytest.mark.parametrize("times", ["[0, 0.5, 2.0]", "{ start = 0.0, stop = 2.0, num = 3 }"])
def test_a_scene_has_them_and_its_archive_is_verified(times, tmp_path):
    scene = cd.parse_scene(SCENE.format(times=times))
    found = cd.run(scene)
    expected = [0.0, 0.5, 2.0] if times.startswith("[") else [0.0, 1.0, 2.0]
    assert found["motion/time"].values.tolist() == expected
    assert cd.verify(cd.save(found, tmp_path / "times.nc")).equal


@pytest.mark.parametrize("times", ["[1.0, 0.5]", "[0.0, 0.0]", "3.0", '["a"]'])
def test_times_of_a_scene_that_cannot_be(times):
    with pytest.raises(SceneError, match="times"):
        cd.parse_scene(SCENE.format(times=times))


@pytest.mark.parametrize(
    ("times", "told"),
    [
        ([], "must not be empty"),
        ([0.0, 0.0], "contains a value twice"),
        ([1.0, 0.5], "must ascend"),
        ([0.0, float("nan")], "finite"),
        ([-1.0, 2.0], "times count from the start of the run"),
        ([0.0, 1e3], "times count from the start of the run"),
        (3.0, "expected a list of numbers"),
    ],
)
def test_times_that_cannot_be(oscillator, times, told):
    with pytest.raises(SettingsError, match=told):
        cd.trajectory(oscillator, periods=2, times=times)


def test_samples_beside_times_are_refused(oscillator):
    with pytest.raises(SettingsError, match="samples is 7; times are given"):
        cd.trajectory(oscillator, times=[0.0, 1.0], samples=7)
    with pytest.raises(SceneError, match="samples: times are given"):
        cd.parse_scene(SCENE.format(times="[0, 1]") + "samples = 7\n")
    assert cd.trajectory(oscillator, periods=2).sizes["time"] == 401


def test_a_run_that_ends_early_keeps_what_it_has():
    x = sympy.Symbol("x", real=True)
    grows = cd.HybridSystem(
        name="grows", states=(x,), parameters={}, modes={"all": {x: x}}, bounds={x: (-10, 10)}, initial={"x": 1.0}
    )
    run = cd.trajectory(grows, times=[0.5, 1.0, 5.0])
    assert run.cd.outcome == "escaped"
    np.testing.assert_allclose(run["states"].values[:, 0], np.exp([0.5, 1.0]), rtol=1e-12)


def test_a_run_ends_at_the_last_time(oscillator):
    longer = cd.trajectory(oscillator, periods=8, samples=1)
    end = float(longer["event_time"].values[3]) - 1e-6
    run = cd.trajectory(oscillator, times=[0.0, end])
    np.testing.assert_array_equal(run["event_time"].values, longer["event_time"].values[:3])
    assert cd.trajectory(oscillator, periods=8, times=[0.0, end]).sizes["event"] == longer.sizes["event"]


def test_what_ends_a_run_behind_the_last_time_is_not_told():
    driven = cd.HybridSystem(
        states="x", modes={"all": {"x": "x + sin(t)/9"}}, period="2*pi", bounds={"x": (-10, 10)}, initial={"x": 1.0}
    )
    assert cd.trajectory(driven, periods=1).cd.outcome == "escaped"
    run = cd.trajectory(driven, times=[0.0, 1.0])
    assert run.cd.outcome == "ok"
    assert "message" not in run.attrs
    assert (cd.trajectory(driven, times=[0.0, 1.0], initial={"x": [1.0, 2.0]}).cd.outcome == "ok").all()

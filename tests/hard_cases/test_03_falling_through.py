"""Case 3: a ball that bounces ever lower never gets below the floor."""

import numpy as np

import chaosdrill as cd


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
    heights = run["state"].values[:, 0]
    assert np.nanmin(heights) >= 0
    assert np.all(run["event_state_after"].values[:, 0] == 0)
    assert int(run["outcome"]) in (cd.Outcome.EVENT_LIMIT, cd.Outcome.STALLED)


def test_a_thousand_bounces_lose_no_height(case):
    run = cd.trajectory(case(3).ball(0.999), duration=1260.0, samples=10)
    speeds = -run["event_speed"].values
    assert len(speeds) > 900
    np.testing.assert_allclose(speeds, 0.999 ** np.arange(len(speeds)), rtol=1e-11)
    assert int(run["outcome"]) not in (cd.Outcome.EVENT_LIMIT, cd.Outcome.STALLED)

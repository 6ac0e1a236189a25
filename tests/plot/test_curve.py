"""The curve that pictures draw jumps exactly at the events, and knows modes, walls and strobe points."""

from itertools import pairwise

import numpy as np

from chaosdrill.plot.curve import join, last_part, stops, strobe


def test_both_sides_of_every_event_stand_at_the_same_time_in_order(ball):
    curve = join(ball)
    assert curve.time.size == 401 + 2 * 10
    assert np.all(np.diff(curve.time) >= 0)
    at = np.flatnonzero(curve.time == 4.0)
    # before, after, and the sample that the archive has there anyway
    assert curve.state[at, 1].tolist() == [-1.0, 1.0, 1.0]


def test_bands_cover_the_whole_time_and_alternate(ball):
    bands = join(ball).bands()
    assert bands[0][0] == 0.0
    assert bands[-1][1] == 20.0
    assert all(a[1] == b[0] and a[2] != b[2] for a, b in pairwise(bands))
    # x < 1/4 near the ends of a flight: t (2 - t) = 1/2 at t = 1 - 1/sqrt 2, so that much of every half flight is wet
    wet = sum(end - start for start, end, mode in bands if mode == 1)
    assert abs(wet - 20 * (1 - 1 / np.sqrt(2))) < 20 * 0.05


def test_a_wall_is_found_where_the_state_jumps_and_nowhere_else(ball):
    assert stops(ball, 0) == [("bounce_off", 0.0)]
    assert stops(ball, 1) == []


def test_events_that_change_no_state_are_no_wall(ball):
    ball["event_state_after"] = ball["event_state_before"]
    assert stops(ball, 0) == []


def test_strobe_points_are_one_a_forcing_period(ball):
    assert strobe(ball).tolist() == [[0.0, 1.0]] * 11
    assert strobe(ball.drop_vars("forcing_period")).shape == (0, 2)


def test_a_long_record_is_cut_at_a_whole_forcing_period(ball):
    end = last_part(ball, 4)
    assert end["time"].values[0] == 14.0
    assert end.sizes["event"] == 4
    assert last_part(ball, 10) is ball

"""Case 4: two crossings inside one step are both found."""

import numpy as np
import pytest

import chaosdrill as cd


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

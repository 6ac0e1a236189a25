"""Case 10: where the force is exactly at friction, its rate decides, and nothing flickers."""

from math import pi, sqrt

import numpy as np
import pytest

import chaosdrill as cd

TINY = 2.0**-20


def names(run):
    meanings = run["event_kind"].attrs["flag_meanings"].split()
    return [meanings[code] for code in run["event_kind"].values]


@pytest.mark.parametrize("mode", ["stick", "slip"])
def test_at_rest_on_the_threshold_nothing_happens(mode, case):
    run = cd.trajectory(case(10).drill(0.0, mode), duration=100.0, samples=10)
    assert run.sizes["event"] == 0
    assert int(run["outcome"]) == cd.Outcome.OK
    np.testing.assert_array_equal(run["state"].values, [[1.0, 0.0, 0.0]] * 11)


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

"""What ended a run, and where, is told by every analysis, also by one whose length is a number of section points."""

import re

import numpy as np
import pytest

import chaosdrill as cd

ANALYSES = [
    cd.trajectory,
    cd.poincare_section,
    cd.lyapunov_spectrum,
    cd.finite_time_exponents,
    cd.covariant_vectors,
    cd.zero_one_test,
]


@pytest.mark.parametrize("transient", [0, 20])
@pytest.mark.parametrize("analysis", ANALYSES)
def test_a_ball_that_comes_to_rest_does_so_at_its_time(analysis, transient):
    """From the floor with speed 1 and half of it after each bounce: 2 (1 + 1/2 + 1/4 + ...) = 4."""
    floor = cd.Transition("floor", "fly", "fly", "x", -1, reset={"v": "-v/2"})
    ball = cd.HybridSystem(
        states="x v", modes={"fly": {"x": "v", "v": "-1"}}, transitions=[floor], initial={"x": 0.0, "v": 1.0}
    )
    ended = analysis(ball, at="floor", periods=1000, transient=transient)
    assert ended.cd.outcome == "stalled"
    assert _time(ended) == pytest.approx(4.0, rel=1e-9)


@pytest.mark.parametrize("analysis", ANALYSES)
def test_what_grows_leaves_its_bounds_at_its_time(analysis):
    mark = cd.Transition("one", "all", "all", "x - 2", +1)
    grows = cd.HybridSystem(
        states="x", modes={"all": {"x": "x"}}, transitions=[mark], bounds={"x": (-10, 10)}, initial={"x": 1.0}
    )
    ended = analysis(grows, at="one", periods=100)
    assert ended.cd.outcome == "escaped"
    assert _time(ended) == pytest.approx(np.log(10), rel=1e-6)


def _time(ended):
    (time,) = re.findall(r"time ([0-9.e+-]+)", ended.attrs["message"])
    return float(time.rstrip("."))

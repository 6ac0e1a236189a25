"""Case 1: a slow hit stretches without bound; the tangent is not clipped and the smallest normal speed is told."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd


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

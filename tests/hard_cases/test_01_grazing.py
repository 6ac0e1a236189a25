"""Case 1: a slow hit stretches without bound; the tangent is not clipped and the smallest normal speed is told."""

import pytest
import sympy

import chaosdrill as cd

X, V = sympy.symbols("x v", real=True)


def thrown(depth):
    """A ball thrown to a ceiling that it would overshoot by ``depth``, one time unit after the start."""
    return cd.HybridSystem(
        name="thrown ball",
        states=(X, V),
        parameters={"e": 0.8},
        modes={"flight": {X: V, V: -1}},
        transitions=[
            cd.Transition("impact", "flight", "flight", guard=X, direction=+1, reset={V: -sympy.Symbol("e") * V})
        ],
        initial={"mode": "flight", X: -0.5 + depth, V: 1.0},
    )


def landing(depth):
    """State at time 2."""
    hit = (2 * depth) ** 0.5
    fall = 1 + hit
    return -0.8 * hit * fall - fall**2 / 2, -0.8 * hit - fall


@pytest.mark.parametrize(
    ("depth", "entry", "digits"), [(1e-4, -129.9, 0.05), (1e-6, -1275.4, 0.05), (1e-8, -12730.0, 1.0)]
)
def test_stretching_grows_as_the_inverse_speed(depth, entry, digits, tangent_entries):
    shrink = 0.5 / abs(entry)
    found = tangent_entries(thrown(depth), 2.0, landing(depth), [[shrink, 0], [0, 0]])
    stretch = min(found.real) / shrink
    assert stretch == pytest.approx(entry, abs=digits)
    # the overshoot itself is rounded where the ball starts, half a unit below the ceiling
    exact = -1.8 / (2 * depth) ** 0.5 - 2.6
    assert stretch == pytest.approx(exact, rel=max(1e-11, 1e-15 / depth))


@pytest.mark.parametrize("depth", [1e-4, 1e-8])
def test_the_smallest_normal_speed_is_reported(depth):
    spectrum = cd.lyapunov_spectrum(thrown(depth), duration=2.0)
    assert float(spectrum["closest_grazing"]) == pytest.approx((2 * depth) ** 0.5, rel=1e-6)


def test_a_ball_that_stays_below_does_not_hit():
    run = cd.trajectory(thrown(-1e-8), duration=2.0)
    assert run.sizes["event"] == 0

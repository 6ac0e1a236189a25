"""Where rebounds come ever faster, the time of rest depends neither on units, nor on the method, nor on modes."""

from functools import cache

import mpmath
import numpy as np
import pytest

import chaosdrill as cd

LIMIT = 4.7719691622793349
"""When a ball on a shaker with e = 1/2 and 1.8 times gravity rests, from 84 rebounds in 60 digits."""


@pytest.fixture(scope="module")
def shaken():
    """The ball in the length unit L and the time unit T."""
    onto = {"guard": "x - A*cos(w*t)", "direction": -1}
    return cd.HybridSystem(
        name="shaken",
        states="x v",
        parameters={"L": 1.0, "T": 1.0, "e": 0.5, "A": 1.8, "w": 1.0, "g": 1.0},
        modes={"fly": {"x": "v", "v": "-g"}, "held": {"x": "-A*w*sin(w*t)", "v": "-A*w**2*cos(w*t)"}},
        transitions=[
            cd.Transition("hit", "fly", "fly", **onto, reset={"v": "-e*v - (1 + e)*A*w*sin(w*t)"}),
            cd.Transition(
                "rest", "fly", "held", **onto, reset={"x": "A*cos(w*t)", "v": "-A*w*sin(w*t)"}, completes="hit"
            ),
            cd.Transition("off", "held", "fly", guard="A*w**2*cos(w*t) - g", direction=1),
        ],
        period="2*pi/w",
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize(("length", "time"), [(1.0, 1.0), (1e-12, 1.0), (1e6, 1e-2), (1e-6, 1e6)])
def test_the_time_of_rest_in_all_units(shaken, length, time, method):
    system = shaken.with_parameters(A=1.8 * length, w=1 / time, g=length / time**2).with_initial(x=2.3 * length)
    for tolerance in (1e-9, 1e-12, 1e-14):
        run = cd.trajectory(system, periods=1, method=method, tolerance=tolerance)
        rest = run["event_time"][run["event_kind"] == 1][0] / time
        assert abs(rest - LIMIT) < max(5 * tolerance, 1e-11)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
@pytest.mark.parametrize("restitution", ["0.9", "0.95"])
def test_the_time_of_rest_after_hundreds_of_rebounds(shaken, restitution, method):
    """On a shaker of 0.6 times gravity, whose rounding hides the last rebounds long before their sum is small."""
    limit = time_of_rest("0.6", restitution)
    # about 1/(1 - e) rebounds count, and the end of all moves by 1/(1 - e) times what one comes too late
    rounding = 30 * 2**-52 * limit / (1 - float(restitution)) ** 2
    system = shaken.with_parameters(A=0.6, e=float(restitution)).with_initial(x=1.1)
    for tolerance in (1e-9, 1e-12, 1e-14):
        given = {"steps": 400} if method == "rk4" else {"tolerance": tolerance}
        run = cd.trajectory(system, periods=6, method=method, **given)
        rest = run["event_time"][run["event_kind"] == 1][0]
        assert abs(float(rest) - limit) < {"taylor": 1e-12, "rk4": 1e-9}.get(method, rounding)


def above(s, height, rate, amplitude, t, sin):
    """How far the ball is above the shaker a time after a rebound at t."""
    return height + rate * s - s * s / 2 + 2 * amplitude * sin(t + s / 2) * sin(s / 2)


@cache
def time_of_rest(amplitude, restitution):
    """When a ball from 1/2 above the shaker rests, rebound by rebound in 30 digits."""
    with mpmath.workdps(30):
        a, e = mpmath.mpf(amplitude), mpmath.mpf(restitution)
        t, speed, height = mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(1) / 2
        while height or speed > 1e-18:
            known = (height, speed - a * mpmath.sin(t), a, t)
            s = 2 * speed / (1 - a * mpmath.cos(t))
            if height or speed > 1e-3:
                steps = max(float(s), 0.1) * np.linspace(0.01, 100, 10_000)
                s = steps[np.argmax(above(steps, *map(float, known), np.sin) < 0)]
            s = mpmath.findroot(lambda s, known=known: above(s, *known, mpmath.sin), s, verify=False)
            speed = e * (s - known[1] - a * mpmath.sin(t + s))
            t, height = t + s, mpmath.mpf(0)
        return float(t)


def test_in_lanes_as_in_one_run(shaken):
    found = cd.bifurcation_diagram(shaken.with_initial(x=2.3), {"e": [0.05, 0.1, 0.2]}, transient=20, periods=40)
    assert (found["period"] == 1).all()
    assert np.isneginf(found["lyapunov_exponent"]).all()


@pytest.mark.parametrize("restitution", [0.5, 0.9, 0.99])
def test_a_ball_on_a_floor_rests_after_its_geometric_series(restitution):
    """From the height 1/2 at gravity 1: 1 + 2 e/(1 - e), with few bounces of many left out."""
    onto = {"guard": "x", "direction": -1}
    ball = cd.HybridSystem(
        name="ball",
        states="x v",
        parameters={"e": restitution},
        modes={"fly": {"x": "v", "v": "-1"}, "held": {"x": "0", "v": "0"}},
        transitions=[
            cd.Transition("hit", "fly", "fly", **onto, reset={"v": "-e*v"}),
            cd.Transition("rest", "fly", "held", **onto, reset={"x": "0", "v": "0"}, completes="hit"),
        ],
        initial={"x": 0.5},
    )
    limit = 1 + 2 * restitution / (1 - restitution)
    for duration in (1.5 * limit, 50 * limit):
        run = cd.trajectory(ball, duration=duration)
        assert run["event_kind"][-1] == 1
        assert run["event_time"][-1] == pytest.approx(limit, rel=1e-12)
        assert run.sizes["event"] < 2000


@pytest.fixture(scope="module")
def block():
    """One that rocks from its right edge to its left, as slender as k times the right."""
    upright = {"theta": "0", "v": "0"}
    right = {"guard": "theta", "direction": -1}
    left = {"guard": "theta", "direction": 1}
    return cd.HybridSystem(
        name="block",
        states="theta v",
        parameters={"r": 0.7, "s": 0.7, "k": 1.0},
        modes={"right": {"theta": "v", "v": "theta - 1"}, "left": {"theta": "v", "v": "theta + k"}, "upright": upright},
        transitions=[
            cd.Transition("onto-left", "right", "left", **right, reset={"v": "r*v"}),
            cd.Transition("onto-right", "left", "right", **left, reset={"v": "s*v"}),
            cd.Transition("rest-right", "right", "upright", **right, reset=upright, completes="onto-left"),
            cd.Transition("rest-left", "left", "upright", **left, reset=upright, completes="onto-right"),
        ],
        initial={"mode": "right", "theta": 0.4},
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
@pytest.mark.parametrize(("r", "s", "k"), [(0.7, 0.7, 1.0), (0.9, 0.5, 3.0), (0.4, 0.95, 0.6)])
def test_rebounds_that_pass_from_one_mode_to_another(block, r, s, k, method):
    """Hit at the speed v, a block is back after 2 artanh v, or 2 artanh v/k (Housner 1963, BSSA 53, 403-417)."""
    limit, speed = np.arctanh(0.8), 0.8
    for _ in range(400):
        limit += 2 * np.arctanh(r * speed / k) + 2 * np.arctanh(r * s * speed)
        speed *= r * s
    for tolerance in (1e-6, 1e-12):
        given = {"steps": 2000} if method == "rk4" else {"tolerance": tolerance}
        run = cd.trajectory(block.with_parameters(r=r, s=s, k=k), duration=10.0, method=method, **given)
        assert run["mode"][-1] == 2
        off = abs(float(run["event_time"][-1]) - limit)
        assert off < {"taylor": 1e-14 + 1e-4 * tolerance, "rk4": 1e-8}.get(method, 1e-12 + 0.1 * tolerance)

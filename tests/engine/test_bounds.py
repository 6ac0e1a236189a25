"""A run ends where a state leaves its bounds, and nowhere else: not at a rest, a limit or a wall that lies on one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.declared import METHODS
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

INF = float("inf")

DECAYS = {
    "decay": ({"x": "-x", "v": "x - 5*v"}, (1.0, 0.0), {"x": (0, 2), "v": (0, 2)}),
    "limit": ({"x": "u - x", "v": "0"}, (0.3, 0.0), {"x": (0, 1)}),
    "logistic": ({"x": "x*(1 - x/u)", "v": "v*(x/u/2 - 1)"}, (0.1, 1.0), {"x": (0, 1), "v": (0, 1)}),
    "mass": ({"x": "v", "v": "-3*v"}, (0.0, 3.0), {"x": (0, 1), "v": (0, INF)}),
    "slow mass": ({"x": "v", "v": "-v/50"}, (0.0, 0.02), {"x": (0, 1), "v": (0, INF)}),
    "critical": ({"x": "v", "v": "-2*v - x"}, (1.0, 0.0), {"x": (0, 2), "v": (-1, 0)}),
    "infection": ({"x": "-3*x*v/u", "v": "3*x*v/u"}, (0.999, 0.001), {"x": (0, 1), "v": (0, 1)}),
    "epidemic": ({"x": "-3*x*v/u", "v": "3*x*v/u - v"}, (0.999, 0.001), {"x": (0, 1), "v": (0, 1)}),
    "spring": ({"x": "v", "v": "-x"}, (0.0, 1.0), {}),
}


@pytest.fixture(scope="module")
def motions():
    modes = {mode: rates for mode, (rates, _, _) in DECAYS.items()}
    return cd.HybridSystem(states="x v", parameters={"u": 1.0}, modes=modes)


def bounded(system, mode, start, bounds, unit=1.0):
    """The system in a mode and a unit, from a start and with bounds in that unit."""
    given = {name: tuple(end * unit for end in pair) for name, pair in bounds.items()}
    here = {"mode": mode, **{name: value * unit for name, value in zip("xv", start, strict=True)}}
    return system.remade(bounds={**system.bounds, **given}).with_parameters(u=unit).with_initial(**here)


def followed(system, method="taylor", tolerance=1e-12, time=1000, steps=20, period=1.0):
    """A run for a time, of so many fixed steps in a unit of it, which adaptive ones may exceed up to the period."""
    run = Run(system, period, Numerics(method, tolerance, int(steps * period) if method == "rk4" else None))
    return run.advance(int(time / period))[0], run


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("mode", [mode for mode, (_, _, bounds) in DECAYS.items() if bounds])
@settings(max_examples=9)
@given(power=st.integers(-12, 12), tolerance=st.sampled_from([1e-6, 1e-9, 1e-12]), period=st.sampled_from([100, 1]))
def test_what_decays_onto_a_bound_stays_on_it(motions, method, mode, power, tolerance, period):
    _, start, bounds = DECAYS[mode]
    outcome, run = followed(bounded(motions, mode, start, bounds, 10.0**power), method, tolerance, period=period)
    assert outcome == cd.Outcome.OK, run.stopped(outcome)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("unit", [1.0, 1e12, 1e-12])
@pytest.mark.parametrize("reach", [2.01, 2 + 1e-6])
def test_what_gets_beyond_a_bound_has_left_it_at_the_bound(motions, method, unit, reach):
    """reach sin(t) within (-4, 2), which is back within the same step."""
    system = bounded(motions, "spring", (0.0, reach), {"x": (-4, 2)}, unit)
    outcome, run = followed(system, method, time=3, steps=2000)
    assert outcome == cd.Outcome.ESCAPED
    # an error of the state by a tolerance moves the instant by that over its speed
    speed = np.sqrt(reach**2 - 4)
    assert run.elapsed == pytest.approx(np.arcsin(2 / reach), abs=1e-12 * max(1.0, 2 / speed))
    assert 2 * unit < run.x[0] <= 2 * unit * (1 + 1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_what_has_long_rested_on_a_bound_can_leave_it(method):
    ways = [cd.Transition("fall", "rest", "leave", "c - 300.25", 1)]
    system = cd.HybridSystem(
        states="x c", modes={"rest": {"x": "-x", "c": "1"}, "leave": {"x": "-1/1000", "c": "1"}}, transitions=ways,
        initial={"mode": "rest", "x": 1.0, "c": 0.0}, bounds={"x": (0, 2)},
    )  # fmt: skip
    outcome, run = followed(system, method, period=50.0)
    assert outcome == cd.Outcome.ESCAPED
    assert run.elapsed == pytest.approx(300.25, abs=1e-9)


PLACES = st.floats(-0.98, 0.98)


@settings(max_examples=20)
@given(x=PLACES, v=PLACES, power=st.integers(-12, 12), method=st.sampled_from(sorted(METHODS)))
def test_the_first_of_two_bounds_ends_a_run_in_any_order_and_unit(motions, x, v, power, method):
    """(sin t, cos t) from (0, 1) is first below x or v, whichever comes first, in closed form."""
    x, v = -abs(x), -abs(v)
    exact = min(np.pi - np.arcsin(x), np.arccos(v))
    unit, other = 10.0**power, motions.remade(states="v x")
    for system, start in ((motions, (0.0, 1.0)), (other, (0.0, 1.0))):
        outcome, run = followed(
            bounded(system, "spring", start, {"x": (x, INF), "v": (v, 9)}, unit), method, time=9, steps=2000
        )
        assert outcome == cd.Outcome.ESCAPED
        speed = abs(np.cos(exact) if exact == np.pi - np.arcsin(x) else np.sin(exact))
        assert run.elapsed == pytest.approx(exact, abs=1e-10 / speed)


@pytest.mark.parametrize("method", METHODS)
def test_bounds_wider_than_the_motion_change_nothing(method):
    """To the bit, though a bound stands at the wall."""
    free = cd.build("impact-oscillator")
    wall = free.parameters["wall"]
    for bounds in ({"x": (-50, 50), "v": (-50, 50)}, {"x": (-50, wall)}, {"v": (-INF, 60), "x": (-INF, wall)}):
        runs = [cd.trajectory(one, periods=30, samples=7, method=method) for one in (free, free.remade(bounds=bounds))]
        assert runs[1].cd.outcome == "ok"
        for name in ("states", "event_time", "event_state_after"):
            np.testing.assert_array_equal(runs[0][name], runs[1][name])


def test_bounds_wider_than_the_motion_change_nothing_in_lanes():
    free = cd.build("impact-oscillator")
    held = free.remade(bounds={"x": (-INF, free.parameters["wall"]), "v": (-9, 9)})
    omega = {"omega": np.linspace(2.0, 3.0, 9)}
    found = [cd.bifurcation_diagram(one, omega, transient=20, periods=10, exponents=2) for one in (free, held)]
    for name in ("section", "lyapunov_exponent", "outcome"):
        np.testing.assert_array_equal(found[0][name], found[1][name])


def test_decays_onto_a_bound_stay_on_it_in_lanes(motions):
    for mode in ("decay", "mass", "infection"):
        _, start, bounds = DECAYS[mode]
        swept = bounded(motions, mode, start, bounds)
        found = cd.transient_chaos(swept, duration=200, initial={"v": np.linspace(0.5, 1.0, 5) * start[1]})
        assert found["escapes"] == 0


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_ball_comes_to_rest_on_a_floor_that_is_a_bound(method):
    """Bounces of half the speed end at time 4; then it stays."""
    ball = cd.HybridSystem(
        states="x v", modes={"fly": {"x": "v", "v": "-1"}, "rest": {"x": "0", "v": "0"}},
        transitions=[
            cd.Transition("bounce", "fly", "fly", "x", -1, reset={"v": "-v/2"}),
            cd.Transition("land", "fly", "rest", "x", -1, reset={"x": "0", "v": "0"}, completes="bounce"),
        ],
        initial={"mode": "fly", "x": 0.0, "v": 1.0}, bounds={"x": (0, INF)},
    )  # fmt: skip
    outcome, run = followed(ball, method, time=50)
    assert (outcome, run.mode) == (cd.Outcome.OK, "rest")

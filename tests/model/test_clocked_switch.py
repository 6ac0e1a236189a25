"""A switch by a clock: the guard that has one zero a tick switches at every tick, one with a side is left at once."""

import numpy as np

import chaosdrill as cd


def converter(guard, direction, period):
    """A ramp up to 1 that a clock of period 1 starts anew."""
    return cd.HybridSystem(
        states="x",
        parameters={"T": 1.0},
        modes={"on": {"x": "1.6"}, "off": {"x": "-0.4"}},
        transitions=[
            cd.Transition("full", "on", "off", guard="x - 1", direction=+1),
            cd.Transition("clock", "off", "on", guard=guard, direction=direction),
        ],
        period=period,
        initial={"x": 0.3},
    )


def test_a_guard_of_one_zero_a_tick_is_a_clock():
    run = cd.trajectory(converter("sin(pi*t/T)", 0, "2*T"), periods=5)
    events = run.cd.events
    assert int(run["outcome"]) == cd.Outcome.OK
    ticks = events["time"][events["kind"] == "clock"]
    assert len(ticks) >= 9
    np.testing.assert_allclose(ticks, 1 + np.arange(len(ticks)), rtol=1e-12)


def test_a_guard_that_has_been_passed_stalls_and_the_advice_says_so():
    run = cd.trajectory(converter("sin(2*pi*t/T)", +1, "T"), periods=5)
    assert int(run["outcome"]) == cd.Outcome.STALLED
    assert "entered where its guard has already been passed" in cd.Outcome.STALLED.advice

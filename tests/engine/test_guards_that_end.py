"""Guards whose series end sooner than those of the states: a pole, a root, a slope that nothing announces.

The same events are written with a guard that is linear; that run is held against the closed form of free motion.
"""

import numpy as np
import pytest
import sympy

import chaosdrill as cd

x, v, e = sympy.symbols("x v e", real=True)
WALL = sympy.Rational(1, 4)

SAME_EVENTS = {
    "root": sympy.sqrt(3 + x) - sympy.sqrt(3 + WALL),
    "pole": 1 / (3 + WALL) - 1 / (3 + x),
    "slope": sympy.tanh(50 * (x - WALL)),
}


def oscillator(guard):
    """x'' = -x from x = 0 with speed 1, and a wall at 1/4 that sends it back with e times its speed."""
    return cd.HybridSystem(
        name="oscillator at a wall",
        states=(x, v),
        parameters={"e": 0.875},
        modes={"free": {x: v, v: -x}},
        transitions=[cd.Transition("impact", "free", "free", guard=guard, direction=+1, reset={v: -e * v})],
        period=sympy.Integer(5),
        initial={"mode": "free", x: 0.0, v: 1.0},
    )


def impacts(speed, count):
    """Times of impacts from x = 0 with that speed: between two the phase goes from the wall through -1 to the wall."""
    found, wall = [np.arcsin(0.25 / speed)], 0.25
    speed = np.sqrt(speed**2 - wall**2)
    for _ in range(count - 1):
        speed *= 0.875
        found.append(found[-1] + 2 * np.pi - 2 * np.arctan2(speed, wall))
    return found


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize("guard", SAME_EVENTS.values(), ids=SAME_EVENTS)
def test_the_events_are_those_of_the_closed_form(guard, method):
    found = cd.trajectory(oscillator(guard), periods=5, method=method)
    assert int(found["outcome"]) == cd.Outcome.OK
    times = found["event_time"].values
    np.testing.assert_allclose(times, impacts(1.0, len(times)), atol=1e-9)
    assert len(times) >= 5


@pytest.mark.parametrize(
    ("guard", "outcome"),
    [
        (sympy.log(4 * (x - sympy.Rational(1, 8))), cd.Outcome.NONFINITE),
        (1 / (WALL + sympy.Rational(1, 2)) - 1 / (x + sympy.Rational(1, 2)), cd.Outcome.STEP_UNDERFLOW),
    ],
    ids=["no number from the start", "pole on the way"],
)
def test_a_guard_that_has_no_value_ends_the_run(guard, outcome):
    """Alone, and stepped in lanes."""
    system = oscillator(guard)
    assert int(cd.trajectory(system, periods=5)["outcome"]) == outcome
    diagram = cd.bifurcation_diagram(system, {"e": [0.8, 0.9]}, transient=4, periods=4, max_period=1, patience=0)
    assert (diagram["outcome"].values == outcome).all()


def test_lanes_meet_the_same_events():
    swept = {"e": np.linspace(0.8, 0.95, 9)}
    settings = {"transient": 0, "periods": 4, "max_period": 1, "patience": 0}
    linear, steep = (
        cd.bifurcation_diagram(oscillator(guard), swept, **settings)["section"].values
        for guard in (x - WALL, SAME_EVENTS["slope"])
    )
    np.testing.assert_allclose(steep, linear, atol=1e-8)


def test_a_right_hand_side_that_is_no_number_anywhere_is_an_outcome():
    system = oscillator(x - WALL)
    broken = cd.HybridSystem(
        name="no number",
        states=(x, v),
        parameters={},
        modes={"free": {x: v, v: -x + sympy.sqrt(-1 - x**2)}},
        period=system.period,
        initial=system.initial,
    )
    assert int(cd.lyapunov_spectrum(broken, periods=4)["outcome"]) == cd.Outcome.NONFINITE

"""Every method finds the same events: first crossings, ties, departures from a guard; adaptive ones double roots."""

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.registry import FIXED_STEP
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, Y, T = sympy.symbols("x y t", real=True)
RATE, BEND, FAST = sympy.symbols("rate bend fast", real=True)
ADAPTIVE = sorted(set(at.METHOD_CODES) - set(FIXED_STEP))


@pytest.fixture(scope="module")
def system():
    """Each mode is a case; what it starts from decides what happens."""
    return cd.HybridSystem(
        name="events",
        states=(X, Y),
        time=T,
        parameters={"rate": 1.0, "bend": 1.0, "fast": 40.0},
        modes={
            "throw": {X: Y, Y: -2},
            "clocks": {X: 1, Y: RATE},
            "drift": {X: 1, Y: 0},
            "ramp": {X: Y, Y: BEND * (1 - T)},
            "rest": {X: 0, Y: 0},
        },
        transitions=[
            cd.Transition("reach", "throw", "rest", guard=X, direction=+1),
            cd.Transition("first", "clocks", "clocks", guard=X - 1, direction=+1, reset={X: 0}),
            cd.Transition("second", "clocks", "clocks", guard=Y - 1, direction=+1, reset={Y: 0}),
            cd.Transition("ripple", "drift", "rest", guard=X - 1 + sympy.cos(FAST * T) / 2, direction=+1),
            cd.Transition("hold", "ramp", "rest", guard=X, direction=-1),
        ],
        initial={X: 0, Y: 0},
    )


def events(system, length, method, mode, tolerance=1e-12, **settings):
    """Run and (time, kind) of its events."""
    names = {k: settings.pop(k) for k in ("rate", "bend", "fast") if k in settings}
    steps = settings.pop("steps", 2000) if method in FIXED_STEP else None
    settings.pop("steps", None)
    run = Run(
        system.with_parameters(**names).with_initial(mode=mode, **settings), length, Numerics(method, tolerance, steps)
    )
    rows = np.zeros((100, at.EVENT_COLUMNS + 4))
    assert run.advance(1, events=rows)[0] == cd.Outcome.OK
    found = rows[: run.filled()[1]]
    return run, found[:, [at.EVENT_TIME, at.EVENT_KIND]]


@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_a_first_crossing(system, method):
    """x = -1 + 3 t - t**2."""
    run, found = events(system, 4.0, method, "throw", x=-1.0, y=3.0)
    np.testing.assert_allclose(found, [[(3 - 5**0.5) / 2, 0]], atol=2e-12)
    assert run.mode == "rest"


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize("method", ADAPTIVE)
def test_two_crossings_inside_one_step(system, method, gap):
    """x rises above zero by ``gap`` only, between two roots sqrt(gap) from 1."""
    _, found = events(system, 4.0, method, "throw", x=gap - 1, y=2.0)
    assert len(found) == 1
    # what the round-off of a step does to a root of slope 2 sqrt(gap)
    assert found[0, 0] == pytest.approx(1 - gap**0.5, abs=2e-15 / gap**0.5)


@pytest.mark.parametrize("method", FIXED_STEP)
def test_two_crossings_inside_one_step_pass_a_fixed_step_unseen(system, method):
    assert len(events(system, 4.0, method, "throw", x=1e-6 - 1, y=2.0, steps=10)[1]) == 0


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_a_guard_that_is_missed_by_a_hair_is_no_event(system, method, gap):
    assert len(events(system, 4.0, method, "throw", x=-gap - 1, y=2.0)[1]) == 0


def ties(system, method, rate):
    run, _ = events(system, 10.25, method, "clocks", rate=rate)
    return [*run.counts[1:3], run.ties]


@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_clocks_in_step_tie_every_time(system, method):
    assert ties(system, method, 1.0) == [10, 10, 10]


@pytest.mark.parametrize("method", ADAPTIVE)
def test_clocks_of_different_rates_tie_where_they_meet(system, method):
    """Not so by bisection, which ends late, for each guard by an amount of its own."""
    assert ties(system, method, 2.0) == [10, 20, 10]
    assert ties(system, method, 0.5) == [10, 5, 5]


@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_a_guard_that_moves_faster_than_the_state(system, method):
    _, found = events(system, 4.0, method, "drift")
    first = mpmath.findroot(lambda t: t - 1 + mpmath.cos(40 * t) / 2, (0.6, 0.62), solver="anderson")
    assert len(found) == 1
    assert found[0, 0] == pytest.approx(float(first), abs=2e-12)


@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_a_guard_that_is_left_without_speed_is_met_when_the_state_comes_back(system, method):
    """x = bend (t**2 / 2 - t**3 / 6) starts at zero with no speed, and is back at t = 3."""
    _, found = events(system, 4.0, method, "ramp", bend=1.0)
    np.testing.assert_allclose(found, [[3.0, 4]], atol=4e-12)


@pytest.mark.parametrize("method", at.METHOD_CODES)
def test_a_guard_that_the_state_goes_through_without_speed_acts_at_once(system, method):
    _, found = events(system, 4.0, method, "ramp", bend=-1.0)
    np.testing.assert_array_equal(found, [[0.0, 4]])

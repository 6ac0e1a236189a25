"""Guards that are reached together are counted as ties, and an event at the end of a step is not lost."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, Y, S = sympy.symbols("x y s", real=True)


@pytest.fixture(scope="module")
def system():
    """Two clocks; each starts anew at 1."""
    return cd.HybridSystem(
        name="clocks",
        states=(X, Y),
        parameters={"rate": 1.0},
        modes={"run": {X: 1, Y: sympy.Symbol("rate")}},
        transitions=[
            cd.Transition("first", "run", "run", guard=X - 1, direction=+1, reset={X: 0}),
            cd.Transition("second", "run", "run", guard=Y - 1, direction=+1, reset={Y: 0}),
        ],
    )


def clocks(system, length, rate, **initial):
    run = Run(system.with_parameters(rate=rate).with_initial(**initial), length, Numerics(), tangents=np.eye(2))
    assert run.advance(1)[0] == cd.Outcome.OK
    return run


def test_clocks_in_step_tie_every_time(system):
    run = clocks(system, 10.5, 1.0)
    assert list(run.counts) == [10, 10]
    assert run.ties == 10


def test_clocks_of_rates_one_and_two_tie_every_other_time(system):
    run = clocks(system, 10.25, 2.0)
    assert list(run.counts) == [10, 20]
    assert run.ties == 10


def test_clocks_that_are_apart_do_not_tie(system):
    run = clocks(system, 10.5, 1.0, x=0.25)
    assert list(run.counts) == [10, 10]
    assert run.ties == 0


@pytest.mark.parametrize("period", [0.5, 1.0, 0.25])
def test_an_event_at_a_strobe_happens_once(system, period):
    """Strobes at multiples of the period fall on the events at 1, 2, 3, ..."""
    run = Run(system.with_initial(y=0.375), period, Numerics(), samples=1)
    for strobe in range(1, round(21 / period)):
        assert run.advance(1)[0] == cd.Outcome.OK
        passed, at_the_end = divmod(strobe * period, 1)
        # an event at the end itself may be left to the next call
        assert run.counts[0] in ((passed - 1, passed) if at_the_end == 0 else (passed,))
        assert run.counts[1] == int(strobe * period + 0.375)

"""A state at zero whose rate is the rounding of larger terms has no size yet; no step is asked for more than it can."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

METHODS = ("taylor", "dop853", "radau", "lanes")
LENGTH = 2.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)

GATES = {
    "tanh": "U*(a + tanh((v - c)/(2*w)))/2",
    "logistic": "U*(a - 1/(1 + exp((v - c)/w)))",
    "feedback": "U*(a + tanh((v - c)/(2*w)))/2 - y",
}
"""All but closed at first; what they begin with is a parameter, so that no identity makes them another."""


@pytest.fixture(scope="module")
def opened():
    return cd.HybridSystem(
        name="opened",
        states="y v",
        parameters={"U": 1.0, "a": 1.0, "c": 1.0, "w": 0.03},
        modes={name: {"y": rate, "v": "1"} for name, rate in GATES.items()},
        initial={"mode": "tanh", "y": 0.0, "v": 0.0},
        bounds={"y": (-1e30, 1e30)},
    )


def moved(gate, c, w):
    """Integral of the logistic function, with what the feedback forgets."""
    if gate != "feedback":
        return w * (np.logaddexp(0, (LENGTH - c) / w) - np.logaddexp(0, -c / w))
    edges = np.clip(c + w * np.arange(-40, 800), 0.0, LENGTH)
    half = np.diff(edges)[:, np.newaxis] / 2
    s = edges[:-1, np.newaxis] + half * (1 + NODES)
    return float(np.sum(half * WEIGHTS * np.exp(s - LENGTH - np.logaddexp(0, (c - s) / w))))


def at_end(system, method, tolerance, length=LENGTH):
    """How a run ends, and where y is."""
    if method != "lanes":
        run = Run(system, length, Numerics(method, tolerance))
        outcome = run.advance(1)[0]
        assert run.standing["steps"] < 2000
        return outcome, run.x[0]
    modes = np.full(2, system.mode_names.index(system.initial["mode"]))
    start = [float(system.initial[name]) for name in system.state_names]
    batch = Batch(system, {}, np.array([start] * 2), modes, Numerics("taylor", tolerance), unit=length)
    batch.run(0, np.array([0, 1]))
    return cd.Outcome(int(batch.outcome[1])), batch.x[1, 0]


@settings(max_examples=60)
@given(
    gate=st.sampled_from(list(GATES)),
    method=st.sampled_from(METHODS),
    tolerance=st.sampled_from([1e-12, 1e-10, 1e-8, 1e-6]),
    unit=st.sampled_from([1e-12, 1e-6, 1.0, 1e6, 1e12]),
    c=st.floats(0.5, 1.9),
    w=st.floats(-2.5, -1.0).map(lambda e: 10**e),
)
@example(gate="tanh", method="dop853", tolerance=1e-12, unit=1.0, c=1.0, w=0.03)
@example(gate="tanh", method="radau", tolerance=1e-12, unit=1.0, c=1.0, w=0.03)
def test_a_gate_opens_from_zero(opened, gate, method, tolerance, unit, c, w):
    system = opened.with_parameters(U=unit, c=c, w=w).with_initial(mode=gate)
    outcome, y = at_end(system, method, tolerance)
    assert outcome == cd.Outcome.OK
    exact = moved(gate, c, w)
    # what rounding leaves of the rates is there for two units of time
    assert y / unit == pytest.approx(exact, rel=100 * tolerance, abs=4e-16)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_tangents_are_as_exact_as_they_can_be(opened, method):
    """The derivative by what the gate depends on is the gate at the end."""
    run = Run(opened, LENGTH, Numerics(method, 1e-12), tangents=np.eye(2), orthonormalise=False)
    assert run.advance(1)[0] == cd.Outcome.OK
    assert run.vectors == pytest.approx(np.array([[1.0, 0.0], [1.0 / (1 + math.exp(-1 / 0.03)), 1.0]]), abs=1e-11)
    assert run.standing["steps"] < 400


@pytest.fixture(scope="module")
def swung():
    return cd.HybridSystem(
        name="swung",
        states="y p q",
        modes={"all": {"y": "1 - 2/(1 + exp(400*p))", "p": "q", "q": "-p"}},
        initial={"p": 1.0},
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_gate_far_ahead_gives_no_size_beyond_the_motion(swung, method):
    """Its last terms are tiny but there: a step that these bound would be a million long."""
    outcome, y = at_end(swung, method, 1e-12, math.pi)
    assert outcome == cd.Outcome.OK
    assert y == pytest.approx(0.0, abs=1e-11)


@pytest.fixture(scope="module")
def gaps():
    """Growth whose series about zero has a term in n; the second state waits for the first."""
    return cd.HybridSystem(
        name="gaps",
        states="y v",
        modes={f"power {n}": {"y": f"1 + y**{n}", "v": f"y**{n}"} for n in (4, 5, 6, 7, 8)},
        initial={"mode": "power 6", "y": 0.0, "v": 0.0},
    )


@pytest.mark.parametrize("n", [4, 5, 6, 7, 8])
@pytest.mark.parametrize("method", METHODS)
def test_gaps_of_a_series_hide_nothing(gaps, method, n):
    """The last terms of the series about zero are zero at most orders; y' = 1 + y**n is infinite at a known time."""
    pole = math.pi / n / math.sin(math.pi / n)
    system = gaps.with_initial(mode=f"power {n}")
    for tolerance in (1e-6, 1e-9, 1e-12):
        outcome, y = at_end(system, method, tolerance, 0.95)
        # time to y by the series of 1/(1 + y**n), or of y**-n/(1 + y**-n) from the pole
        left = sum((-1) ** k * y ** (1 - n * (k + 1)) / (n * (k + 1) - 1) for k in range(2000)) if y > 1 else 0.0
        past = pole - left if y > 1 else sum((-1) ** k * y ** (n * k + 1) / (n * k + 1) for k in range(2000))
        assert outcome == cd.Outcome.OK
        assert past == pytest.approx(0.95, rel=20 * tolerance)
        # whether a series overflows before a step is too short is a question of its order
        assert at_end(system, method, tolerance, 3.0)[0] in (cd.Outcome.NONFINITE, cd.Outcome.ESCAPED)


def test_an_estimate_that_is_zero_by_accident_is_not_believed():
    """Of steps of many lengths from many phases of a swing none that is within the tolerance is far off."""
    swing = cd.HybridSystem(
        name="swing",
        states="y p q",
        parameters={"T": 1.0, "c": 0.4485, "w": 0.3676},
        modes={"on": {"y": "T*atan((p - c)/w)", "p": "T*q", "q": "-T*p"}},
        initial={"y": 1.0, "p": 1.0, "q": 0.0},
    )
    worst = 0.0
    for phase in np.linspace(0.0, 2 * math.pi, 60, endpoint=False):
        for length in (1.0, 3.0, 5.0):
            start = {"p": math.cos(phase), "q": -math.sin(phase)}
            exact = 1.0 + _arctangents(phase, phase + length, 0.4485, 0.3676)
            run = Run(swing.with_parameters(T=length).with_initial(**start), 1.0, Numerics("dop853", 1e-8))
            assert run.advance(1)[0] == cd.Outcome.OK
            worst = max(worst, abs(run.x[0] - exact))
    assert worst < 2e-7


def _arctangents(low, high, c, w):
    edges = np.linspace(low, high, 101)
    half = (high - low) / 200
    return float(np.sum(half * WEIGHTS * np.arctan((np.cos(edges[:-1, np.newaxis] + half * (1 + NODES)) - c) / w)))

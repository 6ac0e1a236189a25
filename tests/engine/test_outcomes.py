"""How a run ends, and what it integrates beside the states."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.declared import METHODS
from chaosdrill.engine import run as engine_run
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

X, Y, V, T = sympy.symbols("x y v t", real=True)


# Each way in which a run can end early has its name, at a small system that ends so; none hangs.


MODES = {
    "grow": {X: X, Y: 0},
    "explode": {X: X**2, Y: 0},
    "shrink": {X: -1 / X, Y: 0},
    "logarithm": {X: sympy.log(X - 3), Y: 0},
    "pole": {X: 1, Y: 1 / (X - 1)},
    "ping": {X: 1, Y: 0},
    "pong": {X: 1, Y: 0},
    "fall": {X: Y, Y: -1},
    "clock": {X: 1, Y: 0},
    "slow": {X: sympy.Rational(1, 10), Y: 0},
}


@pytest.fixture(scope="module")
def system():
    return cd.HybridSystem(
        name="ends",
        states=(X, Y),
        parameters={},
        modes=MODES,
        transitions=[
            cd.Transition("there", "ping", "pong", guard=X - 1, direction=+1, reset={X: 2}),
            cd.Transition("back", "pong", "ping", guard=X - 1, direction=-1, reset={X: 0}),
            cd.Transition("over", "pong", "ping", guard=X - 2, direction=+1, reset={X: 1}),
            cd.Transition("bounce", "fall", "fall", guard=X, direction=-1, reset={Y: -Y / 2}),
            cd.Transition("tick", "clock", "clock", guard=X - sympy.Float("1e-5"), direction=+1, reset={X: 0}),
            cd.Transition("strike", "slow", "slow", guard=X - 1, direction=+1, reset={X: 0}),
        ],
        period=sympy.Integer(5),
        bounds={X: None, Y: (-10, 10)},
    )


def end(system, method="taylor", bounds=None, **initial):
    system = system.with_initial(**initial)
    if bounds:
        system = system.remade(bounds={**system.bounds, **bounds})
    run = Run(system, 5.0, Numerics(method, 1e-10), tangents=np.eye(2))
    return run, run.advance(3)[0]


@pytest.mark.parametrize("method", METHODS)
def test_a_run_beyond_its_bounds_has_escaped(system, method):
    run, outcome = end(system, method, {"x": (-50.0, 50.0)}, mode="grow", x=1.0)
    assert outcome == cd.Outcome.ESCAPED
    assert run.x[0] > 50


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("period", [5.0, 0.3])
def test_an_escape_is_the_first_instant_beyond_a_bound(system, method, period):
    """Of a growth by exp(t), of a throw that is back in the same step, and of a reset."""
    near = 1e-4 if method == "rk4" else 1e-9
    height = 0.5 - 1e-5
    cases = [
        ({"mode": "grow", "x": 1.0}, 50.0, np.log(50)),
        ({"mode": "fall", "x": 0.0, "y": 1.0}, height, 1 - np.sqrt(1 - 2 * height)),
        ({"mode": "ping", "x": 0.5}, 1.5, 0.5),
    ]
    for start, bound, time in cases:
        bounded = system.remade(bounds={**system.bounds, "x": (-50.0, bound)}).with_initial(**start)
        run = Run(bounded, period, Numerics(method, 1e-10))
        assert run.advance(20)[0] == cd.Outcome.ESCAPED
        assert run.elapsed == pytest.approx(time, rel=near)
        assert bound < run.x[0] < bound + 1


def test_lanes_end_at_the_bounds_too(system):
    thrown = system.remade(bounds={**system.bounds, "x": (-1.0, 0.5)}).with_initial(mode="fall", x=0.0)
    speeds = np.array([1.01, 1.5, 3.0])
    found = cd.transient_chaos(thrown, periods=1, initial={"y": speeds})
    np.testing.assert_allclose(found["lifetime"], speeds - np.sqrt(speeds**2 - 1), rtol=1e-12)


def test_a_run_below_its_bounds_has_escaped(system):
    assert end(system, bounds={"x": (-50.0, 50.0)}, mode="grow", x=-1.0)[1] == cd.Outcome.ESCAPED


def test_a_start_outside_of_the_bounds_has_escaped(system):
    run, outcome = end(system, mode="clock", y=11.0)
    assert (outcome, run.elapsed) == (cd.Outcome.ESCAPED, 0.0)
    assert "y = 11 exceeds 10" in run.stopped(outcome)


@pytest.mark.parametrize("method", METHODS)
def test_events_without_advance_of_time_stall(system, method):
    """The reset of each transition lands on the guard of the other."""
    run, outcome = end(system, method, mode="ping", x=0.5)
    assert outcome == cd.Outcome.STALLED
    assert 50 < run.counts.sum() < 60
    assert run.elapsed == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_chatter_ends_by_name(system, method):
    """Bounces of half the speed end at time 4 from unit speed."""
    run, outcome = end(system, method, mode="fall", x=0.0, y=1.0)
    assert outcome in (cd.Outcome.STALLED, cd.Outcome.EVENT_LIMIT)
    assert "events follow each other" in run.stopped(outcome)
    assert run.elapsed == pytest.approx(4.0, abs=1e-6)


def test_too_many_events_in_a_period_reach_the_limit(system):
    run, outcome = end(system, mode="clock")
    assert outcome == cd.Outcome.EVENT_LIMIT
    assert "without end within one period: in mode 'clock', time 0.1" in run.stopped(outcome)
    assert run.elapsed == pytest.approx(run.counts.sum() * 1e-5, rel=1e-9)
    assert run.counts.sum() == 10_001


@pytest.mark.parametrize("method", METHODS)
def test_a_rate_that_is_no_number_ends_the_run(system, method):
    """The logarithm of a negative number."""
    _run, outcome = end(system, method, mode="logarithm", x=1.0)
    assert outcome == cd.Outcome.NONFINITE


def test_a_guard_that_is_no_number_ends_the_run():
    system = cd.HybridSystem(
        states="x",
        parameters={"m": 1.0},
        modes={"on": {"x": "1"}},
        transitions=[cd.Transition("back", "on", "on", guard="x - log(m) - 1", direction=1, reset={"x": "0"})],
    )
    for method in METHODS:
        run = cd.trajectory(system.with_parameters(m=-1.0), duration=2, method=method)
        assert run.cd.outcome == "nonfinite"
    diagram = cd.bifurcation_diagram(system, {"m": [1.0, -1.0]}, at="back", transient=5, periods=5)
    assert list(diagram.cd.outcome.values.ravel()) == ["periodic", "nonfinite"]


@pytest.mark.parametrize(("mode", "start", "when"), [("explode", 1.0, 1.0), ("shrink", 1.0, 0.5), ("pole", 0.0, 1.0)])
@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_singularity_ends_the_run_where_it_is(system, method, mode, start, when):
    """x' = x^2 reaches infinity at 1/x0, x' = -1/x zero at x0^2/2; the logarithm beside a pole leaves its bounds."""
    run, outcome = end(system, method, mode=mode, x=start)
    expected = {
        "explode": (cd.Outcome.NONFINITE, cd.Outcome.ESCAPED),
        "shrink": (cd.Outcome.SINGULAR,),
        "pole": (cd.Outcome.ESCAPED,),
    }
    assert outcome in expected[mode]
    assert run.elapsed == pytest.approx(when, abs=1e-3)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_guard_whose_slope_is_infinite_where_a_run_ends_is_not_zero_there(method):
    root = cd.HybridSystem(
        states="x",
        modes={"on": {"x": "1"}},
        transitions=[cd.Transition("half", "on", "on", "sqrt(x) - 1/2", 1)],
        initial={"x": 0.0},
    )
    run = cd.trajectory(root, duration=1.0, samples=1, method=method)
    assert (run.sizes["event"], run.cd.outcome) == (0, "singular")


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_steps_that_lead_to_no_sample_end_a_run(method):
    turns = cd.HybridSystem(states="x v", modes={"on": {"x": "v", "v": "-x"}}, initial={"x": 1.0})
    for samples, outcome in ((1, cd.Outcome.STEP_UNDERFLOW), (50, cd.Outcome.OK)):
        run = Run(turns, 100.0, Numerics(method, 1e-10), samples=samples)
        run.settings["max_steps"] = 20
        assert run.advance(1)[0] == outcome


def test_a_singular_term_is_named(system):
    run, outcome = end(system, mode="shrink", x=1.0)
    assert "1/x ends where x = 0" in run.stopped(outcome)
    assert "'shrink'" in run.stopped(outcome)


@pytest.mark.parametrize("method", METHODS)
def test_a_start_beyond_a_guard_is_invalid(system, method):
    assert end(system, method, mode="ping", x=1.5)[1] == cd.Outcome.INVALID_START


def test_a_start_on_a_guard_is_valid(system):
    assert end(system, mode="fall", x=0.0, y=1.0)[0].counts[3] > 10


def test_an_outcome_is_what_a_second_call_gives_too(system):
    run, outcome = end(system, mode="ping", x=1.5)
    assert run.advance(1)[0] == outcome


def test_the_limit_counts_events_of_one_period(system):
    """2 000 ticks a period for many periods are no chatter."""
    limit = engine_run.Run(system.with_initial(mode="clock"), 0.02, Numerics())
    assert limit.advance(20)[0] == cd.Outcome.OK
    assert limit.counts.sum() in (39_999, 40_000)


def test_events_that_fall_on_the_beginning_of_a_step_are_no_stall(system):
    """Ten steps of a tenth fall short of 1 by one rounding: every strike comes at once in the step that follows."""
    run = Run(system.with_initial(mode="slow"), 1.0, Numerics())
    assert run.advance(1000)[0] == cd.Outcome.OK
    assert run.counts[-1] in (99, 100)


@pytest.mark.parametrize("method", METHODS)
def test_an_escape_is_one_though_an_integral_overflows(method):
    system = cd.HybridSystem(
        states="x",
        modes={"on": {"x": "exp(x)"}},
        quadratures={"q": "exp(400*x)"},
        bounds={"x": (-1.0, 1.0)},
        initial={"x": 0.9},
    )
    run = Run(system, 1.0, Numerics(method, 1e-10, 1 if method == "rk4" else None))
    assert run.advance(1)[0] == cd.Outcome.ESCAPED


# Quadratures whose integrands are harder than the flow are as exact as the states.


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_integrals_along_a_straight_line(method, tolerance):
    system = cd.HybridSystem(
        name="line",
        states=(X,),
        time=T,
        parameters={},
        modes={"on": {X: 1}},
        quadratures={"waves": sympy.cos(5 * X), "bell": 1 / (1 + X**2), "forced": sympy.sin(3 * T)},
    )
    run = cd.trajectory(system, duration=10.0, samples=10, method=method, tolerance=tolerance)
    expected = {"waves": np.sin(50) / 5, "bell": np.arctan(10), "forced": (1 - np.cos(30)) / 3}
    for name, value in expected.items():
        assert float(run[name][-1]) == pytest.approx(value, abs=50 * tolerance)


def test_an_integral_of_a_high_power_of_an_oscillation():
    system = cd.HybridSystem(
        name="oscillator",
        states=(X, V),
        parameters={},
        modes={"on": {X: V, V: -X}},
        quadratures={"power": V**8, "peaks": 1 / (1 + 30 * X**2)},
        initial={X: 1.0},
    )
    run = cd.trajectory(system, duration=8 * np.pi, samples=4)
    assert float(run["power"][-1]) == pytest.approx(8 * np.pi * 35 / 128, abs=1e-10)
    assert float(run["peaks"][-1]) == pytest.approx(8 * np.pi / np.sqrt(31), abs=1e-10)


def test_a_sum_that_ends_in_rounding_is_named():
    """The root of (a - sin(t))**2, written out, whose base touches zero at pi/2 with a = 1 alone; in sweeps as well."""
    system = cd.HybridSystem(
        states="x",
        time="t",
        parameters={"a": 1.0},
        period=2 * sympy.pi,
        modes={"on": {"x": "sqrt(a**2 - 2*a*sin(t) + sin(t)**2)"}},
    )
    run = cd.trajectory(system, periods=2, samples=3)
    base = "a**2 - 2*a*sin(t) + sin(t)**2"
    told = f"sqrt({base}) ends where {base} = 0, which is lost in the rounding"
    assert run.attrs["message"].startswith(told)
    assert "in mode 'on', time 1.570" in run.attrs["message"]
    swept = cd.bifurcation_diagram(system, {"a": [1.0, 1.5]}, transient=0, periods=4)
    assert swept.attrs["message"].startswith(told)
    assert swept.attrs["message"].endswith("in mode 'on': 1 of 2 runs, first a = 1")

"""Steps count when they were compared with the equations where a method's own estimate sees nothing."""

import importlib
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics

ADAPTIVE = ("taylor", "dop853", "radau")
MOST = 100.0


@pytest.fixture(scope="module")
def study():
    """The study of generated motions through steep terms."""
    folder = Path(__file__).parents[2] / "studies" / "hard_cases"
    sys.path.insert(0, str(folder))
    yield importlib.import_module("steep")
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def friction():
    return cd.HybridSystem(
        name="friction",
        states="v",
        parameters={"e": 0.05},
        modes={"all": {"v": "-tanh(v/e)"}},
        transitions=[cd.Transition("slow", "all", "all", "v - 0.01", -1)],
        initial={"v": 1.0},
    )


def slowed(t, e):
    """sinh(v/e) decays like exp(-t/e)."""
    return e * np.arcsinh(np.exp((1 - t) / e - np.log(2) + np.log1p(-np.exp(-2 / e))))


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("tolerance", [1e-12, 1e-8, 1e-4])
def test_smoothed_friction_holds(friction, method, tolerance):
    """The series of -tanh(20 v) from 1 is constant to the last digit, and the motion slows down all the same."""
    times = [0.5, 0.9, 1.1, 1.5, 2.0]
    run = cd.trajectory(friction, times=times, method=method, tolerance=tolerance)
    exact = [slowed(t, 0.05) for t in times]
    assert run["states"].values[:, 0] == pytest.approx(exact, abs=MOST * tolerance)
    at = 1 / 20 * (np.log(np.sinh(20)) - np.log(np.sinh(0.2)))
    assert run["event_time"].values == pytest.approx([at], abs=1e4 * tolerance)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_tangents_go_through_what_is_steep(friction, method):
    """Along one state a tangent is the ratio of the rates at its ends."""
    run = cd.trajectory(friction, duration=1.2, samples=1, method=method, tangents=True)
    ratio = np.tanh(slowed(1.2, 0.05) / 0.05) / np.tanh(20)
    assert run["final_tangent"].item() == pytest.approx(ratio, rel=1e-9)


@pytest.fixture(scope="module")
def tank():
    return cd.HybridSystem(
        name="tank", states="h", parameters={"k": 0.2}, modes={"full": {"h": "-k*sqrt(h)"}}, initial={"h": 4.0}
    )


@pytest.fixture(scope="module")
def emptied():
    return cd.HybridSystem(
        name="tank",
        states="h",
        parameters={"k": 0.2},
        modes={"full": {"h": "-k*sqrt(h)"}, "empty": {"h": "0"}},
        transitions=[cd.Transition("empties", "full", "empty", "h", -1, reset={"h": "0"})],
        initial={"h": 4.0},
    )


@pytest.mark.parametrize("method", ADAPTIVE)
def test_no_level_rises_beyond_a_branch_point(tank, method):
    """sqrt(h) = sqrt(h0) - k t/2 until the tank is empty, at time 20."""
    before = cd.trajectory(tank, times=[5.0, 15.0, 19.9], method=method)
    assert before["states"].values[:, 0] == pytest.approx([(2 - 0.1 * t) ** 2 for t in (5, 15, 19.9)], abs=1e-10)
    after = cd.trajectory(tank, duration=50.0, samples=100, method=method)
    assert cd.Outcome(int(after["outcome"])) == cd.Outcome.SINGULAR
    assert float(after["time"][-1]) == pytest.approx(20.0, abs=0.5)
    told = after.attrs["message"]
    assert "sqrt(h) ends where h = 0" in told
    assert "'full'" in told
    assert "time 20" in told or "time 19.99" in told


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_guard_at_a_branch_point_fires(emptied, method):
    run = cd.trajectory(emptied, duration=50.0, samples=10, method=method)
    assert cd.Outcome(int(run["outcome"])) == cd.Outcome.OK
    # the level is exact to the tolerance, and time to the root of it
    assert run["event_time"].values == pytest.approx([20.0], abs=1e-5)
    assert float(run["states"][-1, 0]) == 0.0


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_tank_is_filled_again_where_it_is_empty(tank, method):
    """The steps that end at the branch point say nothing of those after its event."""
    fill = cd.Transition("fill", "full", "full", "h", -1, reset={"h": "4"})
    filled = cd.HybridSystem(
        states="h", parameters=tank.parameters, modes=tank.modes, transitions=[fill], initial=tank.initial
    )
    run = cd.trajectory(filled, duration=50.0, samples=1, method=method)
    assert cd.Outcome(int(run["outcome"])) == cd.Outcome.OK
    assert run["event_time"].values == pytest.approx([20.0, 40.0], abs=1e-5)


def test_a_guard_at_a_branch_point_fires_in_lanes(emptied):
    starts = np.linspace(1.0, 4.0, 9)
    batch = Batch(emptied, {}, starts[:, np.newaxis], np.zeros(9, dtype=int), Numerics(), unit=30.0)
    batch.run(0, np.array([0, 1]))
    assert batch.outcome.tolist() == [cd.Outcome.OK] * 9
    assert batch.mode.tolist() == [1] * 9
    assert batch.x[:, 0].tolist() == [0.0] * 9


@pytest.mark.parametrize("method", ADAPTIVE)
def test_integrals_and_tangents_go_through_a_pulse_that_no_state_feels(method):
    """Where y is zero so is its rate, whatever becomes of a deviation from it."""
    pulse = "1000*exp(-(1000*x - 123)**2)"
    system = cd.HybridSystem(
        states="x y", modes={"all": {"x": "1", "y": f"-y*{pulse}"}}, quadratures={"q": pulse}, initial={"x": -1.3}
    )
    run = cd.trajectory(system, duration=2.7, samples=1, tangents=True, method=method)
    assert run["q"].values[-1] == pytest.approx(np.sqrt(np.pi), rel=1e-10)
    assert run["final_tangent"].values[-1] == pytest.approx([0.0, np.exp(-np.sqrt(np.pi))], rel=1e-10)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_pulse_beside_the_start_is_no_size_of_a_longer_step(method):
    """The rate of one stage alone, times a step that is far longer than the pulse, is no size of what it moves."""
    pulse = cd.HybridSystem(
        states="x y", parameters={"w": 1e-7}, modes={"all": {"x": "1", "y": "exp(-(x/w)**2)/w"}}, initial={"y": 0}
    )
    for widths in (0.3, 1.0, 1e6):
        run = cd.trajectory(pulse.with_initial(x=-1e-7 * widths), duration=1e3, samples=1, method=method)
        assert run["states"].values[-1, 1] == pytest.approx(np.sqrt(np.pi) / 2 * (1 + math.erf(widths)), rel=1e-10)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_pulse_moves_a_state_at_rest_in_any_unit(method):
    """Its rates may be too small to tell a size where a stage first meets it."""
    pulse = cd.HybridSystem(
        states="x y", parameters={"u": 1.0}, modes={"all": {"x": "1", "y": "u*exp(-(1000*x)**2)"}}, initial={"x": -1.0}
    )
    for u in (1e9, 1e-80, 1e-200, 1e-220, 1e-240):
        for start in (-1.1, -1.01, -1.0, -0.98, -0.9):
            system = pulse.with_parameters(u=u).with_initial(x=start)
            run = cd.trajectory(system, duration=1 - start, samples=1, method=method)
            assert run["states"].values[-1, 1] / u == pytest.approx(np.sqrt(np.pi) / 1000, rel=1e-10)


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_pulse_of_a_guard_within_a_step_is_found(method):
    """A guard whose series at the ends of a step tell of nothing."""
    system = cd.HybridSystem(
        name="clock",
        states="x",
        parameters={},
        modes={"all": {"x": "1"}},
        transitions=[cd.Transition("pulse", "all", "all", "exp(-1000*(x - 1)**2) - 0.5", +1)],
        initial={"x": 0.0},
    )
    run = cd.trajectory(system, duration=3.0, samples=3, method=method)
    assert run["event_time"].values == pytest.approx([1 - np.sqrt(np.log(2) / 1000)], abs=1e-9)


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize(
    ("exponent", "half"),
    [
        ("-((x - c)/w)**2", lambda w: w * np.sqrt(np.log(2))),
        ("-((x - c)/w)**4", lambda w: w * np.log(2) ** 0.25),
        ("-(40*sin((t - c)/40)/w)**2", lambda w: 40 * np.arcsin(w / 40 * np.sqrt(np.log(2)))),
    ],
)
def test_a_narrow_pulse_of_a_guard_is_met_on_both_sides(method, exponent, half):
    """Far from the pulse its exponent is so large that its rounding hides where it is log(1/2)."""
    system = cd.HybridSystem(
        states="x",
        parameters={"c": 33.3, "w": 0.01},
        modes={"all": {"x": "1"}},
        transitions=[cd.Transition("pulse", "all", "all", f"exp({exponent}) - 1/2", 0)],
    )
    for c, w in ((33.3, 1e-2), (71.9, 1e-4), (20.01, 1e-6)):
        run = cd.trajectory(system.with_parameters(c=c, w=w), duration=100.0, samples=1, method=method)
        assert run["event_time"].values == pytest.approx([c - half(w), c + half(w)], abs=1e-10)


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize(
    ("pulse", "area"),
    [
        ("exp(2000*(cos(t) - 1))", special.ive(0, 2e3)),
        ("exp(-60000*sin(a/2)**2)", special.ive(0, 3e4)),
        ("((1 + cos(t))/2)**200", special.binom(400, 200) / 4.0**200),
    ],
)
def test_no_pulse_of_many_is_passed_over(method, pulse, area):
    """Between them the rates are 0 to doubles, and a step may be as long as many turns."""
    system = cd.HybridSystem(states="a q", modes={"all": {"a": "1", "q": pulse}})
    run = cd.trajectory(system, duration=2000 * np.pi, samples=1, method=method)
    assert run["states"].values[-1, 1] == pytest.approx(2000 * np.pi * area, rel=1e-9)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_pulse_in_the_middle_of_the_first_look_counts(method):
    """Wherever the first look is: its exponent there is that of the start."""
    system = cd.HybridSystem(
        states="x q", parameters={"c": 1.0}, modes={"all": {"x": "1", "q": "exp(-(10000*(x - c))**2)"}}
    )
    for c in 50 * 2.0 ** -np.arange(6, 16):
        run = cd.trajectory(system.with_parameters(c=c), duration=100.0, samples=1, method=method)
        assert run["states"].values[-1, 1] * 1e4 == pytest.approx(np.sqrt(np.pi), rel=1e-10)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_no_gate_of_many_is_passed_over(method):
    """One opens and closes 100 times, for a small part of each turn."""
    system = cd.HybridSystem(
        states="x",
        parameters={"k": 3e4},
        modes={"all": {"x": "1"}},
        transitions=[cd.Transition("opens", "all", "all", "1/3 + tanh(k*(cos(t) - 1 + 1/k))", +1)],
    )
    run = cd.trajectory(system, duration=200 * np.pi, samples=1, method=method)
    first = np.arccos(1 - (1 + np.arctanh(1 / 3)) / 3e4)
    assert run["event_time"].values == pytest.approx(2 * np.pi * np.arange(1, 101) - first, abs=1e-8)


# A case of the study for every method: none is ok and off by more than a hundred tolerances.


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_rate_that_leaves_the_doubles_is_told(method):
    # the quotient is nearly 1, but sinh(p)**2 is infinite from 355.6 on
    rate = "sqrt(p + sinh(p)**2)/cosh(p)"
    system = cd.HybridSystem(states="y p", modes={"all": {"y": rate, "p": "1"}}, initial={"y": 0.0, "p": 340.0})
    run = cd.trajectory(system, duration=20.0, samples=1, method=method)
    assert cd.Outcome(int(run["outcome"])) == cd.Outcome.NONFINITE


@pytest.mark.parametrize("role", ["integral", "guard"])
def test_an_integral_and_a_guard_that_leave_the_doubles_end_a_run(role):
    """Their series do so before they do: a run would go on by steps that obey nothing, or with no number."""
    term = "sqrt(p + sinh(p)**2)/cosh(p)"
    more = {"transitions": [cd.Transition("never", "all", "all", f"{term} - 2", +1)]}
    more = {"quadratures": {"q": term}} if role == "integral" else more
    system = cd.HybridSystem(states="p", modes={"all": {"p": "1"}}, initial={"p": 350.0}, **more)
    for method in (*ADAPTIVE, *(["rk4"] if role == "integral" else [])):
        run = cd.trajectory(system, duration=10.0, samples=1, method=method)
        assert cd.Outcome(int(run["outcome"])) == cd.Outcome.NONFINITE, method


@pytest.mark.parametrize("method", ADAPTIVE)
def test_an_integral_is_a_number_or_ends_the_run(method):
    """Its sum leaves the doubles, and before that the polynomials of an implicit step do."""
    system = cd.HybridSystem(
        states="p", parameters={"a": 1}, modes={"all": {"p": "1"}}, quadratures={"q": "a*cos(p)**2"}, initial={"p": 0}
    )
    for a, duration in ((1e306, 1.0), (1e307, 1.0), (1e306, 1000.0)):
        run = cd.trajectory(system.with_parameters(a=a), duration=duration, samples=1, method=method)
        right = a * (duration / 2 + math.sin(2 * duration) / 4)
        assert run["outcome"] == cd.Outcome.NONFINITE or run["q"].values[-1] == pytest.approx(right, rel=1e-10)


@settings(max_examples=24)
@given(data=st.data())
def test_nothing_is_wrong_in_silence(study, data):
    family = data.draw(st.sampled_from(study.families()))
    method = data.draw(st.sampled_from(study.METHODS))
    tolerance = data.draw(st.sampled_from(study.TOLERANCES))
    draw = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    cases = [family.draw(draw) for _ in range(2)]
    for case, (outcome, found) in zip(cases, study.ends(family, cases, method, tolerance), strict=True):
        assert study.off(case, outcome, found, tolerance) <= MOST
        # a run that ends says why: where it is singular, or where a hyperbolic cosine is no double any more
        assert outcome in (cd.Outcome.OK, cd.Outcome.SINGULAR, cd.Outcome.NONFINITE)
        assert outcome == cd.Outcome.OK or not case.ends or outcome == cd.Outcome.SINGULAR


def test_a_guard_is_not_met_where_the_motion_leaves_it():
    """A contact that begins at no depth, where its force has no series."""
    system = cd.HybridSystem(
        name="contact",
        states="d v",
        parameters={},
        modes={"touch": {"d": "v", "v": "-d**(3/2)"}, "apart": {"d": "v", "v": "0"}},
        transitions=[cd.Transition("part", "touch", "apart", "d", -1)],
        initial={"mode": "touch", "d": 0.0, "v": 1.0},
    )
    ended = cd.trajectory(system, duration=1.0, samples=2)
    assert cd.Outcome(int(ended["outcome"])) == cd.Outcome.SINGULAR
    assert ended["event_time"].size == 0
    # v^2/2 + d^(5/2)/2.5 stays what it is
    gone = cd.trajectory(system, duration=10.0, samples=2, method="dop853")
    assert gone["event_state_before"].values[0] == pytest.approx([0.0, -1.0], abs=1e-9)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_a_motion_ends_where_its_last_rounding_error_ends(method):
    """One rounding error before x = 1 the rate is no zero, and a billion steps would move nothing."""
    ends = cd.HybridSystem(states="x", modes={"m": {"x": "4.112034035386691*sqrt(1 - x**2)"}})
    run = cd.trajectory(ends, duration=1.0, samples=2, method=method)
    assert cd.Outcome(int(run["outcome"])) == cd.Outcome.SINGULAR

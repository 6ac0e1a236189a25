"""Beyond which guards the motion may go on is a matter of each guard alone."""

import math

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.codegen.events import mode_events
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.structure import passes


def kicked(factor, modes=12):
    """A body that each mode kicks where it meets x = 0, its speed being multiplied by a factor."""
    names = [f"m{i}" for i in range(modes)]
    return cd.HybridSystem(
        states="x v u",
        modes={name: {"x": "v", "v": "0", "u": "0"} for name in names},
        transitions=[cd.Transition(f"kick{i}", name, name, "x", -1, {"v": factor}) for i, name in enumerate(names)],
        initial={"mode": "m0", "x": 1.0, "v": -1.0},
    )


@pytest.mark.parametrize("factor", ["v*(u - 1/10)", "v*(u - 1/2)", "v*(u - 1)"])
def test_a_guard_is_passed_whatever_was_asked_of_others_before(factor):
    """The kick passes only at some u, which few states have: so it does in all twelve modes."""
    assert passes(kicked(factor)) == {(mode, 0) for mode in range(12)}


def test_guards_that_mirror_each_other_are_passed_alike():
    """Two equal masses: a guard of one, while the other slips or sticks, has a mirror image."""
    found = passes(cd.build("two-masses-on-belt"))
    assert ((1, 0) in found, (1, 1) in found) == ((3, 1) in found, (3, 2) in found)


def test_walls_are_no_passages_and_brakes_are():
    assert passes(kicked("-v/2", 1)) == frozenset()
    assert passes(kicked("v/2", 1)) == {(0, 0)}


@pytest.mark.parametrize("guard", ["x", "x*(1 + u)", "x + x*u", "x*(1 + v)"])
def test_a_wall_is_one_where_the_motion_is_whatever_its_guard_is_elsewhere(guard):
    """Where u or v is -1 some guards are zero, too, and there the kick changes nothing; at x = 0 all are a wall."""
    ball = cd.HybridSystem(
        states="x v u",
        modes={"fly": {"x": "v", "v": "-1", "u": "1"}},
        transitions=[cd.Transition("hit", "fly", "fly", guard, -1, {"v": "-v/2"})],
        initial={"u": 1.0},
    )
    assert cd.trajectory(ball, duration=1.0, samples=1, max_stalls=4)["outcome"] == cd.Outcome.STALLED
    with pytest.warns(cd.StartWarning):
        beyond = cd.trajectory(ball.with_initial(x=-1e-3), duration=1.0, samples=1)
    assert beyond["outcome"] == cd.Outcome.INVALID_START


@pytest.fixture(scope="module")
def sums():
    """Guards of x + y, which the motion keeps and kicks turn to 2/3 - x - y, and one that has no zero."""
    guards = {"three": "3*x + 3*y - 1", "square": "(x + y)**2 + 4*(x + y) - 13/9", "none": "exp(900*x) + exp(900*y)"}
    return cd.HybridSystem(
        states="x y z",
        parameters={"start": 1.0},
        modes={"on": {"x": "cos(3*z) + 1", "y": "-cos(3*z) - 1", "z": "1"}},
        transitions=[
            cd.Transition("kick", "on", "on", "sin(pi*(z - 1/2))", 0, {"y": "2/3 - 2*x - y"}),
            *(cd.Transition(name, "on", "on", guard, 0) for name, guard in guards.items()),
        ],
        initial={"x": 1.0},
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau", "rk4"])
def test_what_no_motion_changes_is_crossed_by_resets_alone(sums, method):
    """Rounding crosses no guard: where the sum is one of its zeros, and stays it, there is no event."""
    kicked = cd.trajectory(sums, duration=6.0, samples=1, method=method)
    assert np.bincount(kicked["event_kind"], minlength=4).tolist() == [6, 6, 6, 0]
    still = cd.trajectory(sums.with_initial(x=1 / 3), duration=6.0, samples=1, method=method)
    assert np.bincount(still["event_kind"], minlength=4).tolist() == [6, 0, 0, 0]


def test_lanes_cross_by_resets_what_no_motion_changes(sums):
    starts = np.array([[1.0, 0.0, 0.0], [1 / 3, 0.0, 0.0], [-1.0, 2.0, 0.0]])
    runs = Batch(sums, {}, starts, np.zeros(3, dtype=int), Numerics("taylor", 1e-12), unit=6.0)
    runs.run(0, np.array([0, 1]))
    assert runs.counts.tolist() == [[6, 6, 6, 0], [6, 0, 0, 0], [6, 6, 6, 0]]


KEPT = [
    ("x", {"x": "-3*x", "y": "-y"}),
    ("sinh(x)*(1 + y**2)", {"x": "-x/(1 + y**2)", "y": "1"}),
    ("(x - 1)**3", {"x": "(1 - x)*(2 + cos(t))"}),
    ("x - 0.3", {"x": "0.21 - 0.7*x"}),
    ("x - a", {"x": "a*y*(a - x)", "y": "-y"}),
    ("2 - 2*x", {"x": "x*(1 - x)"}),
    ("x - x**2", {"x": "x*(1 - x)"}),
    ("x", {"x": "x*(a - y)", "y": "y*(x - a)"}),
    ("x**2 + y**2 - 1", {"x": "x*(1 - x**2 - y**2) - y", "y": "y*(1 - x**2 - y**2) + x"}),
    ("y - x**3", {"x": "-x", "y": "-3*y"}),
    ("x", {"x": "-tanh(x/a)"}),
]
MET = [
    ("x", {"x": "-sqrt(x)"}),
    ("x", {"x": "-x**(1/3)"}),
    ("x", {"x": "-x**a"}),
    ("x**3 + 3*x**2 + 3*x + 1", {"x": "-(x + 1)**(1/3)"}),
    ("x", {"x": "-x*log(x**2)**2"}),
    ("x", {"x": "x/y", "y": "-1"}),
    ("x", {"x": "-x/(1 - t)"}),
    ("x", {"x": "-x*tan(y)", "y": "1"}),
    ("x", {"x": "-3*x - 1e-30"}),
    ("x - 1", {"x": "a - x"}),
    ("sin(x)", {"x": "-x"}),
    ("x**2 - 2*x", {"x": "x*(1 - x)"}),
    ("x + y", {"x": "-x", "y": "-2*y"}),
]


@pytest.mark.parametrize(("guard", "field", "kept"), [(*c, True) for c in KEPT] + [(*c, False) for c in MET])
def test_motions_keep_to_a_side_where_a_guard_s_rate_is_a_finite_multiple_of_it(guard, field, kept):
    on = cd.Transition("on", "on", "on", guard, 0)
    system = cd.HybridSystem(states=[*field], parameters={"a": 0.5}, modes={"on": field}, transitions=[on])
    assert [event.still for event in mode_events(system.placed, "on")] == [kept]


@pytest.fixture(scope="module")
def nears():
    """Guards on which motions come to lie, and kicks across all of them while s is 1/2, 1, 3/2 and 2."""
    guards = {"x": "3*x*(1 + s**2)", "l": "l - l**2", "circle": "p**2 + q**2 - 1", "u": "u - sin(t)"}
    ring = {"p": "p*(1 - p**2 - q**2) - q", "q": "q*(1 - p**2 - q**2) + p"}
    across = {"x": "-x", "l": "2 - l", "p": "p/(p**2 + q**2)", "q": "q/(p**2 + q**2)", "u": "2*sin(t) - u"}
    return cd.HybridSystem(
        states="x l p q u s",
        modes={"on": {"x": "-3*x", "l": "l*(1 - l)", **ring, "u": "cos(t) - u + sin(t)", "s": "1"}},
        transitions=[
            cd.Transition("kick", "on", "on", "(s - 1/2)*(s - 1)*(s - 3/2)*(s - 2)", 0, across),
            *(cd.Transition(name, "on", "on", guard, 0) for name, guard in guards.items()),
        ],
        initial={"x": 1.0, "l": 0.4, "p": 0.3, "q": 0.1, "u": 1.0},
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_what_comes_to_lie_on_a_guard_crosses_it_by_kicks_alone(nears, method):
    plain = cd.trajectory(nears.with_initial(s=3.0), duration=50.0, samples=1, method=method)
    assert plain.sizes["event"] == 0
    kicked = cd.trajectory(nears, duration=50.0, samples=1, method=method)
    assert np.bincount(kicked["event_kind"]).tolist() == [4, 4, 4, 4, 4]


def test_lanes_cross_by_kicks_alone_what_they_come_to_lie_on(nears):
    starts = np.array(
        [[1.0, 0.4, 0.3, 0.1, 1.0, 0.0], [1.0, 0.4, 0.3, 0.1, 1.0, 3.0], [-0.7, 0.4, 0.0, 1.4, -1.0, 0.0]]
    )
    runs = Batch(nears, {}, starts, np.zeros(3, dtype=int), Numerics("taylor", 1e-12), unit=50.0)
    runs.run(0, np.array([0, 1]))
    assert runs.counts.tolist() == [[4, 4, 4, 4, 4], [0, 0, 0, 0, 0], [4, 4, 4, 4, 4]]


@pytest.mark.parametrize("method", ["taylor", "radau"])
def test_what_decays_onto_a_guard_does_not_cross_it(method):
    """A neuron that is driven up to its threshold and no farther: beyond it is only what ends the polynomials."""
    neuron = cd.HybridSystem(
        states="v",
        parameters={"I": 1.0},
        modes={"on": {"v": "I - v"}},
        transitions=[cd.Transition("spike", "on", "on", "v - 1", 1, {"v": "0"})],
        initial={"v": 0.0},
    )
    assert not cd.trajectory(neuron, duration=300.0, samples=1, method=method).sizes["event"]
    driven = cd.trajectory(neuron.with_parameters(I=1.0 + 1e-6), duration=20.0, samples=1, method=method)
    assert driven["event_time"].values == pytest.approx([math.log((1 + 1e-6) / 1e-6)], abs=1e-5)

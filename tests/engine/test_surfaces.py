"""What is zero together is one surface: events and tangents do not depend on how a system is written."""

import importlib
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

import chaosdrill as cd

writings = importlib.import_module("writings")

METHODS = ("taylor", "dop853", "radau")


@pytest.mark.parametrize("kind", writings.KINDS)
@settings(max_examples=2, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(number=st.integers(0, 2**32 - 1))
@example(number=4390)
def test_events_do_not_depend_on_the_writing(kind, number):
    assert {method: wrong for method, wrong in writings.cases(kind, number) if wrong} == {}


def events(run, system):
    return [
        (system.transitions[int(k)].name, float(t)) for k, t in zip(run["event_kind"], run["event_time"], strict=True)
    ]


# Fields that push onto one surface from both sides


def relay(up, way, down=-1):
    return cd.HybridSystem(
        states="x",
        modes={"above": {"x": "-1"}, "below": {"x": "1"}},
        transitions=[
            cd.Transition("down", "above", "below", "x", down),
            cd.Transition("up", "below", "above", up, way),
        ],
        initial={"mode": "above", "x": 1.0},
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("up", "way"), [("x", 1), ("2*x", 1), ("-x", -1), ("x*(1 + x**2)", 1)])
def test_two_modes_that_push_onto_a_surface_stall_there(method, up, way):
    run = cd.trajectory(relay(up, way), duration=3.0, samples=1, method=method)
    assert cd.Outcome(int(run["outcome"])).meaning == "stalled"
    np.testing.assert_allclose(run["event_time"], 1.0, atol=1e-12)
    message = run.attrs["message"]
    assert all(part in message for part in ("'above'", "'below'", "x = 0", "cd.filippov", "time 1,"))


def test_infinitely_many_changes_between_two_tanks_are_told_apart_from_sliding():
    """One tank is filled while both drain: the 2 in them are gone at 1/4 in a unit of time."""
    system = cd.HybridSystem(
        states="x y",
        modes={"x": {"x": "1/4", "y": "-1/2"}, "y": {"x": "-1/2", "y": "1/4"}},
        transitions=[cd.Transition("to y", "x", "y", "y", -1), cd.Transition("to x", "y", "x", "x", -1)],
        initial={"mode": "x", "x": 1.0, "y": 1.0},
    )
    run = cd.trajectory(system, duration=10.0, samples=1)
    assert run["event_time"].values[-1] == pytest.approx(8.0, abs=1e-9)
    message = run.attrs["message"]
    assert all(part in message for part in ("x = 0", "y = 0", "add a mode"))
    assert "filippov" not in message


@pytest.mark.parametrize("method", METHODS)
def test_switches_in_either_direction_push_and_pass_and_bounce(method):
    """That the fields push onto the surface counts, not that a reset turns the motion back."""
    run = cd.trajectory(relay("x", 0, 0), duration=3.0, samples=1, method=method)
    assert cd.Outcome(int(run["outcome"])).meaning == "stalled"
    ball = cd.HybridSystem(
        states="x v",
        modes={mode: {"x": "v", "v": "-1"} for mode in ("odd", "even")},
        transitions=[
            cd.Transition(f"{a}-{b}", a, b, "x", 0, reset={"v": "-v/2"}) for a, b in (("odd", "even"), ("even", "odd"))
        ],
        initial={"x": 0.5},
    )
    run = cd.trajectory(ball, duration=2.2, samples=1, method=method)
    assert run["event_time"].values == pytest.approx([1.0, 2.0], abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("other", "way"), [("tan(3*({}))", -1), ("-tan({})", 1)])
@pytest.mark.parametrize(("roots", "count"), [([3.875] * 5, 1), ([0.5, 2.25, 2.25, 2.25, 3.0], 3)])
def test_a_surface_is_crossed_whichever_way_the_guard_beyond_it_grows(roots, count, other, way, method):
    """At a root of odd order the gradients of both guards tell what has been crossed, by their signs and sizes."""
    coefficients = np.polynomial.polynomial.polyfromroots(roots)
    coefficients /= 4 * np.abs(np.polynomial.polynomial.polyval(np.linspace(0, 6, 50), coefficients)).max()
    first = " + ".join(f"({a!r})*c**{k}" for k, a in enumerate(coefficients.tolist()))
    system = cd.HybridSystem(
        states="c",
        modes={"a": {"c": "1"}, "b": {"c": "1"}},
        transitions=[
            cd.Transition("rise", "a", "b", first, 1),
            cd.Transition("fall", "b", "a", other.format(first), way),
        ],
        initial={"mode": "a", "c": 0.0},
    )
    run = cd.trajectory(system, duration=6.0, samples=1, method=method)
    assert run["event_kind"].values.tolist() == [0, 1, 0][:count]


# A mode that is entered on its own guard


ENTRIES = {
    "from another surface": ("s - 1", {"x": "0", "v": "0", "s": "1"}, {}, {}),
    "at the turning point of a cubic": ("x", {"x": "v", "v": "6*(s - 1)", "s": "1"}, {"x": -1.0, "v": 3.0}, {}),
    "with its speed taken": ("x", {"x": "v", "v": "0", "s": "1"}, {"x": -1.0, "v": 1.0}, {"v": "0"}),
    "thrown back": ("x", {"x": "v", "v": "0", "s": "1"}, {"x": -1.0, "v": 1.0}, {"v": "-1"}),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("guard", "way"), [("x", -1), ("2*x", -1), ("-x", 1)])
@pytest.mark.parametrize("entry", ENTRIES)
def test_a_mode_that_is_entered_on_its_guard_is_left_at_once(entry, guard, way, method):
    first, rates, start, reset = ENTRIES[entry]
    system = cd.HybridSystem(
        states="x v s",
        modes={"A": rates, "B": {"x": "v", "v": "-1", "s": "1"}, "C": {"x": "0", "v": "0", "s": "1"}},
        transitions=[
            cd.Transition("enter", "A", "B", first, 1, reset=reset),
            cd.Transition("leave", "B", "C", guard, way),
        ],
        initial={"mode": "A", **start},
    )
    found = events(cd.trajectory(system, duration=3.0, samples=1, method=method), system)
    assert [name for name, _ in found] == ["enter", "leave"]
    # a triple root is located to the cube root of its error where it is interpolated
    error = 1e-4 if method != "taylor" and "cubic" in entry else 1e-12
    assert abs(found[0][1] - 1) < error
    assert abs(found[1][1] - found[0][1]) < 1e-7


# A switch on whose guard a motion begins, with a speed or without


ORDERS = (1, 2, 3, 4)
CHAIN = {"x": "v", "v": "w", "w": "z", "z": "1", "s": "1"}


@pytest.fixture(scope="module")
def departures():
    """Modes to begin in, or to enter where s is c, each with a guard that leaves zero then: by states, or by time."""
    modes, transitions = {"out": CHAIN}, []
    for k in ORDERS:
        for of, q in (("states", "zwvx"[k - 1]), ("time", f"(1 + v**2)*(t - c)**{k}")):
            name = f"{of} {k}"
            modes |= {name: CHAIN, f"before {name}": dict.fromkeys(CHAIN, "0") | {"s": "1"}}
            transitions.append(cd.Transition(f"enter {name}", f"before {name}", name, "s - c", 1))
            for way in (-1, 1):
                transitions.append(cd.Transition(f"{way} {name}", name, "out", f"a*{q}", way))
    return cd.HybridSystem(
        states=list(CHAIN),
        parameters={"a": 1.0, "c": 0.0},
        modes=modes,
        transitions=transitions,
        initial={"mode": "out"},
    )


@pytest.mark.parametrize("method", [*METHODS, "rk4"])
@pytest.mark.parametrize("k", ORDERS)
def test_tangents_pass_two_switches_of_one_instant(departures, method, k):
    """In the mode between the two, where no time passes, states that are zero have only begun to move."""
    system = departures.with_parameters(c=0.5).with_initial(mode=f"before states {k}")
    run = cd.trajectory(system, duration=2.0, samples=1, method=method, tangents=True)
    assert run.cd.outcome == "ok"
    np.testing.assert_allclose(run["event_time"], 0.5, rtol=1e-12)
    assert run.sizes["event"] == 2
    time = 1.5
    powers = [time**m / math.factorial(m) for m in range(4)]
    expected = np.eye(5)
    for row in range(4):
        expected[row, : row + 1] = powers[row::-1]
    # each began as much sooner as s is larger
    expected[4, :4] = powers[::-1]
    np.testing.assert_allclose(run["final_tangent"], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("of", ["states", "time"])
@pytest.mark.parametrize("k", ORDERS)
def test_a_switch_acts_at_once_if_its_guard_leads_across_by_whichever_derivative(departures, k, of, method):
    name = f"{of} {k}"
    for a, way in ((1.0, 1), (-3.0, -1)):
        for first, c in (([], 0.0), ([f"enter {name}"], 0.25)):
            system = departures.with_parameters(a=a, c=c).with_initial(mode=f"before {name}" if first else name)
            found = events(cd.trajectory(system, duration=0.5, samples=1, method=method), system)
            assert [event for event, _ in found] == [*first, f"{way} {name}"]
            assert [time for _, time in found] == pytest.approx([c] * len(found), abs=1e-15)


# Resets that land on a guard up to rounding


@pytest.mark.parametrize("angle", ["pi/4", "pi/6", "0.3", "0.7", "1.1"])
@pytest.mark.parametrize("image", ["sin(th) - sin({0})", "sin(th)**2 - sin({0})**2", "sin(th)/sin({0}) - 1"])
def test_a_reset_onto_a_guard_is_on_it(angle, image):
    system = cd.HybridSystem(
        states="th q",
        modes={"A": {"th": "1", "q": "0"}, "B": {"th": "1", "q": "cos(th)"}, "C": {"th": "1", "q": "0"}},
        transitions=[
            cd.Transition("in", "A", "B", f"th - {angle}", 1, reset={"q": image.format(angle)}),
            cd.Transition("out", "B", "C", "q", -1, reset={"q": "0"}),
            cd.Transition("round", "C", "A", "th - 2*pi", 1, reset={"th": "th - 2*pi"}),
        ],
        initial={"mode": "A"},
    )
    found = events(cd.trajectory(system, duration=20 * np.pi, samples=1), system)
    assert [name for name, _ in found] == ["in", "out", "round"] * 9 + ["in", "out"]
    stays = [after[1] - before[1] for before, after in pairwise(found) if before[0] == "in"]
    begin = float(eval(angle, {"pi": np.pi}))
    np.testing.assert_allclose(stays, np.pi - 2 * begin, atol=1e-12)


# Causes


@pytest.mark.parametrize("order", ["A0 A1 C0 C1", "C0 C1 A0 A1", "A0 C1 A1 C0"])
@pytest.mark.parametrize("method", METHODS)
def test_two_copies_in_step_have_the_tangents_of_one(order, method):
    def made(copies, order):
        modes, transitions, start = {}, {}, {}
        for i in copies:
            x, z = f"x{i}", f"z{i}"
            modes |= {x: f"1 + {z}/20", z: f"-{z}"}
            transitions[f"A{i}"] = cd.Transition(f"A{i}", "m", "m", f"{x} - 1", 1, reset={x: f"{x} - 1", z: f"{z} + 5"})
            transitions[f"C{i}"] = cd.Transition(f"C{i}", "m", "m", f"{z} - 3", 1, reset={z: f"{z}/2"})
            start |= {z: 0.5}
        return cd.HybridSystem(
            states=list(modes), modes={"m": modes}, transitions=[transitions[k] for k in order.split()], initial=start
        )

    one = cd.trajectory(made([0], "A0 C0"), duration=3.6, samples=1, tangents=True, method=method)
    two = cd.trajectory(made([0, 1], order), duration=3.6, samples=1, tangents=True, method=method)
    assert two.sizes["event"] == 2 * one.sizes["event"] > 8
    alone, together = one["final_tangent"].values, two["final_tangent"].values
    zero = np.zeros((2, 2))
    np.testing.assert_allclose(together, np.block([[alone, zero], [zero, alone]]), atol=1e-9)


# Surfaces that no expression shows to be one, in lanes


def driven(second, way):
    return cd.HybridSystem(
        states="x v",
        parameters={"k": 2.0, "F": 1.0},
        modes={"right": {"x": "v", "v": "F*cos(2*t) - x - v/5"}, "left": {"x": "v", "v": "F*cos(2*t) - 2*x - v/5"}},
        transitions=[
            cd.Transition("over", "right", "left", "x", -1, reset={"v": "0.9*v"}),
            cd.Transition("back", "left", "right", second, way, reset={"v": "0.9*v"}),
        ],
        period="pi",
        initial={"mode": "right", "x": 1.0},
    )


def test_lanes_see_that_guards_vanish_together():
    sweep = {"F": np.linspace(0.5, 2.0, 8)}
    given = {"transient": 200, "periods": 32, "progress": False}
    plain, *others = (
        cd.bifurcation_diagram(driven(*written), sweep, **given)
        for written in (("x", 1), ("k*x", 1), ("-k*x", -1), ("x*(v - 100)", -1))
    )
    assert (plain["period"] > 0).all()
    for other in others:
        for name in ("period", "outcome", "events_per_period"):
            np.testing.assert_array_equal(other[name], plain[name])
        # of a complex pair the tangents go on turning from where they began, and the sum alone is that of any record
        sums = (each["lyapunov_exponent"].sum("exponent") for each in (other, plain))
        np.testing.assert_allclose(*sums, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("other", ["a", "a*(1 - a/40)", "-a**3*(1 + a/30)"])
def test_a_state_that_every_step_brings_back_to_zero_keeps_its_size(method, other):
    """A rocking block whose steps end where it passes its middle: its angle is not what it is there.

    From a0 at rest an arc lasts arccosh(1/(1 - a0)), and speeds go on as 9/10 of those before.
    """
    way = -1 if other.startswith("-") else 1
    block = cd.HybridSystem(
        states="a w",
        modes={"right": {"a": "w", "w": "a - 1"}, "left": {"a": "w", "w": "a + 1"}},
        transitions=[
            cd.Transition("to_left", "right", "left", "a*exp(a/5)", -1, reset={"w": "9*w/10"}),
            cd.Transition("to_right", "left", "right", other, way, reset={"w": "9*w/10"}),
        ],
        initial={"mode": "right", "a": 0.3},
    )
    run = cd.trajectory(block, duration=6.0, samples=1, method=method)
    speed = np.sqrt(1 - 0.7**2)
    right = [np.arccosh(1 / 0.7)]
    for _ in range(4):
        speed *= 0.9
        right.append(right[-1] + 2 * np.arctanh(speed))
    assert run["event_time"].values == pytest.approx(right, abs=1e-10)

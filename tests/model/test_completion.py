"""A transition that completes what can never be a series of rebounds is refused, with the reason; others are not."""

import dataclasses

import pytest
import sympy

import chaosdrill as cd

HELD = {"x": "0", "v": "0"}
FLIGHT = {"x": "v", "v": "-g"}


def ball(*more, reset="-e*v", lift=None, rate="-g", guard="x", target="fly", parameters=None, **modes):
    transitions = [
        cd.Transition("hit", "fly", target, guard, -1, {"v": reset, **({"x": lift} if lift else {})}),
        cd.Transition("rest", "fly", "held", guard, -1, HELD, completes="hit"),
        *more,
    ]
    return cd.HybridSystem(
        name="ball",
        states="x v",
        parameters={"e": 0.5, "g": 1.0, "w": 2.0, **(parameters or {})},
        modes={"fly": {"x": "v", "v": rate}, "held": HELD, **modes},
        transitions=transitions,
    )


def tanks(*which):
    """Two of them leak, one at a time is filled, the one that is empty (Lee and Seshia 2017, Figure 4.17)."""
    turns = [("to2", "fill1", "fill2", "x2", -1), ("to1", "fill2", "fill1", "x1", -1)]
    empty = {"x1": "0", "x2": "0"}
    return cd.HybridSystem(
        name="tanks",
        states="x1 x2",
        parameters={"w": 0.75, "a": 0.5, "b": 0.5},
        modes={"fill1": {"x1": "w - a", "x2": "-b"}, "fill2": {"x1": "-a", "x2": "w - b"}, "dry": empty},
        transitions=[
            *(cd.Transition(*one) for one in turns),
            *(
                cd.Transition(f"dry-{name}", source, "dry", guard, way, empty, completes=name)
                for name, source, _, guard, way in turns
                if name in which
            ),
        ],
        initial={"mode": "fill1", "x2": 1.0},
    )


@pytest.mark.parametrize("which", [("to2",), ("to1",), ("to1", "to2")])
def test_two_tanks_that_take_turns_are_refused(which):
    with pytest.raises(cd.ModelError) as caught:
        tanks(*which)
    told = str(caught.value).splitlines()
    assert len(told) == len(which)
    for line, other in zip(
        told,
        [
            {
                "to1": "'to2' is an event of another surface, x2 = 0",
                "to2": "'to1' is an event of another surface, x1 = 0",
            }[one]
            for one in sorted(which, reverse=True)
        ],
        strict=True,
    ):
        assert other in line
        assert "has no acceleration" in line
        assert "a guard of its own that is zero when all is over" in line


def test_two_tanks_end_by_the_guard_that_is_advised():
    """Both are empty at 1/(a + b - w) = 4, when their sum is zero."""
    plain = tanks()
    over = cd.Transition("over", ("fill1", "fill2"), "dry", "x1 + x2 - 1e-6", -1, {"x1": "0", "x2": "0"})
    system = cd.HybridSystem(
        name="tanks", states="x1 x2", parameters=plain.parameters, modes=plain.modes,
        transitions=[*plain.transitions, over], initial=plain.initial,
    )  # fmt: skip
    run = cd.trajectory(system, duration=6.0)
    assert int(run["outcome"]) == cd.Outcome.OK
    assert run["event_time"].values[-1] == pytest.approx((1 - 1e-6) / 0.25, rel=1e-12)


BACK = cd.Transition("again", "other", "fly", "2*x", -1, {"v": "-e*v"})
LIFTS = cd.Transition("lifts", "other", "fly", "x", 1, {"x": "v**2 + 0.01"})

REFUSED = {
    "lossless": (lambda: ball(reset="-v"), "loses no speed, .*e < 1"),
    "lossless on a lift": (lambda: ball(reset="-v - 2*g", guard="x + g*t"), "loses no speed"),
    "faster": (lambda: ball(reset="-v*(1 + v**2)"), "loses no speed"),
    "lifted": (lambda: ball(lift="v**2/20"), "takes x from zero to v\\*\\*2/20"),
    "put back": (lambda: ball(lift="1"), "takes x from zero to 1"),
    "lifted by a number": (lambda: ball(lift="2*x + 0.01"), "takes x from zero to 2\\*x \\+ 0.01"),
    "lossless in two modes": (
        lambda: ball(
            cd.Transition("again", "other", "fly", "2*x", -1, {"v": "-v"}), reset="-v", target="other", other=FLIGHT
        ),
        "loses no speed",
    ),
    "lifted in another mode": (
        lambda: ball(
            cd.Transition("again", "other", "fly", "2*x", -1, {"x": "v**2", "v": "-e*v"}), target="other", other=FLIGHT
        ),
        "reset of 'again' takes x from zero",
    ),
    "lifted on the way to a mode that does not": (
        lambda: ball(
            dataclasses.replace(BACK, source="third"),
            dataclasses.replace(LIFTS, target="third"),
            target="other",
            other=FLIGHT,
            third=FLIGHT,
        ),
        "reset of 'lifts' takes x from zero",
    ),
    "passed": (lambda: ball(reset="v"), "so nothing rebounds"),
    "passed slower": (lambda: ball(reset="v**3/(1 + v**2)", rate="-1"), "does not come back"),
    "thrown away": (lambda: ball(reset="-v/2", rate="1 + v**2"), "does not come back"),
    "unaccelerated": (lambda: ball(rate="0"), "has no acceleration"),
    "unaccelerated on the guard": (lambda: ball(rate="-x - x*v**2"), "has no acceleration"),
    "a clock": (lambda: ball(guard="sin(w*t)"), "time alone"),
    "without a way back": (lambda: ball(target="gone", gone=FLIGHT), "no transition leads on"),
    "a way to another surface": (
        lambda: ball(
            cd.Transition("roof", "gone", "fly", "x - 1", 1, {"v": "-v"}), target="gone", gone={"x": "v", "v": "0"}
        ),
        "has no acceleration",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_can_be_no_series_is_refused(case):
    make, reason = REFUSED[case]
    with pytest.raises(cd.ModelError, match=rf"ball: transitions\.rest\.completes: completes 'hit': .*{reason}"):
        make()


RISE = {"x": "v", "v": "-g - v**2"}
ACCEPTED = {
    "ball": ball,
    "elastic for some values": lambda: ball(parameters={"e": 1.0}),
    "put back within rounding": lambda: ball(lift="0.1", guard="3*x - 0.3"),
    "loss near its value only": lambda: ball(reset="-v*(e - 100)", parameters={"e": 100.5}),
    "loss below zero only": lambda: ball(reset="-v*sqrt(-e)", parameters={"e": -0.5}),
    "less than the speed": lambda: ball(reset="-v*(1 - v**2/2)"),
    "drag": lambda: ball(rate="-g - v*sqrt(1 + v**2)"),
    "drive": lambda: ball(rate="-x - cos(w*t)"),
    "put onto the floor": lambda: ball(lift="sin(x)*v"),
    "put onto a moving floor": lambda: ball(
        guard="x - cos(w*t)", lift="cos(w*t)", reset="-w*sin(w*t) - e*(v + w*sin(w*t))"
    ),
    "at rest for some values": lambda: ball(parameters={"g": 0.0}),
    "mode of its own for the way up": lambda: ball(
        cd.Transition("top", "up", "fly", "v", -1), target="up", rate="-g + v**2", up=RISE
    ),
    "through another mode, at the same surface written otherwise": lambda: ball(
        cd.Transition("again", "other", "fly", "2*x*(1 + v**2)", -1, {"v": "-e*v"}), target="other", other=FLIGHT
    ),
    "one of two ways back lifts": lambda: ball(BACK, LIFTS, target="other", other=FLIGHT),
    "one of two lifts, the other way round": lambda: ball(LIFTS, BACK, target="other", other=FLIGHT),
    "a cycle of three modes": lambda: ball(
        cd.Transition("second", "two", "three", "x", -1, {"v": "-e*v"}),
        cd.Transition("third", "three", "fly", "-x", 1, {"v": "-e*v"}),
        target="two",
        two=FLIGHT,
        three=FLIGHT,
    ),
}


@pytest.mark.parametrize("make", ACCEPTED.values(), ids=ACCEPTED)
def test_what_may_be_a_series_is_not_refused(make):
    assert make().transitions[1].completes == "hit"


@pytest.mark.parametrize("names", [("t", "sin"), ("exp", "t"), ("if", "numpy"), ("lambda", "x_0")])
def test_names_have_no_say(names):
    x, v, e = (sympy.Symbol(name, real=True) for name in (*names, "cos"))
    at = {"guard": x, "direction": -1}
    given = {
        "states": names,
        "parameters": {"cos": 0.5},
        "modes": {"fly": {x: v, v: sympy.sqrt(e**2 + 1) / 4 - 1}, "held": {x: 0, v: 0}},
    }

    def transitions(back):
        hit = cd.Transition("hit", "fly", "fly", **at, reset={v: back})
        return [hit, cd.Transition("rest", "fly", "held", **at, reset={x: 0, v: 0}, completes="hit")]

    assert cd.HybridSystem(**given, transitions=transitions(-e * v)).transitions
    with pytest.raises(cd.ModelError, match="loses no speed"):
        cd.HybridSystem(**given, transitions=transitions(-v))

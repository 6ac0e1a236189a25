"""Words are told modulo the shifts of a system: what is carried along changes none, what others see does."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset import Outcome
from chaosdrill.systems import build

LENGTHS = {"transient": 200, "periods": 1024}
SYSTEMS = {
    "duffing": (None, "v"),
    "impact-oscillator": (None, "1 + x"),
    "bouncing-ball": (None, "2"),
    "belt-stick-slip": ("release", "v"),
    "integrate-and-fire": ("spike", "1"),
    "lorenz": ("z > 27", "z"),
}


def carrying(system, rate):
    """The system with a state that grows at a rate and, if there are events, by one at each, and enters nothing."""
    s = sympy.Symbol("carried", real=True)
    known = {x.name: x for x in system.states}
    transitions = [
        cd.Transition(t.name, t.source, t.target, t.guard, t.direction, {**t.reset, s: s + 1}, t.condition,
                      t.priority, t.completes, t.kind)
        for t in system.transitions
    ]  # fmt: skip
    return cd.HybridSystem(
        name=system.name, states=(*system.states, s), time=system.time, period=system.period,
        modes={mode: {**field, s: sympy.sympify(rate, known)} for mode, field in system.modes.items()},
        transitions=transitions, parameters=system.parameters, initial=system.initial,
    )  # fmt: skip


@pytest.mark.parametrize("name", SYSTEMS)
def test_what_is_carried_along_changes_no_word(name):
    at, rate = SYSTEMS[name]
    lengths = LENGTHS | {"at": at}
    both = [build(name), carrying(build(name), rate)]
    words = [int(cd.lyapunov_spectrum(one, **lengths)["outcome"]) for one in both]
    assert words[0] == words[1]
    key = next(iter(both[0].parameters))
    grid = {key: [both[0].parameters[key]]}
    bare, placed = (cd.bifurcation_diagram(one, grid, exponents=1, **lengths) for one in both)
    assert int(placed["outcome"][0, 0]) == int(bare["outcome"][0, 0]) == words[0]
    assert int(placed["period"][0, 0]) == int(bare["period"][0, 0])


@pytest.mark.parametrize(
    ("field", "jumps"),
    [
        ({"x": "v", "v": "cos(t) - x - v/5 + atan(s)", "s": "1 + v/9"}, {}),
        ({"x": "v", "v": "cos(t) - x - v/5", "s": "1"}, {"reset": {"v": "-v/2"}, "condition": "s < 1e5"}),
    ],
)
def test_what_others_see_grow_is_open(field, jumps):
    """An angle without a period, and a clock that a condition reads."""
    hits = [cd.Transition("hit", "on", "on", "x - 1/5", 1, **jumps)] if jumps else []
    system = cd.HybridSystem(
        name="seen", states="x v s", time="t", period="2*pi", parameters={"w": 1.0}, modes={"on": field},
        transitions=hits,
    )  # fmt: skip
    assert int(cd.lyapunov_spectrum(system, **LENGTHS)["outcome"]) == Outcome.OPEN


def test_an_angle_is_told_modulo_its_turns():
    """A rotor that drives an oscillator, by an angle whose turn a parameter tells: a cycle, for any length."""
    rotor = cd.HybridSystem(
        name="rotor", states="phi x v", parameters={"n": 3.0, "w": 0.77},
        modes={"on": {"phi": "w + x/9", "x": "v", "v": "cos(n*phi) - x - v/2"}}, initial={"x": 0.4},
    )  # fmt: skip
    for duration in (200, 800, 3200):
        assert int(cd.lyapunov_spectrum(rotor, duration=duration, transient=60)["outcome"]) == Outcome.PERIODIC
    ds = cd.poincare_section(rotor, at="v > 0", periods=64, transient=40)
    assert int(ds["period"]) == 1
    swept = cd.bifurcation_diagram(rotor, {"n": [2.0, 3.0]}, at="v > 0", periods=64, transient=40)
    assert set(swept["outcome"].values.ravel().tolist()) == {Outcome.PERIODIC}
    chart = cd.parameter_chart(rotor, {"n": [2.0, 3.0], "w": [0.7, 0.77]}, duration=50, transient=60, max_extension=0)
    assert Outcome.OPEN not in chart["outcome"].values


@pytest.mark.parametrize("duration", [300, 6000])
def test_locked_phases_are_on_a_cycle_from_the_beginning(duration):
    """Two rotors that come to one rate rest but for their common phase: that approach is no turn of the motion."""
    field = {"a": "1 + sin(b - a)/3", "b": "1.1 + sin(a - b)/3"}
    rotors = cd.HybridSystem(name="rotors", states="a b", modes={"on": field}, initial={"a": 0.1, "b": 0.2})
    assert int(cd.lyapunov_spectrum(rotors, duration=duration)["outcome"]) == Outcome.PERIODIC


@pytest.mark.parametrize("duration", [60.0, 3000.0])
def test_an_angle_alone_goes_round_a_cycle(duration):
    """An overdamped junction beyond its critical current: a flow of one state leaves a line, but not a circle."""
    junction = cd.HybridSystem(
        name="junction", states="p", parameters={"k": 0.3, "q": 0.0}, modes={"on": {"p": "1/2 - k*sin(p)"}}
    )
    lengths = {"duration": duration, "transient": 20}
    chart = cd.parameter_chart(junction, {"k": [0.3], "q": [0.0]}, exponents=1, max_extension=0, **lengths)
    assert words(cd.lyapunov_spectrum(junction, **lengths)) == words(chart) == {"periodic"}


def test_attractors_are_matched_modulo_shifts():
    """A pendulum at rest but for its shaking, in whichever of its wells."""
    pendulum = cd.HybridSystem(
        name="pendulum", states="x v", time="t", period="2*pi/w", parameters={"w": 0.7},
        modes={"on": {"x": "v", "v": "cos(w*t)/5 - sin(x) - v/2"}},
    )  # fmt: skip
    ds = cd.basins(pendulum, {"x": np.linspace(-9, 9, 8), "v": np.linspace(-4, 4, 4)}, transient=100, periods=64)
    assert np.unique(ds["attractor"]).tolist() == [1]
    assert ds["attractor_period"].values.tolist() == [1]


TURN = "Mod(a + w, 1)"


def words(found):
    return {Outcome(int(code)).meaning for code in found["outcome"].values.ravel()}


@pytest.mark.parametrize(
    ("images", "word"),
    [
        ({"a": TURN, "x": "x/2 + 1"}, "quasiperiodic"),
        ({"a": TURN, "x": "x/2 + Piecewise(1, a < 1/2, 0)"}, "undecided"),
        ({"a": TURN, "x": "Mod(x + sqrt(3)/3, 1)"}, "undecided"),
        ({"a": TURN, "x": "Mod(x + Piecewise(sqrt(3)/3, a < 1/2, sqrt(5)/5), 1)"}, "undecided"),
    ],
)
def test_what_a_step_turns_repeats_by_its_parts_alone(images, word):
    """No slope tells of an angle that `Mod` brings back: whether parts of a turn come back decides."""
    one = cd.Map("a x", {"w": np.sqrt(2) / 2}, images, initial={"a": 0.3, "x": 0.3}, name="turns")
    assert words(cd.lyapunov_spectrum(one, periods=512, transient=100)) == {word}
    for extension in (0, 8):
        length = {"transient": 100, "periods": 512, "max_extension": extension}
        assert words(cd.bifurcation_diagram(one, {"w": [np.sqrt(2) / 2]}, **length)) == {word}
    if "sqrt" not in images["x"]:
        assert words(cd.lyapunov_spectrum(one.with_parameters(w=0.2), periods=512, transient=100)) == {"periodic"}


@pytest.mark.parametrize("image", ["x + 0.4 + k*sin(2*pi*x)", "x + 2/5 + k*sin(6.283185307179586*x)"])
def test_the_angle_of_a_circle_map_is_one_however_its_numbers_are_written(image):
    """Below 1/(2 pi) the map has an inverse: its motion is a cycle or fills the circle, and no state grows."""
    circle = cd.Map("x", {"k": 0.14}, {"x": image}, initial={"x": 0.3}, name="circle")
    assert words(cd.lyapunov_spectrum(circle, periods=1024)) == {"quasiperiodic"}

"""Slow departures, followed sweeps, laminar phases, runs to infinity: systems whose motion is known in closed form."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from support.discrete import clocked

import chaosdrill as cd
from chaosdrill.analysis.judgement.classification import (
    Averages,
    add_ends,
    add_passages,
    add_regularity,
    contracts,
    is_no_channel,
)
from chaosdrill.analysis.judgement.predicting import predicted
from chaosdrill.analysis.judgement.recurrence import recurrence
from chaosdrill.analysis.judgement.stationarity import departs, shows, stationarity
from chaosdrill.analysis.judgement.tori import examine, only_grows, stopped
from chaosdrill.analysis.judgement.words import BOUNDED, RULES, Evidence, steady
from chaosdrill.analysis.judgement.words import words as words_of
from chaosdrill.engine.shifts import Shifts

CHANNEL = 0.51435527
"""A point of the cycle of period three of the logistic map where it is born."""

X, Y, M, R = sympy.symbols("x y m r", real=True)

GOLDEN = (np.sqrt(5) - 1) / 2


def words(found):
    return [cd.Outcome(int(code)).meaning for code in np.ravel(found["outcome"].values)]


def flow(states, field, start, **more):
    return cd.HybridSystem(name="flow", states=states, modes={"on": field}, initial=start, **{"parameters": {}, **more})


@pytest.fixture(scope="module")
def van_der_pol():
    field = {"x": "v", "v": "m*(1 - x**2)*v - x"}
    return flow("x v", field, {"x": 1e-9, "v": 0.0}, parameters={"m": 0.02})


@pytest.fixture(scope="module")
def pitchfork():
    """x -> (1 + m) x - x**3: x = 0 loses its stability to +-sqrt(m) at m = 0."""
    return clocked("pitchfork", (X,), {"m": 0.02}, {X: X + M * X - X**3}, {X: 1e-8})


def test_a_slow_departure_is_no_chaos(van_der_pol):
    """All of the record is the unstable rest: two equal positive exponents, and none is that of the flow."""
    found = cd.lyapunov_spectrum(van_der_pol, duration=1500.0, transient=100.0)
    assert words(found) == ["transient"]
    assert found["lyapunov_exponent"].values[1] > 0.0099
    assert found.attrs["reason"]
    settled = cd.lyapunov_spectrum(van_der_pol.with_initial(x=1.0), duration=500.0, transient=500.0)
    assert words(settled) == ["periodic"]


def test_spectrum_diagram_and_basins_give_one_word(van_der_pol):
    """From one start over one length, and over a longer one if that is allowed."""
    lengths = {"transient": 100.0, "duration": 500.0}
    spectrum = cd.lyapunov_spectrum(van_der_pol, **lengths)
    grid = {"x": [1e-9, 1e-6], "v": [0.0, 1e-9]}
    assert set(words(cd.basins(van_der_pol, grid, **lengths, max_extension=0))) == set(words(spectrum)) == {"transient"}
    for at in (lengths, {"at": "v > 0", "transient": 20, "periods": 128}):
        assert set(words(cd.basins(van_der_pol, grid, **at))) == {"periodic"}


@pytest.mark.parametrize(
    ("name", "parameter", "values", "periods"),
    [
        ("logistic", "r", [3.001, 3.5699456718709, 3.7, 3.8284], 600),
        ("delayed_logistic", "r", [2.005, 2.05, 2.1], 700),
        ("pitchfork", "m", [0.01, 0.02], 1500),
        ("duffing", "gamma", [0.3, 0.4], 130),
    ],
)
def test_all_analyses_give_one_word_for_a_start_and_a_length(name, parameter, values, periods, request):
    """Spectra, diagrams, charts and basins: slow cycles, adding machines, chaos, tori that settle, departures."""
    system = request.getfixturevalue(name)
    lengths = {"periods": periods, "transient": 20}
    state, other = system.state_names[:2]
    starts = np.sort(float(system.initial[state]) + np.random.default_rng(11).uniform(0, 0.05, 3))
    seeds, beside = [{state: float(one)} for one in starts], {other: [float(system.initial[other])]}
    short = {"max_extension": 0, **lengths}
    diagram = np.reshape(words(cd.bifurcation_diagram(system, {parameter: values}, seeds=seeds, **short)), (-1, 3))
    for row, value in zip(diagram.tolist(), values, strict=True):
        here = system.with_parameters(**{parameter: value})
        assert row == [words(cd.lyapunov_spectrum(here.with_initial(**seed), **lengths))[0] for seed in seeds]
        assert row == words(cd.basins(here, {state: starts, **beside}, **short))
        for second in [name for name in system.parameters if name != parameter][:1]:
            sweep = {parameter: [value], second: [float(system.parameters[second])]}
            assert row == words(cd.parameter_chart(here, sweep, seeds=seeds, **short))


@pytest.mark.parametrize("at", [{}, {"at": "x > 0"}])
def test_words_of_a_duration_do_not_depend_on_the_section(van_der_pol, at):
    """Instants of all of it tell what its few points of a section do not: slow departures, and slow cycles."""
    found = []
    for m, start in ((0.01, 0.4), (0.03, 1.0), (0.05, 0.3), (0.05, -0.2), (0.2, 0.1)):
        here = van_der_pol.with_parameters(m=m).with_initial(x=start)
        word = words(cd.lyapunov_spectrum(here, transient=0, duration=600.0))
        if at:
            other = cd.bifurcation_diagram(here, {"m": [m]}, transient=0, duration=600.0, max_extension=0, **at)
        else:
            other = cd.basins(here, {"x": [start], "v": [0.0]}, transient=0, duration=600.0, max_extension=0)
        assert words(other) == word
        found += word
    assert found.count("periodic") > 2


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_departure_ends_on_its_cycle(unit):
    leaving = clocked("pf", (X,), {"m": 0.02}, {X: X + M * X - X**3 / unit**2}, {X: 1e-8 * unit})
    assert words(cd.lyapunov_spectrum(leaving, periods=500, transient=100)) == ["transient"]
    found = cd.bifurcation_diagram(leaving, {"m": [0.01, 0.02, 0.05]}, transient=100, periods=256)
    assert words(found) == ["periodic"] * 3
    np.testing.assert_allclose(found["section"].values[:, 0, -1, 0], unit * np.sqrt([0.01, 0.02, 0.05]), rtol=1e-3)


@pytest.mark.parametrize("side", [1, -1])
def test_a_departure_that_is_over_leaves_a_cycle(side):
    """In the earlier half of a record of a spectrum; the error of the exponent is as large as the departure."""
    leaving = clocked("over", (X,), {"m": 0.08}, {X: side * (X + M * X - X**3)}, {X: 1e-11})
    assert words(cd.lyapunov_spectrum(leaving, periods=1024)) == ["periodic"]


@pytest.mark.parametrize("below", [1e-8, 2e-8])
def test_a_passage_of_a_channel_is_no_cycle(below):
    """Points a turn apart are the same within 1e-6, and go on in one direction."""
    logistic = clocked("channel", (X,), {"r": 1 + 8**0.5 - below}, {X: R * X * (1 - X)}, {X: CHANNEL})
    assert words(cd.lyapunov_spectrum(logistic, periods=64))[0] in {"undecided", "transient"}


@pytest.mark.parametrize("start", [-0.95, -0.965])
def test_a_stay_at_a_neutral_point_is_not_open(start):
    """On the cusp map, 1 - 2 sqrt|x|, a point leaves -1 ever faster: that would be over in a finite time."""
    cusp = clocked("cusp", (X,), {}, {X: 1 - 2 * sympy.sqrt(sympy.Abs(X))}, {X: start})
    assert words(cd.lyapunov_spectrum(cusp, periods=64))[0] in {"undecided", "transient", "chaotic"}


def test_a_departure_that_saturates_is_none_to_infinity():
    """From ``x' = mu x - x**3`` in closed form, and a drift that follows a power of time, begun at any time."""
    time = np.linspace(0.0, 1.0, 2048)
    growth, first = (one.ravel() for one in np.meshgrid(np.linspace(1.2, 2.0, 9), np.geomspace(0.02, 0.1, 9)))
    lacking = (1 / first**2 - 1)[:, np.newaxis] * np.exp(-2 * growth[:, np.newaxis] * time)
    path = 1 / np.sqrt(1 + lacking)
    rest = (path**2).mean(axis=1) * 3 * growth
    exponents = (growth - rest)[:, np.newaxis]
    drifts = only_grows(path[..., np.newaxis], path[:, -1:])
    assert drifts.sum() > 20
    assert departs(path[..., np.newaxis], drifts, exponents)[drifts[:, 0]].all()
    power, begun = (
        one.ravel()[:, np.newaxis] for one in np.meshgrid(np.linspace(1.1, 4.0, 9), np.geomspace(0.01, 100, 9))
    )
    path = (begun + time) ** power
    drifts = only_grows(path[..., np.newaxis], path[:, -1:])
    assert not departs(path[..., np.newaxis], drifts, np.zeros((len(path), 1))).any()


@pytest.mark.parametrize("count", [21, 41])
def test_a_followed_pitchfork_has_no_hysteresis(pitchfork, count):
    m = np.linspace(-0.1, 0.1, count)
    system = pitchfork.with_initial(x=0.1)
    found = cd.bifurcation_diagram(system, {"m": m}, follow="both", transient=100, periods=128)
    both, beyond = found["section"].values[:, :, -1, 0], np.maximum(m, 0)[:, np.newaxis]
    away = np.abs(m) > 1e-12
    np.testing.assert_allclose(both[away] ** 2, np.tile(beyond, 2)[away], atol=1e-6)
    assert set(np.array(words(found)).reshape(count, 2)[away].ravel()) == {"periodic"}


def test_a_followed_flip_doubles_at_once():
    flip = clocked("flip", (X,), {"m": 0.0}, {X: -(1 + M) * X + X**3}, {X: 0.1})
    m = np.linspace(-0.05, 0.06, 23)
    found = cd.bifurcation_diagram(flip, {"m": m}, follow="forward", transient=100, periods=128)
    away = np.abs(m) > 1e-12
    np.testing.assert_array_equal(found["period"].values[away, 0], np.where(m[away] < 0, 1, 2))


def test_a_followed_fixed_point_sheds_its_circle_at_once():
    turn, shrink = sympy.Rational(7, 10), (1 + M) * (1 - X**2 - Y**2)
    images = {
        X: shrink * (sympy.cos(turn) * X - sympy.sin(turn) * Y),
        Y: shrink * (sympy.sin(turn) * X + sympy.cos(turn) * Y),
    }
    shed = clocked("shed", (X, Y), {"m": 0.0}, images, {X: 0.1, Y: 0.0})
    found = cd.bifurcation_diagram(shed, {"m": [-0.01, 0.01, 0.03]}, follow="forward", transient=100, periods=128)
    assert words(found) == ["periodic", "quasiperiodic", "quasiperiodic"]


def test_a_followed_rest_is_left_where_it_is_unstable(van_der_pol):
    values = {"m": [-0.2, -0.1, 0.01, 0.02, 0.1]}
    for lengths in ({"transient": 50, "periods": 64}, {"transient": 200.0, "duration": 400.0}):
        system = van_der_pol.with_initial(x=0.5)
        found = cd.bifurcation_diagram(system, values, follow="forward", at="v > 0", **lengths)
        assert words(found) == ["equilibrium"] * 2 + ["periodic"] * 3


def test_a_followed_pendulum_swings_upward_and_downward():
    """x'' + x'/10 + (1 + a cos 2t) sin x = 0 swings once in two periods for a > 0.2."""
    pendulum = flow(
        "x v", {"x": "v", "v": "-v/10 - (1 + a*cos(2*t))*sin(x)"}, {"x": 0.3}, parameters={"a": 0.1}, period="pi"
    )
    found = cd.bifurcation_diagram(pendulum, {"a": [0.18, 0.24, 0.26]}, follow="both", transient=100, periods=64)
    np.testing.assert_array_equal(found["period"].values, [[1, 1], [2, 2], [2, 2]])
    assert set(words(found)) == {"periodic"}


def test_laminar_phases_are_no_torus_and_no_cycle(logistic):
    """Below r = 1 + sqrt(8) there is intermittent chaos alone, of phases as long as 4,000 iterates at 1e-7."""
    r = 1 + np.sqrt(8) - 10 ** -np.linspace(5, 8, 25)
    for lengths in ({"transient": 500, "periods": 256}, {"transient": 100, "periods": 1024, "max_extension": 0}):
        found = cd.bifurcation_diagram(logistic, {"r": r}, **lengths)
        assert set(words(found)) <= {"chaotic", "undecided", "transient"}
        assert (found["period"].values == 0).all()


def test_an_adding_machine_is_no_torus(logistic):
    found = cd.bifurcation_diagram(logistic, {"r": [3.5699456718709]}, transient=5000, periods=256)
    assert words(found) == ["undecided"]
    assert words(cd.lyapunov_spectrum(logistic.with_parameters(r=3.5699456718709), periods=3000)) == ["undecided"]


def test_a_state_that_is_round_off_does_not_grow():
    """Two rotators, the first of which turns whole times in a period."""

    def rotator(x, y, w):
        return {x: f"{x}*(1 - {x}**2 - {y}**2) - {w}*{y}", y: f"{y}*(1 - {x}**2 - {y}**2) + {w}*{x}"}

    field = rotator("a", "b", "w") | rotator("c", "d", "sqrt(2)")
    two = flow("a b c d", field, {"a": 1.0, "c": 0.5}, period="2*pi", parameters={"w": 1.0})
    assert words(cd.bifurcation_diagram(two, {"w": [1, 2, 3]}, transient=50, periods=256)) == 3 * ["quasiperiodic"]
    for rate in (1, 2, 3):
        one = two.with_parameters(w=rate)
        assert words(cd.lyapunov_spectrum(one, periods=2000, transient=50)) == ["quasiperiodic"], rate


@pytest.mark.parametrize(
    ("states", "field", "start"),
    [
        ("x", {"x": "x"}, {"x": 1e-3}),
        ("x", {"x": "x**2"}, {"x": 0.05}),
        ("x y", {"x": "x", "y": "-2*y"}, {"x": 1e-3, "y": 1.0}),
        ("x y", {"x": "x", "y": "y/2"}, {"x": 1e-3, "y": 1.0}),
        ("x y z", {"x": "x", "y": "y/2", "z": "z/3"}, {"x": 1e-3, "y": 1.0, "z": 1.0}),
        ("x v", {"x": "v", "v": "sin(x)"}, {"x": 1e-9}),
    ],
)
def test_what_leaves_every_bound_is_on_no_attractor(states, field, start):
    found = cd.lyapunov_spectrum(flow(states, field, start), duration=18.0)
    assert words(found)[0] in {"transient", "open"}


@pytest.mark.parametrize("duration", [50.0, 200.0, 2000.0])
def test_a_focus_is_no_cycle(duration):
    focus = flow("x v", {"x": "v", "v": "1 - x - 3*v/10"}, {"x": 1.5})
    assert words(cd.lyapunov_spectrum(focus, duration=duration))[0] in {"transient", "equilibrium"}


def test_growth_that_goes_on_evenly_is_seen_however_little():
    """Straight lines, what comes and goes as on a torus, and shear beside the tangent that shrinks as it grows."""
    t = np.linspace(0, 1, 33)
    courses = np.stack([t / 10, -2 * t, 0 * t, np.sin(40 * t) + t / 10, np.log1p(20 * t)])
    assert steady(courses).tolist() == [True, True, False, False, False]


@pytest.mark.parametrize("slope", [1 - 2e-4, 1 + 2e-4])
def test_a_wheel_that_is_no_rotation_is_on_no_torus(slope):
    """With slopes below one every motion comes to a cycle; with slopes above one there is only chaos."""
    wheel = cd.Map("x", {"b": slope, "c": GOLDEN}, ["Mod(b*x + c, 1)"], name="wheel", initial={"x": 0.2})
    right = "periodic" if slope < 1 else "chaotic"
    assert set(words(cd.lyapunov_spectrum(wheel, periods=1024, transient=200))) <= {"undecided", "transient", right}
    at = {"b": [slope]}
    diagram = cd.bifurcation_diagram(wheel, at, periods=1024, transient=200, max_extension=0)
    assert set(words(diagram)) <= {"undecided", "transient", right}
    turning = cd.lyapunov_spectrum(wheel.with_parameters(b=1.0), periods=1024, transient=200)
    assert words(turning) == ["quasiperiodic"]


def test_a_slow_focus_of_a_map_is_no_torus():
    """Multipliers of modulus 1 - 1e-7: it fades by 1e-4 in the record. At 1 it goes round on its circle."""
    turn = {X: "a*(cos(r)*x - sin(r)*y)", Y: "a*(sin(r)*x + cos(r)*y)"}
    focus = clocked("focus", (X, Y), {"a": 1 - 1e-7, "r": 0.7}, turn, {X: 1.0, Y: 0.0})
    assert words(cd.lyapunov_spectrum(focus, periods=1024))[0] in {"undecided", "transient", "periodic"}
    assert words(cd.lyapunov_spectrum(focus.with_parameters(a=1.0), periods=1024)) == ["quasiperiodic"]


def test_a_curve_within_the_tolerance_is_a_torus():
    """A circle of 1e-6 around a fixed point of size 1: all of its points come back to five digits."""
    turn = {"x": "1 + cos(r)*(x - 1) - sin(r)*(y - 1)", "y": "1 + sin(r)*(x - 1) + cos(r)*(y - 1)"}
    circle = cd.Map("x y", {"r": 0.7}, turn, initial={"x": 1 + 1e-6, "y": 1.0})
    assert words(cd.lyapunov_spectrum(circle, periods=1024, transient=0)) == ["quasiperiodic"]


@pytest.mark.parametrize(("start", "word"), [(0.3, "quasiperiodic"), (1.0, "periodic")])
def test_a_torus_needs_no_area_that_shrinks(start, word):
    """An oscillator without damping beside its forcing; the exponents sum to zero but for round-off."""
    field = {"x": "v", "v": "cos(t) - 2*x"}
    free = flow("x v", field, {"x": start, "v": 0.0}, period="2*pi")
    assert words(cd.lyapunov_spectrum(free, periods=512)) == [word]


@pytest.mark.parametrize(
    ("field", "duration", "right"),
    [
        ({"x": "v", "v": "-x - 2e-7*v"}, 300.0, {"undecided", "transient"}),
        ({"x": "v", "v": "-x"}, 300.0, {"periodic"}),
        ({"x": "y", "y": "-x - y*z", "z": "y**2 - 1"}, 1000.0, {"undecided", "quasiperiodic"}),
    ],
    ids=["fades", "goes round", "thin torus"],
)
def test_only_what_lies_closely_on_a_curve_is_a_neutral_cycle(field, duration, right):
    """An oscillator whose amplitude falls by 3e-5, and Nose and Hoover's torus around (0, 1.55), 1e-3 of its size."""
    start = {"x": 1.0} if len(field) == 2 else {"y": 1.55}
    found = cd.lyapunov_spectrum(flow(" ".join(field), field, start), duration=duration)
    assert words(found)[0] in right


def test_instants_a_turn_apart_are_strobes_of_a_torus():
    """2,048 instants in 4,096 pi: the first of two angles does not move from one to the next."""

    def circle(x, y, w):
        return {x: f"{x}*(1 - {x}**2 - {y}**2) - {w}*{y}", y: f"{y}*(1 - {x}**2 - {y}**2) + {w}*{x}"}

    two = flow("a b c d", circle("a", "b", 1) | circle("c", "d", "sqrt(2)"), {"a": 1.0, "c": 1.0})
    for instants in (2048, 4096):
        found = cd.lyapunov_spectrum(two, duration=np.pi * instants, transient=20.0)
        assert words(found)[0] in {"quasiperiodic", "undecided"}


def test_an_arc_and_a_slow_place_are_not_open():
    """An angle on its way up to a turning point, a narrow passage, and states that grow by laws without an end."""
    time = np.linspace(0.0, 1.0, 257)[:, np.newaxis]
    arcs = [np.sin(begin + 0.3 * time) for begin in np.linspace(-0.6, 0.1, 8)]
    passages = [np.tan(begin + time) for begin in np.linspace(-0.7, -0.3, 5)]
    grow = [2 + time, (1 + time) ** 1.5, (1 + time) ** 3, 5 - 2 * time**0 - 9 * time]
    found = [
        only_grows(path[np.newaxis], np.abs(path).max(axis=0)[np.newaxis]).item() for path in arcs + passages + grow
    ]
    assert found == [False] * (len(arcs) + len(passages)) + [True] * len(grow)


def test_arcs_of_a_slow_angle_are_not_open():
    """A circle in coordinates in which it is passed at an uneven pace, of which 0.01 to 0.3 turns are seen."""
    rng, k = np.random.default_rng(32), np.arange(256) / 256
    turns, begin, bent, phase = (rng.uniform(*ends, (300, 1)) for ends in ((0.01, 0.3), (0, 1), (0, 0.9), (0, 6)))
    angle = 2 * np.pi * (begin + turns * k)
    angle += bent * np.sin(angle + phase)
    paths = np.stack([np.cos(angle), np.sin(angle)], axis=2) * 10 ** rng.uniform(-9, 9, (300, 1, 2))
    assert only_grows(paths, np.abs(paths).max(axis=1)).any(axis=1).sum() <= 1


@pytest.mark.parametrize("base", [2, 3])
def test_only_a_torus_is_known_where_it_was_not_looked_at(base):
    """Points of van der Corput's sequence leave no gaps, and follow from no frequency."""
    digits = np.arange(2048)[:, np.newaxis] // base ** np.arange(12) % base
    points = digits @ (1.0 / base ** np.arange(1, 13))
    assert not predicted(np.column_stack([points, np.tanh(points)]))
    angles = 2 * np.pi * np.outer(np.arange(2048), [np.sqrt(2), np.sqrt(3)])
    assert predicted(np.cos(angles) + np.cos(angles[:, ::-1]) / 2)
    # an adding machine that shrinks fast has few frequencies, and comes back late
    counts = np.arange(8192)[:, np.newaxis] // 5 ** np.arange(6) % 5
    machine = 0.176 * counts @ 0.295 ** np.arange(6)
    assert not predicted(np.column_stack([machine, np.tanh(machine)]))
    # a phase that runs ever faster has no frequency
    assert not predicted(np.cos(1e-4 * np.arange(2048.0) ** 2)[:, np.newaxis])


def test_a_function_of_one_angle_that_is_no_curve_is_no_torus():
    """Keller's pinched maps (1996): their lines are as sharp as those of a torus, but no polynomial of angles fits."""
    angle, x, points = 0.3, 1.0, []
    for _ in range(3048):
        x, angle = 4 * abs(np.cos(np.pi * angle)) * np.tanh(x), (angle + np.sqrt(2) - 1) % 1
        points.append((x, np.cos(2 * np.pi * angle), np.sin(2 * np.pi * angle)))
    assert not predicted(np.array(points[1000:]))


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("points", [256, 1024])
def test_tori_of_two_and_three_angles_need_few_points(count, points):
    """Averages over a thousand points agree to two digits at best, as slow beats do; a polynomial tells them all.

    A cycle of 300 points in any order, and a beat that does not come round in the record, are told by none.
    """
    turns = np.array([np.sqrt(2), np.sqrt(3), np.sqrt(5)])[:count] / 4
    angle = 2 * np.pi * np.outer(np.arange(points), turns)
    path = np.stack([np.cos(angle).sum(axis=1), np.sin(angle + 0.2 * np.sin(angle)).sum(axis=1)], axis=1)
    path[:, 0] += 0.2 * np.tanh(path[:, 1])
    assert predicted(path / np.ptp(path, axis=0)) == (points == 1024 or count == 2)
    cycle = np.random.default_rng(3).random((points // 3, 2))[np.arange(points) % (points // 3)]
    assert not predicted(cycle)
    beat = np.cos(angle[:, 0]) + np.cos(angle[:, 0] * (1 + 0.5 / points))
    assert not predicted(beat[:, np.newaxis])


def test_what_has_been_as_far_away_before_does_not_leave():
    """A motion whose extent swings: it grows in the last 512 points, and did so before; and a growth that is the first.

    Seen at every 64th point, a rotation by nearly as many turns seems to move slowly.
    """
    k, turn = np.arange(2048), np.array([1.0])
    swings = ((1.5 - np.cos(2 * np.pi * k / 1024)) * np.cos(k))[np.newaxis, :, np.newaxis]
    for states, leaves, settles in ((swings, False, False), (swings[:, ::-1], False, False)):
        part, before = states[:, 1024:1536], states[:, :1024]
        assert any(one.item() for one in stationarity(part, turn[np.newaxis] * 3))
        found = stationarity(part, turn[np.newaxis] * 3, before=before)
        assert (found[0].item(), found[1].item()) == (leaves, settles)
    grows = (np.exp(k / 400) * np.cos(k))[np.newaxis, :, np.newaxis]
    for states, which in ((grows, 0), (grows[:, ::-1], 1)):
        assert stationarity(states[:, 1024:], np.abs(states).max(axis=1), before=states[:, :1024])[which].item()
    angle = 2 * np.pi * np.arange(4096) * (3 + 1 / 500) / 64
    path = np.stack([np.cos(angle), np.cos(np.sqrt(2) * angle)], axis=-1)[np.newaxis]
    assert shows(path[:, ::64], path[:, -2048:], 4096).tolist() == [[False, True]]


@pytest.mark.parametrize(("tail", "word"), [(-0.2, "periodic"), (0.0, "undecided"), (0.1, "transient")])
def test_chaos_that_has_fallen_to_a_cycle_is_on_it(tail, word):
    """In the last sixth of a record; a stay at an unstable or a neutral cycle is none of it."""
    rng = np.random.default_rng(8)
    path, grown = rng.random((1, 1200, 2)), np.full(1200, 0.5)
    path[:, 1000:], path[:, :, 1], grown[1000:] = 0.7, 0.0, tail
    course = np.append(0.0, np.cumsum(grown.reshape(24, 50).sum(axis=1)))[np.newaxis, :, np.newaxis]
    lead = np.array([grown.mean()])
    one = np.full((1, 1), 0.02)
    averages = Averages(lead[:, None], one, one, course, np.array([1200.0]), np.zeros(1), np.zeros(1, int), False)
    e = Evidence.of(1, lead=lead, margin=np.array([0.9]), late=np.array([0.1]), length=np.array([1200.0]))
    add_ends(e, averages, path, np.ones((1, 1)), 1.0)
    assert e.stopped.all()
    assert (cd.Outcome(int(words_of(e)[0])).meaning == word) or (word == "transient" and not e.arrives.any())


@pytest.mark.parametrize(("growth", "word"), [(0.0, "undecided"), (1e-5, "quasiperiodic")])
def test_a_part_of_an_exchange_of_intervals_is_no_torus(growth, word):
    """In 1,024 steps four of them in reversed order turn two curves that are cut; what else does so moves tangents."""
    lengths = np.array([0.341, 0.1554, 0.4684, 0.0352])
    begins, places = np.cumsum(lengths) - lengths, 1 - np.cumsum(lengths)
    path = np.full(1025, 0.65)
    for k in range(1024):
        one = np.searchsorted(begins, path[k], side="right") - 1
        path[k + 1] = path[k] + places[one] - begins[one]
    windows = np.stack([path[1:], path[:-1], np.zeros(1024)], axis=1)[np.newaxis]
    # at events, after a quarter on the way
    way = [9.0, 5.0, 0.0] + np.random.default_rng(1).random((1, 341, 3)) * [1.0, 1.0, 0.0]
    for add, record in ((add_regularity, windows), (add_passages, np.concatenate([way, windows], axis=1))):
        known = {"lead": np.array([growth]), "length": np.array([1024.0]), "drawn_in": np.array([True])}
        found = Evidence.of(1, margin=np.ones(1), **known)
        add(found, np.array([0]), record, np.ones((1, 2)), Shifts.none(2))
        assert cd.Outcome(int(words_of(found)[0])).meaning == word


@pytest.mark.parametrize("off", [0.0, 1e-7])
def test_what_comes_back_as_near_as_always_is_no_cycle(off):
    """An adding machine of base 4 has parts of 2e-7 after 64 points; a cycle of 64 is approached, or left out."""
    digits = np.arange(1024)[:, np.newaxis] // 4 ** np.arange(8, dtype=np.int64) % 4
    machine = digits @ (0.3 * 5e-3 ** np.arange(8))
    cycle = machine[np.arange(1024) % 64] + off * np.exp(-np.arange(1024) / 100)
    windows = np.stack([[machine, cycle], np.zeros((2, 1024))], axis=-1)
    found = examine(windows, np.abs(windows[:, :, :1]).max(axis=1), Shifts.none(1), 1e-12)
    assert found.long_cycle.tolist() == [False, True]


def test_chaos_that_ends_is_not_chaotic():
    rng = np.random.default_rng(8)
    path = np.zeros((2, 1024, 2))
    path[:, :, 0] = rng.random((2, 1024))
    path[0, 980:, 0] = 0.7
    ends = stopped(path, np.ones((2, 1)))
    assert ends.tolist() == [True, False]
    known = {"lead": np.full(2, 0.6), "late": np.full(2, 0.5), "margin": np.full(2, 0.1), "length": np.full(2, 1024.0)}
    assert [cd.Outcome(int(one)).meaning for one in words_of(Evidence.of(2, stopped=ends, **known))] == [
        "transient",
        "chaotic",
    ]


@pytest.mark.parametrize(
    ("early", "drawn_in", "word"),
    [(0.0, False, "undecided"), (30.0, False, "quasiperiodic"), (0.0, True, "quasiperiodic")],
)
def test_a_torus_is_reached_by_growth_or_decay(early, drawn_in, word):
    """An exchange of intervals follows one angle for a while, and then another one; no tangent changes meanwhile."""
    known = {"lead": np.array([early / 1000]), "length": np.array([1000.0]), "torus_reached": np.array([True])}
    found = Evidence.of(1, margin=np.ones(1), drawn_in=np.array([drawn_in]), **known)
    assert cd.Outcome(int(words_of(found)[0])).meaning == word


def test_no_word_needs_a_torus_that_is_not_asked_for():
    """Of records whose tangents grow too far it is not asked whether their points are those of a torus."""
    rng, count = np.random.default_rng(5), 20_000
    numbers = {
        name: rng.choice([-1, 1], count) * 10 ** rng.uniform(-5, 0, count) for name in ("lead", "late", "quarter")
    }
    given = numbers | {"margin": 10 ** rng.uniform(-5, 0, count), "length": np.full(count, 1000.0)}
    names = [one.name for one in fields(Evidence) if one.name not in (*given, "ended")]
    given |= {name: rng.random(count) < (0.9 if name in ("measured", "flows") else 0.2) for name in names}
    found = Evidence.of(count, **given)
    asked, reached = found.may_be_torus, found.may_have_reached_torus
    torus = found.torus & asked & (found.settled | found.converges)
    some = {"torus": torus, "ordered": found.ordered & asked, "returns": found.returns & asked}
    less = replace(found, **some, torus_reached=found.torus_reached & reached)
    np.testing.assert_array_equal(words_of(less), words_of(found))
    assert len(np.unique(words_of(found))) >= 8


@pytest.mark.parametrize("rate", [2.1e-3, 3.2e-3, 8e-3])
def test_narrow_bands_are_no_cycle(rate):
    """A tent of slope exp(rate) is chaotic on bands narrower than 1e-6, with this exponent."""
    tent = clocked("tent", (X,), {"a": np.exp(rate)}, {X: "1 - a*Abs(x)"}, {X: 0.31})
    assert words(cd.lyapunov_spectrum(tent, periods=64, transient=2000))[0] in {"undecided", "transient", "chaotic"}


def test_the_documentation_has_all_rules():
    theory = (Path(__file__).parents[2] / "docs" / "theory.md").read_text()
    rows = "\n".join(f"| `{rule.word.meaning}` | {rule.reason} |" for rule in RULES)
    assert rows in theory


@pytest.mark.parametrize(
    ("lead", "late", "more", "word"),
    [
        (0.4, 0.3, {}, "chaotic"),
        (0.4, 0.3, {"leaving": True}, "transient"),
        (0.4, 0.77, {}, "undecided"),
        (0.06, 0.06, {}, "undecided"),
        (0.4, 0.3, {"chaos_possible": False}, "undecided"),
        (0.4, 0.3, {"margin": 1.3}, "undecided"),
    ],
)
def test_growth_beyond_all_digits_in_both_halves_is_chaos(lead, late, more, word):
    """Where it is beyond its error: from round-off to its size a departure has 36.7, and none in one half."""
    known = {name: np.array([value]) for name, value in {"lead": lead, "late": late, "margin": 0.9, **more}.items()}
    assert cd.Outcome(int(words_of(Evidence.of(1, length=np.array([1000.0]), **known))[0])).meaning == word


def test_a_larger_error_makes_no_word_easier():
    """From a margin on nothing but what is open is left, unless other evidence stands by itself."""
    rng = np.random.default_rng(4)
    count = 4000
    flags = ("recurs", "attracts", "leaving", "settling", "drifts", "torus", "converges", "curve", "long_cycle")
    known = {name: rng.random(count) < 0.3 for name in flags}
    lead = rng.normal(size=count) * 10 ** rng.uniform(-4, 0, count)
    length, late = np.full(count, 1000.0), lead * rng.uniform(0, 2, count)
    small, large = (
        words_of(Evidence.of(count, lead=lead, late=late, length=length, margin=np.full(count, margin), **known))
        for margin in (4e-3, 3e-2)
    )
    claims = (cd.Outcome.CHAOTIC, cd.Outcome.PERIODIC)
    for word in claims:
        gained = (large == word) & (small != word)
        # a return that contracts, and instants on a curve, say so whatever the exponent's error
        assert not (gained & ~(known["recurs"] | known["long_cycle"] | known["curve"])).any()
    torus = (large == cd.Outcome.QUASIPERIODIC) & (small != cd.Outcome.QUASIPERIODIC)
    assert (np.abs(lead[torus]) * 1000 <= BOUNDED).all()


@pytest.mark.parametrize("periods", [64, 256])
@pytest.mark.parametrize("states", [("x", "v"), ("v", "x")])
def test_chaos_is_one_attractor_for_any_record(periods, states):
    """Duffing's oscillator has one attractor here, whose two wells a short record visits unevenly."""
    duffing = cd.build("duffing")
    grid = {state: np.linspace(-2, 2, 12) for state in states}
    found = cd.basins(duffing, grid, transient=100, periods=periods)
    assert found.sizes["attractor_number"] == 1
    np.testing.assert_array_equal(found["fraction"], [1.0])


def test_where_no_torus_and_no_chaos_are_possible(duffing, logistic):
    """A map of the plane that shrinks all areas alike keeps no closed curve."""
    forced = {"x": "v", "v": "m*(1 - x**2)*v - x + cos(t)"}
    growing = flow("x v", forced, {"x": 1.0}, parameters={"m": 1.0}, period="2*pi", time="t")
    assert contracts(duffing)
    assert not contracts(growing)
    assert not contracts(logistic)
    torus = np.ones(2, dtype=bool)
    given = Evidence.of(2, torus=torus, converges=torus, torus_possible=np.array([True, False]))
    assert words_of(given).tolist() == [cd.Outcome.QUASIPERIODIC, cd.Outcome.UNDECIDED]
    grown = {"lead": np.ones(2), "late": np.ones(2), "length": np.full(2, 100.0)}
    given = Evidence.of(2, **grown, chaos_possible=np.array([True, False]))
    assert words_of(given).tolist() == [cd.Outcome.CHAOTIC, cd.Outcome.TRANSIENT]


def test_a_torus_may_go_round_through_modes_that_overlap():
    """A heater that a thermostat switches has a cycle of its own, and shrinks areas alike in both modes."""
    room = {"x": "-0.4*(x - 10 - a*cos(0.7*t)) + 0.8*(h - x)"}
    on, off = {**room, "h": "12 - 0.8*(h - x)"}, {**room, "h": "-0.8*(h - x)"}
    switches = [cd.Transition("off", "on", "off", "x - 20", +1), cd.Transition("on", "off", "on", "x - 18", -1)]
    heated = cd.HybridSystem(
        states="x h", parameters={"a": 0.0}, modes={"on": on, "off": off}, transitions=switches, period="2*pi/0.7"
    ).with_initial(x=15.0, h=16.0)
    # without the drive, which is strobed all the same, the cycle's period and that of the strobe have no common measure
    assert words(cd.lyapunov_spectrum(heated, transient=100, periods=512)) == ["quasiperiodic"]


@pytest.mark.parametrize(
    ("force", "shrinks"),
    [("-k*Max(x - 1, 0)", True), ("-k*sign(x)", True), ("-k*Max(v - 1, 0)", False), ("k*sign(v)", False)],
)
def test_areas_shrink_alike_where_events_keep_them(force, shrinks):
    """A spring may have a kink or a jump; a damper that has one shrinks areas here more than there, or at events."""
    field = {"x": "v", "v": f"cos(t) - x - v/10 + ({force})"}
    assert contracts(cd.in_modes(states="x v", parameters={"k": 2.0}, field=field, period="2*pi")) == shrinks


def test_a_torus_about_a_region_of_negative_damping():
    """Van der Pol's oscillator in pieces: damping constant in each, and in all more than none along its cycle."""
    inner, outer = ({"x": "v", "v": f"a*cos(t) - 2*x + {damping}*v"} for damping in (0.6, -1.5))
    across = [("inner", "right", "x - 1"), ("inner", "left", "-1 - x")]
    ways = [(f"to {b}", a, b, guard, +1) for a, b, guard in across] + [(f"from {b}", b, a, g, -1) for a, b, g in across]
    system = cd.HybridSystem(
        states="x v",
        parameters={"a": 0.05},
        modes={"inner": inner, "right": outer, "left": outer},
        transitions=[cd.Transition(*way) for way in ways],
        period="2*pi",
        initial={"x": 0.5},
    )
    spectrum = cd.lyapunov_spectrum(system, transient=100, periods=1000)
    assert float(spectrum["lyapunov_exponent"].sum()) < -0.01
    assert words(spectrum) == ["quasiperiodic"]


@pytest.mark.parametrize(("states", "load", "word"), [("x v", 1.5, "quasiperiodic"), ("v x", 0.5, "periodic")])
def test_a_torus_may_go_round_with_an_angle_where_areas_shrink(states, load, word):
    """A driven pendulum that the load turns over, at a mean rate that the drive does not lock, or not."""
    field = {"x": "v", "v": f"{load} + 3*cos(t)/10 - sin(x) - v"}
    pendulum = flow(states, field, {"x": 0.3, "v": 0.1}, period="2*pi")
    assert words(cd.lyapunov_spectrum(pendulum, periods=512)) == [word]


@pytest.mark.parametrize("units", [(1.0, 1.0), (1e-9, 1e9), (3e7, 2e-8)])
@pytest.mark.parametrize("order", [[0, 1, 2], [1, 0, 2]])
def test_what_turns_or_alternates_is_no_channel_in_any_units_and_order(units, order):
    """Motions that come closer by 1e-4 a step, turning by half a radian or from side to side, and one that goes by."""
    k = np.arange(200)
    closer, zero = 1e-7 * np.exp(-1e-4 * k), 0.0 * k
    ways = [(closer * np.cos(k / 2), closer * np.sin(k / 2)), (closer * (-1.0) ** k, closer), (1e-9 * k, zero)]
    paths = np.stack([np.stack([1 + one, 2 + other, zero], axis=1) for one, other in ways])
    paths[:, :, :2] *= units
    paths, known = paths[:, :, order], np.abs(paths[:, :, order[:2]]).max(axis=1)
    found = recurrence(paths, known, 8)
    closes = is_no_channel(found, np.full(3, -1e-4), paths, known, found.period)
    assert closes.tolist() == [True, True, False]


@pytest.mark.parametrize("transient", [0, 100])
def test_shear_after_a_transient_is_no_growth(transient):
    """Tangents grow like the time since their start, so evenly in a later record; all motions come back (Volterra)."""
    prey = flow("x y", {"x": "x*(a - y)", "y": "y*(x - 1)"}, {"x": 1.8, "y": 1.0}, parameters={"a": 0.5})
    found = cd.bifurcation_diagram(prey, {"a": [0.5, 2.0, 5.0]}, periods=64, transient=transient, at="x > 1.1")
    assert words(found) == ["periodic"] * 3

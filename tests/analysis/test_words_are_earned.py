"""What a motion is called: tori, cycles, centres and runs to infinity whose nature is known in closed form."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.base import Points
from chaosdrill.analysis.grids.judging import judge
from chaosdrill.analysis.grids.plan import make_plan
from chaosdrill.analysis.judgement.tori import examine, only_grows
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.shifts import Shifts

A, B, C, D, R, TH, PH, W = sympy.symbols("a b c d r th ph w", real=True)
ROOT = float(np.sqrt(2))


def words(found):
    return [cd.Outcome(int(code)).meaning for code in np.ravel(found["outcome"].values)]


def polar(order):
    """A torus whose angles are states that only grow."""
    field = {R: R * (1 - R**2), TH: 1, PH: W}
    start = {R: 0.5, TH: 0.0, PH: 0.0}
    return cd.HybridSystem(name="polar", states=order, parameters={"w": ROOT}, modes={"on": field}, initial=start)


@pytest.fixture(scope="module")
def tori():
    """The same torus in polar coordinates, its states in two orders, and in Cartesian ones."""
    pull, push = 1 - A**2 - B**2, 1 - C**2 - D**2
    field = {A: A * pull - B, B: B * pull + A, C: C * push - W * D, D: D * push + W * C}
    cartesian = cd.HybridSystem(
        name="cartesian",
        states=(A, B, C, D),
        parameters={"w": ROOT},
        modes={"on": field},
        initial={A: 0.5, B: 0.0, C: 0.2, D: 0.1},
    )
    return polar((R, TH, PH)), polar((PH, TH, R)), cartesian


@pytest.mark.parametrize(("rate", "count"), [(ROOT, 1), (ROOT, 2), ((np.sqrt(5) - 1) / 2, None)])
def test_a_torus_in_any_coordinates(tori, rate, count):
    for torus in tori:
        found = cd.lyapunov_spectrum(torus.with_parameters(w=rate), duration=300, transient=30, exponents=count)
        assert words(found) == ["quasiperiodic"]
        np.testing.assert_allclose(found["lyapunov_exponent"].values[:2], 0, atol=1e-12)


@pytest.mark.parametrize("rate", [1.0, 1.5, 0.4])
def test_phases_with_a_common_measure_are_a_cycle(tori, rate):
    for torus in tori:
        assert words(cd.lyapunov_spectrum(torus.with_parameters(w=rate), duration=300, transient=30)) == ["periodic"]


def test_the_flow_along_a_shift_is_counted_once():
    """A limit cycle in polar coordinates whose radius decays as slowly as it likes has one exponent that is zero."""
    slow = cd.HybridSystem(
        name="slow",
        states=(R, TH),
        parameters={"w": 0.05},
        modes={"on": {R: W * (1 - R), TH: 1}},
        initial={R: 1.0, TH: 0.0},
    )
    found = cd.lyapunov_spectrum(slow, duration=400)
    np.testing.assert_allclose(found["lyapunov_exponent"].values, [0, -0.05], atol=1e-12)
    assert words(found) == ["periodic"]
    # a run that sits exactly on an unstable cycle is no chaos, though its exponent is positive
    unstable = cd.lyapunov_spectrum(slow.with_parameters(w=-0.05), duration=400)
    np.testing.assert_allclose(unstable["lyapunov_exponent"].values, [0.05, 0], atol=1e-12)
    assert words(unstable) == ["periodic"]


def test_a_run_on_an_unstable_cycle_is_no_chaos(logistic):
    """The fixed point 3/4 of the logistic map at r = 4 has the multiplier -2, and chaos beside it the exponent ln 2."""
    for start, word in ((1 - 1 / 4, "periodic"), (0.3, "chaotic")):
        found = cd.lyapunov_spectrum(logistic.with_parameters(r=4.0).with_initial(x=start), periods=1000)
        assert words(found) == [word]
        assert float(found["lyapunov_exponent"][0]) == pytest.approx(np.log(2), abs=0.05)


@pytest.mark.parametrize(("pull", "word"), [(0.5, "periodic"), (2e-3, "undecided"), (0.0, "periodic")])
def test_the_way_to_a_cycle_is_no_torus(pull, word):
    """Exponents 0 and -2 w: a cycle, the slow way to one over a record too short for its exponent, and a centre."""
    inward = W * (1 - A**2 - B**2)
    spiral = cd.HybridSystem(
        name="spiral",
        states=(A, B),
        parameters={"w": 0.5},
        modes={"on": {A: inward * A - B, B: inward * B + A}},
        initial={A: 0.9, B: 0.0},
    )
    assert words(cd.lyapunov_spectrum(spiral.with_parameters(w=pull), duration=400)) == [word]


@pytest.mark.parametrize(("periods", "word"), [(200, "undecided"), (2000, "quasiperiodic")])
def test_a_torus_needs_a_record(delayed_logistic, periods, word):
    assert words(cd.lyapunov_spectrum(delayed_logistic, periods=periods, transient=500)) == [word]


@pytest.fixture(scope="module")
def neuron():
    """Spikes at v = 30 of v' = v**2/25 + 5 v + 140 - u + I, each of which takes 0.1 from u for ever."""
    v, u, current = sympy.symbols("v u I", real=True)
    rate = v**2 / 25 + 5 * v + 140 - u + current
    return cd.HybridSystem(
        name="neuron",
        states=(v, u),
        parameters={"I": 10.0},
        modes={"on": {v: rate, u: 0}},
        transitions=[cd.Transition("spike", "on", "on", guard=v - 30, direction=+1, reset={v: -65, u: u - 0.1})],
        period=sympy.Integer(10),
        initial={v: -65.0, u: -13.0},
    )


@pytest.mark.parametrize(("max_extension", "at"), [(0, "spike"), (8, "strobe")])
def test_a_run_that_only_grows_is_open(neuron, max_extension, at):
    found = cd.bifurcation_diagram(
        neuron, {"I": [5.0, 10.0]}, transient=50, periods=64, max_extension=max_extension, at=at
    )
    assert words(found) == ["open", "open"]
    assert np.isfinite(found["lyapunov_exponent"].values).all()
    grid = {"v": [-65.0, -60.0], "u": [-13.0, -12.0]}
    basins = cd.basins(neuron, grid, transient=50, periods=64, max_extension=max_extension, at=at)
    assert set(words(basins)) == {"open"}
    assert not basins["attractor"].values.any()


def test_a_spectrum_of_a_run_that_only_grows_is_open(neuron):
    assert words(cd.lyapunov_spectrum(neuron, periods=400, transient=50)) == ["open"]


def test_exponents_that_are_no_numbers_have_an_outcome(circle):
    given = Points(transient=0, periods=20, max_period=4, max_extension=0)
    plan = make_plan(circle, given, Numerics(), swept=("growth",))
    values = {"growth": np.array([-0.1, 0.1])}
    batch = plan.batch(values, np.tile([1.0, 0.0], (2, 1)), np.zeros(2, dtype=int))
    batch.run(0, plan.ends)
    batch.sums[0] = np.nan
    verdict = judge(plan, batch, np.arange(2), plan.ends)
    assert verdict.outcome.tolist() == [cd.Outcome.NONFINITE, cd.Outcome.UNDECIDED]
    assert verdict.decided.tolist() == [True, False]


K = np.arange(512.0)


@pytest.mark.parametrize(
    ("path", "grows"),
    [
        (0.1 * K, True),
        (-3 - K**2, True),
        (K + 2 * np.sin(K), True),
        (1e5 + K, False),
        (np.sqrt(K + 500), False),
        (1 / np.sqrt(K + 500), False),
        (1 - 0.99**K, False),
        (np.cos(np.pi * K / 512), False),
        (np.sin(K), False),
        (np.cumsum(np.random.default_rng(3).normal(size=512)), False),
    ],
)
@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e6])
def test_what_grows_and_what_only_seems_to(path, grows, unit):
    seen = unit * path[np.newaxis, :, np.newaxis]
    assert only_grows(seen, np.abs(seen).max(axis=1))[0, 0] == grows


def test_what_section_points_tell():
    """A torus, a cycle of a hundred points, a transient that dies out turning, and a cloud."""
    k = np.arange(2048)
    golden = np.pi * (np.sqrt(5) - 1)
    x = np.empty(2048)
    x[0] = 0.3
    for i in range(2047):
        x[i + 1] = 3.7 * x[i] * (1 - x[i])
    fades = (1 - 2e-6) ** k
    paths = [np.cos(golden * k), np.cos(2 * np.pi * k / 100), fades * np.cos(np.pi * k), x]
    windows = np.stack([np.stack([path, np.roll(path, 1), 0 * path], axis=1) for path in paths])[:, 1:]
    for units in ([1.0, 1.0], [1e-9, 1e6]):
        found = examine(windows * np.array([*units, 1.0]), np.tile(units, (4, 1)), Shifts.none(2), 1e-12)
        assert found.torus.tolist() == [True, False, False, False]
        assert found.long_cycle.tolist() == [False, True, False, False]


@pytest.fixture(scope="module")
def turning():
    """A third of a turn a period; the path of the angle's cosine has no mean, and there is an impact a turn."""
    x, y, counted = sympy.symbols("x y counted", real=True)
    angle = 2 * sympy.pi / 3
    lap = cd.Transition("lap", "on", "on", guard=y, direction=+1, reset={counted: 0}, kind="impact")
    return cd.HybridSystem(
        name="turning",
        states=(x, y, counted),
        parameters={"w": 1.0},
        modes={"on": {x: -W * angle * y, y: W * angle * x, counted: 0}},
        transitions=[lap],
        period=sympy.Integer(1),
        quadratures={"penetration": x + 1},
        initial={x: 0.8, y: -0.6, counted: 0.0},
    )


@pytest.mark.parametrize("periods", [63, 64, 65])
@pytest.mark.parametrize("at", ["strobe", "lap"])
def test_means_of_a_cycle_are_means_over_whole_cycles(turning, periods, at):
    found = [
        cd.bifurcation_diagram(turning, {"w": [1.0]}, transient=0, periods=periods, at=at),
        cd.poincare_section(turning, periods=periods, at=at),
    ]
    for each in found:
        assert int(np.ravel(each["period"])[0]) == (3 if at == "strobe" else 1)
        assert float(np.ravel(each["impacts_per_period"])[0]) == pytest.approx(1 / 3, rel=1e-13)
        assert float(np.ravel(each["progression_rate"])[0]) == pytest.approx(1.0, rel=1e-11)


def test_means_of_a_cycle_of_an_autonomous_system():
    """The rolling gait of the rimless wheel takes no whole number of any unit of time."""
    wheel = cd.build("rimless-wheel")
    section = cd.poincare_section(wheel, duration=50.0, transient=100, at="step")
    apart = np.diff(section["time"].values)[-1]
    assert float(section["impacts_per_time"]) == pytest.approx(1 / apart, rel=1e-9)


def test_the_drill_of_period_twelve():
    """Rate and impacts per period, 7/6, of its orbit, in records that hold no whole number of cycles."""
    drill = cd.drill(eta=0.6237)
    orbit = cd.periodic_orbit(drill, period=12, transient=400)
    diagram = cd.bifurcation_diagram(drill, {"eta": [0.6237]}, transient=300, periods=128)
    for found in (orbit, diagram, cd.poincare_section(drill, transient=300, periods=128)):
        assert int(np.ravel(found["period"])[0]) == 12
        assert float(np.ravel(found["progression_rate"])[0]) == pytest.approx(0.1491790, abs=5e-8)
        assert float(np.ravel(found["impacts_per_period"])[0]) == pytest.approx(7 / 6, rel=1e-13)


def hopf(names, rate, turn):
    """Hopf's normal form, whose cycle has the radius sqrt(rate)."""
    a, b = names
    pull = f"({rate} - {a}**2 - {b}**2)"
    return {a: f"{a}*{pull} - {turn}*{b}", b: f"{turn}*{a} + {b}*{pull}"}


def test_a_flow_that_left_is_called_by_its_later_half():
    """By then it is on the cycle beside the point that it left, or on the torus of two such."""
    one = cd.HybridSystem(states="x y", modes={"on": hopf("xy", 0.02, 1)}, initial={"x": 1e-9})
    two = cd.HybridSystem(
        states="x y u w",
        modes={"on": hopf("xy", 0.05, 1) | hopf("uw", 0.05, "sqrt(2)")},
        initial={"x": 1e-9, "u": 1e-6},
    )
    assert words(cd.lyapunov_spectrum(one, duration=4000)) == ["periodic"]
    assert words(cd.lyapunov_spectrum(two, duration=4000)) == ["quasiperiodic"]
    # half of it is spent on the way
    assert words(cd.lyapunov_spectrum(one, duration=1500)) == ["transient"]


def test_a_laminar_phase_of_a_flow_is_no_cycle():
    """Just above its window at 166.06 Lorenz's system stays near the cycle that is gone for hundreds of turns."""
    lorenz = cd.build("lorenz").with_parameters(rho=166.063)
    for start, length in ((1.0, 20.0), (3.0, 22.0), (-4.0, 27.0), (7.0, 30.0), (11.0, 39.0), (-13.0, 52.0)):
        found = cd.lyapunov_spectrum(lorenz.with_initial(x=start), duration=length, transient=50)
        assert set(words(found)) <= {"undecided", "transient", "chaotic"}

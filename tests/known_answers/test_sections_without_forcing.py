"""One definition of a system without forcing serves every analysis, over a section that is named; no period is made up.

Truths: an integrate-and-fire cell fires every tau log(R I/(R I - theta)) (Lapicque 1907, translated in
doi:10.1007/s00422-007-0189-6); the rimless wheel's return map om**2 -> cos(2 alpha)**2 (om**2 + 4 sin(alpha)
sin(gamma)) (McGeer 1990); the spikes of an Izhikevich neuron (2003, doi:10.1109/TNN.2003.820440) as scipy finds them;
a cell with an adaptation current, whose return map is linear; doublings and unstable orbits of Roessler's system; the
wells of Duffing's oscillator, which a half turn exchanges.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import chaosdrill as cd
from chaosdrill.plots.contents import fits
from chaosdrill.scene import parse_scene

NEURON = """
[system.definition]
states = ["v", "u"]
modes.on = { v = "v**2/25 + 5*v + 140 - u + I", u = "a*(b*v - u)" }
[[system.definition.transitions]]
name = "spike"
source = "on"
target = "on"
guard = "v - 30"
direction = 1
reset = { v = "c", u = "u + d" }
[system.parameters]
a = 0.02
b = 0.2
c = -65.0
d = 8.0
I = 10.0
[system.initial]
v = -65.0
u = -13.0
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.I = [3.0, 10.0]
at = "spike"
transient = 20
periods = 16
[analysis.spectrum]
kind = "lyapunov-spectrum"
at = "v > 0"
transient = 20
periods = 64
"""


def words(ds):
    return [cd.Outcome(int(code)).meaning for code in np.ravel(ds["outcome"].values)]


@pytest.fixture(scope="module")
def neuron():
    return parse_scene(NEURON).system


@pytest.fixture(scope="module")
def cell():
    """tau v' = R I - v, and v falls to 0 from theta."""
    return cd.HybridSystem(
        name="cell",
        states=("v",),
        parameters={"tau": 10.0, "R": 2.0, "I": 0.75, "theta": 1.0},
        modes={"on": {"v": "(R*I - v)/tau"}},
        transitions=[cd.Transition("fire", "on", "on", guard="v - theta", direction=+1, reset={"v": "0"})],
    )


@pytest.fixture(scope="module")
def wells():
    """x'' = x - x**3 - delta x'."""
    return cd.HybridSystem(
        name="wells",
        states=("x", "v"),
        parameters={"delta": 0.25},
        modes={"on": {"x": "v", "v": "x - x**3 - delta*v"}},
        initial={"x": 1.0, "v": 0.5},
    )


def spikes_by_scipy(numbers, count):
    """Times of the first spikes."""
    a, b, c, d, current = numbers

    def field(_, y):
        return [y[0] ** 2 / 25 + 5 * y[0] + 140 - y[1] + current, a * (b * y[0] - y[1])]

    def peak(_, y):
        return y[0] - 30

    peak.terminal, peak.direction = True, 1
    state, time, times = [-65.0, -13.0], 0.0, []
    while len(times) < count:
        run = solve_ivp(field, (time, time + 1000), state, events=peak, method="DOP853", rtol=1e-12, atol=1e-12)
        time, (_, u) = float(run.t_events[0][0]), run.y_events[0][0]
        state, times = [c, u + d], [*times, time]
    return np.array(times)


@pytest.mark.parametrize(("c", "period"), [(-65.0, 1), (-47.0, 2)])
def test_spikes_of_a_neuron(neuron, c, period):
    right = spikes_by_scipy((0.02, 0.2, c, 8.0, 10.0), 60)
    system = neuron.with_parameters(c=c)
    section = cd.poincare_section(system, transient=20, periods=40, at="spike")
    np.testing.assert_allclose(section["time"], right[20:], rtol=1e-9)
    path = cd.trajectory(system, transient=20, periods=6, at="spike", samples=5)
    np.testing.assert_allclose(path["event_time"], right[20:26], rtol=1e-9)
    np.testing.assert_allclose(path["time"][[0, -1]], right[[19, 25]], rtol=1e-9)
    diagram = cd.bifurcation_diagram(system, {"c": [c]}, transient=20, periods=30, at="spike")
    assert int(section["period"]) == int(diagram["period"].item()) == period
    np.testing.assert_allclose(diagram["section"].values[0, 0], section["section"].values[:30], rtol=1e-9)
    interval = np.diff(right)[-period:].mean()
    orbit = cd.periodic_orbit(system, at="spike", transient=20, period=period)
    assert int(orbit["period"]) == period
    assert float(orbit["period_time"]) == pytest.approx(period * interval, rel=1e-8)
    for found in (section, diagram):
        assert float(found["return_time"].item()) == pytest.approx(interval, rel=1e-8)


def test_a_neuron_below_its_threshold_is_at_rest(neuron):
    """Fixed points of v**2/25 + (5 - b) v + 140 + I exist up to I = (5 - b)**2 25/4 - 140 = 4; the left is stable."""
    given = {"transient": 20, "periods": 30}
    for at in ("spike", "v > 20"):
        chart = cd.parameter_chart(neuron, {"I": [3.0, 10.0], "b": [0.2]}, at=at, **given)
        assert words(chart) == ["equilibrium", "periodic"]
        assert chart["period"].values.ravel().tolist() == [0, 1]
        assert chart["attractor_count"].values.ravel().tolist() == [1, 1]
    basins = cd.basins(neuron.with_parameters(I=3.0), {"v": [-70.0, -60.0], "u": [-14.0, 0.0]}, at="spike", **given)
    assert basins["fraction"].values.tolist() == [1.0]
    left = (-4.8 - np.sqrt(4.8**2 - 4 / 25 * 143)) / (2 / 25)
    np.testing.assert_allclose(basins["attractor_state"], [[left, 0.2 * left]], rtol=1e-12)


def test_an_integrate_and_fire_cell(cell):
    """Silent below I = theta/R; its only exponent is that of the flow, also through the reset, which keeps it."""
    currents = np.array([0.4, 0.55, 0.75, 2.0])
    interval = 10 * np.log(2 * currents[1:] / (2 * currents[1:] - 1))
    diagram = cd.bifurcation_diagram(cell, {"I": currents}, transient=2, periods=10, at="fire")
    assert words(diagram) == ["equilibrium", "periodic", "periodic", "periodic"]
    np.testing.assert_allclose(diagram["return_time"].values[1:, 0], interval, rtol=1e-12)
    np.testing.assert_allclose(diagram["events_per_time"].values[1:, 0], 1 / interval, rtol=1e-12)
    np.testing.assert_allclose(diagram["lyapunov_exponent"].values[1:, 0], 0, atol=1e-12)
    assert words(cd.lyapunov_spectrum(cell, duration=200.0)) != ["chaotic"]
    orbit = cd.periodic_orbit(cell, at="fire", transient=5)
    assert float(orbit["period_time"]) == pytest.approx(interval[1], rel=1e-12)


def test_a_branch_of_the_cell_has_its_interval(cell):
    branch = cd.continue_orbit(cell, {"I": (0.55, 3.0)}, at="fire", transient=5)
    above = 2 * branch["I"].values
    np.testing.assert_allclose(branch["period_time"], 10 * np.log(above / (above - 1)), rtol=1e-11)
    np.testing.assert_allclose(branch["section"].values[:, 0, 0], 1, rtol=1e-12)
    np.testing.assert_allclose(branch["orbit_state"].values[:, 0], 0, atol=1e-12)


def test_points_of_orbits_are_those_of_diagrams():
    """The current w, of decay 1/tau, grows by b at a spike: an interval T leaves w = b q/(1 - q), q = exp(-T/tau)."""
    system = cd.HybridSystem(
        states="v w",
        parameters={"J": 2.5, "tau": 3.0, "b": 0.3},
        modes={"on": {"v": "J - v - w", "w": "-w/tau"}},
        transitions=[cd.Transition("spike", "on", "on", guard="v - 1", direction=1, reset={"v": "0", "w": "w + b"})],
    )
    values = np.linspace(0.1, 1.0, 4)
    diagram = cd.bifurcation_diagram(system, {"b": values}, at="spike", transient=200, periods=20)
    branch = cd.continue_orbit(system, {"b": (0.1, 1.0)}, at="spike")
    orbit = cd.periodic_orbit(system, at="spike")
    for found, b in ((branch, branch["b"].values), (orbit, 0.3)):
        left = np.exp(-found["period_time"].values / 3)
        before = b * left / (1 - left)
        np.testing.assert_allclose(found["section"].values[..., 0, 0], 1, rtol=1e-11)
        np.testing.assert_allclose(found["section"].values[..., 0, 1], before, rtol=1e-10)
        np.testing.assert_allclose(found["orbit_state"].values[..., 0], 0, atol=1e-11)
        np.testing.assert_allclose(found["orbit_state"].values[..., 1], before + b, rtol=1e-10)
    ends = branch["section"].values[[branch["b"].values.argmin(), branch["b"].values.argmax()], 0]
    np.testing.assert_allclose(diagram["section"].values[[0, -1], 0, -1], ends, rtol=1e-9)
    assert fits(branch, diagram)
    assert not fits(branch, cd.bifurcation_diagram(system, {"b": values}, at="w < 1", transient=50, periods=20))


@pytest.mark.parametrize(
    ("at", "angles"), [("y > 0", [0]), ("x < a", [np.pi / 2]), ("turn", [0]), ("x*y < 0", [np.pi / 2, -np.pi / 2])]
)
def test_points_of_a_circle_on_any_surface(at, angles):
    """r' = r (b - r**2), phi' = w: a circle of radius sqrt(b), gone around in 2 pi/w; a mark named turn is at y = 0."""
    growth = "(b - x**2 - y**2)"
    system = cd.HybridSystem(
        states="x y",
        parameters={"a": 0.0, "b": 2.0, "w": 3.0},
        modes={"on": {"x": f"x*{growth} - w*y", "y": f"y*{growth} + w*x"}},
        transitions=[cd.Transition("turn", "on", "on", guard="y + a*x", direction=+1)],
        initial={"x": 1.0},
    )
    at = at.replace("y > 0", "y > a")
    branch = cd.continue_orbit(system, {"b": (1.0, 4.0)}, at=at, transient=20, period=len(angles))
    np.testing.assert_allclose(branch["period_time"], 2 * np.pi / 3, rtol=1e-11)
    orbit = cd.periodic_orbit(system, at=at, transient=20, period=len(angles))
    assert int(orbit["period"]) == len(angles)
    for found, b in ((branch, branch["b"].values), (orbit.expand_dims("point"), np.array([2.0]))):
        here = found["section"].values
        assert here.shape[1] == len(angles)
        seen = np.sort(np.round(np.arctan2(here[..., 1], here[..., 0]), 9) + 0.0, axis=1)
        np.testing.assert_allclose(seen, np.broadcast_to(np.sort(angles), seen.shape), atol=1e-8)
        np.testing.assert_allclose(np.hypot(here[..., 0], here[..., 1]), np.sqrt(b)[:, None] + 0 * seen, rtol=1e-10)


def test_the_gait_of_a_wheel_over_any_section():
    wheel = cd.build("rimless-wheel")
    alpha, gamma = wheel.parameters["alpha"], wheel.parameters["gamma"]
    kept = np.cos(2 * alpha) ** 2
    # speed before the step, from the fixed point of the return map
    speed = np.sqrt(4 * np.sin(alpha) * np.sin(gamma) / (1 - kept))
    for at, right in (("step", [gamma + alpha, speed]), ("th > 0", None)):
        section = cd.poincare_section(wheel, transient=60, periods=8, at=at)
        assert int(section["period"]) == 1
        np.testing.assert_allclose(section["multiplier_real"], [1, kept], rtol=1e-7)
        if right is not None:
            np.testing.assert_allclose(section["section"][-1], right, rtol=1e-9)
        spectrum = cd.lyapunov_spectrum(wheel, transient=60, periods=50, at=at)
        time = float(section["return_time"])
        np.testing.assert_allclose(spectrum["lyapunov_exponent"], [0, np.log(kept) / time], atol=1e-6)
        assert float(spectrum["events_per_time"]) == pytest.approx(1 / time, rel=1e-9)


def test_wells_that_a_turn_exchanges(wells):
    """Spirals into x = +-1 with exponents -delta/2, whatever lengths count."""
    grid = {"x": np.linspace(-1.9, 1.9, 8), "v": np.linspace(-1.5, 1.5, 8)}
    by_time = cd.basins(wells, grid, transient=150, duration=60)
    by_returns = cd.basins(wells, grid, transient=12, periods=12, at="v > 0")
    for found in (by_time, by_returns):
        assert set(words(found)) == {"equilibrium"}
        numbers = found["attractor"].values
        np.testing.assert_array_equal(numbers + numbers[::-1, ::-1], 3)
        np.testing.assert_allclose(np.sort(found["attractor_state"][:, 0]), [-1, 1], rtol=1e-12)
    np.testing.assert_array_equal(by_time["attractor"], by_returns["attractor"])
    np.testing.assert_allclose(by_time["attractor_exponent"].sum("exponent"), -0.25, rtol=1e-9)
    right = [[solve_ivp(lambda _, y: [y[1], y[0] - y[0] ** 3 - y[1] / 4], (0, 150), [x, v], rtol=1e-9).y[0, -1]
              for v in grid["v"][:3]] for x in grid["x"][:3]]  # fmt: skip
    state = by_time["attractor_state"].values[:, 0]
    np.testing.assert_array_equal(np.sign(right), np.sign(state[by_time["attractor"].values[:3, :3] - 1]))


def test_a_cascade_of_a_smooth_flow():
    """Doublings of Roessler's orbits at c = 2.8324 and 3.8373; at c = 5.7 the fixed point's multiplier is -2.4040."""
    system = cd.build("roessler", {"c": 2.5})
    branch = cd.continue_orbit(system, {"c": (2.4, 3.9)}, at="y > 0", transient=50, doublings=1)
    np.testing.assert_allclose(branch["doubling_value"], [2.8324, 3.8373], atol=2e-4)
    for period, time in ((1, 5.8811), (2, 11.7586), (3, 17.5959)):
        orbit = cd.periodic_orbit(system.with_parameters(c=5.7), at="y > 0", transient=200, period=period)
        assert int(orbit["period"]) == period
        assert float(orbit["period_time"]) == pytest.approx(time, abs=1e-4)
        if period == 1:
            assert float(orbit["multiplier_real"][0]) == pytest.approx(-2.4040, abs=2e-4)


def test_lengths_are_those_of_scenes_and_archives(neuron, tmp_path):
    tree = cd.run(parse_scene(NEURON))
    cd.save(tree, tmp_path / "neuron.nc")
    assert not cd.verify(tmp_path / "neuron.nc").differences
    diagram = cd.bifurcation_diagram(neuron, {"I": [3.0, 10.0]}, at="spike", transient=20, periods=16)
    np.testing.assert_array_equal(diagram["section"], tree["diagram"]["section"])
    assert words(tree["diagram"]) == ["equilibrium", "periodic"]
    assert words(tree["spectrum"]) == ["periodic"]

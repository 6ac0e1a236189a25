"""Basins: attractors are recognised across the cells, and the fractions are those of the cells."""

import numpy as np
import pytest
import sympy
from support.discrete import clocked

import chaosdrill as cd
from chaosdrill.analysis.grids.matching import moments, number_attractors
from chaosdrill.analysis.tuning import PLAN
from chaosdrill.engine.shifts import Shifts

LENGTHS = {"transient": 60, "periods": 32, "max_period": 8}


@pytest.fixture(scope="module")
def wells(bistable):
    grid = {"y": np.array([-0.5, 0.5]), "x": np.array([-2.0, -1.5, -0.6, -1e-3, 0.5, 1.0, 1.7, 2.0])}
    return cd.basins(bistable.with_parameters(a=0.0), grid, **LENGTHS)


def test_each_cell_leads_to_its_own_side(wells):
    assert wells["attractor"].dims == ("y", "x")
    state = wells["attractor_state"].values
    np.testing.assert_allclose(np.sort(state[:, 0]), [-1.0, 1.0], atol=1e-9)
    side = np.sign(state[:, 0])[wells["attractor"].values - 1]
    np.testing.assert_array_equal(side, np.sign(wells["x"].values) * np.ones((2, 1)))


def test_fractions_have_their_standard_errors(bistable):
    """The unstable equilibrium at x = 0 parts the cells three to one."""
    found = cd.basins(bistable, {"x": np.array([-1.5, -0.7, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]), "y": [0.0, 1.0]}, **LENGTHS)
    np.testing.assert_allclose(found["fraction"].values, [0.75, 0.25], rtol=1e-15)
    np.testing.assert_allclose(found["fraction_error"].values, np.sqrt(0.7 * 0.3 / 16), rtol=1e-15)
    np.testing.assert_array_equal(found["attractor_number"].values, [1, 2])
    np.testing.assert_allclose(found["attractor_exponent"].values, [[-0.5, -2.0]] * 2, rtol=1e-6)


def test_cells_that_escape_are_on_no_attractor():
    """x' = x**3 - x runs away from beyond 1 in finite time."""
    x, y = sympy.symbols("x y", real=True)
    system = cd.HybridSystem(
        name="escaping",
        states=(x, y),
        parameters={},
        modes={"only": {x: x**3 - x, y: -y}},
        period=sympy.Integer(1),
        bounds={x: (-10, 10)},
    )
    found = cd.basins(system, {"x": [-1.5, -0.9, 0.9, 1.1], "y": [0.0, 2.0]}, **LENGTHS)
    expected = np.repeat([[0], [1], [1], [0]], 2, axis=1)
    np.testing.assert_array_equal(found["attractor"].values, expected)
    np.testing.assert_array_equal(found["outcome"].values, np.where(expected, cd.Outcome.PERIODIC, cd.Outcome.ESCAPED))
    np.testing.assert_allclose(found["fraction"].values, 0.5)
    np.testing.assert_allclose(found["attractor_state"].values, 0.0, atol=1e-9)


GRID = {"x": np.linspace(0.03, 0.97, 40), "y": [-1.0, 0.0, 1.0]}


@pytest.fixture(scope="module")
def twofold():
    """x -> r x (1 - x**2) on either side of zero, which it does not cross for r < 2.598; y -> y/2."""
    x, y, r = sympy.symbols("x y r", real=True)
    return clocked("cubic", (x, y), {"r": 2.1}, {x: r * x * (1 - x**2), y: y / 2}, {x: 0.3})


def test_a_cycle_is_one_attractor_whatever_its_phase(twofold):
    """The starts meet the cycle of two at either of its points."""
    found = cd.basins(twofold, GRID, **LENGTHS)
    assert found.sizes["attractor_number"] == 1
    assert int(found["attractor_period"][0]) == 2
    assert (found["attractor"].values == 1).all()


def test_chaos_is_one_attractor(twofold):
    found = cd.basins(twofold.with_parameters(r=2.5), GRID, transient=60, periods=300)
    assert found.sizes["attractor_number"] == 1
    assert int(found["attractor_outcome"][0]) == cd.Outcome.CHAOTIC


@pytest.mark.parametrize(("r", "kind"), [(2.1, cd.Outcome.PERIODIC), (2.5, cd.Outcome.CHAOTIC)])
def test_mirror_images_are_two_attractors(twofold, r, kind):
    grid = {"x": [-0.9, -0.5, -0.2, 0.1, 0.4, 0.8], "y": [0.3, 0.5]}
    found = cd.basins(twofold.with_parameters(r=r), grid, transient=200, periods=512)
    assert found.sizes["attractor_number"] == 2
    assert (found["attractor_outcome"].values == kind).all()
    sides = found["attractor"].values[:3], found["attractor"].values[3:]
    assert [len(set(side.ravel().tolist())) for side in sides] == [1, 1]


def test_moments_do_not_know_the_phase():
    rng = np.random.default_rng(5)
    cycle = np.concatenate([rng.normal(size=(6, 3)), np.zeros((6, 1))], axis=1)
    windows = np.stack([np.tile(np.roll(cycle, shift, axis=0), (4, 1)) for shift in range(6)])
    found, state = moments(windows, np.ones((6, 3)), np.full(6, 6), Shifts.none(3))
    np.testing.assert_allclose(found, found[:1] * np.ones((6, 1, 1)), rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(state, np.repeat(cycle[[cycle[:, 0].argmin()], :3], 6, axis=0))
    np.testing.assert_allclose(found[0, 0], cycle[:, :3].mean(axis=0))
    np.testing.assert_allclose(found[0, 1], cycle[:, :3].std(axis=0))


def test_numbers_go_by_size_whatever_the_order():
    period = np.array([1, 2, 2, 1, 3, 2, 0])
    found = {
        "period": period,
        "outcome": np.array([1, 1, 1, 1, 1, 1, int(cd.Outcome.ESCAPED)]),
        "moments": np.repeat(period[:, np.newaxis, np.newaxis], 4, axis=1).astype(float),
        "lyapunov_exponent": np.zeros((7, 0)),
        "lyapunov_error": np.zeros((7, 0)),
    }
    numbers, leaders = number_attractors(found)
    assert numbers.tolist() == [2, 1, 1, 2, 3, 1, 0]
    assert leaders.tolist() == [1, 0, 4]


@pytest.mark.parametrize(
    "lengths", [{"at": "v > 0", "periods": 8}, {"at": "x**2 > 1", "periods": 8}, {"duration": 20}], ids=str
)
def test_a_rest_is_one_however_late_runs_come_to_it(lengths):
    """Spirals into x = -1 and x = 1, on sections through both, or in time: they come closer in ever smaller turns."""
    system = cd.HybridSystem(
        name="spirals", states="x v", parameters={"d": 0.3}, modes={"on": {"x": "v", "v": "x - x**3 - d*v"}},
        initial={"x": 1.0, "v": 0.0},
    )  # fmt: skip
    grid = {"x": np.linspace(-2, 2, 6), "v": np.linspace(-2, 2, 5)}
    found = cd.basins(system, grid, transient=5, max_period=3, exponents=0, **lengths)
    np.testing.assert_allclose(np.sort(found["attractor_state"].sel(state="x")), [-1, 1], atol=0.1)


def test_a_point_that_no_start_has_reached_is_one():
    """Multipliers of -0.99: after 40 iterates each of 100 starts is still on its way, to x = 0 or to x = 3."""
    slow = cd.Map("x", {"m": -0.99}, {"x": "piecewise(m*x, x < 3/2, 3 + m*(x - 3))"}, initial={"x": 0.1})
    away = np.geomspace(1e-8, 1, 50)
    starts = {"x": np.concatenate([away, 3 + away])}
    found = cd.basins(slow, initial=starts, transient=40, periods=8, max_period=3, exponents=0)
    np.testing.assert_array_equal(found["fraction"], [0.5, 0.5])
    assert len(np.unique(found["attractor"][:50])) == 1


def test_a_point_on_a_section_is_the_rest_in_it():
    found = {
        "period": np.array([1, 0, 1, 2]),
        "outcome": np.array([cd.Outcome.PERIODIC, cd.Outcome.EQUILIBRIUM, cd.Outcome.PERIODIC, cd.Outcome.PERIODIC]),
        "moments": np.array([[[1.0], [0], [0], [1]]] * 3 + [[[1.0], [0.1], [0], [1]]]),
        "lyapunov_exponent": np.zeros((4, 0)),
        "lyapunov_error": np.zeros((4, 0)),
    }
    numbers, leaders = number_attractors(found)
    assert (numbers.tolist(), leaders.tolist()) == ([1, 1, 1, 2], [1, 3])


def test_a_state_that_the_mode_holds_spans_no_grid():
    with pytest.raises(cd.SettingsError, match=r"grid\.w: mode 'stick', the initial one, leaves it no freedom"):
        cd.basins(cd.drill(), {"y": [0.0], "w": [0.0, 0.1]}, transient=1, periods=4)


@pytest.mark.parametrize(
    ("grid", "words"),
    [
        ({"x": [0.0]}, r"grid: names \['x'\]; basins are drawn over two states"),
        ({"x": [0.0], "a": [0.0]}, "grid.a: unknown state; known here: x, y"),
        ({"x": [0.0, 0.0], "y": [1.0]}, "grid.x is .*; contains a value twice"),
        (None, "grid: missing; give two states with their values"),
    ],
)
def test_grids_that_cannot_be_used(bistable, grid, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.basins(bistable, grid, **LENGTHS)


@pytest.mark.parametrize("unsettled", [{"exponents": 0}, {"max_extension": 0}])
def test_a_cycle_that_is_approached_slowly_counts_once(logistic, unsettled):
    """The fixed point at r = 2.999 has the multiplier -0.999: some runs nearly come back after two steps."""
    starts = {"x": np.linspace(0.05, 0.95, 40), "clock": np.array([0.5])}
    found = cd.basins(logistic.with_parameters(r=2.999), starts, transient=40, periods=64, **unsettled)
    assert found.sizes["attractor_number"] == 1


def rings(factor):
    """A flow that turns once in 2 pi about the centre, and goes off by a factor of its distance."""
    rates = {"x": f"-y - x*({factor})", "y": f"x - y*({factor})"}
    return cd.HybridSystem(states="x y", parameters={}, modes={"on": rates}, initial={"x": 0.1, "y": 0.0})


@pytest.fixture(scope="module")
def ring():
    """The rest at the centre and the circle of radius 2 attract."""
    return rings("(1 - x**2 - y**2)*(4 - x**2 - y**2)/8")


def test_a_cycle_keeps_its_word_where_instants_are_whole_turns_apart(ring):
    for apart in (1.003, 1.0267):
        duration = PLAN.parts * 4 * np.pi * apart
        found = cd.basins(ring, {"x": [0.1, 2.0], "y": [0.2, 1.0]}, duration=duration, transient=300.0)
        assert found.cd.words("outcome").values.tolist() == [["equilibrium", "periodic"], ["periodic", "periodic"]]


@pytest.mark.parametrize("turns", [512, 1024, PLAN.parts])
def test_a_cycle_counts_once_where_instants_are_whole_turns_apart(ring, turns):
    """Each run stands at the same point of the circle at all instants, or at a few, another one than other runs."""
    grid = {"x": np.linspace(-3, 3, 12), "y": np.linspace(-3, 3, 12)}
    found = cd.basins(ring, grid, duration=turns * 2 * np.pi, transient=300.0)
    assert found.sizes["attractor_number"] == 2
    x, y = np.meshgrid(grid["x"], grid["y"], indexing="ij")
    outside = found["attractor"].values == found["attractor"].values[0, 0]
    assert (outside == (np.hypot(x, y) > 1)).all()


def test_cycles_around_each_other_are_two():
    """The circles of radii 1 and 1.15 attract, and the one of radius 1.08 between them is their boundary."""
    grid = {"x": np.linspace(0.5, 2, 6), "y": np.linspace(-1, 1, 6)}
    factor = "20*(x**2 + y**2 - 1)*(x**2 + y**2 - 1.08**2)*(x**2 + y**2 - 1.15**2)"
    found = cd.basins(rings(factor), grid, duration=200.0, transient=100.0)
    x, y = np.meshgrid(grid["x"], grid["y"], indexing="ij")
    assert (found["attractor"].values == np.where(np.hypot(x, y) > 1.08, 1, 2)).all()


def test_a_gait_is_no_part_of_the_sea_of_a_walker_that_has_fallen():
    """Fallen, its legs swing as pendulums do, without friction: through all states, those of the gait as well."""
    starts = [{"theta": theta, "omega": omega} for theta, omega in ((0.2, -0.2), (0.21, -0.21), (0.2, -0.19))]
    found = cd.basins(cd.build("simplest-walker"), initial=starts, duration=400.0, transient=300.0)
    one, same, other = found["attractor"].values.tolist()
    assert one == same != other
    assert found.cd.words("outcome").values.tolist() == ["periodic", "periodic", "chaotic"]

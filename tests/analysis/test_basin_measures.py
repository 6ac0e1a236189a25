"""Measures of basins, against model basins in closed form and published exponents."""

import numpy as np
import pytest
import sympy
import xarray as xr
from scipy.stats import binom
from support.discrete import clocked

import chaosdrill as cd
from chaosdrill.analysis.grids.boundaries import (
    merged_distances,
    mixing,
    share_error_of_grid,
    smallest_kicks,
    uncertainty,
)
from chaosdrill.analysis.starts import share_of
from chaosdrill.plots.shares import uncertain_fraction

CANTOR = 1 - np.log(2) / np.log(3)


def stripes(width, count, shape=(120, 120)):
    """Straight stripes of so many cells, whose basins take turns."""
    return 1 + (np.arange(shape[0]) // width % count)[:, np.newaxis] + np.zeros(shape, dtype=int)


def cantor(places):
    """To which side points of a line leave the middle thirds: their boundary is Cantor's set."""
    left = np.zeros(len(places), dtype=int)
    x = places.copy()
    for _ in range(40):
        gone = (left == 0) & ((x < 0) | (x > 1) | ((x > 1 / 3) & (x < 2 / 3)))
        left[gone] = 1 + (x[gone] > 0.5)
        x = np.where(x < 0.5, 3 * x, 3 * x - 2)
    return left


def newton(count, side, off=0.0):
    """Roots of z**3 = 1 to which Newton's method leads from a square."""
    along = np.linspace(-side, side, count) + off
    z = along[:, np.newaxis] * 1j + along
    for _ in range(60):
        with np.errstate(all="ignore"):
            z = z - (z**3 - 1) / (3 * z * z)
    return 1 + np.argmin(np.abs(z[..., np.newaxis] - np.exp(2j * np.pi * np.arange(3) / 3)), axis=-1)


def half_planes(along, across, place):
    """Basins on the two sides of a straight line."""
    return 1 + (across[0] * along[:, np.newaxis] + across[1] * along > place)


# Entropies.


def test_entropies_of_stripes():
    """Boxes of 8 over stripes of 4 are all half and half; of stripes of 12, every third box is."""
    both = mixing(stripes(4, 2), 8)
    assert both["basin_entropy"] == (pytest.approx(np.log(2)), pytest.approx(0, abs=1e-12))
    assert both["boundary_entropy"][0] == pytest.approx(np.log(2))
    wide = mixing(stripes(12, 2), 8)
    assert wide["basin_entropy"][0] == pytest.approx(np.log(2) / 3)
    assert wide["boundary_entropy"][0] == pytest.approx(np.log(2))
    assert mixing(stripes(4, 3), 12)["basin_entropy"][0] == pytest.approx(np.log(3))
    alone = mixing(np.ones((20, 20), dtype=int), 5)
    assert alone["basin_entropy"][0] == 0.0
    assert np.isnan(alone["boundary_entropy"][0])


@pytest.mark.parametrize("name", ["basin_entropy", "boundary_entropy"])
def test_errors_of_entropies_know_where_boxes_begin(name):
    """All boxes along a straight boundary of the grid are alike; elsewhere in them it has another entropy."""
    k = np.arange(1, 5) / 5
    of_boundary = -(k * np.log(k) + (1 - k) * np.log(1 - k)).mean()
    exact = {"boundary_entropy": of_boundary, "basin_entropy": of_boundary * 4 / 5 / 20}[name]
    for place in range(40, 45):
        value, error = mixing(half_planes(np.arange(100), (1, 0), place), 5)[name]
        # no box is on the boundary if that lies between boxes
        assert np.isnan(value) or abs(value - exact) <= 2 * error


@pytest.mark.parametrize("basin", ["line", "disc", "graph"])
def test_errors_of_entropies_are_those_of_a_moved_grid(basin):
    rng, along, found = np.random.default_rng(4), np.linspace(-1, 1, 120), []
    for _ in range(80):
        moved = along + rng.uniform(-2.5, 2.5, 2)[:, np.newaxis] * 2 / 119
        x, y = moved[0][:, np.newaxis], moved[1]
        edge = sum(2.0 ** (-k / 2) * np.cos(2.0**k * np.pi * x) for k in range(50))
        inside = {"line": np.cos(0.5) * x + np.sin(0.5) * y > 0.1, "disc": x**2 + y**2 < 0.4, "graph": 4 * y > edge}
        found.append(list(mixing(1 + inside[basin], 5).values()))
    values, errors = np.moveaxis(found, 2, 0)
    assert (np.mean(np.abs(values - values.mean(axis=0)) <= 2 * errors, axis=0) >= 0.9).all()
    # those of a line know nothing of its regularity
    assert (np.median(errors, axis=0) <= (3.2 if basin == "line" else 1.5) * values.std(axis=0)).all()


def test_a_grid_smaller_than_a_box_has_no_entropy():
    for small in (mixing(np.array([[0, 1]]), 5), mixing(np.array(1), 5)):
        assert all(np.isnan(value) for both in small.values() for value in both)
    assert np.isnan(uncertainty(np.array([[0, 1]])).exponent)
    assert np.isnan(uncertainty(np.array(1)).exponent)


def test_entropy_in_three_dimensions():
    cube = np.zeros((8, 8, 8), dtype=int)
    cube[:, :, 4:] = 1
    assert mixing(cube, 8)["basin_entropy"][0] == pytest.approx(np.log(2))
    assert mixing(cube, 4)["basin_entropy"][0] == 0.0


# The uncertainty exponent.


def test_a_smooth_boundary_has_the_exponent_one():
    rng = np.random.default_rng(1)
    for _ in range(20):
        along, angle, off = np.linspace(-1, 1, rng.integers(100, 200)), *rng.uniform((0, -0.3), (2 * np.pi, 0.3))
        found = uncertainty(1 + (np.cos(angle) * along[:, np.newaxis] + np.sin(angle) * along > off))
        assert abs(found.exponent - 1) <= 2 * found.exponent_error
        assert found.exponent == pytest.approx(1, abs=0.03)
        assert found.exponent_error < 0.15


def test_errors_cover_what_a_boundary_is_on_smaller_scales():
    """A wall of merlons 12 cells wide: seen from farther away it fills a strip, and nearer it is a smooth boundary."""
    x, y = np.mgrid[:600, :600]
    found = uncertainty(1 + (x < np.where(y // 12 % 2, 340, 260)))
    assert found.exponent < 0.5
    assert abs(found.exponent - 1) <= 2 * found.exponent_error


@pytest.mark.parametrize("flat", [False, True])
def test_a_cantor_set_has_the_exponent_of_its_dimension(flat):
    rng = np.random.default_rng(2)
    found = []
    for count in rng.integers(300, 3000, 20) if not flat else [400, 600]:
        line = cantor(np.linspace(0, 1, count) + rng.uniform(0, 0.002))
        found.append(uncertainty(line[:, np.newaxis] + np.zeros(300, dtype=int) if flat else line))
    exponents, errors = (np.array([getattr(one, name) for one in found]) for name in ("exponent", "exponent_error"))
    assert (np.abs(exponents - CANTOR) <= 2 * errors).all()
    assert exponents.mean() == pytest.approx(CANTOR, abs=0.03)
    assert (errors < 0.2).all()


def test_newtons_method_has_the_published_exponent():
    """0.58, from the dimension 1.42 of the boundary (as the tests of Attractors.jl have it)."""
    for count, side, off in ((128, 1.5, 0.0), (300, 1.0, 0.0), (400, 1.5, 0.1)):
        found = uncertainty(newton(count, side, off))
        assert abs(found.exponent - 0.58) <= 2 * found.exponent_error
        assert found.exponent == pytest.approx(0.58, abs=0.1)


@pytest.mark.parametrize("ratio", [1.3, 1.5, 1.7])
def test_a_boundary_that_is_a_function_has_its_own_exponent(ratio):
    """x -> ratio x + cos(u), u -> 2 u: 1 - ln(ratio)/ln 2 is the paper's dimension of the boundary, less 1."""
    rng, hits = np.random.default_rng(8), []
    for count in rng.integers(200, 900, 12).tolist():
        u = np.linspace(0, 2 * np.pi, count) + rng.uniform(0, 0.1)
        edge = -sum(np.cos(2.0**k * u) / ratio ** (k + 1) for k in range(60))
        found = uncertainty(1 + (np.linspace(-4, 4, count) > edge[:, np.newaxis]))
        hits.append(abs(found.exponent - np.log(ratio) / np.log(2)) <= 2 * found.exponent_error < 0.3)
    assert np.mean(hits) >= 0.9


def test_errors_cover_what_a_rough_boundary_hides_between_cells():
    """Weierstrass' function, of Hoelder exponent 0.3: between cells it leaves them and comes back."""
    rng, found = np.random.default_rng(3), []
    for count in rng.integers(200, 500, 50).tolist():
        along = np.linspace(0, 2 * np.pi, count)
        edge = sum(np.cos(1.7**k * along + turn) / 1.7 ** (0.3 * k) for k, turn in enumerate(rng.uniform(0, 6.3, 60)))
        most = 1.1 * np.abs(edge).max()
        one = uncertainty(1 + (np.linspace(-most, most, count) > edge[:, np.newaxis]))
        found.append((abs(one.exponent - 0.3) <= 2 * one.exponent_error, one.exponent_error))
    held, errors = np.array(found).T
    assert held.mean() >= 0.88
    assert np.median(errors) < 0.17


def test_what_is_too_coarse_has_no_exponent():
    assert np.isnan(uncertainty(newton(60, 1.5)).exponent)
    assert np.isnan(uncertainty(np.ones((200, 200), dtype=int)).exponent)


# Shares of a grid, and basins of Wada.


def test_errors_of_shares_of_a_grid_cover():
    rng = np.random.default_rng(3)
    hits = []
    for _ in range(100):
        count, radius = rng.integers(40, 90), rng.uniform(0.4, 0.9)
        off, along = rng.uniform(-0.05, 0.05, 2), np.linspace(-1, 1, count)
        inside = (along[:, np.newaxis] - off[0]) ** 2 + (along - off[1]) ** 2 < radius**2
        # a cell is as wide as the distance of two starts
        exact = np.pi * radius**2 / (2 * count / (count - 1)) ** 2
        error = share_error_of_grid(1 + inside, 2, 1.0)
        assert error < 0.02
        hits.append(abs(inside.mean() - exact) <= 2 * error)
    assert np.mean(hits) >= 0.95
    assert share_error_of_grid(np.ones((9, 9)), 1, 0.25) == 0.25


@pytest.mark.parametrize("starts", [1, 5, 20])
def test_errors_of_shares_of_few_starts_cover(starts):
    hits = np.arange(starts + 1)
    share, error = share_of(hits, starts)
    for exact in (0.05, 0.3, 0.5, 0.8):
        covered = np.abs(share - exact) <= 2 * error
        assert binom.pmf(hits, starts, exact)[covered].sum() >= 0.9


def test_merged_boundaries_are_the_same_for_newtons_method_alone():
    assert merged_distances(newton(300, 1.5)).max() <= 6
    assert merged_distances(stripes(20, 3)).min() >= 18
    assert np.isnan(merged_distances(stripes(20, 2))).all()


# The analysis.


@pytest.fixture(scope="module")
def found():
    x, y = sympy.symbols("x y", real=True)
    size = 3 * (x**2 + y**2) ** 2
    images = {x: 2 * x / 3 + (x**2 - y**2) / size, y: 2 * y / 3 - 2 * x * y / size}
    system = clocked("newton", (x, y), {}, images, {x: 0.1, y: 0.2})
    along = np.linspace(-1.5, 1.5, 64)
    lengths = {"transient": 40, "periods": 16, "max_period": 2, "exponents": 0}
    return system, lengths, cd.basin_measures(system, {"y": along, "x": along}, box=4, **lengths)


def test_measures_are_those_of_the_basins(found):
    _, _, measures = found
    direct = newton(64, 1.5)
    for name, (value, error) in mixing(direct, 4).items():
        assert float(measures[name]) == pytest.approx(value)
        assert float(measures[f"{name}_error"]) == pytest.approx(error)
    shares = [np.mean(direct == number) for number in (1, 2, 3)]
    np.testing.assert_allclose(np.sort(measures["fraction"]), np.sort(shares), atol=1e-12)
    np.testing.assert_allclose(np.hypot(*measures["attractor_state"].values[:, :2].T), 1.0)
    assert np.isnan(measures["uncertainty_exponent"])
    assert (measures["wada_distance"] <= 6).all()
    assert (measures["fraction_error"] < 0.01).all()
    assert measures["fraction_none"] == 0.0


def test_a_list_has_shares_alone(found):
    system, lengths, _ = found
    starts = [[1.0, 0.1, 0.5], [-0.5, 0.8, 0.5], [-0.5, 0.9, 0.5], [-0.5, -0.9, 0.5]]
    measures = cd.basin_measures(system, initial=starts, **lengths)
    np.testing.assert_allclose(measures["fraction"], [0.5, 0.25, 0.25])
    assert "basin_entropy" not in measures
    assert int(measures["start_count"]) == 4
    beside = cd.basin_measures(system, {"x": [0.9, 1.0], "y": [0.0, 0.1]}, initial=starts, box=2, **lengths)
    assert float(beside["fraction"][0]) == pytest.approx(5 / 8)
    assert float(beside["basin_entropy"]) == 0.0


def test_the_smallest_kick_leads_to_the_boundary():
    """Of x' = x - x**3, y' = -y at x = 0; of a disc along its radius, however long the axes are."""
    wells = cd.HybridSystem(
        name="wells", states="y x", parameters={}, modes={"on": {"x": "x - x**3", "y": "-y"}}, period="1",
        initial={"x": 0.5},
    )  # fmt: skip
    grid = {"x": np.linspace(-1.5, 1.5, 40), "y": np.linspace(-40, 60, 21)}
    measures = cd.basin_measures(wells, grid, transient=60, periods=16, max_period=4)
    kick, error = (measures[name].sel(state="x").values for name in ("smallest_kick", "smallest_kick_error"))
    assert (np.abs(kick + measures["attractor_state"].sel(state="x").values) <= 2 * error).all()
    np.testing.assert_allclose(measures["smallest_kick"].sel(state="y"), 0.0, atol=5)
    along = {"x": np.linspace(-1, 1, 81), "y": np.linspace(-10, 10, 81)}
    inside = 1 + (along["x"][:, np.newaxis] ** 2 + (along["y"] / 10) ** 2 > 0.25)
    kick, error = smallest_kicks(inside, along, 1, np.array([0.24, 3.2]))
    assert (np.abs(kick - [0.06, 0.8]) <= 2 * error).all()
    assert np.isnan(smallest_kicks(inside, along, 1, np.array([0.0, 11.0]))[0]).all()


@pytest.mark.parametrize("first", [-1, 5])
def test_kicks_leave_out_whole_turns(first):
    """Wells of an angle at the multiples of pi, with edges where its cosine is 0.1; the grid may begin anywhere."""
    wells = cd.HybridSystem(
        name="turning wells", states="v phi", parameters={}, period="1", initial={"phi": 0.5},
        modes={"on": {"phi": "0.2*sin(phi) - sin(2*phi)", "v": "-v"}},
    )  # fmt: skip
    grid = {"phi": first + np.linspace(0, 2 * np.pi, 41)[:-1], "v": np.linspace(-20, 20, 5)}
    measures = cd.basin_measures(wells, grid, transient=60, periods=16, max_period=4, exponents=0)
    kick, error = (measures[name].sel(state="phi").values for name in ("smallest_kick", "smallest_kick_error"))
    edge = np.arccos(0.1)
    at_pi = np.cos(measures["attractor_state"].sel(state="phi").values) < 0
    assert sorted(at_pi) == [False, True]
    assert (np.abs(np.abs(kick) - np.where(at_pi, np.pi - edge, edge)) <= 2 * error).all()


@pytest.mark.parametrize("basin", ["half-plane", "disc"])
def test_errors_of_kicks_cover_along_the_boundary(basin):
    """Where a boundary is about as far in many directions, cells do not tell to which place the kick leads."""
    rng, hits = np.random.default_rng(6), []
    for _ in range(100):
        point, turn, place = rng.uniform(-0.3, 0.3, 2), rng.uniform(0, 2 * np.pi), rng.uniform(0.45, 0.6)
        grid = {name: np.linspace(-1, 1, count) for name, count in zip("xy", rng.integers(20, 90, 2), strict=True)}
        x, y = np.meshgrid(*grid.values(), indexing="ij")
        across = np.array([np.cos(turn), np.sin(turn)])
        if basin == "disc":
            outside, exact = x**2 + y**2 > 0.64, 0.8 * point / np.linalg.norm(point) - point
        else:
            outside, exact = across[0] * x + across[1] * y > place, across * (place - across @ point)
        kick, error = smallest_kicks(1 + outside, grid, 1, point)
        hits.append(np.abs(kick - exact) <= 2 * error)
    assert (np.mean(hits, axis=0) >= 0.95).all()


def test_a_grid_of_unequal_steps_knows_its_kicks():
    along = {"x": np.linspace(0, 1, 30) ** 2}
    for place in np.linspace(0.3, 0.95, 40):
        kick, error = smallest_kicks(1 + (along["x"] > place), along, 1, np.array([0.1]))
        assert abs(kick[0] - (place - 0.1)) <= 2 * error[0]


def test_a_state_of_one_value_is_held_there():
    wells = cd.HybridSystem(
        name="wells", states="y x", parameters={}, modes={"on": {"x": "x - x**3", "y": "-y"}}, period="1",
        initial={"x": 0.5},
    )  # fmt: skip
    given = {"transient": 60, "periods": 16, "max_period": 4, "exponents": 0}
    along = np.linspace(-1.2, 1.5, 120)
    alone, beside = (cd.basin_measures(wells, grid, **given) for grid in ({"x": along}, {"y": [0.0], "x": along}))
    for name in ("boundary_entropy", "uncertain_fraction", "smallest_kick", "smallest_kick_error", "fraction_error"):
        assert np.isfinite(alone[name]).all()
        np.testing.assert_array_equal(alone[name], beside[name])
    single = cd.basin_measures(wells, {"y": [0.0], "x": [0.7]}, **given)
    assert float(single["fraction"][0]) == 1.0
    assert np.isnan(single["smallest_kick"]).all()


@pytest.fixture(scope="module")
def clocked_wells():
    return cd.HybridSystem(
        name="wells", states="x", parameters={"T": 1.0}, modes={"on": {"x": "x - x**3"}}, period="T", initial={"x": 0.5}
    )


def test_one_state_spans_a_grid(clocked_wells):
    measures = cd.basin_measures(clocked_wells, {"x": np.linspace(-1, 1, 40)}, transient=50, periods=16, max_period=4)
    np.testing.assert_allclose(measures["fraction"], 0.5)
    assert measures["fraction_error"].max() == pytest.approx(1 / 40 / np.sqrt(12))


def test_a_value_without_a_run_gets_an_outcome(clocked_wells):
    """A period that is not positive; the sweep goes on."""
    given = {"transient": 50, "periods": 16, "max_period": 4, "exponents": 0}
    measures = cd.basin_measures(clocked_wells, {"x": np.linspace(-1, 1, 40)}, {"T": [1.0, -1.0, 2.0]}, **given)
    assert measures.cd.words("outcome").values.tolist() == ["ok", "failed", "ok"]
    for name in ("basin_entropy", "fraction_none", "fraction", "smallest_kick"):
        known = np.isfinite(measures[name].values).reshape(3, -1)
        assert known.any(axis=1).tolist() == [True, False, True]


# Along a parameter: a line x = middle root of a + x - x**3 parts two basins for abs(a) < 2/sqrt(27).

ALONG = [0.1, -0.2, 0.5, 0.3, -0.5, -0.37]
LENGTHS = {"transient": 400, "periods": 16, "max_period": 2}


def roots(a):
    found = np.roots([-1, 0, 1, a])
    return np.sort(found.real[np.abs(found.imag) < 1e-9])


@pytest.fixture(scope="module")
def moving():
    system = cd.Map("x y", parameters={"a": 0.0}, images={"x": "x + (a + x - x**3)/10", "y": "y/2"}, initial={"x": 0.1})
    grid = {"y": np.linspace(-1, 1, 8), "x": np.linspace(-1.5, 1.5, 160)}
    return system, grid, cd.basin_measures(system, grid, {"a": ALONG}, **LENGTHS)


def test_measures_along_a_parameter_are_those_of_the_closed_form(moving):
    _, grid, found = moving
    assert found["fraction"].dims == ("a", "attractor")
    left, right = (found.isel(attractor=k) for k in np.argsort(found["first_value"].values))
    assert (left["first_value"], left["last_value"]) == (-0.5, 0.3)
    assert (right["first_value"], right["last_value"]) == (-0.37, 0.5)
    assert [str(one.cd.words("end_above").values) for one in (left, right)] == ["jump", "limit"]
    for a in ALONG:
        parted = len(roots(a)) > 1
        low = np.mean(grid["x"] < roots(a)[1]) if parted else float(a < 0)
        np.testing.assert_allclose(found["uncertainty_exponent"].sel(a=a), 1.0 if parted else np.nan, rtol=1e-12)
        # the line passes through one box in 32
        assert (float(found["basin_entropy"].sel(a=a)) > 0) <= parted
        assert float(found["basin_entropy"].sel(a=a)) <= np.log(2) / 32
        for one, share, root in ((left, low, 0), (right, 1 - low, -1)):
            here = one.sel(a=a)
            assert float(here["fraction"]) == pytest.approx(share, abs=1e-15)
            assert np.isnan(here["fraction_error"]) == (share == 0)
            kick, error = (here[name].sel(state="x") for name in ("smallest_kick", "smallest_kick_error"))
            assert abs(kick - (roots(a)[1] - roots(a)[root])) <= 2 * error if parted else np.isnan(kick)


def test_measures_along_a_parameter_are_those_of_each_value(moving):
    system, grid, found = moving
    for a in ALONG[1:3]:
        one, here = cd.basin_measures(system.with_parameters(a=a), grid, **LENGTHS), found.sel(a=a)
        here = here.isel(attractor=np.argsort(-here["fraction"].values, kind="stable")[: one.sizes["attractor"]])
        for name in set(one.data_vars):
            np.testing.assert_allclose(here[name].values, one[name].values, rtol=1e-9, atol=0)


def test_measures_depend_neither_on_workers_nor_on_the_order_of_values(moving, tmp_path):
    system, grid, found = moving
    for given in ({"workers": 2, "store": tmp_path}, {"store": tmp_path}):
        again = cd.basin_measures(system, grid, {"a": ALONG}, **given, **LENGTHS)
        assert again.drop_attrs().identical(found.drop_attrs())
    assert cd.basin_measures(system, grid, {"a": sorted(ALONG)}, **LENGTHS).equals(found.sortby("a"))


def test_a_list_along_a_parameter_has_the_shares_of_attractors(moving):
    system, _, _ = moving
    starts = np.linspace([-1, 0], [1, 1], 12)
    listed, followed = (
        one(system, initial=starts, sweep={"a": ALONG}, **LENGTHS) for one in (cd.basin_measures, cd.attractors)
    )
    assert "basin_entropy" not in listed
    for name in set(listed.data_vars) - {"outcome", "start_count"}:
        np.testing.assert_array_equal(listed[name].values, followed[name].values)


def test_pictures_along_a_parameter(moving):
    _, _, found = moving
    panels = cd.plot(found).figure.axes
    assert [panel.get_ylabel() for panel in panels] == ["fraction of the basin", "entropy", "uncertainty exponent"]
    drawn = panels[1].containers[0].lines[0]
    np.testing.assert_array_equal(drawn.get_xdata(), sorted(ALONG))
    np.testing.assert_array_equal(drawn.get_ydata(), found["basin_entropy"].sortby("a"))
    assert cd.plot(found, kind="shares").get_ylabel() == "fraction of the basin"


def test_pictures_say_the_numbers(found):
    _, _, measures = found
    axes = cd.plot(measures, kind="basin-shares")
    np.testing.assert_allclose([bar.get_width() for bar in axes.patches], measures["fraction"])
    shares = [text.get_text() for text in axes.get_yticklabels()]
    assert shares == ["1: period 1", "2: period 1", "3: period 1"]
    drawn = cd.plot(measures)
    assert drawn.get_title(loc="left").startswith("basin entropy ")


def test_what_is_lacking_has_a_reason(moving):
    system, _, _ = moving
    for count in (1, 2, 5, 30):
        along = np.linspace(-0.9, 0.7, count)
        alone = cd.basin_measures(system, {"x": along}, **LENGTHS)
        swept = cd.basin_measures(system, {"y": along[:1], "x": along}, {"a": ALONG}, **LENGTHS)
        for found in (alone, swept):
            names = [name for name in found if name.startswith(("basin", "bound", "unc", "wada", "small"))]
            lacking = {name.removesuffix("_error") for name in names if np.isnan(found[name]).any()}
            assert {name for name in lacking if name not in found.attrs["reason"]} == set()
            assert {name for name in ("basin_entropy:", "uncertainty_exponent:") if name in found.attrs["reason"]} <= {
                f"{name}:" for name in lacking
            }
    assert "30 values along a state are too few for a fit: give 96 at least" in alone.attrs["reason"]
    uneven = cd.basin_measures(system, {"x": np.linspace(-1, 1, 120) ** 3}, **LENGTHS)
    assert "uncertainty_exponent: x has unequal steps" in uneven.attrs["reason"]


def test_the_axis_of_uncertain_fractions_has_round_numbers():
    distance, part = np.array([3, 4, 5, 6, 8]), np.array([0.19, 0.22, 0.25, 0.28, 0.33])
    columns = {"uncertain_fraction": part, "uncertain_fraction_error": part / 8}
    single = {"uncertainty_exponent": 0.56, "uncertainty_exponent_error": 0.05}
    found = xr.Dataset(
        {name: ("distance", values) for name, values in columns.items()} | single,
        {"distance": distance},
        {"kind": "basin-measures"},
    )
    for name in ("basin_entropy", "boundary_entropy"):
        found = found.assign({name: 0.5, f"{name}_error": 0.1})
    figure = uncertain_fraction(found)
    low, high = figure.axes[0].get_ylim()
    ticks = [tick for tick in figure.axes[0].get_yticks() if low <= tick <= high]
    np.testing.assert_allclose(ticks, [0.15, 0.2, 0.3, 0.4])

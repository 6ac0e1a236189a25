"""Attractors along a parameter: shares against closed forms and published ones, and where attractors begin and end."""

import numpy as np
import pytest
import sympy
from support.discrete import clocked

import chaosdrill as cd
from chaosdrill.analysis.starts import share_of

x, a, r = sympy.symbols("x a r", real=True)
FOLD = 2 / np.sqrt(27)
SHORT = {"transient": 60, "periods": 32, "max_period": 8}
CHAOS = {"transient": 200, "periods": 200}


def ends(found):
    return [tuple(found.cd.words(f"end_{side}").values.tolist()) for side in ("below", "above")]


@pytest.fixture(scope="module")
def wells():
    """x' = a + b x - c x**3: for b = c = 1 two points at rest between a = -+2/sqrt(27), parted by the middle root."""
    return cd.HybridSystem(
        name="wells", states="x", parameters={"a": 0.0, "b": 1.0, "c": 1.0}, modes={"on": {"x": "a + b*x - c*x**3"}},
        period="1", initial={"x": -1.0}, bounds={"x": (-10, 10)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def cubic():
    """x -> r x (1 - x**2): two attractors that mirror each other merge at r = 3 sqrt(3)/2 = 2.598."""
    return clocked("cubic", (x,), {"r": 2.1}, {x: r * x * (1 - x**2)}, {x: 0.3})


@pytest.fixture(scope="module")
def mirrored(cubic):
    starts = np.random.default_rng(2).uniform(-1, 1, 40)
    values = [1.9, 2.2, 2.3, 2.55, 2.62]
    return starts, values, cd.attractors(cubic, {"r": values}, initial={"x": starts}, **CHAOS)


def exact_shares(value, starts):
    """Parts of the starts below and above the root that parts the basins."""
    roots = np.sort(np.roots([-1, 0, 1, value]).real[np.abs(np.roots([-1, 0, 1, value]).imag) < 1e-9])
    if len(roots) == 1:
        return sorted([float(roots[0] < 0), float(roots[0] > 0)])
    return sorted([np.mean(starts < roots[1]), np.mean(starts > roots[1])])


def test_shares_of_two_wells_are_those_of_the_closed_form(wells):
    starts, values = np.linspace(-2, 2, 40), np.linspace(-0.6, 0.6, 13)
    found = cd.attractors(wells, {"a": values}, initial=starts[:, np.newaxis], **SHORT)
    assert found["fraction"].dims == ("a", "attractor")
    for value, shares in zip(values, found["fraction"].values, strict=True):
        np.testing.assert_allclose(np.sort(shares), exact_shares(value, starts), atol=1e-15)
    inside = values[np.abs(values) < FOLD]
    order = np.argsort(found["first_value"].values)
    np.testing.assert_allclose(found["first_value"].values[order], [values[0], inside[0]])
    np.testing.assert_allclose(found["last_value"].values[order], [inside[-1], values[-1]])
    assert ends(found.isel(attractor=order)) == [("limit", "jump"), ("jump", "limit")]
    low, high = found["attractor"].values[order]
    assert found["next_above"].sel(attractor=low) == high
    assert found["next_below"].sel(attractor=high) == low
    assert found["fraction_none"].max() == 0.0


def test_an_attractor_that_no_start_leads_to_is_followed(wells):
    """All starts lie in the left well but at one value; from there the right one is known all the way to its fold."""
    values = np.array([-0.36, -0.2, 0.0, 0.2, 0.37])
    found = cd.attractors(wells, {"a": values}, initial=np.array([[-1.2], [-0.45], [-0.42]]), **SHORT)
    left, right = (found.isel(attractor=k) for k in np.argsort(found["attractor_state"].sel(a=0.0, state="x").values))
    np.testing.assert_array_equal(right["fraction"].values, [0, 0, 0, 0, 2 / 3])
    np.testing.assert_array_equal(right["attractor_outcome"].values, cd.Outcome.PERIODIC)
    np.testing.assert_allclose(left["fraction"].values + right["fraction"].values, 1.0)
    roots = [np.roots([-1, 0, 1, value]).real.max() for value in values]
    np.testing.assert_allclose(right["attractor_state"].sel(state="x"), roots, atol=1e-6)
    assert right["fraction_error"].min() > 0.0


def test_mirror_images_merge(mirrored):
    starts, _, found = mirrored
    shares = found["fraction"].values
    left = np.mean(starts < 0)
    np.testing.assert_allclose(np.sort(shares[:4]), np.sort([[0.0, left, 1 - left]] * 4), atol=1e-15)
    np.testing.assert_allclose(np.sort(shares[4]), [0, 0, 1])
    assert ends(found) == [("limit", "limit", "split"), ("merger", "merger", "limit")]
    merged = int(found["attractor"][2])
    assert found["next_above"].values.tolist() == [merged, merged, 0]
    periods = found["attractor_period"].sel(attractor=1).values
    assert periods.tolist() == [1, 2, periods[2], 0, 0]
    reached = found["reached"].sel(r=1.9).values
    assert {tuple(np.unique(reached[side])) for side in (starts < 0, starts > 0)} == {(1,), (2,)}


def test_a_pitchfork_splits_one_into_two(wells):
    found = cd.attractors(wells, {"b": [0.5, -0.5, 0.2, -0.2]}, initial={"x": [-1.0, -0.3, 0.4, 0.7]}, **SHORT)
    assert ends(found) == [("limit", "merger", "merger"), ("split", "limit", "limit")]
    np.testing.assert_allclose(found["fraction"].values, [[0, 0.5, 0.5], [1, 0, 0], [0, 0.5, 0.5], [1, 0, 0]])


def test_a_period_doubling_is_no_end(logistic):
    """Nor is the band of period 3 in chaos; the clock of the map is neutral and makes no attractors of its own."""
    values = [2.7, 2.9, 3.1, 3.3, 3.5, 3.7, 3.83, 3.9]
    found = cd.attractors(logistic, {"r": values}, random={"count": 8, "seed": 1, "x": (0.1, 0.9)}, **CHAOS)
    assert found.sizes["attractor"] == 1
    assert found["attractor_period"].values[:, 0].tolist() == [1, 1, 2, 2, 4, 0, 3, 0]
    np.testing.assert_array_equal(found["fraction"].values, 1.0)


def test_starts_that_run_away_have_no_attractor(wells):
    """x' = x**3 - x + a runs away from beyond its outer root; at a = 0.5 there is nothing to stay at."""
    system = wells.with_parameters(b=-1.0, c=-1.0)
    found = cd.attractors(system, {"a": [0.0, 0.2, 0.5]}, initial={"x": [-1.5, -0.5, 0.5, 0.9, 1.5]}, **SHORT)
    np.testing.assert_allclose(found["fraction_none"].values, [0.4, 0.6, 1.0])
    np.testing.assert_allclose(found["fraction"].values[:, 0], [0.6, 0.4, 0.0])
    assert ends(found) == [("limit",), ("lost",)]
    assert np.isnan(found["fraction_error"].values[2, 0])


def test_values_and_grids_at_which_nothing_runs_have_no_shares():
    """Beyond a wall: shares were 0 and 1, as where all starts run away."""
    system = cd.build("impact-oscillator")
    beyond = cd.basin_measures(system, {"x": [0.5, 0.6, 0.7], "v": [0.0, 1.0, 2.0]}, **SHORT)
    along = cd.attractors(system, {"wall": [-1.0, 0.3]}, initial={"x": [0.0, 0.5], "v": [0.0, 0.0]}, **SHORT)
    assert along.cd.words("outcome").values[:, 1].tolist() == ["invalid_start", "invalid_start"]
    for name in ("fraction", "fraction_error", "fraction_none", "fraction_none_error"):
        assert np.isnan(beyond[name]).all(), name
        assert np.isnan(along[name].values[0]).all(), name
        assert np.isfinite(along[name].values[1]).all(), name
    assert along["fraction_none"][1] == 0.5


def test_shares_of_a_duffing_oscillator_are_the_published_ones():
    """Five cycles; shares of 4,000 starts by bSTAB (Stender and Hoffmann 2022), in its repository, and their errors."""
    duffing = cd.HybridSystem(
        name="hardening", states="y v", time="t", parameters={"A": 0.2}, period="2*pi", initial={"y": 0.1},
        modes={"on": {"y": "v", "v": "A*cos(t) - 0.08*v - y**3"}},
    )  # fmt: skip
    box = {"count": 400, "seed": 1, "y": (-1, 1), "v": (-0.5, 1)}
    found = cd.attractors(duffing, {"A": [0.2]}, random=box, transient=150, periods=32, max_period=8).sel(A=0.2)
    published = {  # a point of the cycle, its period, its share and error
        (-0.21, 0.02): (1, 0.1955, 0.0063),
        (1.05, 0.77): (1, 0.4945, 0.0079),
        (-0.67, 0.02): (2, 0.0275, 0.0026),
        (-0.46, 0.30): (2, 0.02625, 0.0025),
        (-0.43, 0.12): (3, 0.25625, 0.0069),
    }
    assert found.sizes["attractor"] == 5
    for point, (period, share, error) in published.items():
        near = int(np.abs(found["attractor_state"].values - point).max(axis=1).argmin())
        one = found.isel(attractor=near)
        assert int(one["attractor_period"]) == period
        assert abs(float(one["fraction"]) - share) <= 3 * np.hypot(error, float(one["fraction_error"]))


def test_stable_orbits_of_the_drill_are_found():
    """Where the reference table of its orbits (tests/support) has stable ones; two of period 2 coexist at 0.68."""
    box = {"count": 16, "seed": 1, "y": (-1.5, 0.9), "u": (-1.5, 1.5)}
    values = [0.5, 0.54, 0.6, 0.68, 0.8]
    lengths = {"transient": 200, "periods": 64, "max_period": 8, "exponents": 1, "tolerance": 1e-10}
    found = cd.attractors(cd.drill(), {"eta": values}, random=box, **lengths)
    periods = found["attractor_period"].values
    for k, (period, count) in enumerate([(1, 1), (1, 1), (2, 1), (2, 2), (1, 1)]):
        assert np.count_nonzero(periods[k] == period) >= count
    np.testing.assert_allclose(found["fraction"].sum("attractor") + found["fraction_none"], 1.0)


def test_attractors_do_not_depend_on_workers_chunks_order_or_length(cubic, mirrored, tmp_path):
    starts, values, found = mirrored
    told = []
    given = {"initial": {"x": starts}, **CHAOS}
    cd.attractors(cubic, {"r": values}, **given, workers=2, store=tmp_path)
    again = cd.attractors(cubic, {"r": values}, **given, store=tmp_path, progress=lambda *now: told.append(now))
    for other in (again, cd.attractors(cubic, {"r": values[::-1]}, **given).sortby("r")):
        for name in found.variables:
            np.testing.assert_array_equal(other[name].values, found[name].values)
    # the store had all of it
    assert told[0][0] == told[0][1] == 40 * 5
    assert told[-1][0] == told[-1][1] > 40 * 5
    longer = {"initial": {"x": starts[::-1]}, "transient": 300, "periods": 333}
    other = cd.attractors(cubic, {"r": values}, **longer)
    for name in ("fraction", "first_value", "last_value", "end_below", "end_above", "next_above"):
        np.testing.assert_array_equal(other[name].values, found[name].values)


def test_a_section_of_a_system_without_forcing():
    """r' = r (1 - r**2)(r**2 - a): a ring of radius 1 and a point at rest, parted by the ring of radius sqrt(a)."""
    growth = "(1 - x**2 - y**2)*(x**2 + y**2 - a)"
    system = cd.HybridSystem(
        name="rings", states="x y", parameters={"a": 0.3}, initial={"x": 1.0},
        modes={"on": {"x": f"-y + x*{growth}", "y": f"x + y*{growth}"}},
    )  # fmt: skip
    starts = np.column_stack([np.linspace(0.15, 1.35, 7), np.zeros(7)])
    lengths = {"transient": 20, "periods": 16, "max_period": 4, "max_return": 20.0}
    found = cd.attractors(system, {"a": [0.2, 0.5]}, initial=starts, at="y > 0", **lengths)
    inside = np.array([np.mean(starts[:, 0] ** 2 < value) for value in (0.2, 0.5)])
    kinds = found.cd.words("attractor_outcome").values
    ring = int((kinds[0] == "periodic").argmax())
    np.testing.assert_allclose(found["fraction"].values[:, ring], 1 - inside)
    np.testing.assert_allclose(found["fraction"].values[:, 1 - ring], inside)
    assert (kinds[:, 1 - ring] == "equilibrium").all()
    assert ends(found) == [("limit", "limit"), ("limit", "limit")]


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_errors_of_shares_cover(share):
    hits = np.random.default_rng(1).binomial(100, share, 2000)
    found, error = share_of(hits, 100)
    assert np.mean(np.abs(found - share) <= 2 * error) >= 0.93
    assert error.mean() < 1.1 * found.std() + 0.005
    assert share_of(0, 100)[1] > 0.01


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"sweep": {"a": [0.0]}}, "give the initial states whose shares are counted"),
        ({"sweep": {"a": [0.0], "b": [1.0]}, "initial": [[0.0]]}, "attractors are followed along one parameter"),
        ({"sweep": {"a": [0.0]}, "initial": [[0.0, 1.0]]}, "it must be a list of initial states"),
    ],
)
def test_what_cannot_be_used(wells, given, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.attractors(wells, **given, **SHORT)


def test_the_picture_has_a_band_for_each_and_marks_the_ends(mirrored):
    _, _, found = mirrored
    axes = cd.plot(found)
    texts = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert texts[2].startswith("3: ")
    assert texts[3:] == ["merger", "split"]
    heights = [band.get_paths()[0].get_extents() for band in axes.collections if band.get_paths()][:3]
    assert max(one.y1 for one in heights) == pytest.approx(1.0)
    marks = [(line.get_marker(), float(line.get_xdata()[0])) for line in axes.lines if line.get_marker() in ("o", "P")]
    assert sorted(marks) == [("P", 2.62), ("o", 2.55), ("o", 2.55)]


@pytest.mark.parametrize("unit", [1e60, 1e-60])
def test_attractors_are_told_apart_in_any_unit(unit):
    """Wells at plus and minus a unit, to which each half of the starts leads."""
    images = {"x": "x + (a*u + x - x*(x/u)**2)/10"}
    wells = cd.Map("x", {"a": 0.0, "u": unit}, images, initial={"x": 0.1 * unit})
    drawn = {"count": 10, "seed": 1, "x": (-unit, unit)}
    found = cd.attractors(wells, {"a": [0.0]}, periods=64, transient=100, random=drawn)
    state, start = found["attractor_state"].values.ravel() / unit, found["initial_state"].values.ravel()
    np.testing.assert_allclose(np.sort(state), [-1, 1])
    np.testing.assert_array_equal(state[found["reached"].values.ravel() - 1] > 0, start > 0)

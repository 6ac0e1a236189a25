"""Basins from a list of initial states, in any form and of any dimension."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.errors import SceneError, SettingsError
from chaosdrill.workflow.run_scene import rerun

LENGTHS = {"periods": 20, "transient": 60, "max_period": 2, "exponents": 0}


@pytest.fixture(scope="module")
def wells():
    """x' = x - x**3: to the sign of x; y and z decay."""
    return cd.HybridSystem(
        name="wells",
        states="x y z",
        parameters={},
        modes={"on": {"x": "x - x**3", "y": "-y", "z": "-2*z"}, "off": {"x": "-x", "y": "-y", "z": "-z"}},
        transitions=[cd.Transition("never", "on", "off", guard="x - 50", direction=+1)],
        period="1",
        initial={"x": 1.0, "y": 0.1, "z": 0.2, "mode": "on"},
        bounds={"x": (-100, 100)},
    )


@pytest.fixture(scope="module")
def cloud():
    return np.random.default_rng(5).uniform(-3, 3, (40, 3))


def sides(ds):
    """The first state of the attractor to which each start leads."""
    return ds["attractor_state"].sel(state="x").values[ds["attractor"].values - 1]


def test_starts_in_three_dimensions_go_to_their_side(wells, cloud):
    ds = cd.basins(wells, initial=cloud, **LENGTHS)
    np.testing.assert_allclose(sides(ds), np.sign(cloud[:, 0]), rtol=1e-9)
    np.testing.assert_array_equal(ds["initial_state"].values, cloud)
    assert ds["attractor"].dims == ds["outcome"].dims == ("run",)
    share = np.mean(cloud[:, 0] > 0)
    assert ds["fraction"].values.tolist() == pytest.approx(sorted((share, 1 - share), reverse=True))


FORMS = {
    "lists": lambda rows: rows.tolist(),
    "mappings": lambda rows: [dict(zip("zxy", row[[2, 0, 1]], strict=True)) for row in rows],
    "columns": lambda rows: {name: rows[:, k] for k, name in enumerate("xyz")},
    "frame": lambda rows: pd.DataFrame(rows, columns=list("xyz"))[["y", "z", "x"]].assign(mode="on"),
    "dataset": lambda rows: xr.Dataset({name: ("k", rows[:, k]) for k, name in enumerate("xyz")}),
    "array": lambda rows: xr.DataArray(rows[:, ::-1], dims=("k", "state"), coords={"state": list("zyx")}).T,
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_the_form_of_a_list_does_not_matter(wells, cloud, form):
    ds, plain = (cd.basins(wells, initial=one, **LENGTHS) for one in (form(cloud[:7]), cloud[:7]))
    xr.testing.assert_equal(ds, plain)


def test_order_and_company_do_not_matter(wells, cloud):
    ds, some = (cd.basins(wells, initial=rows, **LENGTHS) for rows in (cloud, cloud[30::-4]))
    np.testing.assert_allclose(sides(some), sides(ds)[30::-4], rtol=1e-12)


def test_modes_and_states_that_are_left_out(wells):
    ds = cd.basins(wells, initial=[{"mode": "off"}, {"x": -2.0}, {"y": 5.0}], **LENGTHS)
    np.testing.assert_allclose(sides(ds), [0.0, -1.0, 1.0], atol=1e-9)
    assert ds.cd.words("initial_mode").values.tolist() == ["off", "on", "on"]
    assert ds["initial_state"].values.tolist() == [[1.0, 0.1, 0.2], [-2.0, 0.1, 0.2], [1.0, 5.0, 0.2]]


def test_a_system_of_one_state():
    well = cd.HybridSystem(
        name="well", states="x", parameters={}, modes={"on": {"x": "x - x**3"}}, period="1", initial={"x": 0.5}
    )
    ds = cd.basins(well, initial=[-0.3, 2.0, 0.1], **LENGTHS)
    np.testing.assert_allclose(sides(ds), [-1.0, 1.0, 1.0], rtol=1e-9)
    assert cd.plot(ds).has_data()


def test_a_list_beside_a_grid_follows_its_cells(wells, tmp_path):
    grid = {"x": [-1.0, 0.5], "y": [0.0, 1.0, 2.0]}
    both, cells = cd.basins(wells, grid, initial=[{"z": 9.0}], **LENGTHS), cd.basins(wells, grid, **LENGTHS)
    np.testing.assert_array_equal(sides(both)[:6], sides(cells).ravel())
    assert both["initial_state"].values[[4, 6]].tolist() == [[0.5, 1.0, 0.2], [1.0, 0.1, 9.0]]
    assert cd.verify(cd.save(both, tmp_path / "both.nc")).equal


SCENE = """
[system]
model = "impact-oscillator"
[analysis.basins]
kind = "basins"
initial = {initial}
transient = 20
periods = 8
"""


@pytest.mark.parametrize("initial", ["[[0.0, 0.1], [0.2, 0.0]]", "[{ v = 0.1 }, { x = 0.2 }]"])
def test_a_scene_has_them(initial):
    found = cd.run(cd.parse_scene(SCENE.format(initial=initial)))["basins"]
    assert found["attractor"].dims == ("run",)
    assert found["initial_state"].values[1, 0] == 0.2


@pytest.mark.parametrize(
    ("initial", "told"),
    [
        ("[]", "initial: must not be empty"),
        ("[[0.0]]", "has 1 numbers; the system has the states x, v"),
        ("[[0.0, true]]", "a list of finite numbers"),
        ("[{ w = 1 }]", "unknown state"),
        ("[[0.0, 0.1], { x = 1.0 }]", "all as tables, or all as lists"),
        ("{ x = 1.0 }", "expected a list of initial states"),
    ],
)
def test_lists_of_a_scene_that_cannot_be(initial, told):
    with pytest.raises(SceneError, match=told):
        cd.parse_scene(SCENE.format(initial=initial))


@pytest.mark.parametrize(
    ("initial", "told"),
    [
        ([], r"initial is \[\]; it must be a list"),
        (3.0, "initial is 3.0"),
        (np.zeros((4, 2)), r"ndarray of shape \(4, 2\)"),
        ([[0.0, np.nan, 1.0]], "initial of run 1 has y = nan"),
        ([{"w": 1.0}], "names 'w', which is not a state"),
        ([{"mode": "onn"}], "run 1 has the mode 'onn'; did you mean 'on'"),
        ({"x": [1.0, 2.0], "y": [0.0]}, "columns of lengths"),
        (None, "grid: missing; give two states .* or a list"),
    ],
)
def test_lists_that_cannot_be(wells, initial, told):
    with pytest.raises(SettingsError, match=told):
        cd.basins(wells, initial=initial, **LENGTHS)


def test_its_picture_tells_the_attractors_apart(wells, cloud):
    ds = cd.basins(wells, initial=cloud, **LENGTHS)
    axes = cd.plot(ds, state=("x", "z"))
    points = {tuple(one.get_facecolor()[0]): one.get_offsets() for one in axes.collections if len(one.get_offsets())}
    assert sorted(np.unique(np.sign(xy[:, 0])).tolist() for xy in points.values()) == [[-1.0], [1.0]]
    with pytest.raises(SettingsError):
        cd.plot(ds.sel(run=3))


MU, PERIOD = 0.125, 2.0


def sledge(**initial):
    """A body that friction alone slows down to the speed of a belt; it is strobed twice before most of it slides."""
    return cd.filippov(
        name="sledge",
        states="x v",
        parameters={"mu": MU, "belt": 0.5},
        surface="v - belt",
        above={"x": "v", "v": "-mu"},
        below={"x": "v", "v": "mu"},
        period=str(PERIOD),
        initial=initial,
    )


def slowed(v, belt, time):
    """Its speed."""
    return belt + np.sign(v - belt) * np.maximum(np.abs(v - belt) - MU * time, 0)


SPEEDS = np.array([-2.0, 0.0, 0.5, 0.75, 3.0])


def test_a_start_that_names_no_mode_is_in_that_of_its_state():
    times = [1.0, 3.0]
    for given in ([{"v": v} for v in SPEEDS], np.array([[0.0, v] for v in SPEEDS])):
        runs = cd.trajectory(sledge(), times=times, initial=given)
        np.testing.assert_allclose(runs["states"].values[..., 1], [slowed(v, 0.5, np.array(times)) for v in SPEEDS])
        assert runs["initial_mode"].values.tolist() == [1, 1, 2, 0, 0]
    for v in SPEEDS:
        run = cd.trajectory(sledge().with_initial(v=v), times=times)
        np.testing.assert_allclose(run["states"].values[:, 1], slowed(v, 0.5, np.array(times)))
        run = cd.trajectory(sledge(v=0.5).with_parameters(belt=v), times=times)
        np.testing.assert_allclose(run["states"].values[:, 1], slowed(0.5, v, np.array(times)))


def test_every_point_of_a_sweep_starts_in_the_mode_of_its_state_there():
    drawn = {"count": 5, "seed": 1, "v": (-2, 3)}
    diagram = cd.bifurcation_diagram(
        sledge(),
        {"belt": SPEEDS},
        transient=0,
        periods=2,
        max_extension=0,
        seeds=[{"v": v} for v in SPEEDS],
        random=drawn,
    )
    starts = diagram["initial_state"].sel(state="v").values
    expected = slowed(starts[np.newaxis, :], SPEEDS[:, np.newaxis], PERIOD)
    np.testing.assert_allclose(diagram["section"].sel(state="v", iterate=0).values, expected, atol=1e-14)


def test_every_cell_of_a_basin_starts_in_the_mode_of_its_state():
    lengths = {"transient": 30, "periods": 4}
    basins = cd.basins(sledge(), {"x": [0.0, 1.0], "v": SPEEDS}, **lengths)
    assert (basins["attractor_state"].sel(state="v").values == 0.5).all()
    assert not (basins["outcome"] == cd.Outcome.INVALID_START).any()
    listed = cd.basins(sledge(), initial=[{"v": 3.0}, {"v": 0.0}, {"v": 0.0, "mode": "above"}], **lengths)
    assert listed["initial_mode"].values.tolist() == [0, 1, 0]
    assert (listed["outcome"] == cd.Outcome.INVALID_START).values.tolist() == [False, False, True]


def test_a_mode_that_is_named_stays():
    named = sledge(mode="above", v=2.0)
    assert named.with_initial(v=-2.0).initial["mode"] == named.with_parameters(belt=3.0).initial["mode"] == "above"
    with pytest.warns(cd.StartWarning):
        assert int(cd.trajectory(named.with_initial(v=-2.0), periods=1)["outcome"]) == cd.Outcome.INVALID_START


def test_an_archive_knows_the_modes_of_its_starts(tmp_path):
    ds = cd.bifurcation_diagram(sledge(), {"belt": SPEEDS}, transient=0, periods=2, max_extension=0)
    cd.save(ds, tmp_path / "sweep.nc")
    assert cd.verify(tmp_path / "sweep.nc").equal
    again = rerun(cd.open(tmp_path / "sweep.nc").to_dataset())
    np.testing.assert_allclose(again["section"].sel(iterate=0, state="v").values[:, 0], slowed(0, SPEEDS, PERIOD))
    cd.save_scene(tmp_path / "sledge.toml", sledge(), {"t": {"kind": "trajectory", "periods": 2}})
    read = cd.load_scene(tmp_path / "sledge.toml").system
    assert read.with_parameters(belt=-1.0).initial["mode"] == "above"
    assert read.with_parameters(belt=0.0).initial["mode"] == "sliding"

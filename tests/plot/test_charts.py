"""Pictures over a plane: charts, basins, and the cells that both are made of."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.text import Annotation

from chaosdrill.plots.categories import POSITIVE, UNRECOGNISED, Category, by_period
from chaosdrill.plots.charts import (
    attractor_count_chart,
    basins,
    isoperiodic_chart,
    lyapunov_chart,
    outcome_chart,
    progression_chart,
)
from chaosdrill.plots.palette import (
    ATTRACTOR_COLOURS,
    LONGER_COLOUR,
    OUTCOMES,
    PERIOD_COLOURS,
    diverging,
    sequential,
)
from chaosdrill.plots.pictures import PICTURES
from chaosdrill.plots.plane import bounds, draw_cells
from chaosdrill.plots.style import style

# Charts over two parameters: what each cell shows, what the legend says, and grids of every size.


CHARTS = [isoperiodic_chart, lyapunov_chart, progression_chart, attractor_count_chart, outcome_chart]


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def _colours(figure, panel=0):
    """Colours of the cells of a panel as hex, over p (up) and q (across), both ascending."""
    return [[to_hex(cell).upper() for cell in row] for row in figure.axes[panel].collections[0].get_array()]


def test_axes_are_named_by_the_archive_and_cells_have_their_true_bounds(chart):
    axes = isoperiodic_chart(chart.isel(seed=[0])).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("load", "p")
    mesh = axes.collections[0].get_coordinates()
    np.testing.assert_allclose(mesh[0, :, 0], [-0.1, 0.1, 0.35, 0.75, 1.25])
    np.testing.assert_allclose(mesh[:, 0, 1], [-0.5, 0.5, 1.5, 2.5, 3.5, 4.5])


def test_periods_and_what_there_is_instead(chart):
    figure = isoperiodic_chart(chart)
    assert [axes.get_title(loc="left") for axes in figure.axes[:2]] == ["seed 1", "seed 2"]
    one, two, three = PERIOD_COLOURS[:3]
    chaos, escaped = (OUTCOMES[name][0] for name in ("chaotic", "escaped"))
    own = [one, two, LONGER_COLOUR, chaos]
    assert _colours(figure)[:4] == [own] * 4
    assert _colours(figure, 1)[:4] == [own, *[[three] * 4] * 3]
    assert _colours(figure)[4][:3] == [escaped] * 3
    assert _legend(figure) == ["period 1", "period 2", "period 3", "period 12", "chaotic", "escaped", "stalled"]


def test_longer_periods_are_one_kind_with_their_range(chart):
    chart["period"][1, :2] = 24
    assert "periods 12 to 24" in _legend(isoperiodic_chart(chart))


def test_a_region_of_longer_periods_has_the_shortest_written_into_it():
    """Of several, with a sign for more; runs that ended without a period are told apart from cycles."""
    flags = {"flag_values": [0], "flag_meanings": "ok"}
    for last, text, short in ((20, "period 20", "20"), (24, "periods 20 to 24", "≥ 20")):
        points = xr.Dataset({"outcome": ("q", [0] * 4, flags), "period": ("q", [2, 20, last, 0])})
        index, found = by_period(points)
        named = ["period 2", text, "no period found"]
        assert ([one.name for one in found], index.tolist()) == (named, [0, 1, 1, 2])
        assert [one.short for one in found] == ["2", short, ""]


def test_a_cycle_whose_period_was_not_found_is_no_chaos(chart):
    chart["period"][0] = 0
    assert "period not found" in _legend(isoperiodic_chart(chart))


def test_seeds_have_their_names(chart):
    named = chart.assign_coords(seed=["fixed 1", "random 2"])
    figure = isoperiodic_chart(named)
    assert [axes.get_title(loc="left") for axes in figure.axes[:2]] == ["fixed 1", "random 2"]
    assert (figure.get_supxlabel(), figure.get_supylabel()) == ("load", "p")


def test_panels_say_where_their_seeds_start(chart):
    states = xr.DataArray([[0.5, -1.0, 0.0], [0.5, 0.25, 2.0]], dims=("seed", "state"))
    named = chart.assign(initial_state=states).assign_coords(seed=["fixed 1", "fixed 2"], state=["x", "y", "u"])
    figure = isoperiodic_chart(named)
    assert [axes.get_title(loc="left") for axes in figure.axes[:2]] == [
        "fixed 1: y = −1, u = 0",
        "fixed 2: y = 0.25, u = 2",
    ]


def test_more_seeds_than_find_room_are_counted(chart):
    figure = outcome_chart(xr.concat([chart.isel(seed=0, drop=True)] * 12, "seed"))
    assert figure.get_suptitle() == "seeds 1 to 9 of 12"
    assert len([axes for axes in figure.axes if axes.collections]) == 9


def test_the_sign_of_the_exponent_is_its_colour(chart):
    """0.4 is positive, -0.6, -0.4 and -0.1 are not; the scale's ends are the extremes."""
    row = _colours(lyapunov_chart(chart))[0]
    expected = [diverging()(share) for share in (0, 0.5 - 0.5 * 0.4 / 0.6, 0.5 - 0.5 * 0.1 / 0.6, 1.0)]
    np.testing.assert_allclose([to_rgb(c) for c in row], np.array(expected)[:, :3], atol=0.02)


def test_lost_exponents_and_missing_ones_stand_apart(chart):
    figure = lyapunov_chart(chart)
    assert _legend(figure) == ["escaped", "stalled", "−∞ (all directions lost at events)", "positive"]
    assert _colours(figure)[4] == [OUTCOMES["escaped"][0]] * 3 + ["#CC79A7"]
    assert len(set(_colours(figure)[3])) == 1
    assert figure.axes[-1].get_ylabel() == "largest Lyapunov exponent"


def test_an_exponent_that_is_zero_within_its_error_is_neither_positive_nor_a_scale(chart):
    exponents = chart["lyapunov_exponent"].copy(deep=True)
    flow = np.where(np.isfinite(exponents.values), 1e-9 * np.sign(exponents.values), exponents.values)
    noise = chart.assign(
        lyapunov_exponent=exponents.copy(data=flow), lyapunov_error=exponents.copy(data=np.full(flow.shape, 1e-9))
    )
    figure = lyapunov_chart(noise)
    assert "positive" not in _legend(figure)
    low, high = figure.axes[-1].get_ylim()
    assert low < -0.5 < 0.5 < high
    assert "positive" in _legend(lyapunov_chart(noise.drop_vars("lyapunov_error")))


def test_positive_exponents_are_hatched_for_those_who_see_no_colours(chart):
    """q = 1 for p = 0, 1, 2: three cells of 0.5 x 1."""
    hatched = [patch for patch in lyapunov_chart(chart).axes[0].patches if patch.get_hatch() == POSITIVE.hatch]
    corners = np.concatenate([patch.get_path().vertices.reshape(-1, 5, 2) for patch in hatched])
    assert np.prod(corners[:, 2] - corners[:, 0], axis=1).sum() == pytest.approx(3 * 0.5)
    # 0.4 is the largest of all, and its colour dark
    (shown,) = [patch for patch in hatched if len(patch.get_path().vertices)]
    assert to_hex(shown.get_edgecolor()) == "#ffffff"


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_exponents_of_one_sign_leave_zero_in_the_middle(chart, sign):
    chart["lyapunov_exponent"] = sign * np.abs(chart["lyapunov_exponent"])
    bar = lyapunov_chart(chart).axes[-1]
    low, high = bar.get_ylim()
    assert low < 0 < high
    assert low == pytest.approx(-high)


def test_few_extreme_exponents_do_not_set_the_scale(chart):
    many = xr.concat([chart.isel(p=[0])] * 200, "p").assign_coords(p=np.arange(200.0))
    many["lyapunov_exponent"][0, 0] = -1e6
    assert lyapunov_chart(many).axes[-1].get_ylim()[0] == pytest.approx(-0.6)


def test_few_extreme_rates_do_not_set_the_scale(chart):
    usual = chart.isel(p=[1])
    many = xr.concat([usual] * 600, "p").assign_coords(p=np.arange(600.0))
    many["progression_rate"][0, 0] = 1e6
    top = progression_chart(many).axes[-1].get_ylim()[1]
    assert top == np.nanmax(usual["progression_rate"])


def test_progression_is_dark_where_it_is_fast(chart):
    figure = progression_chart(chart)
    assert figure.axes[-1].get_ylabel() == "mean progression rate"
    ends = [to_hex(sequential()(share)).upper() for share in (0.0, 1.0)]
    colours = _colours(figure)
    assert [colours[0][3], colours[3][3]] == ends


def test_progression_in_si_units_where_there_is_one(chart):
    chart["progression_rate_si"] = 3 * chart["progression_rate"]
    chart["progression_rate_si"].attrs |= {"long_name": "mean progression rate", "units": "m h-1"}
    assert progression_chart(chart).axes[-1].get_ylabel() == "mean progression rate (m h⁻¹)"


def test_attractors_are_counted_over_all_seeds(chart):
    figure = attractor_count_chart(chart)
    assert len(figure.axes) == 1
    assert _legend(figure) == ["none", "1 attractor", "2 attractors"]


def test_more_attractors_than_shades(chart):
    chart["attractor_count"][:] = np.arange(20).reshape(4, 5)
    assert _legend(attractor_count_chart(chart))[-2:] == ["7 attractors", "8 or more attractors"]


def test_outcomes(chart):
    assert _legend(outcome_chart(chart)) == ["periodic", "chaotic", "escaped", "stalled"]


@pytest.mark.parametrize("draw", CHARTS)
@pytest.mark.parametrize("shape", [(1, 5), (4, 1), (1, 1), (2, 2)])
def test_grids_of_any_size(chart, draw, shape, tmp_path):
    small = chart.isel(q=slice(shape[0]), p=slice(shape[1]))
    figure = draw(small)
    figure.savefig(tmp_path / "a.png", dpi=40)
    assert figure.axes[0].collections[0].get_array().shape[:2] == shape[::-1]


def test_a_chart_in_which_nothing_ended_has_only_what_can_be_drawn(chart):
    lost = chart.assign(
        outcome=chart["outcome"] * 0 + 4,
        period=chart["period"] * 0,
        attractor_count=chart["attractor_count"] * 0,
        lyapunov_exponent=chart["lyapunov_exponent"] * np.nan,
        progression_rate=chart["progression_rate"] * np.nan,
    )
    lost["outcome"].attrs = chart["outcome"].attrs
    suitable = [picture for picture in PICTURES if picture.suits(lost)]
    assert [picture.name for picture in suitable] == ["isoperiodic-chart", "attractor-count-chart", "outcome-chart"]
    assert [_legend(picture.draw(lost)) for picture in suitable] == [["escaped"], ["none"], ["escaped"]]


@pytest.mark.parametrize("draw", [isoperiodic_chart, lyapunov_chart])
def test_more_cells_are_no_more_artists(chart, draw):
    """A cell costs its corners, however many there are; at random, no two neighbours are joined."""
    rng = np.random.default_rng(0)
    artists = []
    for size in (30, 120):
        grid = {"q": np.linspace(0, 1, size), "p": np.linspace(0, 1, size)}
        take = {name: xr.DataArray(rng.integers(0, chart.sizes[name], (size, size)), dims=("q", "p")) for name in grid}
        large = chart.isel(seed=[0]).isel(take).transpose("q", "p", ...).drop_vars(["q", "p"]).assign_coords(grid)
        axes = draw(large).axes[0]
        (mesh,) = (one for one in axes.collections if isinstance(one, QuadMesh))
        assert mesh.get_array().shape[:2] == (size, size)
        assert sum(len(patch.get_path().vertices) for patch in axes.patches) <= 5 * size**2
        artists.append(len(axes.get_children()))
    # what a colour means is written into its cells where it finds room
    assert artists[1] < 2 * artists[0]


@pytest.mark.parametrize(("cells", "least", "most"), [(50, 150, 150), (1000, 150, 300), (3000, 300, 300)])
def test_every_cell_has_a_dot_as_far_as_prints_show(chart, cells, least, most):
    wide = chart.isel(seed=[0], q=np.arange(cells) % 4).assign_coords(q=np.linspace(0, 1, cells))
    with style():
        figure = lyapunov_chart(wide)
    assert least <= figure.dpi <= most
    figure.draw_without_rendering()
    assert figure.axes[0].get_window_extent().width >= min(cells, 5 * most)


# Basins: a colour an attractor, a legend that says what each is, and attractors marked where they can be seen.


def _cells(figure):
    """Colours as hex, over v (up) and x (across)."""
    return np.array([[to_hex(cell).upper() for cell in row] for row in figure.axes[0].collections[0].get_array()])


def test_the_legend_says_what_each_attractor_is_and_its_part(basin):
    """Half of 19/20 each; sqrt(0.475 0.525 / 800) is 0.01766, and sqrt(0.05 0.95 / 800) is 0.0077."""
    assert _legend(basins(basin)) == [
        "1: period 2, λ₁ = −0.25; 48(2) %",
        "2: chaotic, λ₁ = 0.0151(4); 48(2) %",
        "escaped; 5.0(8) %",
        "points of attractors",
    ]


def test_cells_have_the_colour_of_their_attractor(basin):
    cells = _cells(basins(basin))
    assert (cells[:19, :20] == ATTRACTOR_COLOURS[0]).all()
    assert (cells[:19, 20:] == ATTRACTOR_COLOURS[1]).all()
    assert (cells[19] == OUTCOMES["escaped"][0]).all()


def test_axes_are_named_and_regions_numbered(basin):
    axes = basins(basin).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("height", "speed")
    texts = {text.get_text(): text.get_position()[0] for text in axes.texts}
    assert texts["1"] < 0 < texts["2"]


def test_only_points_in_the_plane_of_the_grid_are_marked(basin):
    axes = basins(basin).axes[0]
    (mark,) = axes.get_lines()
    assert [mark.get_xdata()[0], mark.get_ydata()[0]] == [-0.5, 0.5]
    assert mark.get_color() == ATTRACTOR_COLOURS[0]
    assert [text.get_text() for text in axes.texts if isinstance(text, Annotation)] == ["1"]


def test_points_outside_of_the_grid_are_not_marked(basin):
    axes = basins(basin.isel(x=slice(20, 40))).axes[0]
    assert not axes.get_lines()
    assert axes.get_xlim()[0] > -0.5


def test_a_run_that_ended_on_no_known_attractor_is_said(basin):
    basin["attractor"][:, 0] = 0
    figure = basins(basin)
    assert f"{UNRECOGNISED.name}; 5.0(8) %" in _legend(figure)
    assert (_cells(figure)[0] == UNRECOGNISED.colour).all()


def test_many_attractors_share_a_look_in_the_end(basin):
    """Twenty of them: twelve are named, and the rest is one kind."""
    table = {
        name: v for name, v in basin.variables.items() if "attractor_number" in v.dims and name != "attractor_number"
    }
    many = xr.Dataset(
        {name: xr.concat([basin[name].isel(attractor_number=0)] * 20, "attractor_number") for name in table}
    )
    many = many.assign_coords(attractor_number=np.arange(1, 21)).assign_attrs(basin.attrs)
    reached = basin["attractor"].copy(data=np.arange(800).reshape(40, 20) % 20 + 1)
    figure = basins(many.assign(attractor=reached, outcome=basin["outcome"], state=basin["state"]))
    names = _legend(figure)
    assert names[12] == "further attractors; 40(2) %"
    assert [name.split(":")[0] for name in names[:12]] == [str(n) for n in range(1, 13)]


@pytest.mark.parametrize("shape", [(1, 20), (40, 1), (2, 2)])
def test_grids_of_any_size_of_basins(basin, shape, tmp_path):
    figure = basins(basin.isel(x=slice(shape[0]), v=slice(shape[1])))
    figure.savefig(tmp_path / "a.png", dpi=40)
    assert _cells(figure).shape == shape[::-1]


def test_a_grid_on_which_everything_escapes(basin):
    lost = basin.isel(v=[19]).isel(attractor_number=slice(0))
    assert _legend(basins(lost)) == ["escaped; 100 %"]


def test_the_title_says_where_the_plane_is(basin):
    assert basins(basin).axes[0].get_title(loc="left") == "at w = 0.25"
    plane = basin.isel(state=[0, 1]).assign_attrs(initial='{"mode": "free", "x": 0.0, "v": 0.0}')
    figure = basins(plane)
    assert figure.axes[0].get_title(loc="left") == ""
    assert len(figure.axes[0].get_lines()) == 2, "in a plane of all states every attractor can be marked"


def test_the_progression_is_told_where_there_is_one(basin):
    basin["attractor_rate"] = ("attractor_number", [0.146, np.nan])
    first, second = _legend(basins(basin))[:2]
    assert first == "1: period 2, λ₁ = −0.25, progression 0.146; 48(2) %"
    assert "progression" not in second
    basin["attractor_rate_error"] = ("attractor_number", [0.002, np.nan])
    assert _legend(basins(basin))[0] == "1: period 2, λ₁ = −0.25, progression 0.146(2); 48(2) %"


# Cells have their true bounds on any grid, hatchings cover what they should, and names stand inside their regions.


PLAIN, HATCHED = Category("plain", "#FFFFFF", short="plain"), Category("hatched", "#009E73", "....", "h")


def test_bounds_are_half_way_between_neighbours_and_as_far_outside():
    np.testing.assert_allclose(bounds(np.array([0.0, 1.0, 4.0])), [-0.5, 0.5, 2.5, 5.5])


@pytest.mark.parametrize(("value", "expected"), [(2.0, [1.9, 2.1]), (-2.0, [-2.1, -1.9]), (0.0, [-0.5, 0.5])])
def test_a_value_alone_has_a_cell_around_it(value, expected):
    np.testing.assert_allclose(bounds(np.array([value])), expected)


def _drawn(kinds, x=None, y=None, **options):
    axes = Figure().subplots()
    x = np.arange(kinds.shape[1] + 1.0) if x is None else x
    y = np.arange(kinds.shape[0] + 1.0) if y is None else y
    draw_cells(axes, x, y, kinds, [PLAIN, HATCHED], (5.0, 4.0), **options)
    return axes


def _area(patch):
    """Of the rectangles of a path, each of five corners."""
    corners = patch.get_path().vertices.reshape(-1, 5, 2)
    return np.prod(corners[:, 2] - corners[:, 0], axis=1).sum()


def _hatched(axes):
    return next(patch for patch in axes.patches if isinstance(patch, PathPatch))


def test_the_mesh_has_the_bounds_and_the_colours_of_the_looks():
    x, y = np.array([0.0, 0.1, 2.0]), np.array([1.0, 5.0])
    mesh = _drawn(np.array([[0, 1]]), x, y).collections[0]
    np.testing.assert_array_equal(mesh.get_coordinates()[0, :, 0], x)
    np.testing.assert_array_equal(mesh.get_coordinates()[:, 0, 1], y)
    np.testing.assert_allclose(mesh.get_array()[0], [[1, 1, 1], [0, 0x9E / 255, 0x73 / 255]])
    assert mesh.get_rasterized()


def test_hatching_covers_exactly_the_cells_of_its_kind():
    rng = np.random.default_rng(3)
    kinds = rng.integers(0, 2, (12, 15))
    x, y = np.sort(rng.random(16)), np.sort(rng.random(13))
    cells = np.diff(y)[:, None] * np.diff(x)
    axes = _drawn(kinds, x, y)
    assert _area(_hatched(axes)) == pytest.approx(cells[kinds == 1].sum(), rel=1e-12)
    inside = _hatched(axes).get_path()
    centres = [((x[j] + x[j + 1]) / 2, (y[i] + y[i + 1]) / 2) for i in range(12) for j in range(15)]
    np.testing.assert_array_equal(inside.contains_points(centres), kinds.ravel() == 1)


def test_hatching_of_a_grid_finer_than_a_point_is_as_large():
    row, column = np.mgrid[0:1500, 0:1000]
    kinds = ((row - 750) ** 2 + (column - 500) ** 2 < 400**2).astype(int)
    patch = _hatched(_drawn(kinds))
    assert _area(patch) == pytest.approx(np.pi * 400**2, rel=5e-3)
    assert len(patch.get_path().vertices) < 5 * 300


def test_a_name_that_has_room_lies_in_its_region_whole():
    """Cells of a point: a strip with a bay in its middle, where there is most room around a name that it cuts."""
    kinds = np.ones((80, 160), dtype=int)
    kinds[:32] = 0
    kinds[11:45, 73:81] = 1
    axes, size = Figure().subplots(), (160 / 72, 80 / 72)
    draw_cells(axes, np.arange(161.0), np.arange(81.0), kinds, [replace(PLAIN, short="periodic"), HATCHED], size)
    x, y = next(text for text in axes.texts if text.get_text() == "periodic").get_position()
    # eight letters of five points or less, and eight points high
    assert (kinds[round(y - 4) : round(y + 4), round(x - 20) : round(x + 20)] == 0).all()


def test_names_stand_inside_their_regions_and_small_regions_have_none():
    """A disc and a speck of kind 1 in a sea of kind 0: the disc is named in its middle, the speck is not."""
    row, column = np.mgrid[0:100, 0:100]
    kinds = ((row - 40) ** 2 + (column - 60) ** 2 < 20**2).astype(int)
    kinds[90, 90] = 1
    texts = {text.get_text(): text.get_position() for text in _drawn(kinds).texts}
    assert set(texts) == {"plain", "h"}
    np.testing.assert_allclose(texts["h"], [60.5, 40.5], atol=2)
    x, y = texts["plain"]
    assert kinds[int(y), int(x)] == 0
    assert not _drawn(kinds, names=False).texts


def test_regions_apart_are_named_apart():
    kinds = np.zeros((60, 90), dtype=int)
    kinds[:, :40] = kinds[:, 50:] = 1
    axes = _drawn(kinds)
    where = sorted(text.get_position()[0] for text in axes.texts if text.get_text() == "h")
    np.testing.assert_allclose(where, [20, 70], atol=2)


def test_cells_with_a_colour_of_their_own_keep_it():
    shades = np.full((1, 2, 3), 0.25)
    mesh = _drawn(np.array([[-1, 1]]), colours=shades).collections[0]
    np.testing.assert_allclose(mesh.get_array()[0], [[0.25] * 3, [0, 0x9E / 255, 0x73 / 255]])

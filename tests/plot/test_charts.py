"""Charts over two parameters: what each cell shows, what the legend says, and grids of every size."""

import time

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex, to_rgb

from chaosdrill.plot.charts import (
    attractor_count_chart,
    isoperiodic_chart,
    lyapunov_chart,
    outcome_chart,
    progression_chart,
)
from chaosdrill.plot.looks import LONGER_COLOUR, PERIOD_COLOURS, POSITIVE, diverging, sequential
from chaosdrill.plot.pictures import PICTURES
from chaosdrill.plot.style import OUTCOME_COLOURS, style

CHARTS = [isoperiodic_chart, lyapunov_chart, progression_chart, attractor_count_chart, outcome_chart]


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def _colours(figure, panel=0):
    """Colours of the cells of a panel as hex, over p (up) and q (across), both ascending."""
    return [[to_hex(cell).upper() for cell in row] for row in figure.axes[panel].collections[0].get_array()]


def test_axes_are_named_by_the_archive_and_cells_have_their_true_bounds(chart):
    axes = isoperiodic_chart(chart.isel(seed=[0])).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("load q", "p")
    mesh = axes.collections[0].get_coordinates()
    np.testing.assert_allclose(mesh[0, :, 0], [-0.1, 0.1, 0.35, 0.75, 1.25])
    np.testing.assert_allclose(mesh[:, 0, 1], [-0.5, 0.5, 1.5, 2.5, 3.5, 4.5])


def test_periods_and_what_there_is_instead(chart):
    figure = isoperiodic_chart(chart)
    assert [axes.get_title() for axes in figure.axes[:2]] == ["seed 1", "seed 2"]
    one, two, three = PERIOD_COLOURS[:3]
    chaos, escaped = (OUTCOME_COLOURS[name] for name in ("chaotic", "escaped"))
    own = [one, two, LONGER_COLOUR, chaos]
    assert _colours(figure)[:4] == [own] * 4
    assert _colours(figure, 1)[:4] == [own, *[[three] * 4] * 3]
    assert _colours(figure)[4][:3] == [escaped] * 3
    assert _legend(figure) == ["period 1", "period 2", "period 3", "period 12", "chaotic", "escaped", "stalled"]


def test_longer_periods_are_one_kind_with_their_range(chart):
    chart["period"][1, :2] = 24
    assert "periods 12 to 24" in _legend(isoperiodic_chart(chart))


def test_a_cycle_whose_period_was_not_found_is_no_chaos(chart):
    chart["period"][0] = 0
    assert "period not found" in _legend(isoperiodic_chart(chart))


def test_seeds_have_their_names(chart):
    named = chart.assign_coords(seed_name=("seed", ["fixed 1", "random 2"]))
    figure = isoperiodic_chart(named)
    assert [axes.get_title() for axes in figure.axes[:2]] == ["fixed 1", "random 2"]
    assert (figure.get_supxlabel(), figure.get_supylabel()) == ("load q", "p")


def test_panels_say_where_their_seeds_start(chart):
    states = xr.DataArray([[0.5, -1.0, 0.0], [0.5, 0.25, 2.0]], dims=("seed", "state"))
    named = chart.assign(initial_state=states).assign_coords(
        seed_name=("seed", ["fixed 1", "fixed 2"]), state_name=("state", ["x", "y", "u"])
    )
    figure = isoperiodic_chart(named)
    assert [axes.get_title() for axes in figure.axes[:2]] == ["fixed 1: y = −1, u = 0", "fixed 2: y = 0.25, u = 2"]


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
    assert _colours(figure)[4] == [OUTCOME_COLOURS["escaped"]] * 3 + ["#CC79A7"]
    assert len(set(_colours(figure)[3])) == 1
    assert figure.axes[-1].get_ylabel() == "largest Lyapunov exponent"


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
def test_a_million_cells_take_seconds(chart, draw, tmp_path):
    """Of the worst kind: every cell is drawn at random, so that no two neighbours are joined."""
    rng = np.random.default_rng(0)
    grid = {"q": np.linspace(0, 1, 1000), "p": np.linspace(0, 1, 1000)}
    take = {name: xr.DataArray(rng.integers(0, chart.sizes[name], (1000, 1000)), dims=("q", "p")) for name in grid}
    large = chart.isel(seed=[0]).isel(take).transpose("q", "p", ...).drop_vars(["q", "p"]).assign_coords(grid)
    start = time.process_time()
    draw(large).savefig(tmp_path / "a.png", dpi=150)
    assert time.process_time() - start < 10


@pytest.mark.parametrize(("cells", "least", "most"), [(50, 150, 150), (1000, 150, 300), (5000, 300, 300)])
def test_every_cell_has_a_dot_as_far_as_prints_show(chart, cells, least, most):
    wide = chart.isel(seed=[0], q=np.arange(cells) % 4).assign_coords(q=np.linspace(0, 1, cells))
    with style():
        figure = lyapunov_chart(wide)
    assert least <= figure.dpi <= most
    figure.draw_without_rendering()
    assert figure.axes[0].get_window_extent().width >= min(cells, 5 * most)

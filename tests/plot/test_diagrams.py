"""Pictures over one axis: bifurcation diagrams, and error over time."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

import chaosdrill as cd
from chaosdrill.plots.accuracy import work_precision
from chaosdrill.plots.sections import bifurcation

# The diagram tells one, two and eight seeds apart, and says what it has no number for.


def _labels(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def _several(diagram, count, **coords):
    return xr.concat([diagram] * count, "seed").assign_coords(**coords)


def test_diagram_names_sweep_unit_lost_exponent_and_outcomes(diagram):
    figure = bifurcation(diagram)
    section, spectrum, rate, outcome = figure.axes
    assert outcome.get_xlabel() == "load (kN)"
    assert _labels(spectrum) == ["λ₁", "λ₂ = −∞"]
    assert _labels(outcome) == ["period 1", "period 2", "escaped"]
    assert rate.get_ylabel() == "mean\nprogression\nrate"
    assert section.get_xlim() == (0.0, 1.0)


def test_diagram_leaves_out_what_the_archive_has_not(diagram):
    assert len(bifurcation(diagram.drop_vars(["lyapunov_exponent", "progression_rate"])).axes) == 2


def test_points_without_a_result_are_counted_and_shaded(diagram):
    figure = bifurcation(diagram)
    assert _labels(figure.axes[0]) == ["no result: 1 of 101 points"]
    (shade,) = figure.axes[0].patches
    np.testing.assert_allclose([shade.get_x(), shade.get_x() + shade.get_width()], [0.695, 0.705])
    # circles, dots and stars would look like points of the section
    assert set(shade.get_hatch()) <= set("/\\|-")


def test_a_point_that_one_of_two_seeds_has_a_result_at_is_not_shaded(diagram):
    other = diagram.copy(deep=True)
    other["outcome"][70], other["section"][70] = 1, 0.5
    figure = bifurcation(xr.concat([diagram, other], "seed"))
    assert not figure.axes[0].patches


def test_a_section_that_is_never_reached_is_said(diagram):
    diagram["section"][20:30] = np.nan
    assert "section not reached: 10 of 101 points" in _labels(bifurcation(diagram).axes[0])


def test_shorter_records_of_a_section_keep_their_last_turn(diagram):
    """At an event there may be fewer points than asked for; the rest is missing."""
    diagram["section"][:, :, 3:] = np.nan
    cycles, _ = bifurcation(diagram).axes[0].get_lines()
    assert cycles.get_xdata().size == 51 + 2 * 49


def test_a_state_that_the_section_pins_is_passed_over(diagram):
    diagram["section"][..., 0] = diagram["section"][..., 0] * 0 + 0.3
    axes = bifurcation(diagram).axes[0]
    assert axes.get_ylabel() == "v"
    assert np.ptp(axes.get_lines()[0].get_ydata()) > 1


def test_a_value_that_no_line_reaches_is_a_dot(diagram):
    few = diagram.isel(q=[10, 20, 60, 90])
    few["period"][:, 0] = [1, 1, 2, 4]
    few["lyapunov_exponent"][:, 0, 0] = [-0.1, -0.2, -4.0, 8.0]
    panel = bifurcation(few).axes[1]
    (dots,) = (line for line in panel.get_lines() if line.get_marker() == "o")
    np.testing.assert_allclose(dots.get_xydata(), [[0.6, -4.0], [0.9, 8.0]])


def test_lost_exponents_are_marked_at_the_foot(diagram):
    exponents = diagram["lyapunov_exponent"].values
    exponents[..., 1] = -2.0
    exponents[10:14, :, 1] = -np.inf
    axes = bifurcation(diagram).axes[1]
    assert _labels(axes) == ["λ₁", "λ₂", "λ₂ = −∞ at 4 of 101 points"]
    marks = axes.get_lines()[-1]
    np.testing.assert_allclose(marks.get_xdata(), [0.10, 0.11, 0.12, 0.13])
    # heights are parts of the panel, so that the marks stand at its foot whatever the scale
    assert marks.get_ydata().max() < 0.2
    assert np.isfinite(axes.get_ylim()).all()


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_exponents_of_rounding_are_drawn_as_zero(diagram, unit):
    """One rounding a period is no growth, in any unit of time; a growth of 1e-6 a period is one."""
    diagram["forcing_period"] = 3.0 * unit
    diagram["lyapunov_exponent"] *= 2**-52 / unit
    low, high = bifurcation(diagram).axes[1].get_ylim()
    assert min(-low, high) * unit > 0.01
    diagram["lyapunov_exponent"] *= 2**32
    low, high = bifurcation(diagram).axes[1].get_ylim()
    assert (high - low) * unit < 1e-5


def test_a_power_of_ten_stands_beside_the_legend(diagram):
    diagram["lyapunov_exponent"] *= 1e-6
    figure = bifurcation(diagram)
    figure.draw_without_rendering()
    axes = figure.axes[1]
    power = axes.yaxis.get_offset_text()
    assert power.get_text()
    assert not power.get_window_extent().overlaps(axes.get_legend().get_window_extent())


def test_of_a_cycle_one_turn_is_drawn(diagram):
    """100 points of periods 1 (51 of them) and 2 (49), and nothing at the one that escaped."""
    cycles, clouds = bifurcation(diagram).axes[0].get_lines()
    assert cycles.get_xdata().size == 51 + 2 * 49
    assert clouds.get_xdata().size == 0


def test_seeds_are_told_apart_by_colour_and_size(diagram):
    section = bifurcation(_several(diagram, 2, seed=["forward", "backward"])).axes[0]
    assert _labels(section)[-2:] == ["forward", "backward"]
    drawn = [line for line in section.get_lines() if line.get_xdata().size > 10]
    assert len({to_hex(line.get_color()) for line in drawn}) == 2
    assert drawn[0].get_markersize() > 2 * drawn[1].get_markersize()


@pytest.mark.parametrize("count", [1, 2, 8])
def test_each_seed_has_a_row_of_its_own_and_its_name(diagram, count):
    rows = bifurcation(_several(diagram, count)).axes[-1]
    assert rows.collections[0].get_array().shape == (count, 101, 3)
    names = [f"seed {i + 1}" for i in range(count)] if count > 1 else []
    assert [text.get_text() for text in rows.get_yticklabels()] == names
    low, high = rows.get_ylim()
    assert low > high, "the first seed stands on top"


def test_very_many_seeds_share_a_strip(diagram, tmp_path):
    figure = bifurcation(_several(diagram, 200))
    assert figure.get_figheight() < 11
    assert figure.axes[-1].get_ylabel() == "200 seeds"
    figure.savefig(tmp_path / "a.png", dpi=40)


def test_values_in_any_order_are_drawn_in_theirs(diagram):
    shuffled = diagram.isel(q=np.random.default_rng(0).permutation(101))
    rate = bifurcation(shuffled).axes[2].get_lines()[0]
    assert (np.diff(rate.get_xdata()) > 0).all()


def test_lines_join_what_was_followed_and_nothing_else(diagram):
    followed = _several(diagram, 3, seed=["forward", "random 1", "random 2"])
    styles = [line.get_linestyle() for line in bifurcation(followed).axes[2].get_lines()]
    assert styles == ["-", "None", "None"]


def test_a_jump_that_takes_two_steps_is_no_line_and_a_dip_is_one(diagram):
    """-|q - 1/2| from 0.3 on is 0.6 lower, and half so at 0.3: two long steps; ln|q - 0.905| dips there."""
    q = diagram["q"].values
    values = diagram["lyapunov_exponent"].values.copy()
    values[:, 0, 0] = 0.02 * np.log(np.abs(q - 0.905)) - 0.5 * (q > 0.305) - 0.25 * (np.abs(q - 0.3) < 1e-6)
    values[:, 0, 1] = -np.inf
    diagram["outcome"][:], diagram["period"][:] = 1, np.where(q > 0.305, 2, 1)[:, None]
    diagram["lyapunov_exponent"] = diagram["lyapunov_exponent"].copy(data=values)
    line = next(line for line in bifurcation(diagram).axes[1].get_lines() if len(line.get_xdata()) > 50)
    x, y = line.get_data()
    assert np.nanmax(np.abs(np.diff(y))) < 0.05
    assert np.isnan(y).sum() == 2
    assert np.isfinite(y[np.abs(x - 0.9) < 0.05]).all()


def test_a_diagram_of_one_point_has_a_width(diagram):
    low, high = bifurcation(diagram.isel(q=[50])).axes[0].get_xlim()
    assert low < 0.5 < high


def test_the_caption_names_the_panels_that_are_drawn(diagram):
    assert bifurcation(diagram).get_label() == "section, exponents, progression and periods"
    assert bifurcation(diagram.drop_vars("progression_rate")).get_label() == "section, exponents and periods"


# The picture of a made-up table: one line a method, a panel a quantity, titles with the price of a digit.


FLAGS = {"flag_values": np.arange(8, dtype=np.int8), "flag_meanings": "ok a b c escaped e f nonfinite"}

QUANTITIES = ["strobe", "event_time", "tangent", "multiplier", "flow_direction", "exponent"]


@pytest.fixture
def table():
    """`series` pays 3 % a digit, `steps` twice the price; strobe and multipliers were measured."""
    tolerances = 10.0 ** -np.arange(4, 15, 2)
    digits = -np.log10(tolerances)
    error = np.full((6, 2, 6), np.nan)
    error[[0, 3]] = tolerances
    times = 1e-6 * np.array([10 * 1.03**digits, 50 * 2.0**digits])
    return xr.Dataset(
        {
            "error": (("quantity", "method", "tolerance"), error),
            "wall_time": (("method", "tolerance"), times),
            "horizon": (("method", "tolerance"), np.full((2, 6), np.nan)),
            "lyapunov_exponent": -0.1,
            "lyapunov_error": 0.0,
            "period": 1,
            "outcome": (("method", "tolerance"), np.zeros((2, 6), dtype=np.int8), FLAGS),
            "forcing_period": 2.0,
        },
        {"quantity": QUANTITIES, "method": ["series", "steps"], "tolerance": tolerances},
        {"kind": "work-precision", "system": "oscillator"},
    )


def texts(panel):
    return [text.get_text() for text in panel.texts]


def test_a_panel_a_quantity_with_the_price_of_a_digit(table):
    figure = work_precision(table)
    assert [panel.get_title(loc="left") or panel.get_title(loc="left") for panel in figure.axes] == [
        "Strobe point\neach digit: series +3 %, steps +100 %",
        "Multipliers\neach digit: series +3 %, steps +100 %",
    ]
    assert figure.axes[0].get_ylabel() == "time per forcing period (µs)"
    assert figure.get_suptitle().startswith("Cost of a digit: oscillator, on a cycle of period 1\n")


def test_one_legend_names_the_lines_and_the_ring_its_tolerance(table):
    figure = work_precision(table)
    panel = figure.axes[0]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["series", "steps"]
    assert "Points: tolerances 1e-4 to 1e-14." in figure.get_suptitle()
    (tolerance,) = texts(panel)
    assert tolerance in {f"1e-{n}" for n in range(4, 15, 2)}
    assert len({line.get_linestyle() for line in panel.lines[:2]}) == 2
    assert len({line.get_marker() for line in panel.lines[:2]}) == 2


def test_titles_of_many_methods_stay_over_their_panels(table):
    figure = work_precision(
        table.isel(method=[0, 1, 0, 1]).assign_coords(method=["series", "steps", "third", "fourth"])
    )
    figure.canvas.draw()
    left, right = (panel._left_title if panel.get_title(loc="left") else panel.title for panel in figure.axes[:2])
    assert left.get_window_extent().x1 < right.get_window_extent().x0


def test_points_stand_at_digits_and_microseconds(table):
    x, y = work_precision(table).axes[0].lines[0].get_data()
    np.testing.assert_allclose(x, [4, 6, 8, 10, 12, 14])
    np.testing.assert_allclose(y[0], 10 * 1.03**4)


def test_the_ring_is_at_the_cell_to_use(table):
    panel = work_precision(table).axes[1]
    ring = panel.lines[-1]
    x, y = ring.get_data()
    assert (ring.get_markersize(), x[0]) == (11, 10)
    np.testing.assert_allclose(y[0], 10 * 1.03**10)


def test_in_chaos_the_horizon_has_a_panel_and_the_statistical_error_a_shade(table):
    error = table["error"].values.copy()
    error[5], error[3] = error[3], np.nan
    chaos = table.assign(
        error=(("quantity", "method", "tolerance"), error),
        horizon=(("method", "tolerance"), np.arange(12.0).reshape(2, 6) * 20),
        lyapunov_exponent=0.02,
        lyapunov_error=1e-3,
        period=0,
    )
    strobe, exponent, horizon = work_precision(chaos).axes[:3]
    assert "lost in the statistical\nerror of the run" in texts(exponent)
    assert exponent.patches[0].get_x() == pytest.approx(3)
    assert horizon.get_xlabel() == "forcing periods within 1e-6 of the truth"
    np.testing.assert_allclose(horizon.lines[0].get_xdata(), np.arange(6) * 10)
    assert not strobe.patches


def test_a_cell_without_a_number_is_left_out(table):
    error = table["error"].values.copy()
    error[0, 0, 2] = np.nan
    error[0, 1, 0] = np.inf
    panel = work_precision(table.assign(error=(("quantity", "method", "tolerance"), error))).axes[0]
    assert [len(line.get_xdata()) for line in panel.lines[:2]] == [5, 5]


def test_a_method_without_a_result_is_named(table):
    codes = table["outcome"].copy()
    codes[0] = 7
    codes[1, 0] = 4
    assert (
        work_precision(table.assign(outcome=codes))
        .get_suptitle()
        .startswith("Cost of a digit: oscillator, on a cycle of period 1 (not measured: series, nonfinite)\n")
    )


def test_nothing_measured_is_said(table):
    figure = work_precision(table.assign(error=table["error"] * np.nan))
    assert texts(figure.axes[0]) == ["nothing could be measured; see outcome"]


def test_an_exponent_without_neighbours_is_a_dot():
    """At 2.5 the map rests, at 5 it escapes, at 4 it is chaotic and beside nothing."""
    logistic = cd.Map("x", {"r": 2.5}, ["r*x*(1 - x)"], initial={"x": 0.3})
    diagram = cd.bifurcation_diagram(logistic, {"r": [2.5, 5.0, 4.0, 6.0]}, transient=50, periods=128)
    lines = [line for line in bifurcation(diagram).axes[1].get_lines() if line.get_marker() == "o"]
    values = diagram["lyapunov_exponent"].values[[0, 2], 0, 0]
    np.testing.assert_allclose(lines[0].get_xydata(), np.column_stack([[2.5, 4.0], values]))

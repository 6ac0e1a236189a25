"""The picture of a made-up table: one line a method, a panel a quantity, titles with the price of a digit."""

import numpy as np
import pytest
import xarray as xr

from chaosdrill.plot.work_precision import work_precision

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
    assert [panel.get_title(loc="left") or panel.get_title() for panel in figure.axes] == [
        "Strobe point\neach digit: series +3 %, steps +100 %",
        "Multipliers\neach digit: series +3 %, steps +100 %",
    ]
    assert figure.axes[0].get_ylabel() == "time per forcing period (µs)"
    assert figure.get_suptitle().startswith("What a digit costs: oscillator, on a cycle of period 1\n")


def test_lines_are_named_and_points_carry_their_tolerance(table):
    panel = work_precision(table).axes[0]
    assert [text for text in texts(panel) if not text.startswith("1e")] == ["series", "steps"]
    assert texts(panel).count("1e-8") == 2
    assert len({line.get_linestyle() for line in panel.lines[:2]}) == 2
    assert len({line.get_marker() for line in panel.lines[:2]}) == 2


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
        .startswith("What a digit costs: oscillator, on a cycle of period 1 (not measured: series, nonfinite)\n")
    )


def test_nothing_measured_is_said(table):
    figure = work_precision(table.assign(error=table["error"] * np.nan))
    assert texts(figure.axes[0]) == ["nothing could be measured; see outcome"]

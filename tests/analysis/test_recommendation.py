"""What the advice says follows from the table, here one made up so that every number is known."""

import numpy as np
import pytest
import xarray as xr

from chaosdrill.analysis.precision.advice import best, cheapest, duration, recommend, shown_quantities

QUANTITIES = ["strobe", "event_time", "tangent", "multiplier", "flow_direction", "exponent"]
TOLERANCES = np.array([1e-4, 1e-8, 1e-12])


def table(**changes):
    """Multipliers only: `series` gains digits at 10, 13 and 20 us, `steps` at 5, 500 and 50000 us, one digit less."""
    error = np.full((6, 2, 3), np.nan)
    error[3, 0] = TOLERANCES
    error[3, 1] = 10 * TOLERANCES
    times = np.array([[10e-6, 13e-6, 20e-6], [5e-6, 500e-6, 0.05]])
    ds = xr.Dataset(
        {
            "error": (("quantity", "method", "tolerance"), error),
            "wall_time": (("method", "tolerance"), times),
            "horizon": (("method", "tolerance"), np.full((2, 3), np.nan)),
            "lyapunov_exponent": -0.1,
            "lyapunov_error": 0.0,
            "forcing_period": 2.0,
        },
        {"quantity": QUANTITIES, "method": ["series", "steps"], "tolerance": TOLERANCES},
    )
    return ds.assign(changes)


def test_the_cheapest_cell_that_reaches_the_digits():
    assert cheapest(table(), "multiplier", 3) == ("steps", 1e-4, 5e-6)
    assert cheapest(table(), "multiplier", 4) == ("series", 1e-4, 10e-6)
    assert cheapest(table(), "multiplier", 8) == ("series", 1e-8, 13e-6)
    assert cheapest(table(), "multiplier", 12.5) is None
    assert cheapest(table(), "exponent", 1) is None


def test_of_equal_prices_the_tightest_is_taken():
    times = np.array([[10e-6, 10.1e-6, 10.5e-6], [5e-6, 500e-6, 0.05]])
    assert cheapest(table(wall_time=(("method", "tolerance"), times)), "multiplier", 4) == ("series", 1e-12, 10.5e-6)


def test_a_cell_without_a_time_is_not_advised():
    times = table()["wall_time"].copy()
    times[0, 1] = np.nan
    assert cheapest(table(wall_time=times), "multiplier", 8) == ("series", 1e-12, 20e-6)


def test_advice_is_a_sentence():
    assert recommend(table()) == (
        "8 digits of the multipliers cost 1.3 times what 4 cost (12 digits 2 times); "
        "use series at 1e-08 (13 us a period)"
    )


def test_what_is_not_reached_is_said():
    error = np.maximum(table()["error"], 3e-6)
    assert best(table(error=error), "multiplier") == ("series", 1e-8, 3e-6)
    assert recommend(table(error=error)) == (
        "8 digits of the multipliers are not reached; the best is 5.5 (series at 1e-08)"
    )


def test_advice_without_errors_says_so():
    error = table()["error"] * np.nan
    assert recommend(table(error=error)) == "nothing could be measured; see outcome"


def test_infinite_errors_are_never_best():
    error = table()["error"].copy()
    error[3, 0] = np.inf
    assert best(table(error=error), "multiplier")[0] == "steps"


def chaotic():
    error = table()["error"].copy()
    error[5] = error[3]
    error[3] = np.nan
    horizon = [[20.0, 60.0, 120.0], [10.0, 50.0, 90.0]]
    return table(error=error, lyapunov_exponent=0.015, lyapunov_error=0.004, horizon=(("method", "tolerance"), horizon))


def test_statistical_error_and_horizon_are_told():
    lines = recommend(chaotic()).splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("8 digits of the leading exponent cost 1.3 times what 4 cost")
    assert "0.015 +- 0.004" in lines[1]
    # an error of 4e-4 is a tenth of the statistical one
    assert "series at 0.0001 is exact enough" in lines[1] or "steps at 0.0001 is exact enough" in lines[1]
    assert "for 60 periods at most (series at 1e-12)" in lines[2]


def test_on_a_cycle_the_multipliers_stand_for_tangents_and_exponents():
    error = table()["error"].copy()
    error[2], error[5] = error[3], error[3]
    assert shown_quantities(table(error=error)) == ["multiplier"]


@pytest.mark.parametrize(
    ("seconds", "text"), [(7.3e-6, "7.3 us"), (99.4e-6, "99 us"), (2.34e-4, "234 us"), (1.5e-3, "1.5 ms"), (3.0, "3 s")]
)
def test_durations_for_people(seconds, text):
    assert duration(seconds) == text

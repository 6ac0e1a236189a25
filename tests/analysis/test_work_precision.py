"""Errors of the methods on the drill's cycle at eta = 0.8, whose multipliers are known to 14 digits."""

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.dataset import Outcome

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)


@pytest.fixture(scope="module")
def measured():
    calls = []
    ds = cd.work_precision(
        cd.drill(eta=0.8),
        methods=["taylor"],
        tolerances=TOLERANCES,
        periods=64,
        transient=300,
        repeats=2,
        progress=lambda *call: calls.append(call),
    )
    return ds.assign_attrs(calls=calls)


@pytest.fixture(scope="module")
def fixed_steps():
    """Steps doubled thrice, the bisection of event times at round-off."""
    return cd.work_precision(
        cd.drill(eta=0.8),
        methods=["rk4"],
        tolerances=[4e-15, 3e-15, 2e-15, 1e-15],
        steps=[200, 400, 800, 1600],
        periods=64,
        transient=300,
        repeats=1,
    )


def test_the_start_is_the_strobe_point_of_the_cycle(measured):
    assert int(measured["period"]) == 1
    expected = [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]
    np.testing.assert_allclose(measured["start"], expected, rtol=1e-15)
    modulus = np.hypot(0.11672896840556, 0.65713468420972)
    assert float(measured["lyapunov_exponent"]) == pytest.approx(np.log(modulus) * 0.8 / (2 * np.pi), rel=1e-13)
    assert float(measured["lyapunov_error"]) == 0


@pytest.mark.parametrize("quantity", ["strobe", "event_time", "tangent", "multiplier", "flow_direction"])
def test_error_follows_tolerance(measured, quantity):
    """From 1e-4 to 1e-14: at most 100 times as large, and not from round-off alone."""
    ratio = measured["error"].sel(quantity=quantity).values[0] / np.array(TOLERANCES)
    assert np.all(ratio < 100)
    assert np.all(ratio > 1e-4)


def test_the_truth_is_known_better_than_doubles(measured):
    errors = measured["reference_error"].sel(quantity=["strobe", "event_time", "tangent", "multiplier"])
    assert np.all(errors < 1e-21)


def test_eight_digits_of_the_multipliers_at_1e10(measured):
    cell = {"quantity": "multiplier", "method": "taylor", "tolerance": 1e-10}
    assert float(measured["error"].sel(cell)) < 1e-8


@pytest.mark.parametrize("quantity", ["strobe", "tangent", "multiplier", "flow_direction"])
def test_fixed_steps_have_order_four(fixed_steps, quantity):
    error = fixed_steps["error"].sel(quantity=quantity).values[0]
    orders = np.log2(error[:-1] / error[1:])
    assert np.all(np.abs(orders - 4) < 0.35), orders


def test_work_is_counted(measured, fixed_steps):
    """A step ends at each of the three events of a period; a further one ends nowhere else."""
    assert np.all(np.abs(fixed_steps["steps"].values[0] - [203, 403, 803, 1603]) <= 1)
    assert fixed_steps["steps_per_period"].values.tolist() == [[200, 400, 800, 1600]]
    assert np.all(fixed_steps["evaluations"] >= 4 * fixed_steps["steps"] - 1e-9)
    assert measured["steps_per_period"].values.tolist() == [[0] * 6]
    assert np.all(measured["steps"] >= 4)
    assert np.all(measured["evaluations"] > 5 * measured["steps"])


def test_eight_more_digits_cost_less_than_two_and_a_half_times(measured):
    """From 1e-6 to 1e-14, in evaluations, which no other work on the machine disturbs."""
    work = measured["evaluations"].values[0]
    assert work[5] < 2.5 * work[1]


def test_times_are_positive_and_more_steps_take_more_evaluations(measured, fixed_steps):
    assert np.all(measured["wall_time"] > 0)
    assert np.all(measured["wall_time_spread"] >= 0)
    evaluations = fixed_steps["evaluations"].values[0]
    assert evaluations[3] > 3 * evaluations[0]


def test_every_cell_came_to_its_end(measured, fixed_steps):
    assert np.all(measured["outcome"] == Outcome.OK)
    assert np.all(fixed_steps["outcome"] == Outcome.OK)
    assert np.isnan(measured["horizon"]).all()


def test_progress_ends_at_its_total(measured):
    calls = measured.attrs["calls"]
    assert [done for done, _, _ in calls] == list(range(1, 1 + 1 + len(TOLERANCES) + 2))
    assert {total for _, total, _ in calls} == {len(calls)}


def test_advice_names_the_multipliers(measured):
    lines = measured.attrs["recommendation"].splitlines()
    assert any("the multipliers" in line and " cost " in line and "use taylor at 1e-" in line for line in lines)
    assert not any("exponent" in line or "tangent map" in line for line in lines)


def on_a_cycle(unit):
    """A cycle of one period whose multipliers are complex: what a tangent has grown depends on where it turns from."""
    duffing = cd.HybridSystem(
        name="duffing",
        states="x v",
        parameters={"d": 0.1, "X": 1.0, "V": 1.0, "A": 0.05},
        modes={"on": {"x": "X*v/V", "v": "V*(x/X - (x/X)**3 - d*v/V + A*cos(t))"}},
        period="2*pi",
        bounds={"x": None, "v": None},
    )
    return cd.work_precision(
        duffing.with_parameters(X=unit, V=1 / unit).with_initial(x=unit),
        methods=["taylor", "rk4"],
        tolerances=[1e-4, 1e-8],
        periods=8,
        transient=100,
        repeats=1,
    )


@pytest.fixture(scope="module")
def usual():
    return on_a_cycle(1.0)


@pytest.mark.parametrize("unit", [2.0**-40, 2.0**30])
def test_errors_on_a_cycle_do_not_depend_on_units(usual, unit):
    """Powers of two leave every digit as it is."""
    other = on_a_cycle(unit)
    xr.testing.assert_allclose(usual["error"], other["error"], rtol=1e-6, atol=1e-12)
    assert usual["period"] == other["period"] > 0

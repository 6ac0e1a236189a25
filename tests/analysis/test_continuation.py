"""Branches start where the system is, and say what happens on them; a start without an orbit is a result."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset import BranchEnd, Outcome, Special

DOUBLING = 2.65334772785532


@pytest.fixture(scope="module")
def branch():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6})
    return cd.continue_orbit(system, {"omega": (2.55, 2.7)}, doublings=1)


def test_a_period_doubling_and_the_doubled_branch(branch):
    (kind,), (value,) = branch["special_kind"].values, branch["special_value"].values
    assert kind == Special.PERIOD_DOUBLING
    assert value == pytest.approx(DOUBLING, abs=1e-9)
    assert branch["branch_parent"].values.tolist() == [-1, 0]
    assert branch["branch_period"].values.tolist() == [1, 2]


@pytest.mark.parametrize("tolerance", [1e-10, 1e-8, 1e-6, 1e-5])
def test_a_branch_at_a_loose_tolerance_ends_where_it_should(tolerance):
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6})
    loose = cd.continue_orbit(system, {"omega": (2.55, 2.7)}, tolerance=tolerance)
    assert (loose["branch_end"].item(), loose["special_kind"].item()) == (BranchEnd.LIMIT, Special.PERIOD_DOUBLING)
    assert loose["special_value"].item() == pytest.approx(DOUBLING, abs=10 * tolerance)


def test_stable_on_this_side_of_the_doubling_only(branch):
    first = branch["branch"].values == 0
    before = branch["omega"].values[first] < DOUBLING - 1e-6
    beyond = branch["omega"].values[first] > DOUBLING + 1e-6
    stable = branch["stable"].values[first]
    assert stable[before].all()
    assert not stable[beyond].any()
    assert before.sum() > 20 < beyond.sum()


def test_a_branch_reaches_both_limits(branch):
    swept = branch["omega"].values
    assert swept.min() == pytest.approx(2.55, abs=1e-12)
    assert swept.max() == pytest.approx(2.7, abs=1e-12)
    assert branch["branch_end"].values.tolist() == [BranchEnd.LIMIT, BranchEnd.LIMIT]


def test_no_step_is_longer_than_asked_for():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6})
    fine = cd.continue_orbit(system, {"omega": (2.59, 2.61)}, step=1e-3)
    assert np.abs(np.diff(fine["omega"].values)).max() <= 1e-3 * (1 + 1e-9)


def test_multipliers_have_the_closed_form_all_along(branch):
    one = branch.isel(point=branch["branch"].values == 0)
    omega, r = one["omega"].values, 0.8
    c = np.cos(2 * np.pi / omega)
    trace = -2 * r * c + (1 + r) ** 2 * (1 - omega**2) * (1 + c) / 2
    np.testing.assert_allclose(one["multiplier_real"].values.sum(axis=1), trace, atol=1e-10)


def test_sections_are_filled_up_to_the_longest_period(branch):
    doubled = branch["period"].values == 2
    assert np.isnan(branch["section"].values[~doubled, 1]).all()
    assert np.isfinite(branch["section"].values[doubled]).all()


def test_a_parameter_that_does_nothing():
    x, v, t = sympy.symbols("x v t", real=True)
    system = cd.HybridSystem(
        name="deaf",
        states=(x, v),
        time=t,
        parameters={"idle": 1.0},
        modes={"free": {x: v, v: -x - v / 5 + sympy.cos(2 * t)}},
        period=sympy.pi,
    )
    ds = cd.continue_orbit(system, {"idle": (0.5, 2.0)})
    assert ds["branch_end"].values.tolist() == [BranchEnd.NO_EFFECT]
    assert ds["branch_end_text"].item().endswith(".")


def test_no_orbit_to_start_from_is_told():
    x = sympy.Symbol("x", real=True)
    system = cd.HybridSystem(
        name="away",
        states=(x,),
        parameters={"rate": 1.0},
        modes={"only": {x: sympy.Symbol("rate", real=True) * x}},
        period=sympy.Integer(1),
        initial={x: 1.0},
        bounds={x: (-10, 10)},
    )
    ds = cd.continue_orbit(system, {"rate": (0.5, 2.0)})
    assert Outcome(int(ds["outcome"])) == Outcome.ESCAPED
    assert ds.sizes["point"] == ds.sizes["branch_number"] == 0
    assert ds.attrs["message"]


def test_few_points_are_told():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6})
    ds = cd.continue_orbit(system, {"omega": (2.55, 2.65)}, max_points=5)
    assert ds["branch_end"].values.tolist() == [BranchEnd.MOST_POINTS]


def test_the_curve_of_period_doublings_has_its_closed_form():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6})
    ds = cd.continue_orbit(system, {"omega": (2.55, 2.8), "e": (0.7, 0.9)}, follow="period_doubling", step=0.01)
    omega, r = ds["omega"].values, ds["e"].values
    c = np.cos(2 * np.pi / omega)
    trace = -2 * r * c + (1 + r) ** 2 * (1 - omega**2) * (1 + c) / 2
    # at a multiplier of -1 the trace is -(1 + determinant)
    np.testing.assert_allclose(trace, -(1 + r**2), atol=1e-9)
    assert r.min() == pytest.approx(0.7, abs=1e-12)
    assert ds["special_value_2"].values.tolist() == pytest.approx([0.8], abs=1e-12)


def test_no_point_to_follow_is_told():
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.6})
    ds = cd.continue_orbit(system, {"omega": (2.59, 2.61), "e": (0.7, 0.9)}, follow="grazing")
    assert Outcome(int(ds["outcome"])) == Outcome.NO_SPECIAL_POINT
    assert "no grazing on the branch of omega" in ds.attrs["message"]
    assert ds.sizes["point"] == 0

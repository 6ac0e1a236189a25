"""An orbit that is found has its closed form; a start that leads to none gets an outcome in words and no numbers."""

from math import cos, pi

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.dataset import Outcome

R = 0.8


def oscillator(w, **start):
    return cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": w, "e": R}, initial=start)


def outcome(ds):
    return Outcome(int(ds["outcome"]))


def has_no_numbers(ds):
    named = ("orbit_state", "residual", "period_time", "multiplier_real", "lyapunov_exponent")
    return int(ds["period"]) == 0 and all(np.isnan(ds[name].values).all() for name in named)


def closed_trace(w):
    return -2 * R * cos(2 * pi / w) + (1 + R) ** 2 * (1 - w**2) * (1 + cos(2 * pi / w)) / 2


@pytest.mark.parametrize("w", [2.6, 2.7])
def test_trace_and_determinant_stable_or_not(w):
    # no run stays on the orbit of 2.7, which is unstable: it is looked for from that of 2.6
    start = cd.periodic_orbit(oscillator(2.6))["orbit_state"].values
    ds = cd.periodic_orbit(oscillator(w, x=start[0], v=start[1]), start="guess")
    assert outcome(ds) == Outcome.PERIODIC
    assert bool(ds["stable"]) == (w < 2.65334)
    values = ds["multiplier_real"].values + 1j * ds["multiplier_imag"].values
    assert values.sum().real == pytest.approx(closed_trace(w), abs=1e-11)
    assert np.prod(values).real == pytest.approx(R**2, abs=1e-11)
    assert float(ds["residual"]) < 1e-12
    assert bool(ds["consistent"])


def test_newton_squares_its_residual():
    ds = cd.periodic_orbit(oscillator(2.6, x=-0.7, v=0.05), start="guess")
    residuals = ds["newton_residual"].values
    assert outcome(ds) == Outcome.PERIODIC
    inside = [k for k in range(len(residuals) - 1) if 1e-7 < residuals[k] < 1e-1]
    assert inside
    assert all(residuals[k + 1] < 50 * residuals[k] ** 2 + 1e-14 for k in inside), residuals


def test_a_multiple_of_the_period_is_told():
    ds = cd.periodic_orbit(oscillator(2.6), period=3)
    assert int(ds["period"]) == ds.sizes["iterate"] == 1
    assert ds.attrs["message"] == "its period is 1, not 3"


def test_rank_that_is_lost_is_exactly_zero():
    system = cd.drill(friction="stribeck", contact="hunt-crossley", eta=0.8, xi=0.06)
    ds = cd.periodic_orbit(system)
    assert int(ds["rank"]) == 2
    assert ds["multiplier_real"].values[2] == ds["multiplier_imag"].values[2] == 0.0
    # quadruple precision, another program
    np.testing.assert_allclose(ds["multiplier_real"].values[:2], 0.11672896840556, atol=1e-10)
    np.testing.assert_allclose(np.abs(ds["multiplier_imag"].values[:2]), 0.65713468420972, atol=1e-10)
    expected = [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]
    np.testing.assert_allclose(ds["orbit_state"].values, expected, atol=1e-12)


def test_events_stand_in_their_order():
    ds = cd.periodic_orbit(cd.drill(friction="stribeck", contact="hunt-crossley", eta=0.8, xi=0.06))
    times = ds["event_time"].values
    assert int(ds["event_count"]) == ds.sizes["event"] == 3
    assert (np.diff(times) > 0).all()
    assert 0 <= times[0] <= times[-1] < float(ds["period_time"])
    assert float(ds["smallest_speed"]) == np.abs(ds["event_speed"].values).min()


def test_period_counts_the_events_of_its_section():
    """The orbit that fires once takes about twice the time of the returns that it was looked for from."""
    ds = cd.periodic_orbit(cd.build("izhikevich", {"c": -50.0, "d": 2.0}), at="spike")
    assert int(ds["period"]) == int(ds["event_count"]) == 1


def test_the_section_does_not_change_the_orbit():
    """Half a return after one event of a symmetric orbit is the other one."""
    modes = {
        "on": {"x": "v", "v": "-k*x - c*v + z", "z": "(1 - z)/2"},
        "off": {"x": "v", "v": "-k*x - c*v + z", "z": "(-1 - z)/2"},
    }
    relay = cd.HybridSystem(
        name="relay",
        states="x v z",
        parameters={"c": 0.6, "s": 0.2, "k": 0.6},
        modes=modes,
        transitions=[
            cd.Transition("down", "on", "off", "x - s", direction=+1),
            cd.Transition("up", "off", "on", "x + s", direction=-1),
        ],
        initial={"v": 0.3},
    )
    unnamed = cd.periodic_orbit(relay, transient=60)
    assert int(unnamed["event_count"]) == 2
    for at in ("down", "up", "x > 0", "v < 0.1", "z > 0"):
        ds = cd.periodic_orbit(relay, at=at, transient=60)
        assert int(ds["period"]) == 1, (at, ds.attrs["message"])
        assert float(ds["period_time"]) == pytest.approx(float(unnamed["period_time"]), rel=1e-12)
        for name in ("multiplier_real", "multiplier_imag"):
            np.testing.assert_allclose(ds[name], unnamed[name], rtol=0, atol=1e-11)


def test_a_point_at_rest_is_no_orbit():
    x, v, t = sympy.symbols("x v t", real=True)
    damped = cd.HybridSystem(
        name="damped",
        states=(x, v),
        time=t,
        parameters={},
        modes={"free": {x: v, v: -x - v / 2}},
        period=sympy.Integer(1),
        initial={x: 1.0},
    )
    ds = cd.periodic_orbit(damped)
    assert outcome(ds) == Outcome.EQUILIBRIUM
    assert has_no_numbers(ds)
    assert ds.attrs["message"]


def test_a_run_away_is_told():
    x = sympy.Symbol("x", real=True)
    system = cd.HybridSystem(
        name="away",
        states=(x,),
        parameters={},
        modes={"only": {x: x}},
        period=sympy.Integer(1),
        initial={x: 1.0},
        bounds={x: (-10, 10)},
    )
    ds = cd.periodic_orbit(system)
    assert outcome(ds) == Outcome.ESCAPED
    assert has_no_numbers(ds)


@pytest.mark.parametrize("start", ["attractor", "guess"])
def test_a_state_that_only_grows_is_told(start):
    x, t = sympy.symbols("x t", real=True)
    system = cd.HybridSystem(
        name="onwards",
        states=(x,),
        time=t,
        parameters={},
        modes={"only": {x: 3 + 1 / (1 + x**2) + sympy.cos(t)}},
        period=2 * sympy.pi,
    )
    ds = cd.periodic_orbit(system, start=start)
    assert outcome(ds) == Outcome.OPEN
    assert has_no_numbers(ds)
    assert "x changes by" in ds.attrs["message"]


@pytest.mark.parametrize("period", [1, 3])
def test_an_irrational_rotation_has_no_orbit(period):
    x = sympy.Symbol("x", real=True)
    system = cd.HybridSystem(
        name="hand of a clock",
        states=(x,),
        parameters={},
        modes={"turn": {x: sympy.Integer(1)}},
        transitions=[cd.Transition("round", "turn", "turn", guard=x - 1, direction=+1, reset={x: 0})],
        period=sympy.sqrt(2) / 2,
        initial={x: 0.25},
    )
    ds = cd.periodic_orbit(system, period=period)
    assert outcome(ds) == Outcome.NO_ORBIT
    assert has_no_numbers(ds)
    assert "Newton's method" in ds.attrs["message"]


def test_an_orbit_of_a_system_without_forcing():
    wheel = cd.build("rimless-wheel")
    ds = cd.periodic_orbit(wheel)
    assert outcome(ds) == Outcome.PERIODIC
    assert "forcing_period" not in ds
    expected = [1.0, cos(2 * wheel.parameters["alpha"]) ** 2]
    np.testing.assert_allclose(ds["multiplier_real"].values, expected, atol=1e-10)
    assert bool(ds["stable"])


def test_a_search_finds_what_attracts_and_what_does_not():
    w = 2.7
    ds = cd.periodic_orbit(oscillator(w, x=-0.5), start="search", max_period=2)
    assert ds["period"].dims == ("orbit",)
    assert ds["period"].values.tolist() == [1, 2]
    assert ds["stable"].values.tolist() == [0, 1]
    assert ds["multiplier_real"].values[0].sum() == pytest.approx(closed_trace(w), abs=1e-10)
    assert np.isnan(ds["section"].values[0, 1]).all()
    assert ds.attrs["message"] == ""


def test_a_search_that_finds_nothing_says_so():
    x = sympy.Symbol("x", real=True)
    system = cd.HybridSystem(
        name="away",
        states=(x,),
        parameters={},
        modes={"only": {x: 1 + x**2 / 100}},
        period=sympy.Integer(1),
        initial={x: 1.0},
        bounds={x: (-10, 10)},
    )
    ds = cd.periodic_orbit(system, start="search", max_period=2)
    assert ds.sizes["orbit"] == 0
    assert "no orbit of a period up to 2 was found" in ds.attrs["message"]

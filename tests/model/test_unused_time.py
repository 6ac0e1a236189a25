"""A symbol for time that nothing uses changes no result, to the bit; nor do the helpers that give every system one."""

import numpy as np
import pytest

import chaosdrill as cd

OSCILLATOR = {
    "states": "x v",
    "parameters": {"mu": 1.0, "k": 1.0},
    "modes": {"flow": {"x": "v", "v": "mu*(1 - x**2)*v - k*x"}},
    "quadratures": {"work": "v**2"},
    "initial": {"x": 1.0},
}
WELLS = {
    "states": "x v",
    "parameters": {"c": 0.25},
    "modes": {"flow": {"x": "v", "v": "x - x**3 - c*v"}},
    "initial": {"x": 1.5, "v": 0.5},
}
BALL = {
    "states": "x v",
    "parameters": {"e": 0.6},
    "modes": {"free": {"x": "v", "v": "-x - x**3"}},
    "transitions": [cd.Transition("hit", "free", "free", "x", -1, {"v": "-e*v + 0.5"})],
    "initial": {"x": 1.0},
}
BELT = {
    "name": "belt",
    "states": "x v",
    "parameters": {"belt": 0.3, "hold": 1.0, "fall": 0.4},
    "surface": "v - belt",
    "above": {"x": "v", "v": "-x - hold + fall*(v - belt)"},
    "below": {"x": "v", "v": "-x + hold + fall*(v - belt)"},
    "initial": {"x": 0.5},
}
CALLS = {
    "spectrum": lambda time: cd.lyapunov_spectrum(cd.HybridSystem(**OSCILLATOR, **time), duration=60, transient=20),
    "spectrum of a rest": lambda time: cd.lyapunov_spectrum(cd.HybridSystem(**WELLS, **time), duration=200),
    "section": lambda time: cd.poincare_section(
        cd.HybridSystem(**OSCILLATOR, **time), at="x > 0", transient=20, periods=8
    ),
    "diagram": lambda time: cd.bifurcation_diagram(
        cd.HybridSystem(**OSCILLATOR, **time), {"mu": [0.5, 1.0]}, at="x > 0", transient=10, periods=32, exponents=2
    ),
    "chart": lambda time: cd.parameter_chart(
        cd.HybridSystem(**OSCILLATOR, **time), {"mu": [0.5, 1.0], "k": [1.0, 2.0]}, duration=60, transient=30
    ),
    "basins": lambda time: cd.basins(
        cd.HybridSystem(**WELLS, **time),
        {"x": np.linspace(-2, 2, 4), "v": np.linspace(-1.5, 1.5, 4)},
        transient=150,
        duration=60,
    ),
    "no return": lambda time: cd.poincare_section(
        cd.HybridSystem(**WELLS, **time).with_initial(x=0.5), at="x < 0", max_return=200.0, periods=2
    ),
    "orbit": lambda time: cd.periodic_orbit(cd.HybridSystem(**OSCILLATOR, **time), start="attractor", transient=30),
    "impacts": lambda time: cd.periodic_orbit(
        cd.HybridSystem(**BALL, **time), at="hit", start="attractor", transient=30
    ),
    "precision": lambda time: cd.work_precision(
        cd.HybridSystem(**BALL, **time), duration=0.25, methods=["dop853"], tolerances=[1e-8], repeats=1
    )[["error", "reference_error", "outcome"]],
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_an_unused_symbol_changes_no_bit(call):
    without, *others = (call(time) for time in ({}, {"time": "t"}, {"time": "tau"}))
    for other in others:
        assert set(other.variables) == set(without.variables)
        for name, variable in without.variables.items():
            np.testing.assert_array_equal(other[name].values, variable.values, err_msg=name)


def test_the_wells_are_two_attractors_at_rest():
    found = CALLS["basins"]({"time": "t"})
    assert found.sizes["attractor_number"] == 2
    assert set(found["outcome"].values.ravel()) == {int(cd.Outcome.EQUILIBRIUM)}


@pytest.mark.parametrize("initial", [{"x": 0.5}, {"x": -0.2, "v": 0.1}])
def test_a_belt_made_of_two_fields_has_multipliers(initial):
    found = cd.poincare_section(cd.filippov(**{**BELT, "initial": initial}), at="slide", transient=8, periods=8)
    assert int(found["period"]) == 1
    # along the flow, and none: sliding loses a direction
    np.testing.assert_allclose(found["multiplier_real"].values, [1.0, 0.0], atol=1e-9)
    np.testing.assert_array_equal(found["multiplier_imag"].values, [0.0, 0.0])


def test_made_systems_are_forced_where_time_is_named_alone():
    field = {"x": "v", "v": "-Abs(x) + a*cos(t)"}
    given = {"name": "kink", "states": "x v", "parameters": {"a": 0.5}}
    assert cd.filippov(**BELT).autonomous
    assert not cd.in_modes(**given, field=field).autonomous
    assert cd.in_modes(**given, field={**field, "v": "-Abs(x) - a*v"}).autonomous
    plain = cd.HybridSystem(states="x", parameters={"d": 1.0}, modes={"flow": {"x": "d - x"}})
    assert plain.autonomous
    assert not cd.driven(plain, "d", "square", period=2.0).autonomous


@pytest.mark.parametrize(
    "change",
    [
        {"modes": {"free": {"x": "v", "v": "-x + sin(t)"}}},
        {"transitions": [cd.Transition("hit", "free", "free", "x - sin(t)", -1, {"v": "-v"})]},
        {"transitions": [cd.Transition("hit", "free", "free", "x", -1, {"v": "-v*sin(t)**2"})]},
        {"transitions": [cd.Transition("hit", "free", "free", "x", -1, {"v": "-v"}, "sin(t) > 0")]},
        {"modes": {"free": lambda t, x, p: (x.v, -x.x + t)}},
    ],
    ids=["rate", "guard", "reset", "condition", "function"],
)
def test_what_moves_by_time_is_forced(change):
    assert not cd.HybridSystem(**{**BALL, **change}).autonomous


def test_an_integral_of_time_feeds_back_into_nothing():
    timed = cd.HybridSystem(**{**OSCILLATOR, "quadratures": {"work": "v**2", "clock": "cos(t)**2"}})
    assert timed.autonomous
    plain = cd.HybridSystem(**OSCILLATOR)
    one, other = (cd.lyapunov_spectrum(s, duration=60, transient=20) for s in (plain, timed))
    np.testing.assert_array_equal(one["lyapunov_exponent"].values, other["lyapunov_exponent"].values)
    assert int(one["outcome"]) == int(other["outcome"])

"""A symbol for time that nothing uses changes no result, to the bit; nor do the helpers that give every system one."""

import inspect

import numpy as np
import pytest
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill.analysis.registry import FUNCTIONS

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
SHORT = short_calls(("x", [0.5, 1.0]), ("v", [0.0, 0.5]), ("mu", [0.5, 1.0]), ("k", [1.0, 2.0]))
SHORT["equilibria"] = {"sweep": {"mu": (0.5, 1.0)}, "region": {"x": (-1, 1), "v": (-1, 1)}, "starts": 9}
SHORT["transient_chaos"] = {"duration": 20.0, "initial": [{"x": 0.5}, {"x": 1.0}]}
SHORT["periodic_orbit"] = {"start": "attractor"}
# back in time the oscillator runs away
SHORT["manifolds"] |= {"max_return": 20.0}
GRID = {"x": np.linspace(-2, 2, 4), "v": np.linspace(-1.5, 1.5, 4)}
MORE = {
    "a duration": (OSCILLATOR, "lyapunov_spectrum", {"duration": 60, "transient": 20}),
    "a rest": (WELLS, "lyapunov_spectrum", {"duration": 200}),
    "two rests": (WELLS, "basins", {"grid": GRID, "transient": 150, "duration": 60}),
    "no return": (WELLS, "poincare_section", {"at": "x < 0", "max_return": 200.0, "periods": 2}),
    "impacts": (BALL, "periodic_orbit", {"at": "hit", "start": "attractor", "transient": 30}),
    "steps": (BALL, "work_precision", {"duration": 0.25, "methods": ["dop853"], "tolerances": [1e-8], "repeats": 1}),
}


def over_a_section(name):
    """An analysis of the oscillator, over a section where forced systems have their strobe."""
    at = {"at": "x > 0"} if "at" in inspect.signature(getattr(cd, name)).parameters else {}
    return OSCILLATOR, name, SHORT[name] | at


CALLS = {name: over_a_section(name) for name in FUNCTIONS} | MORE


@pytest.mark.parametrize(("given", "name", "arguments"), CALLS.values(), ids=CALLS)
def test_an_unused_symbol_changes_no_bit(given, name, arguments):
    without, other = (getattr(cd, name)(cd.HybridSystem(**given, time=time), **arguments) for time in (None, "tau"))
    assert set(other.variables) == set(without.variables)
    for variable in without.variables:
        if not variable.startswith("wall_time"):
            np.testing.assert_array_equal(other[variable].values, without[variable].values, err_msg=variable)


def test_the_wells_are_two_attractors_at_rest():
    wells, name, arguments = MORE["two rests"]
    found = getattr(cd, name)(cd.HybridSystem(**wells, time="t"), **arguments)
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


@pytest.mark.parametrize(
    ("rate", "autonomous"),
    [
        ("-x + sin(t)**2 + cos(t)**2 - 1", True),
        ("-(x*cos(k*t))**2 - (x*sin(k*t))**2", True),
        ("-x*exp(t)/(1 + exp(t)) - x/(1 + exp(t))", True),
        ("-x + 1e-9*sin(t)", False),
        ("-x + sin(t)**2 + cos(k*t)**2 - 1", False),
        ("-x - 8*exp(-((t - 60)/0.5)**2)", False),
        ("-x + exp(-1000*(1 + cos(t)))", False),
    ],
)
def test_forced_is_what_depends_on_time_not_what_names_it(rate, autonomous):
    kick = cd.Transition("kick", "flow", "flow", "v", 1, {"v": "v/2"}, condition="x - t > -t" if autonomous else None)
    given = {"states": "x v", "parameters": {"k": 2.0}, "modes": {"flow": {"x": "v", "v": rate}}}
    assert cd.HybridSystem(**given, transitions=[kick]).autonomous == autonomous

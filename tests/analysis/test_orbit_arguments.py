"""What the analyses of orbits refuse, with the argument, the value and the remedy; nothing is computed."""

import pytest

import chaosdrill as cd
from chaosdrill.errors import SettingsError


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator")


@pytest.fixture(scope="module")
def roessler():
    return cd.build("roessler")


def refusal(function, *arguments, **keywords):
    with pytest.raises(SettingsError) as caught:
        function(*arguments, **keywords)
    return str(caught.value)


ORBITS = [
    ({"start": "rest"}, ["start is 'rest'", "'attractor', 'guess', 'search'"]),
    ({"start": None}, ["start is None"]),
    ({"period": 0}, ["period is 0", "at least 1"]),
    ({"period": 2.5}, ["period is 2.5", "whole number"]),
    ({"period": 10**6}, ["period is 1000000", "at most 1000"]),
    ({"transient": 2.5}, ["transient is 2.5", "expected whole forcing periods"]),
    ({"transient": -1}, ["transient is -1"]),
    ({"start": "search"}, ["max_period: missing"]),
    ({"start": "search", "max_period": 0}, ["max_period is 0"]),
    ({"start": "search", "max_period": 3, "period": 2}, ["period is 2", "looks for all", "leave it out"]),
    ({"start": "search", "max_period": 3, "at": "x > 0"}, ["at is 'x > 0'", "counts forcing periods", "leave it out"]),
    ({"max_period": 3}, ['max_period is 3; applies with start = "search" only']),
    ({"start": "guess", "seeds": [{"x": 0.1}]}, ["seeds is [{'x': 0.1}]", "search"]),
    ({"random": {"count": 3, "seed": 1, "x": (0, 1)}}, ["random: applies", "search"]),
    ({"start": "search", "max_period": 1, "seeds": []}, ["seeds is []", "must not be empty"]),
    ({"start": "search", "max_period": 1, "random": {"count": 3, "seed": 1}}, ["random: names no state"]),
    ({"tolerance": 0}, ["tolerance is 0"]),
    ({"method": "euler"}, ["unknown method 'euler'"]),
]


@pytest.mark.parametrize(("keywords", "words"), ORBITS)
def test_an_orbit_is_refused(oscillator, keywords, words):
    message = refusal(cd.periodic_orbit, oscillator, **keywords)
    assert all(word in message for word in words), message


BRANCHES = [
    ("omega", {}, ["sweep is 'omega'", "give one parameter"]),
    ({}, {}, ["give one parameter"]),
    ({"omega": (1, 2), "wall": (0, 1), "e": (0.5, 1)}, {}, ["sweep: names ['e', 'omega', 'wall']"]),
    ({"omego": (1, 2)}, {}, ["sweep.omego: unknown parameter", "'omega'"]),
    ({"omega": 2.0}, {}, ["sweep.omega is 2.0", "two limits"]),
    ({"omega": (1, 2, 3)}, {}, ["sweep.omega is (1, 2, 3)"]),
    ({"omega": "12"}, {}, ["sweep.omega is '12'"]),
    ({"omega": (1, float("inf"))}, {}, ["sweep.omega.stop is inf", "must be finite"]),
    ({"omega": (2.5, 2.5)}, {}, ["start and stop are equal"]),
    ({"omega": (2.6, 3)}, {}, ["the branch starts at", "omega = 2.5, which is not between"]),
    (
        {"omega": (2, 3), "wall": (0, 1)},
        {},
        ["follow: missing", "'fold', 'period_doubling', 'neimark_sacker', 'grazing'"],
    ),
    ({"omega": (2, 3)}, {"follow": "fold"}, ["follow is 'fold'", "name the second parameter"]),
    ({"omega": (2, 3), "wall": (0, 1)}, {"follow": "torus"}, ["follow is 'torus'"]),
    ({"omega": (2, 3), "wall": (0, 1)}, {"follow": "fold", "doublings": 1}, ["doublings is 1"]),
    ({"omega": (2, 3)}, {"start": "search"}, ["start is 'search'", "['attractor', 'guess']"]),
    ({"omega": (2, 3)}, {"doublings": 40}, ["doublings is 40", "at most 12"]),
    ({"omega": (2, 3)}, {"step": 0}, ["step is 0"]),
    ({"omega": (2, 3)}, {"step": 1.5}, ["step is 1.5", "range of 'omega', which is 1"]),
    ({"omega": (2, 3)}, {"max_points": 1}, ["max_points is 1"]),
]


@pytest.mark.parametrize(("sweep", "keywords", "words"), BRANCHES)
def test_a_branch_is_refused(oscillator, sweep, keywords, words):
    message = refusal(cd.continue_orbit, oscillator, sweep, **keywords)
    assert all(word in message for word in words), message


def test_periods_are_not_counted_without_forcing(roessler):
    assert "no forcing period" in refusal(cd.periodic_orbit, roessler, period=2)
    assert "no forcing period" in refusal(cd.continue_orbit, roessler, {"a": (0.1, 0.2)}, period=2)
    assert "transient is -0.5; must be at least 0" in refusal(cd.periodic_orbit, roessler, transient=-0.5)


def test_a_parameter_with_the_name_of_a_result():
    import sympy

    x, v, t, mode = sympy.symbols("x v t mode", real=True)
    system = cd.HybridSystem(
        name="named",
        states=(x, v),
        time=t,
        parameters={"mode": 1.0},
        modes={"free": {x: v, v: -x - v + mode * sympy.cos(t)}},
        period=2 * sympy.pi,
    )
    assert "sweep.mode: is reserved" in refusal(cd.continue_orbit, system, {"mode": (1, 2)})

"""An argument of the wrong type is refused like one of the wrong value: its name, what was given, what is allowed."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.spans import MOST_NUMBERS, check_record

NUMERICS = [
    ({"tolerance": "fine"}, "tolerance is 'fine'; expected a number"),
    ({"tolerance": None}, "tolerance is None"),
    ({"tolerance": [1e-9]}, r"tolerance is \[1e-09\]"),
    ({"tolerance": float("nan")}, "tolerance is nan"),
    ({"tolerance": 1e-9j}, "tolerance is 1e-09j"),
    ({"method": ["taylor"]}, r"method is \['taylor'\]; expected text"),
    ({"method": None}, "method is None"),
    ({"method": "rk4", "steps": "many"}, "steps is 'many'; expected a whole number"),
    ({"method": "rk4", "steps": True}, "steps is True"),
    ({"method": "rk4", "steps": [100]}, r"steps is \[100\]"),
    ({"method": "rk4", "steps": 100.5}, "steps is 100.5"),
    ({"method": "rk4", "steps": float("inf")}, "steps is inf"),
]


@pytest.mark.parametrize(("arguments", "words"), NUMERICS)
def test_numerics(duffing, arguments, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.trajectory(duffing, periods=1, **arguments)


@pytest.mark.parametrize("duration", ["ten", float("inf"), float("nan"), [3.0], np.array([3.0]), True, 3j])
def test_a_duration_that_is_no_time(bouncer, duration):
    with pytest.raises(cd.SettingsError, match=r"duration is .*; (expected a number|must be finite)"):
        cd.trajectory(bouncer, duration=duration)


@pytest.mark.parametrize("transient", ["a", None, [1], True])
def test_a_transient_that_is_no_time(bouncer, transient):
    with pytest.raises(cd.SettingsError, match=r"transient is .*; expected a number"):
        cd.trajectory(bouncer, duration=1.0, transient=transient)


@pytest.mark.parametrize("periods", [[3], np.array([3]), None, 10**400, 10**17, 3j, b"3"])
def test_periods_that_are_no_count(duffing, periods):
    with pytest.raises(cd.SettingsError, match="periods"):
        cd.trajectory(duffing, periods=periods)


def test_exact_numbers_of_other_libraries_are_numbers(bouncer):
    found = cd.trajectory(bouncer, duration=sympy.Rational(1, 2), samples=np.int64(4))
    assert found["time"].values.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]


def test_a_record_that_no_memory_holds():
    check_record(MOST_NUMBERS // 4, 4, "periods")
    with pytest.raises(cd.SettingsError, match=r"500000001 samples of 4 numbers \(16 GB\).*give fewer periods"):
        check_record(MOST_NUMBERS // 4 + 1, 4, "periods")


@pytest.mark.parametrize("at", [3, ["hit"], np.array(["hit", "apex"]), {"hit": 1}, ""])
def test_a_section_at_nothing(bouncer, duffing, at):
    with pytest.raises(cd.SettingsError, match=r"unknown event .*; or give a comparison|at.*expected text"):
        cd.poincare_section(bouncer, duration=1.0, at=at)
    with pytest.raises(cd.SettingsError, match=r"unknown event .*; or give a comparison|at.*expected text"):
        cd.bifurcation_diagram(duffing, {"gamma": [0.4]}, transient=1, periods=2, at=at)


@pytest.mark.parametrize("sweep", [0.4, "gamma", None, ["gamma"], [("gamma", 0.4)]])
def test_a_sweep_that_names_no_parameter(duffing, sweep):
    with pytest.raises(cd.SettingsError, match=r"sweep is .*; expected a table of values .*, as in .* one parameter"):
        cd.bifurcation_diagram(duffing, sweep, transient=1, periods=2)


VALUES = [
    0.4,
    "0.4",
    None,
    ["a"],
    ["0.4"],
    [[0.4, 0.5]],
    [[0.4], [0.5]],
    np.ones((1, 2)),
    [0.4, None],
    [True],
    {0.4: 1},
]


@pytest.mark.parametrize("values", VALUES, ids=repr)
def test_a_sweep_without_values(duffing, values):
    with pytest.raises(cd.SettingsError, match=r"sweep\.gamma(.* is .*; expected a|\.0\.4: unknown key)"):
        cd.bifurcation_diagram(duffing, {"gamma": values}, transient=1, periods=2)


@pytest.mark.parametrize("seeds", [{"x": 0.1}, 3, "x", [0.1, 0.2], [{"x": 0.1}, 3], [["x", 0.1]]], ids=str)
def test_seeds_that_are_no_list_of_initial_values(duffing, seeds):
    with pytest.raises(
        cd.SettingsError, match=r"seeds.* expected a (list|table) of initial values, as in .*{'x': 0.1}"
    ):
        cd.bifurcation_diagram(duffing, {"gamma": [0.4]}, transient=1, periods=2, seeds=seeds)


def test_seeds_and_sweep_may_be_named_by_symbols(duffing):
    x, gamma = sympy.symbols("x gamma")
    found = cd.bifurcation_diagram(duffing, {gamma: [0.4]}, transient=0, periods=2, exponents=0, seeds=[{x: 0.25}])
    assert found["initial_state"].values.tolist() == [[0.25, -0.2]]
    assert found["gamma"].values.tolist() == [0.4]

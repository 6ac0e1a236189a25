"""A call that is wrong in one place is refused with that place, not with another, and never read as something else."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import chaosdrill as cd

DIAGRAM = {"transient": 1, "periods": 4}


@pytest.mark.parametrize("values", [(0.1, 0.3), (0.1, 0.3, 5), (1, 2, 3)])
@pytest.mark.parametrize("kind", ["diagram", "chart", "basins"])
def test_a_tuple_that_may_be_values_or_limits_is_refused_with_both_ways(duffing, kind, values):
    calls = {
        "diagram": lambda: cd.bifurcation_diagram(duffing, {"gamma": values}, **DIAGRAM),
        "chart": lambda: cd.parameter_chart(duffing, {"gamma": values, "omega": [1.0, 1.1]}, **DIAGRAM),
        "basins": lambda: cd.basins(duffing, {"x": values, "v": [0.0, 0.1]}, **DIAGRAM),
    }
    with pytest.raises(cd.SettingsError) as caught:
        calls[kind]()
    assert f"write {list(values)}" in str(caught.value)
    assert f"'start': {values[0]}, 'stop': {values[1]}, 'num': " in str(caught.value)


def test_what_can_be_values_alone_is(duffing):
    for values in ([0.1, 0.3], (0.1, 0.2, 0.35), np.array([0.1, 0.3])):
        found = cd.bifurcation_diagram(duffing, {"gamma": values}, max_extension=0, **DIAGRAM)
        assert found["gamma"].values.tolist() == list(values)


def test_limits_are_two(duffing):
    with pytest.raises(cd.SettingsError, match="expected two limits, start and stop, between which a branch finds"):
        cd.continue_orbit(duffing, {"gamma": (0.1, 0.3, 100)})


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda s: cd.lyapunov_spectrum(s, period=8), r"lyapunov_spectrum\(\) got .*'period'; did you mean 'periods'"),
        (lambda s: cd.bifurcation_diagram(s, {"gamma": [0.1]}, transiant=8, periods=4), "'transiant'; did you mean 't"),
        (lambda s: cd.basins(s, {"x": [0.0, 1.0]}, sytem=3), "got an unexpected keyword argument 'sytem'"),
        (lambda s: cd.build("lorenz", parametres={}), r"build\(\) got .*'parametres'; did you mean 'parameters'"),
        (lambda s: cd.save(s, pth="a.nc"), r"save\(\) got .*'pth'; did you mean 'path'"),
        (lambda s: cd.trajectory(), r"trajectory\(\) missing a required argument: 'system'"),
        (lambda s: cd.bifurcation_diagram(s, {"gamma": [0.1]}, periods=4), "missing a required argument: 'transient'"),
        (lambda s: cd.HybridSystem(**OWN, initial_mode="free"), r"'initial_mode'; write initial=\{'mode': ...\}"),
        (
            lambda s: cd.in_modes(states="x", rates={"x": "-x"}),
            "argument: 'field'; 'rates' is not one of its arguments",
        ),
    ],
)
def test_a_name_that_no_argument_has(duffing, call, told):
    with pytest.raises(TypeError, match=told):
        call(duffing)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda s: cd.bifurcation_diagram("duffing", {"gamma": [0.1]}, periods=4), "system is 'duffing'"),
        (lambda s: cd.bifurcation_diagram(s, {"gama": [0.1]}, periods=4), "sweep.gama: unknown parameter"),
        (lambda s: cd.bifurcation_diagram(s, {"gamma": [0.1]}, periods=1), "periods is 1; must be at least 2"),
    ],
)
def test_what_is_missing_hides_no_other_fault(duffing, call, told):
    with pytest.raises(cd.SettingsError, match=told):
        call(duffing)


OWN = {"states": "x v", "modes": {"free": {"x": "v", "v": "-x + cos(t)"}}}


def _own(**changed):
    return cd.HybridSystem(**{**OWN, **changed})


def _with_guard(guard):
    return _own(transitions=[{"name": "hit", "source": "free", "target": "free", "guard": guard, "direction": 1}])


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda s: cd.lyapunov_exponents(s), "did you mean 'lyapunov_spectrum'"),
        (lambda s: cd.load("a.nc"), "did you mean 'open'"),
        (lambda s: cd.simulate(s), "did you mean 'trajectory'"),
        (lambda s: cd.bifurcation(s), "did you mean 'bifurcation_diagram'"),
        (lambda s: cd.lyapunov_spectrum(s, 100), r"takes 1 argument .* \(system\), received 2; name the others"),
        (lambda s: cd.bifurcation_diagram(s, "gamma", [1]), r"sweep\), received 3; give sweep=\{'gamma': \[...\]\}"),
        (lambda s: cd.bifurcation_diagram(s, "gamma"), r"as in \{'name of the parameter': numpy.linspace"),
        (lambda s: cd.continue_orbit(s, "gamma"), r"as in \{'name of the parameter': \(0, 1\)\}"),
        (lambda s: cd.lyapunov_spectrum(s, periods=9, rtol=1e-9), "did you mean 'tolerance'"),
        (lambda s: cd.lyapunov_spectrum(s, n=9), "did you mean 'periods'"),
        (lambda s: cd.lyapunov_spectrum(s, periods=9, dt=0.01), "the method chooses its own steps"),
        (lambda s: cd.lyapunov_spectrum(s, periods=9, x0=[0, 1]), r"system.with_initial\(name=value\)"),
        (lambda s: cd.lyapunov_spectrum(s, periods=9, params={}), r"system.with_parameters\(name=value\)"),
        (lambda s: cd.lyapunov_spectrum(s, periods=9, gamma=0.2), r"pass system.with_parameters\(gamma=...\)"),
        (lambda s: cd.lyapunov_spectrum(s, periods=9, sweep={}), "bifurcation_diagram and parameter_chart sweep"),
        (lambda s: cd.bifurcation_diagram(s, gamma=[1, 2]), r"give sweep=\{'gamma': \[...\]\}"),
        (lambda s: cd.bifurcation_diagram(s, {"gamma": [1]}, n_jobs=2), "did you mean 'workers'"),
        (lambda s: cd.build("lorenz", rho=28), r"a parameter goes into parameters=\{'rho': 28\}"),
        (lambda s: cd.build("drill"), "did you mean 'drill-string', 'percussive-drill' or 'percussive-drill-5d'"),
        (lambda s: cd.plot(s, color="red"), "change the axes that come back"),
        (lambda s: cd.plot(s, figsize=(3, 2)), "pass axes of your own figure"),
        (lambda s: cd.save("a.nc", s), r"tree is 'a.nc'; .*; the order is save\(tree, path\)"),
        (lambda s: s.gamma, r"its value is system.parameters\['gamma'\]"),
        (lambda s: s.params, "did you mean 'parameters'"),
        (lambda s: s.simulate(10), r"analyses are functions, as in chaosdrill.trajectory\(system\)"),
        (lambda s: s.parameters["Gamma"], "no entry 'Gamma'; did you mean 'gamma'"),
        (lambda s: cd.Outcome("chaotic"), "write Outcome.CHAOTIC"),
        (lambda s: _own(equations={}), "did you mean 'modes'"),
        (lambda s: cd.Map("x", {}, step={"x": "x"}), "did you mean 'images'"),
        (lambda s: _own(modes=OWN["modes"]["free"]), r"give the mode a name, as in \{'free': \{'x': 'v', ...\}\}"),
        (lambda s: _own(modes={"free": {"x": "v", "v": "x if v > 0 else -x"}}), "or a mode for each case"),
        (lambda s: _own(modes={"free": {"x": "v", "v": "cos(2 t)"}}), r"write \* for a product"),
        (lambda s: _own(parameters={"k": "2"}), "it must be a finite number, without quotes"),
        (
            lambda s: _own(initial=[1, 0]),
            r"by name, as in \{'x': 0.1\}, .*; with_initial also takes numbers in the order",
        ),
        (lambda s: _own(modes={"free": {"x": "v", "v": "-1,5*x"}}), "write a point for a decimal comma"),
        (
            lambda s: _own(modes={"free": {"x": "v", "v": "-sin(radians(x))"}}),
            r"in radians; write x\*180/pi or x\*pi/180",
        ),
        (lambda s: _own(labels={"x": "$\theta$"}), r"'\\t' in a formula is one letter; write the text raw"),
        (lambda s: _own(guards={}), "did you mean 'transitions'"),
        (lambda s: cd.HybridSystem("x v"), "takes no arguments without a name, received 1; name them"),
        (lambda s: cd.filippov(s), "takes no arguments without a name, received 1; name them, as in name="),
        (lambda s: cd.with_noise(s), r"has no attribute 'with_noise'; systems have it, as in system.with_noise"),
        (
            lambda s: cd.HybridSystem(states="x"),
            r"missing a required argument: 'modes'; see help\(chaosdrill.HybridSystem",
        ),
        (
            lambda s: cd.Transition("hit", "free", "free", "x"),
            r"missing .* 'direction'; see help\(chaosdrill.Transition",
        ),
        (lambda s: cd.Transition("hit", "free", "free", "x", 1, resets={}), "did you mean 'reset'"),
        (lambda s: cd.Transition("hit", "free", "free", "x = 1", 1), "a guard and a rate are the expression alone"),
        (lambda s: cd.plot(s), r"as in chaosdrill.plot\(chaosdrill.trajectory\(system, ...\)\)"),
        (lambda s: cd.plot("a.nc"), r"as in chaosdrill.open\('a.nc'\)\['motion'\], or take plot_archive"),
        (lambda s: cd.plot([s, s]), "one after the other, on the axes of your own"),
        (lambda s: cd.plot(s, ax=Figure()), "must be plane axes of matplotlib"),
        (lambda s: cd.plot(s, ax=Figure().add_subplot(projection="polar")), "must be plane axes of matplotlib"),
        (lambda s: cd.plot(s, ax=Figure().add_subplot(projection="3d")), "must be plane axes of matplotlib"),
        (lambda s: cd.plot(s, ax=SimpleNamespace(set_xlabel=print)), "must be plane axes of matplotlib"),
        (lambda s: cd.lyapunov_spectrum(xr.Dataset()), r"that of a scene or a result \(.*, system\(ds\)\)"),
        (lambda s: s.with_parameters(pd.Series([1, 2])), r"parameters are [^\n]*; give them by name"),
        (lambda s: cd.series_measures(xr.Dataset()), r"values is [^\n]*; it must be a series"),
        (lambda s: cd.plot(s, fontsize=9), r"or use matplotlib.rc_context\(\{'figure.figsize'"),
        (lambda s: cd.save_scene(s, "a.toml"), r"the order is save_scene\(path, system, analyses\)"),
        (lambda s: cd.save_scene("a.toml", s), r"missing a required argument: 'analyses'; see help"),
        (lambda s: cd.report(s, "a.html"), "run an analysis of the system and save its result"),
        (lambda s: cd.basins(s, {"x": [0, 1]}, periods=9, transient=9), "attractors follows random starts"),
        (
            lambda s: _with_guard("x > 0.3"),
            "is a comparison; .* write the difference of the two sides, as in 'x - 0.3'",
        ),
    ],
)
def test_what_a_newcomer_writes_is_answered_with_the_way(duffing, call, told):
    with pytest.raises((TypeError, AttributeError, KeyError, ValueError, cd.ChaosdrillError), match=told):
        call(duffing)


def test_states_run_together_are_told_where_they_are_missing():
    """A transition that names them has no fault of its own."""
    hit = {"name": "hit", "source": "free", "target": "free", "guard": "x - 1", "direction": 1, "reset": {"v": "-v"}}
    with pytest.raises(cd.ModelError, match=r"modes\.free: gives no rate for 'xv'") as caught:
        _own(states="xv", transitions=[hit])
    assert "None" not in str(caught.value)


def test_completion_offers_what_users_look_for(duffing):
    offered = [name for name in dir(duffing) if not name.startswith("_")]
    assert {"parameters", "initial", "with_parameters", "with_initial"} <= set(offered)
    assert all(hasattr(duffing, name) for name in offered)
    assert "told_held" not in offered


def test_dates_are_no_times_of_a_run(duffing):
    with pytest.raises(cd.SettingsError, match="times"):
        cd.trajectory(duffing, periods=2, times=np.array(["2020-01-01", "2020-01-02"], dtype="datetime64[ns]"))


WALL = {"modes": {"free": {"x": "v", "v": "-x"}}, "states": "x v", "name": "hitter"}
HIT = cd.Transition("hit", "free", "free", guard="x - 1", direction=1, reset={"v": "-v"})


@pytest.mark.parametrize(
    "call",
    [
        lambda s: cd.trajectory(s, duration=1),
        lambda s: cd.lyapunov_spectrum(s, duration=1),
        lambda s: cd.basins(s, initial=[{"x": 2.0}, {"x": 3.0}], duration=4, transient=1, at="x < 0"),
    ],
)
def test_a_start_beyond_a_wall_is_told_where_it_was_asked_for(call):
    system = cd.HybridSystem(**WALL, transitions=[HIT], initial={"x": 2.0})
    with pytest.warns(cd.StartWarning, match=r"At x = 2, v = 0 the guard x - 1 of 'hit' is 1, .*negative") as told:
        found = call(system)
    assert [one.filename for one in told] == [__file__]
    assert found.attrs["message"] in str(told[0].message)


def test_a_grid_with_a_start_on_this_side_is_a_result():
    system = cd.HybridSystem(**WALL, transitions=[HIT], initial={"x": 2.0})
    found = cd.basins(system, initial=[{"x": 2.0}, {"x": 0.5}], duration=4, transient=1, at="x < 0")
    assert (found["outcome"] == cd.Outcome.INVALID_START).values.tolist() == [True, False]

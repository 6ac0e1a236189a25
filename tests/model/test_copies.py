"""Copies with other numbers: the original keeps its own, and both share what was compiled."""

import numpy as np
import pandas as pd
import pytest
import sympy
import xarray as xr

import chaosdrill as cd
from chaosdrill.codegen import kernels_of

X, V, T, K, OMEGA = sympy.symbols("x v t k omega", real=True)


@pytest.fixture
def system():
    return cd.HybridSystem(
        name="mass",
        states=(X, V),
        time=T,
        parameters={"k": 2.0, "omega": 4.0},
        modes={"free": {X: V, V: -K * X + sympy.cos(OMEGA * T)}, "held": {X: 0, V: 0}},
        transitions=[
            cd.Transition("hit", "free", "free", guard=X - 1, direction=+1, reset={V: -V}),
            cd.Transition("catch", ("free",), "held", guard=V + K, direction=-1, reset={V: 0}),
        ],
        period=2 * sympy.pi / OMEGA,
        initial={"mode": "free", X: 0.25},
        bounds={V: (-5, 7)},
    )


def test_parameters_change_in_the_copy_only(system):
    other = system.with_parameters(k=3)
    assert (other.parameters["k"], system.parameters["k"]) == (3.0, 2.0)
    assert other.parameters["omega"] == 4.0


def test_the_period_follows_the_parameters(system):
    assert system.forcing_period() == pytest.approx(1.5707963267948966, rel=1e-15)
    assert system.with_parameters(omega=1.0).forcing_period() == pytest.approx(6.283185307179586, rel=1e-15)


def test_the_start_changes_in_the_copy_only(system):
    other = system.with_initial(v=-1, mode="held")
    assert other.initial == {"mode": "held", "x": 0.25, "v": -1.0}
    assert system.initial == {"mode": "free", "x": 0.25, "v": 0.0}


@pytest.mark.parametrize(
    "start",
    [
        [0.5, -1.0],
        np.array([0.5, -1.0]),
        {"x": 0.5, V: np.float64(-1)},
        xr.DataArray([-1.0, 0.5], dims="state", coords={"state": ["v", "x"]}),
        xr.DataArray([0.5, -1.0], dims="state"),
        pd.Series({"v": -1.0, "x": 0.5}).to_dict(),
    ],
    ids=["list", "array", "names", "named by xarray", "in order", "series"],
)
def test_a_start_in_any_form(system, start):
    assert system.with_initial(start).initial == {"mode": "free", "x": 0.5, "v": -1.0}
    assert system.with_initial(start, v=2.0, mode="held").initial == {"mode": "held", "x": 0.5, "v": 2.0}


@pytest.mark.parametrize(
    ("start", "told"),
    [
        ([0.5], r"the initial state is \[0.5\]; it must have 2 numbers, in the order x, v"),
        (np.zeros((3, 2)), r"an array of shape \(3, 2\); it must have 2 numbers"),
        ("0.5 1", "the initial state is '0.5 1'"),
        (3.0, r"the initial state is 3.0; .*as in x=0.1"),
        ([0.5, "a"], "initial 'v' is 'a'; it must be a finite number"),
        ({"x": np.array([0.5])}, r"initial 'x' is array\(\[0.5\]\); it must be a finite number"),
        ({"x": np.complex128(1 + 2j)}, "initial 'x' is .*; it must be a finite number"),
        ({"x": sympy.Float("1e-400")}, "initial 'x' is .*e-400; it must be a finite number"),
        (
            xr.Dataset({"states": (("time", "state"), np.zeros((3, 2)))}),
            r"whole result; .*with_initial\(ds\['states'\]\[-1\]",
        ),
        ({"velocity": 1.0}, "initial names 'velocity', which is not a state"),
    ],
)
def test_a_start_that_is_none_is_told_by_what_is_wrong(system, start, told):
    with pytest.raises(cd.SettingsError, match=told):
        system.with_initial(start)


def test_parameters_by_a_table(system):
    assert system.with_parameters({"k": 3}).parameters == system.with_parameters(k=3).parameters
    with pytest.raises(cd.SettingsError, match=r"parameters are \[3\]; give them by name"):
        system.with_parameters([3])


def test_copies_share_the_kernels(system):
    other = system.with_parameters(k=3).with_initial(x=0.5)
    assert kernels_of(other) is kernels_of(system)


@pytest.mark.parametrize("period", [0.0, -1.0])
def test_a_period_that_is_not_positive_is_refused(system, period):
    with pytest.raises(cd.SettingsError, match=r"mass: the period 2\*pi/omega is .* it must be > 0"):
        system.with_parameters(omega=period).forcing_period()


def test_unknown_names_are_refused_with_the_known_ones(system):
    with pytest.raises(cd.SettingsError, match=r"unknown parameter 'omga'; did you mean 'omega'"):
        system.with_parameters(omga=1.0)
    with pytest.raises(cd.SettingsError, match=r"'y', which is not a state; known here: mode, x, v"):
        system.with_initial(y=1.0)
    with pytest.raises(cd.SettingsError, match=r"unknown parameter 'mass'.*'k', 'omega'"):
        system.augmented(parameters=["mass"])


@pytest.mark.parametrize("where", ["rate", "guard"])
def test_a_kink_in_a_parameter_is_told_where_its_derivative_is_needed(where):
    kink = {"rate": "1", "guard": "x - 1", where: f"{2 if where == 'rate' else 'x - 1'} - Abs(k - 1)"}
    hit = cd.Transition("hit", "free", "free", kink["guard"], +1, reset={"x": 0})
    system = cd.HybridSystem(states="x", parameters={"k": 1.0}, modes={"free": {"x": kink["rate"]}}, transitions=[hit])
    with pytest.raises(cd.SettingsError, match=r"^own-system: Abs\(k - 1\) has a kink or a jump in the parameter 'k'"):
        cd.continue_orbit(system, {"k": (0.5, 1.5)}, at="hit", start="guess")


def test_beside_a_kink_in_a_parameter_its_branch_is_derived():
    decay = cd.HybridSystem(states="x", parameters={"k": -2.0}, modes={"on": {"x": "-Abs(k)*x"}}, initial={"x": 1.0})
    wide = decay.augmented(parameters=["k"])
    x, k = wide.states
    assert wide.modes["on"][x] == x * k
    assert cd.trajectory(wide, duration=1.0, samples=2)["outcome"] == cd.Outcome.OK
    beyond = wide.with_initial(k=2.0)
    assert cd.trajectory(beyond, duration=1.0, samples=2)["outcome"] == cd.Outcome.ESCAPED


def test_augmented_with_time_and_parameters(system):
    wide = system.augmented(time=True, parameters=["k"])
    assert wide.state_names == ("x", "v", "t", "k")
    assert wide.time is None
    assert wide.parameters == {"omega": 4.0}
    for mode in ("free", "held"):
        assert wide.modes[mode][T] == 1
        assert wide.modes[mode][K] == 0
    assert wide.modes["free"][V] == system.modes["free"][V]
    assert wide.initial == {"mode": "free", "x": 0.25, "v": 0.0, "t": 0.0, "k": 2.0}
    assert wide.bounds["v"] == (-5.0, 7.0)
    assert wide.bounds["t"] == (-float("inf"), float("inf"))
    assert wide.forcing_period() == system.forcing_period()


def test_augmented_without_a_word_is_the_same_system(system):
    same = system.augmented()
    assert (same.states, same.modes, same.parameters) == (system.states, system.modes, system.parameters)


def test_a_map_with_a_parameter_among_its_states_is_a_map():
    henon = cd.Map("x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"}, initial={"x": 0.1})
    wide = henon.augmented(parameters=["a"])
    assert (type(wide), wide.state_names, wide.parameters) == (cd.Map, ("x", "y", "a"), {"b": 0.3})
    assert {x.name: str(image) for x, image in wide.images.items()} == {"x": "-a*x**2 + y + 1", "y": "b*x", "a": "a"}
    assert wide.initial_values == [0.1, 0.0, 1.4]


@pytest.mark.parametrize("discrete", [False, True])
def test_what_noise_is_made_of_stays_behind_a_parameter_among_the_states(system, discrete):
    narrow = cd.Map("x", {"omega": 1.4, "k": 0.3}, {"x": "omega - k*x**2"}) if discrete else system
    drawn = narrow.with_noise({"k": cd.Uniform(1.0, 1.4)}, at=None if discrete else "hit")
    wide = drawn.augmented(parameters=["omega"])
    assert wide.free == drawn.free + 1
    assert wide.state_names == (*drawn.state_names[: drawn.free], "omega", *drawn.state_names[drawn.free :])


def test_the_representation_tells_states_modes_and_transitions(system):
    assert repr(system) == (
        "HybridSystem('mass', states=('x', 'v'), modes=('free', 'held'), transitions=('hit', 'catch'))"
    )


def test_a_transition_counts_under_its_kind_or_its_name():
    hit = cd.Transition("hit", "a", "a", guard=X, direction=1)
    assert (hit.kind, hit.source) == ("hit", ("a",))
    assert cd.Transition("hit", "a", "a", guard=X, direction=1, kind="impact").kind == "impact"


def test_only_what_changes_nothing_is_a_mark():
    assert cd.Transition("mark", "a", "a", guard=X, direction=1).marks_only()
    assert not cd.Transition("mark", "a", "b", guard=X, direction=1).marks_only()
    assert not cd.Transition("mark", "a", "a", guard=X, direction=1, reset={X: 0}).marks_only()

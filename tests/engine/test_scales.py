"""Guards and states of any size: a factor, a unit or a neighbour changes nothing but the unit of the answer."""

import importlib
import math
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy

import chaosdrill as cd

sys.path.insert(0, str(Path(__file__).parents[2] / "studies" / "hard_cases"))
scales = importlib.import_module("case_14_clocks_ties_and_scales")

X, V, U, T = sympy.symbols("x v u t", real=True)
METHODS = ("taylor", "dop853")


def outcome(run):
    return cd.Outcome(int(run["outcome"])).meaning


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("switch", [False, True])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e3, 1e6, 1e9])
def test_a_factor_before_a_guard_changes_nothing_next_to_a_state_that_decays(method, switch, scale):
    right = scales.rises()
    assert len(right) == 32
    run = cd.trajectory(
        scales.beside_decay(switch).with_parameters(scale=scale), duration=20.0, samples=2, method=method
    )
    assert outcome(run) == "ok"
    names = run["event_kind"].attrs["flag_meanings"].split()
    found = run["event_time"].values[run["event_kind"].values == names.index("rise")]
    assert len(found) == 32
    np.testing.assert_allclose(found, right, rtol=0, atol=1e-8)


@pytest.mark.parametrize("method", METHODS)
def test_a_state_that_has_decayed_to_nothing_stops_no_tangent(method):
    """u' = -1000 u is below the smallest number after 0.75."""
    system = cd.HybridSystem(
        name="oscillator beside a decay",
        states=(X, V, U),
        parameters={},
        modes={"run": {X: V, V: -X, U: -1000 * U}},
        period=sympy.Integer(1),
        initial={X: 1.0, V: 0.0, U: 1.0},
    )
    run = cd.lyapunov_spectrum(system, periods=6, blocks=2, method=method)
    np.testing.assert_allclose(run["lyapunov_exponent"], [0, 0, -1000], rtol=1e-9, atol=0.3)
    assert outcome(run) not in ("step_underflow", "nonfinite")


@pytest.mark.parametrize("power", [3, 7])
def test_an_energy_is_kept_within_ten_tolerances(power):
    """x'' = -x**power from (1, 0): the largest jump of the energy within half a unit, in a run of 20000."""
    p = sympy.Integer(power)
    system = cd.HybridSystem(
        name=f"power-{power}",
        states=(X, V),
        parameters={},
        modes={"free": {X: V, V: -(X**p)}},
        initial={X: 1.0},
    )
    run = cd.trajectory(system, duration=20000.0, samples=40000, tolerance=1e-9)
    x, v = run["state"].values.T
    energy = v**2 / 2 + x ** (power + 1) / (power + 1)
    assert np.abs(np.diff(energy)).max() <= 1e-8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("size", "rate"), [(1.0, 1.0), (1e-3, 1.0), (1e-9, 1.0), (1e6, 1.0), (2e-6, 2 * math.pi * 1e5), (1e-9, 1e-4)]
)
def test_an_oscillator_of_any_size_keeps_its_energy(method, size, rate):
    """x'' = -w**2 (x + x**3/size**2) over a hundred radians: relative to its energy, and beside the one of size 1."""
    system = scales.duffing()
    runs = {
        s: cd.trajectory(
            system.with_parameters(size=s, w=w).with_initial(x=s), duration=100.0 / w, samples=100, method=method
        )["state"].values
        / [s, s * w]
        for s, w in {(1.0, 1.0), (size, rate)}
    }
    energy = scales.energy(*runs[size].T, 1.0, 1.0)
    np.testing.assert_allclose(energy, 0.75, rtol=1e-10)
    np.testing.assert_allclose(runs[size], runs[1.0], rtol=0, atol=1e-9)


def in_units(system):
    """The same system with lengths and speeds in units of one's choice, which are parameters of it."""
    length, second = sympy.symbols("unit_length unit_time", real=True)
    sizes = {"y": length, "u": length / second, "w": length / second}
    states = {s: sizes[s.name] for s in system.states}
    into = {s: s / size for s, size in states.items()}
    if system.time is not None:
        into[system.time] = system.time / second

    def read(expression):
        return sympy.sympify(expression).xreplace(into)

    return cd.HybridSystem(
        name=f"{system.name} in units",
        states=system.states,
        time=system.time,
        parameters={**system.parameters, "unit_length": 1.0, "unit_time": 1.0},
        modes={
            mode: {s: size / second * read(flow[s]) for s, size in states.items()}
            for mode, flow in system.modes.items()
        },
        transitions=[
            cd.Transition(
                t.name,
                t.source,
                t.target,
                guard=read(t.guard),
                direction=t.direction,
                reset={s: states[s] * read(value) for s, value in t.reset.items()},
                condition=None if t.condition is None else read(t.condition),
                priority=t.priority,
                kind=t.kind,
            )
            for t in system.transitions
        ],
        period=system.period * second,
        initial=system.initial,
        bounds=dict.fromkeys(system.states),
    )


@pytest.fixture(scope="module")
def drill():
    system = cd.drill(eta=0.8)
    return in_units(system)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("length", "second"), [(1.7e-3, 1.0), (1.7e3, 1.0), (1.7e-9, 1.0), (1.7e-3, 0.02), (1.7e3, 2e4)]
)
def test_the_drill_in_metres_and_in_micrometres_is_the_drill(method, length, second, drill):
    """Ten periods from rest with hits, sticks and slips, in metres or micrometres, and in seconds or microseconds."""
    own = cd.trajectory(drill, periods=10, samples=16, method=method)
    other = cd.trajectory(
        drill.with_parameters(unit_length=length, unit_time=second), periods=10, samples=16, method=method
    )
    assert outcome(own) == outcome(other) == "ok"
    assert own.sizes["event"] > 20
    np.testing.assert_array_equal(other["event_kind"].values, own["event_kind"].values)
    np.testing.assert_allclose(other["event_time"].values / second, own["event_time"].values, rtol=0, atol=1e-10)
    sizes = [length, length / second, length / second]
    np.testing.assert_allclose(other["state"].values / sizes, own["state"].values, rtol=0, atol=1e-10)


def test_the_drill_has_the_same_exponents_in_any_unit(drill):
    """On its cycle the exponents are those of the multipliers, whatever lengths are measured in."""
    found = [
        cd.lyapunov_spectrum(drill.with_parameters(unit_length=length), periods=64, transient=64)
        for length in (1.0, 1.7e-3, 1.7e3)
    ]
    exponents = np.array([run["lyapunov_exponent"].values for run in found])
    np.testing.assert_array_equal(np.isneginf(exponents), np.isneginf(exponents[[0, 0, 0]]))
    finite = np.isfinite(exponents[0])
    np.testing.assert_allclose(exponents[1:, finite], exponents[[0, 0]][:, finite], rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("other", [1e-12, 1.0, 1e6])
def test_a_neighbour_of_any_size_does_not_move_an_event(method, other):
    """x = size sin t rises through half its size at pi/6 + 2 pi k, beside an oscillator of another size."""
    y, u = sympy.symbols("y u", real=True)
    size = 1e-6
    system = cd.HybridSystem(
        name="neighbours",
        states=(X, V, y, u),
        parameters={"c": size / 2},
        modes={"free": {X: V, V: -X, y: u, u: -2 * y}},
        transitions=[cd.Transition("rise", "free", "free", guard=X - sympy.Symbol("c"), direction=+1)],
        initial={V: size, y: other},
        bounds=dict.fromkeys((X, V, y, u)),
    )
    run = cd.trajectory(system, duration=100.0, samples=3, method=method)
    right = math.pi / 6 + 2 * math.pi * np.arange(16)
    np.testing.assert_allclose(run["event_time"].values, right, rtol=0, atol=1e-10)

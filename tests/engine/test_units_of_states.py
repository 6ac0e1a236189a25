"""What is found of a system before any run, and what ends runs, is the same in any unit of its states."""

import math

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.structure import examine, passes, sizes_of

UNITS = (1e-12, 1e12)
NAMES = ("belt-stick-slip", "impact-oscillator", "relay-sliding")


def in_units(system):
    """The same system with a parameter for the unit of each state."""
    units = {x: sympy.Symbol(f"unit_of_{x.name}", real=True) for x in system.states}
    put = {x: x / unit for x, unit in units.items()}

    def of(rates):
        return {x: unit * sympy.sympify(rates[x]).xreplace(put) for x, unit in units.items()}

    transitions = [
        cd.Transition(
            t.name,
            t.source,
            t.target,
            t.guard.xreplace(put),
            t.direction,
            reset={x: units[x] * image.xreplace(put) for x, image in t.reset.items()},
            priority=t.priority,
            condition={mode: one.xreplace(put) for mode, one in t.conditions.items()} or None,
            completes=t.completes,
        )
        for t in system.transitions
    ]
    return cd.HybridSystem(
        name="in units",
        states=system.states,
        time=system.time,
        period=system.period,
        parameters={**system.parameters, **{unit.name: 1.0 for unit in units.values()}},
        modes={mode: of(rates) for mode, rates in system.modes.items()},
        transitions=transitions,
        initial=dict(system.initial),
        bounds=dict.fromkeys(system.states),
    )


@pytest.mark.parametrize("name", NAMES)
def test_structure_does_not_depend_on_units(name):
    """Which guards are passed, which transitions may lose rank, and which states drive others."""
    system = in_units(cd.build(name))
    known = passes(system), examine(system)
    for factor in UNITS:
        for alike in (True, False):
            factors = [factor if alike or i % 2 else 1 / factor for i in range(len(system.states))]
            units = {f"unit_of_{x}": value for x, value in zip(system.state_names, factors, strict=True)}
            start = {x: value * system.initial[x] for x, value in zip(system.state_names, factors, strict=True)}
            here = system.with_parameters(**units).with_initial(**start)
            found = examine(here)
            assert passes(here) == known[0]
            assert found.deficient == known[1].deficient
            assert ((found.frame != 0) == (known[1].frame != 0)).all()


def softening(x_unit, v_unit):
    """A saddle with wells beside it, at rest, that a kick sends on beyond its guard if it is fast enough."""
    x, v = sympy.symbols("x v", real=True)
    put = {x: x / x_unit, v: v / v_unit}
    rates, reset = {x: v, v: x - x**3 - v / 10}, {x: -x / 2, v: v**3 - v / 2}
    units = {x: x_unit, v: v_unit}
    rates, reset = ({s: units[s] * e.xreplace(put) for s, e in one.items()} for one in (rates, reset))
    kick = cd.Transition("kick", "run", "run", guard=(x + v / 3).xreplace(put), direction=1, reset=reset)
    return cd.HybridSystem(states=(x, v), modes={"run": rates}, transitions=[kick], initial={"x": 0.0, "v": 0.0})


@pytest.mark.parametrize("units", [(1, 1), (1e-9, 1), (1, 1e-9), (1e9, 1), (1, 1e9), (1e-9, 1e9), (1e9, 1e9)])
def test_states_at_rest_have_the_sizes_of_what_is_beside_it(units):
    """The wells are at 1, and the saddle's rates are of about 1; what a linear motion is made of goes together."""
    system = softening(*units)
    sizes, unit = sizes_of(system)
    assert 0.25 < sizes[0] / units[0] < 2
    assert 0.25 < sizes[1] / units[1] < 2
    assert unit == pytest.approx(1 / (math.sqrt(1 + 0.05**2) + 0.05))
    assert passes(system) == {(0, 0)}
    assert not examine(system).deficient
    rates = {"x": f"{units[0]}*v/{units[1]}", "v": f"-{units[1]}*x/{units[0]}"}
    linear = cd.HybridSystem(states="x v", modes={"run": rates}, initial={"x": 0.0, "v": 0.0})
    ratio = np.divide(*sizes_of(linear)[0])
    assert ratio == pytest.approx(units[0] / units[1], rel=1e-12)


def test_starts_of_about_the_same_sizes_share_what_is_known():
    system = cd.build("belt-stick-slip")
    starts = [system.with_initial(x=x) for x in np.linspace(0.0, 0.9, 40)]
    assert {examine(here).deficient for here in starts} == {examine(system).deficient}
    assert len(system.shared["coupling"]) <= 3
    assert {passes(here) for here in starts} == {passes(system)}


def test_a_run_says_which_bound_it_has_left():
    """States that have grown by 1e10 are beyond their bounds by default, and nothing else is wrong with them."""
    grown = cd.HybridSystem(states="x v", modes={"m": {"x": "v", "v": "x"}}, initial={"x": 1.0, "v": 0.0})
    run = cd.trajectory(grown, duration=25.0, samples=3)
    assert cd.Outcome(int(run["outcome"])) == cd.Outcome.ESCAPED
    assert "x = " in run.attrs["message"]
    assert "exceeds 1e+09" in run.attrs["message"]
    assert "bounds={'x': (low, high)}" in run.attrs["message"]
    wide = cd.trajectory(grown.remade(bounds={"x": (-1e12, 1e12), "v": (-1e12, 1e12)}), duration=25.0, samples=3)
    assert cd.Outcome(int(wide["outcome"])) == cd.Outcome.OK


@pytest.mark.parametrize("method", ["taylor", "radau"])
def test_a_sweep_says_which_terms_have_ended_its_runs(method):
    """sqrt(h) = sqrt(h0) - k t/2 is empty at time 2 sqrt(h0)/k, within the record for three of four."""
    tank = cd.HybridSystem(
        states="h", parameters={"k": 0.1, "s": 1.0}, modes={"full": {"h": "-k*s*sqrt(h)"}}, initial={"h": 1.0}
    )
    sweep = {"k": [0.01, 0.5], "s": [1.0, 100.0]}
    chart = cd.parameter_chart(tank, sweep, duration=10.0, transient=0.0, max_extension=0, method=method)
    assert (chart["outcome"] == cd.Outcome.SINGULAR).sum() == 3
    assert chart.attrs["message"] == ("sqrt(h) ends where h = 0, in mode 'full': 3 of 4 runs, first k = 0.01, s = 100")
    basin = cd.basins(tank, initial=[[1.0], [1e4]], duration=30.0, transient=0.0, max_extension=0, method=method)
    assert basin.attrs["message"] == "sqrt(h) ends where h = 0, in mode 'full': 1 of 2 runs, first run = 1"
    windows = {"windows": [1.0, 2.0], "duration": 10.0, "transient": 0.0, "method": method}
    measured = cd.finite_time_exponents(tank, {"k": [0.01, 0.5]}, **windows)
    assert measured.attrs["message"] == "sqrt(h) ends where h = 0, in mode 'full': 1 of 2 runs, first k = 0.5"


def test_a_reset_that_cancels_beside_a_state_in_a_tiny_unit():
    """What w is off by, 1e12 in its unit, cancels in the reset: no guard may count as zero for it."""
    one = "sin(w)**2 + cos(w)**2"
    system = cd.HybridSystem(
        name="tiny-unit",
        states="x w z",
        modes={"run": {"x": "1", "w": "-w/3", "z": "-z"}},
        transitions=[
            cd.Transition("turn", "run", "run", "x - 1", +1, {"x": "x - 1", "z": "z + 5", "w": f"w + 2**40*({one})"}),
            cd.Transition("half", "run", "run", "z - 3", +1, {"z": f"z/2 + {one} - 1"}),
        ],
        initial={"z": 0.5},
        bounds={"w": (-1e14, 1e14)},
    )
    found = cd.trajectory(system, duration=4.5, samples=1)
    assert found["event_kind"].values.tolist() == [0, 1] * 4


def test_rebounds_without_end_stall_with_tangents_in_any_unit():
    """The last of them have no speed, and then the tangents no number."""
    table = cd.HybridSystem(
        states="h v",
        parameters={"g": 1.3},
        modes={"air": {"h": "v", "v": "-1"}},
        transitions=[
            cd.Transition(
                "hit", "air", "air", guard="h - g*(1 + sin(t))", direction=-1, reset={"v": "-v/2 + 3*g/2*cos(t)"}
            )
        ],
        time="t",
        period=2 * sympy.pi,
        initial={"h": 3.0, "v": 0.0},
    )
    system = in_units(table)
    for h, v in ((1.0, 1.0), (1e3, 1e3), (1e-3, 1.0), (9e7, 1.6)):
        units = {"unit_of_h": h, "unit_of_v": v}
        start = {"h": 3.0 * h, "v": 0.0}
        spectrum = cd.lyapunov_spectrum(system.with_parameters(**units).with_initial(**start), periods=64)
        assert spectrum.cd.outcome == "stalled", (h, v)

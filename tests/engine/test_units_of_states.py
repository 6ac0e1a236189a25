"""What is found of a system before any run, and what ends runs, is the same in any unit of its states."""

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.engine.structure import examine, passes

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


def test_a_run_says_which_bound_it_has_left():
    """States that have grown by 1e10 are beyond their bounds by default, and nothing else is wrong with them."""
    grown = cd.HybridSystem(states="x v", modes={"m": {"x": "v", "v": "x"}}, initial={"x": 1.0, "v": 0.0})
    run = cd.trajectory(grown, duration=25.0, samples=3)
    assert cd.Outcome(int(run["outcome"])) == cd.Outcome.ESCAPED
    assert "x = " in run.attrs["message"]
    assert "whose bounds are -1e+09 and 1e+09" in run.attrs["message"]
    assert "bounds={'x': (low, high)}" in run.attrs["message"]
    wide = cd.trajectory(grown.changed(bounds={"x": (-1e12, 1e12), "v": (-1e12, 1e12)}), duration=25.0, samples=3)
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

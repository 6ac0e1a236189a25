"""Integers without end, arrays of 10^12 entries and complex numbers get one error: the field, the value, the remedy."""

import copy
import pickle

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.errors import ChaosdrillError, SettingsError

LONG = 10**5000
MANY = np.broadcast_to(np.float64(1.0), (10**12,))
COMPLEX = np.array([2.0 + 1j, 3.0])
SYSTEM = cd.build("impact-oscillator")
MOTION = cd.trajectory(SYSTEM, periods=2, samples=4)
x, v = sympy.symbols("x v")


def made(**other):
    return cd.HybridSystem(**{"states": (x, v), "modes": {"only": {x: v, v: -x}}, **other})


CALLS = {
    "eta": lambda value: cd.drill(eta=value),
    "zeta": lambda value: SYSTEM.with_parameters(zeta=value),
    "initial 'x'": lambda value: SYSTEM.with_initial(x=value),
    "parameter 'p'": lambda value: made(parameters={"p": value}),
    "bounds": lambda value: made(bounds={x: (0, value)}),
    "period": lambda value: made(period=value),
    "priority": lambda value: cd.Transition(
        "hit", source="only", target="only", guard=x, direction=1, priority=[value]
    ),
    "guard": lambda value: cd.Transition("hit", source="only", target="only", guard=[value], direction=1),
    "periods": lambda value: cd.trajectory(SYSTEM, periods=value),
    "samples": lambda value: cd.trajectory(SYSTEM, periods=2, samples=value),
    "tolerance": lambda value: cd.trajectory(SYSTEM, periods=2, tolerance=value),
    "method": lambda value: cd.trajectory(SYSTEM, periods=2, method=value),
    "times": lambda value: cd.trajectory(SYSTEM, periods=2, times=value),
    "transient": lambda value: cd.lyapunov_spectrum(SYSTEM, periods=2, transient=value),
    "sweep.omega": lambda value: cd.bifurcation_diagram(SYSTEM, {"omega": value}, periods=2, transient=1),
    "seeds": lambda value: cd.bifurcation_diagram(SYSTEM, {"omega": [2.0]}, periods=2, transient=1, seeds=value),
    "workers": lambda value: cd.bifurcation_diagram(SYSTEM, {"omega": [2.0]}, periods=2, transient=1, workers=value),
    "grid.x": lambda value: cd.basins(SYSTEM, {"x": value, "v": [0.0]}, periods=2, transient=1),
    "path": cd.open,
    "state": lambda value: cd.plot(MOTION, state=value),
    "runs": cd.join,
    "start": lambda value: cd.cut(MOTION, [value], 1.0),
}


@pytest.mark.parametrize("field", CALLS)
@pytest.mark.parametrize("value", [LONG, [LONG], MANY, COMPLEX], ids=["long", "listed", "many", "complex"])
def test_one_error_names_the_field(field, value):
    with pytest.raises(ChaosdrillError) as caught:
        CALLS[field](value)
    assert field in str(caught.value)
    assert len(str(caught.value)) < 500


def test_a_complex_sweep_is_not_made_real():
    with pytest.raises(SettingsError, match=r"^sweep\.omega\[0\] is .*2.*1j.*; expected a number$"):
        cd.bifurcation_diagram(SYSTEM, {"omega": COMPLEX}, periods=2, transient=1)


def test_a_sweep_of_more_points_than_there_is_time_for():
    with pytest.raises(
        SettingsError, match=r"^sweep\.omega is .*; has 1e\+12 entries, and at most 100000000 are taken$"
    ):
        cd.bifurcation_diagram(SYSTEM, {"omega": MANY}, periods=2, transient=1)


@pytest.mark.parametrize("values", [range(10**15), range(10**30), range(10**15, 0, -2)])
def test_a_range_that_no_memory_holds(values):
    with pytest.raises(SettingsError, match=r"^sweep\.omega is range.*; has .* entries, and at most 100000000 are"):
        cd.bifurcation_diagram(SYSTEM, {"omega": values}, periods=2, transient=1)


def test_an_expression_with_a_number_that_no_double_holds():
    with pytest.raises(ChaosdrillError, match="larger than any double"):
        made(modes={"only": {x: v, v: -x + sympy.Integer(LONG)}})


def test_a_cut_without_an_end():
    assert cd.cut(MOTION, 0.0, LONG).sizes == MOTION.sizes


@pytest.mark.parametrize(
    "change",
    [
        lambda table: table.pop("zeta"),
        lambda table: table.update(more=1.0),
        lambda table: table.setdefault("more", 1.0),
        lambda table: table.clear(),
        lambda table: table.__setitem__("zeta", 0.1),
        lambda table: table.__delitem__("zeta"),
        lambda table: table.popitem(),
        lambda table: table.__ior__({"more": 1.0}),
    ],
)
def test_the_parameters_of_a_system_stay(change):
    """What was derived from a system belongs to them; a parameter that is gone made of the period "not positive"."""
    before = dict(SYSTEM.parameters)
    with pytest.raises(SettingsError, match=r"with_parameters\(name=value\) returns a copy with other parameters"):
        change(SYSTEM.parameters)
    assert SYSTEM.parameters == before


def content(system):
    """All that a system is made of, as text; how much of it has been asked for is no part of it."""
    tables = ("parameters", "initial", "bounds", "regions", "quadratures", "labels", "limits")
    return (
        {name: str(dict(getattr(system, name))) for name in tables},
        {mode: str(dict(rates)) for mode, rates in system.modes.items()},
        [(t.name, t.source, t.target, str(t.guard), str(dict(t.reset))) for t in system.transitions],
        (system.name, str(system.states), str(system.time), str(system.period)),
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda system: setattr(system, "period", None),
        lambda system: setattr(system, "parameters", {}),
        lambda system: delattr(system, "initial"),
        lambda system: system.initial.update(mode="nowhere"),
        lambda system: system.initial.__setitem__(system.state_names[0], 9.0),
        lambda system: system.modes.clear(),
        lambda system: next(iter(system.modes.values())).popitem(),
        lambda system: system.bounds.clear(),
        lambda system: system.regions.update(more=1),
        lambda system: system.quadratures.update(more={}),
        lambda system: system.labels.update(more="one more"),
        lambda system: system.limits.update(more=None),
        lambda system: system.transitions[0].reset.update(more=0),
    ],
)
def test_a_system_stays_as_it_is(change):
    before = content(SYSTEM)
    for system in (SYSTEM, copy.copy(SYSTEM), copy.deepcopy(SYSTEM), pickle.loads(pickle.dumps(SYSTEM)), SYSTEM.placed):
        with pytest.raises(SettingsError, match=r"with_parameters\(name=value\) .* with_initial\(name=value\) "):
            change(system)
    assert content(SYSTEM) == before


def test_parameters_are_copied_and_pickled_as_they_are():
    for other in (copy.deepcopy(SYSTEM), copy.copy(SYSTEM), pickle.loads(pickle.dumps(SYSTEM))):
        assert other.parameters == SYSTEM.parameters
        with pytest.raises(SettingsError):
            other.parameters["more"] = 1.0
    own = SYSTEM.parameters.copy()
    own["more"] = 1.0
    assert "more" not in SYSTEM.parameters
    assert SYSTEM.with_parameters(zeta=0.25).parameters["zeta"] == 0.25

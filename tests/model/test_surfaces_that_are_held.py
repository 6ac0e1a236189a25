"""Which surfaces a mode holds: its field does not leave them, and every way in ends on them."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.codegen import kernels_of
from chaosdrill.model.held import Trial, _spread, held_surfaces, kept_apart

HIT = {"name": "hit", "source": "on", "target": "on", "guard": "x", "direction": -1}


def relay(on="-v/tau", up="x + tau*v", reset=None, more=(), modes=None, parameters=None, drift="v"):
    return cd.HybridSystem(
        name="relay",
        states="x v",
        parameters={"tau": 0.6, **(parameters or {})},
        modes={"above": {"x": "v", "v": "-1"}, "below": {"x": "v", "v": "1"}, "on": {"x": drift, "v": on}}
        | (modes or {}),
        transitions=[
            {"name": "down", "source": "above", "target": "on", "guard": "x + tau*v", "direction": -1},
            {"name": "up", "source": "below", "target": "on", "guard": up, "direction": 1, "reset": reset or {}},
            *more,
        ],
        time="t",
    )


def held(system, mode="on"):
    return [str(surface) for surface in held_surfaces(system)[mode]]


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"on": "-v/tau - 1e6*(x + tau*v)"},
        {"on": "-v/tau + sin(x + tau*v)*exp(v)"},
        {"on": "x/tau**2"},
        {"up": "-x - tau*v"},
        {"up": "x/tau + v"},
        {"up": "x - 2", "reset": {"v": "-x/tau"}},
        {"up": "(x + tau*v)*(1 + x**2)"},
    ],
    ids=str,
)
def test_a_field_that_does_not_leave_a_guard_holds_it(more):
    assert held(relay(**more)) == ["tau*v + x"]


def test_rounded_numbers_stand_for_exact_ones():
    system = cd.HybridSystem(
        name="rounded",
        states="x v",
        parameters={},
        modes={"off": {"x": "v", "v": "-1"}, "on": {"x": "v", "v": f"-{1 / 0.6}*v"}},
        transitions=[{"name": "in", "source": "off", "target": "on", "guard": "x + 0.6*v", "direction": -1}],
    )
    assert held(system) == ["0.6*v + x"]


@pytest.mark.parametrize(
    "more",
    [
        {"on": "-3*v"},
        {"on": "-v/tau + 1e-6"},
        {"on": "-k*v", "parameters": {"k": 1 / 0.6}},
        {"up": "x - 5"},
        {"up": "x - 2", "reset": {"v": "-x"}},
        {
            "more": [
                {"name": "hit", "source": "on", "target": "on", "guard": "x", "direction": -1, "reset": {"v": "-v + 1"}}
            ]
        },
        {
            "modes": {"other": {"x": "v", "v": "0"}},
            "more": [{"name": "beside", "source": "other", "target": "on", "guard": "v - 1", "direction": 1}],
        },
    ],
    ids=str,
)
def test_a_direction_that_may_be_there_is_not_lost(more):
    assert held(relay(**more)) == []


def test_what_was_held_before_is_held_on():
    """Between two modes on the surface the motion changes by another guard; none of them loses it."""
    system = relay(
        modes={"on too": {"x": "-x/tau", "v": "-v/tau"}},
        more=[
            {"name": "there", "source": "on", "target": "on too", "guard": "x - 1", "direction": -1},
            {"name": "back", "source": "on too", "target": "on", "guard": "x - 0.5", "direction": -1},
        ],
    )
    assert held(system) == held(system, "on too") == ["tau*v + x"]
    assert held(system, "above") == held(system, "below") == []


def test_what_nothing_establishes_is_not_held():
    """Two modes keep the energy, and an event between them too: it may have any value."""
    system = cd.HybridSystem(
        name="energy",
        states="x v",
        parameters={"e": 1.0},
        modes={"one": {"x": "v", "v": "-x"}, "two": {"x": "-v", "v": "x"}, "end": {"x": "0", "v": "0"}},
        transitions=[
            {"name": "there", "source": "one", "target": "two", "guard": "x", "direction": 1},
            {"name": "back", "source": "two", "target": "one", "guard": "v", "direction": 1},
            {"name": "out", "source": "one", "target": "end", "guard": "x**2 + v**2 - e", "direction": 1},
        ],
    )
    assert held(system, "one") == held(system, "two") == []
    assert held(system, "end") == ["-e + v**2 + x**2"]


def test_modes_that_only_lead_to_each_other_are_on_no_surface():
    """The circle is invariant in both, and reached by neither: a run beside it has a tangent across."""
    system = cd.in_modes(states="x v", field={"x": "v", "v": "-x - Max(x**2 + v**2 - 1, 0)*v"}, initial={"x": 1.4})
    assert not any(held_surfaces(system).values())


def test_a_pinned_state_is_no_surface():
    system = relay(on="0", drift="0", up="v", reset={"v": 0, "x": 2})
    assert held(system) == []


def test_a_capture_that_is_no_guard():
    """Two masses that stick together where they meet: their speeds are one."""
    speed = "(u + m*w)/(1 + m)"
    system = cd.HybridSystem(
        name="capture",
        states="a u b w",
        parameters={"m": 2.0},
        modes={
            "apart": {"a": "u", "u": "-a", "b": "w", "w": "1"},
            "together": {"a": "u", "u": "-a/(1 + m)", "b": "w", "w": "-b/(1 + m)"},
        },
        transitions=[cd.Transition("meet", "apart", "together", "a - b", 1, reset={"u": speed, "w": speed})],
    )
    found = [{str(x) for x in s.free_symbols} - {"m"} for s in held_surfaces(system)["together"]]
    assert sorted(map(sorted, found)) == [["a", "b"], ["u", "w"]]


@pytest.mark.parametrize("names", ["x v", "v x", "z0 a9"])
@pytest.mark.parametrize("reverse", [False, True])
def test_whatever_names_and_order(names, reverse):
    x, v = names.split()
    order = -1 if reverse else 1
    modes = {"off": {x: v, v: "-1"}, "on": {x: v, v: f"-{v}/tau"}, "out": {x: v, v: "1"}}
    transitions = [
        {"name": "in", "source": "off", "target": "on", "guard": f"{x} + tau*{v}", "direction": -1},
        {"name": "leave", "source": "on", "target": "out", "guard": f"{x} - 2", "direction": 1},
    ]
    system = cd.HybridSystem(
        name="named",
        states=names.split()[::order],
        parameters={"tau": 0.6},
        modes=dict(list(modes.items())[::order]),
        transitions=transitions[::order],
    )
    counts = dict(zip(system.mode_names, kernels_of(system).layout.held, strict=True))
    assert counts == {"off": 0, "on": 1, "out": 0}


@pytest.mark.parametrize("free", [["b"], ["xi", "a"]])
def test_parameters_among_the_states_add_none(free):
    system = systems.build("percussive-drill")
    wide = system.augmented(parameters=free)
    assert kernels_of(wide).layout.held == kernels_of(system).layout.held


@pytest.mark.parametrize("unit", [2.0**k for k in (-80, -45, -25, 0, 25, 45, 80)])
def test_in_any_unit_a_held_surface_is_one_and_another_is_none(unit):
    """States in units of their own: a surface that the field of ``on`` keeps, and a thermostat, which stays on none."""
    x, v, tau = sympy.symbols("x v tau", real=True)
    drift, surface = {x: v / unit**2}, unit * x + tau * v / unit
    belt = cd.HybridSystem(
        name="belt",
        states=(x, v),
        parameters={"tau": 0.6},
        modes={"above": drift | {v: -unit}, "below": drift | {v: unit}, "on": drift | {v: -v / tau}},
        transitions=[
            cd.Transition("down", "above", "on", guard=surface, direction=-1),
            cd.Transition("up", "below", "on", guard=surface, direction=1),
        ],
    )
    assert kernels_of(belt).layout.held == (0, 0, 1)
    on, off = {x: 2 / unit - x, v: unit * x - v}, {x: -x, v: unit * x - v}
    thermostat = cd.HybridSystem(
        name="thermostat",
        states=(x, v),
        parameters={},
        modes={"on": on, "off": off},
        transitions=[
            cd.Transition("hot", "on", "off", guard=unit * x - 1.3, direction=1),
            cd.Transition("cold", "off", "on", guard=(unit * x - 0.7) ** 3 * (v / 40 - 1), direction=1),
        ],
    )
    assert kernels_of(thermostat).layout.held == (0, 0)


@pytest.mark.parametrize("unit", [2.0**k for k in (-60, -24, 0, 24, 60)])
def test_what_no_mode_holds_is_not_held_at_zero_in_any_unit(unit):
    """A block that rocks on two corners, whose angle is zero at each of its events."""
    a, w = sympy.symbols("a w", real=True)
    modes = {mode: {a: w / unit, w: unit * a - sign} for mode, sign in (("right", 1), ("left", -1))}
    block = cd.HybridSystem(
        name="block",
        states=(a, w),
        parameters={},
        modes=modes,
        transitions=[
            cd.Transition("to_left", "right", "left", guard=unit * a, direction=-1, reset={w: 0.9 * w}),
            cd.Transition("to_right", "left", "right", guard=unit * a * (1 + w / 50), direction=1, reset={w: 0.9 * w}),
        ],
    )
    assert held_surfaces(block) == {"right": (), "left": ()}


X, V, Y = sympy.symbols("x v y", real=True)


@pytest.mark.parametrize("written", [sympy.sympify, sympy.expand, sympy.simplify], ids=lambda f: f.__name__)
@pytest.mark.parametrize(
    "surface",
    [
        X + 0.3 * V - 0.7 * Y - 2.2,
        X + Y**3 + Y,
        (X + 0.3 * Y) * (1 + X**2),
        sympy.sqrt(1 + X**2) - 1 - Y,
        sympy.tanh(X) - Y,
    ],
    ids=str,
)
def test_a_curved_surface_is_held_in_any_unit_and_however_the_field_is_written(surface, written):
    """The rate of y, or of v, is what keeps the surface, whose numbers are rounded."""
    kept = V if surface.has(V) else Y
    rates = {X: V, V: -sympy.sin(X) - 0.1 * V, Y: sympy.sin(X) - Y}
    others = sum(sympy.diff(surface, s) * rates[s] for s in rates if s != kept)
    on = {**rates, kept: written(-others / sympy.diff(surface, kept))}
    rng = np.random.default_rng(4127)
    for bits in (0, 10, 40, 40):
        units = {s: 2.0 ** float(rng.integers(-bits, bits + 1)) for s in rates}
        put = {s: s * unit for s, unit in units.items()}
        modes = {"above": {**rates, kept: -1}, "below": {**rates, kept: 1}, "on": on}
        system = cd.HybridSystem(
            name="curved",
            states=tuple(rates),
            parameters={},
            modes={
                mode: {s: sympy.sympify(e).xreplace(put) / units[s] for s, e in field.items()}
                for mode, field in modes.items()
            },
            transitions=[
                cd.Transition("down", "above", "on", guard=surface.xreplace(put), direction=-1),
                cd.Transition("up", "below", "on", guard=surface.xreplace(put), direction=1),
            ],
        )
        assert [len(found) for found in held_surfaces(system).values()] == [0, 0, 1], units


def test_an_expression_of_many_numbers_is_gone_through_a_few_times_not_once_for_each(monkeypatch):
    x, walks, whole = sympy.Symbol("lambda", real=True), [], sympy.Basic.xreplace
    monkeypatch.setattr(sympy.Basic, "xreplace", lambda e, rule: walks.append(e) or whole(e, rule))
    _spread([x], [sympy.Add(*(sympy.sin(k * x) for k in range(2, 100)))], np.array([[0.3, 0.7]]))
    assert len(walks) < 10


def test_terms_that_expressions_share_are_compiled_once(monkeypatch):
    system, compiled, whole = relay(), [], sympy.lambdify
    x, v = system.states
    trial = Trial(system)
    trial.points(())
    monkeypatch.setattr(sympy, "lambdify", lambda *given, **how: compiled.append(given) or whole(*given, **how))
    assert not any(trial.zero(m * sympy.sin(x) + n * sympy.cos(v), ()) for m in range(1, 5) for n in range(1, 5))
    assert trial.zero(kept_apart([sympy.sin(x), sympy.cos(v), -sympy.sin(x), -sympy.cos(v)]), ())
    assert len(compiled) == 2

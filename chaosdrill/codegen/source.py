"""The source file of a system: small numba functions of fixed signature, written from its expressions."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.constants import Constants
from chaosdrill.codegen.expression import ExpressionPrinter, special_imports, statements
from chaosdrill.codegen.rounding import rounding_bound
from chaosdrill.codegen.taylor import ModeSource
from chaosdrill.codegen.transit import transit
from chaosdrill.codegen.variational import tangent
from chaosdrill.model.derive import guard_gradient, jacobian, rate, reset_jacobian, reset_map
from chaosdrill.model.places import UnsupportedError

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_HEAD = '''"""Kernels of a hybrid system, generated from its expressions."""

import math

from numba import uint64

from chaosdrill.codegen.signatures import CONSTANTS, SIGNATURES
from chaosdrill.engine.jit import RECIPROCAL, helper, kernel
{imports}
'''

_LANES_HEAD = '''"""Series of a hybrid system for lanes, generated from its expressions."""

import math

from numba import uint64

import chaosdrill.engine.lane_functions
from chaosdrill.codegen.signatures import LANE_SIGNATURES
from chaosdrill.engine.jit import RECIPROCAL, helper, kernel
from chaosdrill.engine.lanes import row_of, table_of
'''

_SERIES = {
    "jet": ("order, t, c, x, ws", "order, row_of(t)[0], row_of(c), row_of(x), table_of(ws)"),
    "jacobian_jet": ("order, c, ws", "order, row_of(c), table_of(ws)"),
    "tangent": (
        "order, c, first, second, ws, row",
        "order, row_of(c), row_of(first), row_of(second), table_of(ws), row",
    ),
}
"""Arguments of the functions that make series, and the same arrays seen as rows of lanes."""


@dataclass(frozen=True)
class Event:
    """A guard that one mode watches: its outcomes are transitions in the order in which they are tried."""

    guard: Any
    direction: int
    outcomes: tuple[int, ...]
    affine: bool
    """Whether it is linear in the states and free of time."""
    entire: bool
    """Whether its series reaches as far as that of the states: sums, products, sines, cosines, and what drives them."""
    timed: bool
    """Whether it depends on time alone."""
    key: int
    """Number of the guard with its direction, the same in all modes that watch it."""
    surface: int
    """Number of the surface on which it is zero, the same for both directions and for the guard with the other sign."""


@dataclass(frozen=True)
class SystemSource:
    """Source text and the layout that goes with it."""

    text: str
    lanes: str
    events: tuple[tuple[Event, ...], ...]
    rows: int
    own_jacobian: bool
    constants: int


def mode_events(system: "HybridSystem", mode: str) -> tuple[Event, ...]:
    """The events that a mode watches, larger priority first, then in order of declaration."""
    groups: dict[tuple[Any, int], list[int]] = {}
    for index, transition in enumerate(system.transitions):
        if mode in transition.source:
            groups.setdefault((transition.guard, transition.direction), []).append(index)
    moving = {*system.states, system.time}
    in_rates = {part for rate in system.modes[mode].values() for part in sympy.preorder_traversal(rate)}
    keys = guard_keys(system)
    surfaces = list(dict.fromkeys(_unsigned(g) for g, _ in keys))
    events = [
        Event(
            guard,
            direction,
            tuple(found),
            affine=not any(g.free_symbols & moving for g in guard_gradient(system, guard)),
            entire=_is_entire(guard, moving, in_rates),
            timed=not guard.free_symbols & set(system.states),
            key=keys.index((guard, direction)),
            surface=surfaces.index(_unsigned(guard)),
        )
        for (guard, direction), found in groups.items()
    ]
    return tuple(sorted(events, key=lambda e: -max(system.transitions[i].priority for i in e.outcomes)))


def guard_keys(system: "HybridSystem") -> list[tuple[Any, int]]:
    """The guards of a system with their directions, each once."""
    return list(dict.fromkeys((t.guard, t.direction) for t in system.transitions))


def _unsigned(guard: Any) -> Any:
    return -guard if guard.could_extract_minus_sign() else guard


def _is_entire(expression: Any, moving: set[Any], in_rates: set[Any]) -> bool:
    if not expression.free_symbols & moving or expression.is_Symbol or expression in in_rates:
        return True
    power = expression.is_Pow and expression.exp.is_Integer and expression.exp > 0
    if not (power or expression.is_Add or expression.is_Mul or expression.func in (sympy.sin, sympy.cos)):
        return False
    return all(_is_entire(part, moving, in_rates) for part in expression.args)


def write_source(system: "HybridSystem") -> SystemSource:
    """Generate the source file of a system."""
    _check_functions(system)
    printer = ExpressionPrinter(system)
    constants = Constants(system, printer)
    events = tuple(mode_events(system, mode) for mode in system.modes)
    modes = [
        ModeSource(system, m, [e.guard for e in ev], constants) for m, ev in zip(system.modes, events, strict=True)
    ]
    bodies = {
        "jet": [m.jet() for m in modes],
        "jacobian_jet": [m.jacobian_jet() for m in modes],
        "tangent": [tangent(m, constants) for m in modes],
    }
    parts = [part for name in bodies for part in _series(name, bodies[name], lanes=False)]
    parts += _pointwise(system, printer, events)
    extra = [f"c[{constants.first + i}] = {printer.doprint(e)}" for i, e in enumerate(constants.expressions)]
    parameters = [f"c[{i}] = p[{i}]" for i in range(len(system.parameters))]
    body = [*parameters, *extra] or ["return"]
    parts.append(_function("constants", "p, c", body, decorator="@kernel(CONSTANTS)"))
    imports = "\n".join(special_imports(_all_expressions(system)))
    text = "\n\n".join([_HEAD.format(imports=imports), *parts]) + "\n"
    series = [part for name in bodies for part in _series(name, bodies[name], lanes=True)]
    return SystemSource(
        text=text,
        lanes="\n\n".join([_LANES_HEAD, *series]) + "\n",
        events=events,
        rows=max(m.row_count for m in modes),
        own_jacobian=any(m.in_jacobian for m in modes),
        constants=constants.first + len(constants.expressions),
    )


def _series(name: str, bodies: list[list[str]], *, lanes: bool) -> list[str]:
    """Source of one function of all modes that makes series, for one trajectory or for lanes."""
    arguments, seen_as_lanes = _SERIES[name]
    parts = [_function(f"_{name}_{i}", arguments, body, decorator="@helper") for i, body in enumerate(bodies)]
    passed = seen_as_lanes if lanes else arguments
    signature = f'LANE_SIGNATURES["{name}"]' if lanes else f'SIGNATURES["{name}"], packed={name == "tangent"}'
    calls = [[f"_{name}_{i}({passed})"] for i in range(len(bodies))]
    return [*parts, _branches(name, f"mode, {arguments}", "mode", calls, f"@kernel({signature})")]


def _pointwise(system: "HybridSystem", printer: ExpressionPrinter, events: tuple[tuple[Event, ...], ...]) -> list[str]:
    n = len(system.states)
    unpack = [f"x{i} = x[{i}]" for i in range(n)]
    outputs = [f"out[{i}]" for i in range(n)]
    direction = [sympy.Symbol(f"d_{i}", real=True) for i in range(n)]
    fields, variations, guards, errors, transits = [], [], [], [], []
    for mode, watched in zip(system.modes, events, strict=True):
        rates = [system.modes[mode][s] for s in system.states] + list(system.quadratures.values())
        fields.append(unpack + statements(printer, [f"out[{i}]" for i in range(len(rates))], rates))
        image = list(jacobian(system, mode) * sympy.Matrix(direction))
        variations.append([*unpack, *(f"d_{i} = d[{i}]" for i in range(n)), *statements(printer, outputs, image)])
        guards.append([_guard_body(system, printer, e) for e in watched])
        errors.append([_error_body(system, printer, mode, e) for e in watched])
        transits.append([transit(system, printer, mode, e) for e in watched])
    return [
        _branches("field", "mode, t, c, x, out", "mode", fields),
        _branches("variation", "mode, t, c, x, d, out", "mode", variations),
        _nested("guard", "mode, j, t, c, x, gradient", unpack, guards, "return 0.0"),
        _nested("guard_error", "mode, j, t, c, x, out", unpack, errors, "return"),
        _nested("transit", "mode, j, tangents, t, c, x, scale, tolerance, event", unpack, transits, "return -1"),
    ]


def _guard_body(system: "HybridSystem", printer: ExpressionPrinter, event: Event) -> list[str]:
    gradient = guard_gradient(system, event.guard)
    names = ["value", *(f"gradient[{i}]" for i in range(len(gradient)))]
    return [*statements(printer, names, [event.guard, *gradient]), "return value"]


def _error_body(system: "HybridSystem", printer: ExpressionPrinter, mode: str, event: Event) -> list[str]:
    return [*statements(printer, ["out[0]", "out[1]"], _rounding_bounds(system, mode, event.guard)), "return"]


def _rounding_bounds(system: "HybridSystem", mode: str, guard: Any) -> list[Any]:
    return [rounding_bound(e) for e in (guard, rate(system, mode, guard))]


def _function(name: str, arguments: str, body: list[str], decorator: str | None = None) -> str:
    decorator = decorator or f'@kernel(SIGNATURES["{name}"])'
    return "\n".join([decorator, f"def {name}({arguments}):", *(f"    {line}" for line in body)])


def _branches(name: str, arguments: str, selector: str, bodies: list[list[str]], decorator: str | None = None) -> str:
    lines = []
    for index, body in enumerate(bodies):
        lines += [f"{'if' if index == 0 else 'elif'} {selector} == {index}:", *(f"    {line}" for line in body)]
    return _function(name, arguments, lines or ["return"], decorator)


def _nested(name: str, arguments: str, head: list[str], bodies: list[list[list[str]]], last: str) -> str:
    lines = list(head)
    for mode, guards in enumerate(bodies):
        for j, body in enumerate(guards):
            lines += [f"if mode == {mode} and j == {j}:", *(f"    {line}" for line in body)]
    return _function(name, arguments, [*lines, last])


def _all_expressions(system: "HybridSystem") -> list[Any]:
    found = [*(f for field in system.modes.values() for f in field.values()), *system.quadratures.values()]
    for transition in system.transitions:
        found += [transition.guard, *reset_map(system, transition)]
        found += [bound for mode in transition.source for bound in _rounding_bounds(system, mode, transition.guard)]
        found += [v for row in reset_jacobian(system, transition) for v in row]
        found += [] if transition.condition is None else [sympy.sympify(transition.condition)]
    return found


def _check_functions(system: "HybridSystem") -> None:
    """Kinks inside of a flow would be stepped over in silence; they belong into modes."""
    for mode, field in system.modes.items():
        for state, slope in field.items():
            if slope.has(sympy.Abs, sympy.Piecewise, sympy.Max, sympy.Min, sympy.sign, sympy.Heaviside, sympy.Mod):
                raise UnsupportedError(
                    *(f"mode {mode!r}, d", state, "/dt = ", slope, " has a kink or a jump; "),
                    "write its branches as modes with a guard between them",
                )
    for transition in system.transitions:
        rows = [guard_gradient(system, transition.guard), *reset_jacobian(system, transition)]
        unprintable = (sympy.Heaviside, sympy.DiracDelta, sympy.Derivative, sympy.Subs)
        if any(value.has(*unprintable) for row in rows for value in row):
            raise UnsupportedError(
                f"transition {transition.name!r}: guard or reset has no derivative; write its "
                "branches as transitions of their own with a condition each"
            )

"""The kernels of a system, written as LLVM code."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import sympy
from llvmlite import ir

from chaosdrill.codegen.code import Code
from chaosdrill.codegen.constants import Constants
from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Index, Module, Number, array
from chaosdrill.codegen.events import Event, guard_keys, mode_events, returns
from chaosdrill.codegen.expression import Expressions
from chaosdrill.codegen.layout import Layout
from chaosdrill.codegen.machine import FROM_PYTHON, register_width
from chaosdrill.codegen.mathematics import imports
from chaosdrill.codegen.mode import Mode
from chaosdrill.codegen.pointwise import Pointwise
from chaosdrill.codegen.series import InLine
from chaosdrill.codegen.signatures import LANES, POINTWISE
from chaosdrill.codegen.steep import Steep, steep_operations
from chaosdrill.codegen.tables import InTables
from chaosdrill.model.held import held_surfaces
from chaosdrill.model.python import Called

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

Series = InLine | InTables

_VECTOR, _MATRIX, _BLOCK = array(1), array(2), array(3)


@dataclass(frozen=True)
class SystemCode:
    """The code of a system and the layout that goes with it."""

    single: tuple[Code, ...]
    modes: tuple[Series, ...]
    events: tuple[tuple[Event, ...], ...]
    steep: tuple[tuple[Steep, ...], ...]
    """Operations of each mode that are watched."""
    layout: Layout

    def lanes(self) -> Code:
        """The same series for several trajectories in SIMD lanes."""
        return _series(self.modes, LANES)


def write(system: "HybridSystem", guards: Sequence[Any] | None = None) -> SystemCode:
    """The code of a system; ``guards``, as they are written, where those of its transitions are their surfaces."""
    guards = [t.guard for t in system.transitions] if guards is None else guards
    constants = Constants(system)
    events = tuple(mode_events(system, mode) for mode in system.modes)
    moving = {*system.states, system.time}
    steep = tuple(
        steep_operations(
            [*system.modes[m].values(), *system.integrands(m), *(e.guard for e in ev if not e.still)], moving
        )
        for m, ev in zip(system.modes, events, strict=True)
    )
    modes = tuple(
        InLine(mode) if mode.small else InTables(mode)
        for m, ev, watched in zip(system.modes, events, steep, strict=True)
        if not system.sources
        for mode in [Mode(system, m, [e.guard for e in ev], [s.argument for s in watched], constants)]
    )
    filled = len(system.states) + len(system.quadratures) + max(map(len, events))
    held = tuple(held_surfaces(system).values())
    single = (
        *((_series(modes, 1),) if modes else ()),
        _pointwise(system, guards, constants, events, held, modes, steep),
    )
    layout = Layout(
        events=tuple(tuple(one.watched() for one in ev) for ev in events),
        rows=max((m.row_count for m in modes), default=filled),
        own_jacobian=any(m.mode.in_jacobian for m in modes),
        constants=len(constants.places),
        held=tuple(map(len, held)),
        steep=tuple(tuple(one.shape for one in watched) for watched in steep),
        watched=tuple(tuple(m.watched_rows()) for m in modes),
        returns=tuple(tuple(row) for row in returns(system, events)),
        moves=tuple(_moves(system)),
        targets=tuple((system.mode_names.index(t.target), int(t.marks_only())) for t in system.transitions),
        feeds=tuple(_feeds(system)),
        proportional=tuple(_proportional(system)),
    )
    return SystemCode(single=single, modes=modes, events=events, steep=steep, layout=layout)


def _code(module: Module, names: Sequence[str]) -> Code:
    return Code(tuple(names), str(module), tuple(imports(module)))


def _series(modes: tuple[Series, ...], width: int) -> Code:
    """The functions of series."""
    module = Module(width, max(width // register_width(), 1))
    row, table, time = (_VECTOR, _MATRIX, DOUBLE) if width == 1 else (_MATRIX, _BLOCK, _VECTOR)

    def entry(name: str, types: dict[str, Any], each: Callable[[Series, str], Any]) -> None:
        f = Function(module, name, {"mode": INT, "order": INT, **types})
        mode, order, *rest = f.arguments
        passed = [order]
        for argument, kind in zip(rest, types.values(), strict=True):
            if kind is time:
                passed.append(argument if width == 1 else f.row(argument)[0].value)
            elif kind is table:
                passed += [f.row(argument).data, f.row_length(argument).value]
            else:
                passed.append(argument if kind is INT else f.row(argument).data)
        _by_number(f, mode, {i: each(m, f"{name}_{i}") for i, m in enumerate(modes)}, passed)

    entry("jet", {"t": time, "c": row, "x": row, "ws": table}, lambda m, name: m.jet(module, name))
    entry("jacobian_jet", {"c": row, "ws": table}, lambda m, name: m.jacobian_jet(module, name))
    vectors = {"c": row, "first": row, "second": row}
    entry("tangent", {**vectors, "ws": table, "row": INT}, lambda m, name: m.tangent(module, name))
    return _code(module, ["jet", "jacobian_jet", "tangent"])


def _by_number(f: Function, number: Any, calls: dict[int, Any], arguments: list[Any], otherwise: Any = None) -> None:
    """Call the function of this number and give what it gives; where there is none give ``otherwise``."""

    def call(called: Any) -> None:
        result = f.builder.call(called, arguments)
        f.give(None if otherwise is None else Number(f, result))

    f.switch(Index(f, number), {i: partial(call, called) for i, called in calls.items()})
    if otherwise is not None:
        f.builder.ret(otherwise)
    f.end()


def _pointwise(
    system: "HybridSystem",
    written: Sequence[Any],
    constants: Constants,
    events: tuple[tuple[Event, ...], ...],
    held: tuple[tuple[Any, ...], ...],
    series: tuple[Series, ...],
    steep: tuple[tuple[Steep, ...], ...],
) -> Code:
    """The functions of one point."""
    module = Module()
    tables = {mode: one for mode, one in zip(system.modes, series, strict=False) if isinstance(one, InTables)}
    large = {mode: f"field_{i}" for i, mode in enumerate(system.modes) if mode in tables}
    modes = [Pointwise(module, system, written, constants, mode, large) for mode in system.modes]

    def passed(f: Function, arguments: Sequence[Any]) -> list[Any]:
        return [a if a.type in (INT, DOUBLE) else f.row(a).data for a in arguments]

    point = {"t": DOUBLE, "c": _VECTOR, "x": _VECTOR}

    def of_modes(name: str, more: dict[str, Any], write_one: Callable[[int, str], Any]) -> None:
        """A function of mode and point."""
        f = Function(module, name, {"mode": INT, **point, **more})
        calls = {i: write_one(i, f"{name}_{i}") for i in range(len(modes))}
        _by_number(f, f.arguments[0], calls, passed(f, f.arguments[1:]))

    def of_guards(
        name: str,
        more: dict[str, Any],
        write_one: Callable[[Pointwise, str, Any], Any],
        guards: Sequence[Sequence[Any]],
        otherwise: Any,
    ) -> None:
        """A function of mode, number of the guard in it, and point; ``otherwise`` where there is none to be written."""
        most = max(map(len, guards), default=0)
        types = {"mode": INT, "j": INT, **point, **more}
        f = Function(module, name, types, otherwise.type)
        mode, j, *rest = f.arguments
        calls = {
            i * most + k: made
            for i, m in enumerate(modes)
            for k, guard in enumerate(guards[i])
            if (made := write_one(m, f"{name}_{i}_{k}", guard)) is not None
        }
        number = f.builder.add(f.builder.mul(mode, INT(most)), j)
        _by_number(f, number, calls, passed(f, rest), otherwise)

    of_modes("field", {"out": _VECTOR}, lambda i, name: tables.get(modes[i].mode, modes[i]).field(module, name))
    varied = {"d": _VECTOR, "out": _VECTOR}
    of_modes("variation", varied, lambda i, name: (series[i] if series else modes[i]).variation(module, name))
    guards = [[*(event.guard for event in watched), *more] for watched, more in zip(events, held, strict=True)]
    of_guards("guard", {"gradient": _VECTOR}, Pointwise.guard, guards, DOUBLE(0.0))
    of_guards("guard_error", {"doubt": _VECTOR}, Pointwise.guard_error, events, DOUBLE(0.0))
    rates = [[*watched, *m.rates()] for watched, m in zip(events, modes, strict=True)]
    of_guards("rate_error", {"doubt": _VECTOR}, Pointwise.rate_error, rates, DOUBLE(0.0))
    event = {"tangents": INT, "scale": _VECTOR, "tolerance": DOUBLE, "event": _VECTOR}
    of_guards("event_map", event, Pointwise.event_map, events, INT(-1))
    of_modes("watch", {"out": _VECTOR}, lambda i, name: modes[i].watch(name, [s.argument for s in steep[i]]))
    _constants(module, constants)
    for name in (*POINTWISE, "constants"):
        _from_python(module, name)
    return _code(module, [*POINTWISE, "constants"])


def _from_python(module: Module, name: str) -> None:
    """A function that takes pointers for the vectors of another."""
    called = module.module.globals[name]
    types = {a.name: DOUBLE.as_pointer() if a.type == _VECTOR else a.type for a in called.args}
    result = called.function_type.return_type
    f = Function(module, name + FROM_PYTHON, types, result)
    passed = [
        f.builder.insert_value(ir.Constant(_VECTOR, ir.Undefined), given, 4) if own.type == _VECTOR else given
        for given, own in zip(f.arguments, called.args, strict=True)
    ]
    value = f.builder.call(called, passed)
    if result != ir.VoidType():
        f.builder.ret(value)
    f.end()


def _constants(module: Module, constants: Constants) -> None:
    f = Function(module, "constants", {"p": _VECTOR, "c": _VECTOR})
    p, c = (f.row(argument) for argument in f.arguments)
    derived = constants.derived()
    parameters = {symbol: p[i] for i, symbol in enumerate(constants.symbols)}
    values = Expressions(f, parameters, [e for _, e in derived])
    for symbol, number in parameters.items():
        c[constants.places[symbol]] = number
    for place, e in derived:
        c[place] = values[e]
    f.end()


def _moves(system: "HybridSystem") -> Iterator[tuple[int, ...]]:
    """By transition and key: 1 where the transition resets a state that the guard depends on."""
    keys = guard_keys(system)
    for transition in system.transitions:
        reset = {state for state, image in transition.reset.items() if image != state}
        yield tuple(int(bool(guard.free_symbols & reset)) for guard, _ in keys)


def _feeds(system: "HybridSystem") -> Iterator[tuple[int, ...]]:
    """By mode and state: 1 where rates in the mode depend on the state."""
    for field in system.modes.values():
        used = set().union(*(rate.free_symbols for rate in field.values()))
        yield tuple(int(state in used) for state in system.states)


def _proportional(system: "HybridSystem") -> Iterator[tuple[int, ...]]:
    """By mode and state: 1 where the state stays zero if it is, and leaves zero at a rate that changes.

    It may change along the motion or from mode to mode. A population that falls by many powers of ten comes back from
    what is left of it.
    """
    moving = {*system.states, system.time}
    rates = [[_rate_from_zero(state, rate) for state, rate in field.items()] for field in system.modes.values()]
    changes = []
    for of_state in zip(*rates, strict=True):
        found = {one for one in of_state if one != 0}
        along = any(one.free_symbols & moving for one in found)
        changes.append(along or (len(found) > 1 and len(set(map(sympy.expand, found)) - {0}) > 1))
    for of_mode in rates:
        yield tuple(int(one != 0 and change) for one, change in zip(of_mode, changes, strict=True))


def _rate_from_zero(state: Any, rate: Any) -> Any:
    """The rate at which a state leaves zero, in parts of itself; 0 if it is fed or rests there, or none is known."""
    if state not in rate.free_symbols or rate.has(Called) or not _vanishes(rate.xreplace({state: sympy.S.Zero})):
        return sympy.S.Zero
    growth = sympy.diff(rate, state).xreplace({state: sympy.S.Zero})
    return sympy.S.Zero if growth.has(sympy.nan, sympy.zoo, sympy.oo) else growth


def _vanishes(e: Any) -> bool:
    if e.is_Add and 1 in Counter(symbol for term in e.args for symbol in term.free_symbols).values():
        # no other term cancels what depends on it
        return False
    return bool(e.is_zero or sympy.expand(e).is_zero)

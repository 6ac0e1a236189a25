"""The kernels of a system: written as LLVM code, compiled, and cached by content."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir

from chaosdrill.codegen import kept
from chaosdrill.codegen.constants import Constants
from chaosdrill.codegen.emitter import DOUBLE, INT, Function, Module, array
from chaosdrill.codegen.events import Event, guard_keys, mode_events, returns
from chaosdrill.codegen.expression import Expressions
from chaosdrill.codegen.machine import FROM_PYTHON, NativeFunction, load, register_width
from chaosdrill.codegen.mathematics import address, imports
from chaosdrill.codegen.pointwise import Pointwise
from chaosdrill.codegen.series import ModeSeries
from chaosdrill.codegen.signatures import CONSTANTS, LANE_SIGNATURES, LANES, POINTWISE, SIGNATURES
from chaosdrill.codegen.steep import Steep, steep_operations
from chaosdrill.model.exponents import specialise
from chaosdrill.model.held import held_surfaces
from chaosdrill.model.places import parameter, places_of
from chaosdrill.model.python import sources

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_compiling, _loading = RLock(), RLock()
_VECTOR, _MATRIX, _BLOCK = array(1), array(2), array(3)


@dataclass(frozen=True)
class Code:
    """LLVM code of functions that are compiled together."""

    names: tuple[str, ...]
    text: str
    imports: tuple[str, ...]
    """Special functions that it calls."""

    def functions(self, signatures: dict[str, Any]) -> dict[str, NativeFunction]:
        """Its functions by name, compiled unless cached on disk."""
        code = kept.object_code(self.text)
        library = load(code, {name: address(name) for name in self.imports})
        return {name: NativeFunction(name, signatures[name], library) for name in self.names}


class NoFunction:
    """A function that a system does not have, and no method calls that it has."""

    address = 0


@dataclass(frozen=True)
class Written:
    """The code of a system and the layout that goes with it."""

    single: tuple[Code, ...]
    modes: tuple[ModeSeries, ...]
    events: tuple[tuple[Event, ...], ...]
    rows: int
    own_jacobian: bool
    constants: int
    held: tuple[int, ...]
    """How many surfaces each mode holds."""
    steep: tuple[tuple[Steep, ...], ...]
    """Operations of each mode that are watched."""
    returns: list[list[int]]
    """See `codegen.events.returns`."""

    def lanes(self) -> Code:
        """The same series for several trajectories in SIMD lanes."""
        return _series(self.modes, LANES)


def write(system: "HybridSystem") -> Written:
    """The code of a system."""
    constants = Constants(system)
    events = tuple(mode_events(system, mode) for mode in system.modes)
    moving = {*system.states, system.time}
    steep = tuple(
        steep_operations([*system.modes[m].values(), *system.integrands(m), *(e.guard for e in ev)], moving)
        for m, ev in zip(system.modes, events, strict=True)
    )
    modes = tuple(
        ModeSeries(system, m, [e.guard for e in ev], [s.argument for s in watched], constants)
        for m, ev, watched in zip(system.modes, events, steep, strict=True)
        if not sources(system)
    )
    filled = len(system.states) + len(system.quadratures) + max(map(len, events))
    held = tuple(held_surfaces(system).values())
    return Written(
        single=(*((_series(modes, 1),) if modes else ()), _pointwise(system, constants, events, held, modes, steep)),
        modes=modes,
        events=events,
        rows=max((m.row_count for m in modes), default=filled),
        own_jacobian=any(m.in_jacobian for m in modes),
        constants=len(constants.places),
        held=tuple(map(len, held)),
        steep=steep,
        returns=returns(system, events),
    )


def _code(module: Module, names: Sequence[str]) -> Code:
    return Code(tuple(names), str(module), tuple(imports(module)))


def _series(modes: tuple[ModeSeries, ...], width: int) -> Code:
    """The functions of series."""
    module = Module(width, max(width // register_width(), 1))
    row, table, time = (_VECTOR, _MATRIX, DOUBLE) if width == 1 else (_MATRIX, _BLOCK, _VECTOR)

    def entry(name: str, types: dict[str, Any], each: Callable[[ModeSeries, str], Any]) -> None:
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
    builder = f.builder
    last = f.made.append_basic_block("none")
    switch = builder.switch(number, last)
    for i, called in calls.items():
        block = f.made.append_basic_block("one")
        switch.add_case(INT(i), block)
        builder.position_at_end(block)
        result = builder.call(called, arguments)
        if otherwise is None:
            builder.ret_void()
        else:
            builder.ret(result)
    builder.position_at_end(last)
    if otherwise is not None:
        builder.ret(otherwise)
    f.end()


def _pointwise(
    system: "HybridSystem",
    constants: Constants,
    events: tuple[tuple[Event, ...], ...],
    held: tuple[tuple[Any, ...], ...],
    series: tuple[ModeSeries, ...],
    steep: tuple[tuple[Steep, ...], ...],
) -> Code:
    """The functions of one point."""
    module = Module()
    tables = {mode: one.tables for mode, one in zip(system.modes, series, strict=False) if one.tables is not None}
    large = {mode: f"field_{i}" for i, mode in enumerate(system.modes) if mode in tables}
    modes = [Pointwise(module, system, constants, mode, large) for mode in system.modes]

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
        otherwise: Any = None,
    ) -> None:
        """A function of mode, number of the guard in it, and point."""
        most = max(map(len, guards), default=0)
        types = {"mode": INT, "j": INT, **point, **more}
        f = Function(module, name, types, None if otherwise is None else otherwise.type)
        mode, j, *rest = f.arguments
        calls = {
            i * most + k: write_one(m, f"{name}_{i}_{k}", guard)
            for i, m in enumerate(modes)
            for k, guard in enumerate(guards[i])
        }
        number = f.builder.add(f.builder.mul(mode, INT(most)), j)
        _by_number(f, number, calls, passed(f, rest), otherwise)

    of_modes("field", {"out": _VECTOR}, lambda i, name: tables.get(modes[i].mode, modes[i]).field(module, name))
    varied = {"d": _VECTOR, "out": _VECTOR}
    of_modes("variation", varied, lambda i, name: (series[i] if series else modes[i]).variation(module, name))
    guards = [[*(event.guard for event in watched), *more] for watched, more in zip(events, held, strict=True)]
    of_guards("guard", {"gradient": _VECTOR}, Pointwise.guard, guards, DOUBLE(0.0))
    of_guards("guard_error", {"doubt": _VECTOR}, Pointwise.guard_error, events, DOUBLE(0.0))
    of_guards("rate_error", {"doubt": _VECTOR}, Pointwise.rate_error, events, DOUBLE(0.0))
    event = {"tangents": INT, "scale": _VECTOR, "tolerance": DOUBLE, "event": _VECTOR}
    of_guards("event_map", event, Pointwise.event_map, events, INT(-1))
    of_modes("watch", {"out": _VECTOR}, lambda i, name: modes[i].watch(module, name, [s.argument for s in steep[i]]))
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


@dataclass(frozen=True)
class Kernels:
    """Compiled functions of a system and the layout of what they fill.

    Attributes
    ----------
    functions : tuple
        The functions of ``codegen.signatures.SIGNATURES``, in order; a system of Python functions has no series.
    written : Written
        Their code.
    rows : int
        Workspace rows before those of the tangents.
    own_jacobian : bool
        Whether the Jacobian needs series that the jet does not hold.
    mode_table : ndarray of int64, shape (modes, 1 + guards)
        Number of guards, then their directions.
    key_table, surface_table : ndarray of int64, shape (modes, guards)
        Number of each guard with its direction, and of the surface on which it is zero; -1 behind the last guard.
    moves_table : ndarray of int64, shape (transitions, keys)
        1 where the transition resets a state that the guard depends on.
    transition_table : ndarray of int64, shape (transitions, 2)
        Target mode; 1 if the transition only marks a section.
    """

    functions: tuple[Any, ...]
    fill_constants: Any
    written: Written
    mode_table: np.ndarray
    key_table: np.ndarray
    surface_table: np.ndarray
    moves_table: np.ndarray
    transition_table: np.ndarray

    @property
    def events(self) -> tuple[tuple[Event, ...], ...]:
        """Guards that each mode watches."""
        return self.written.events

    @property
    def held(self) -> tuple[int, ...]:
        """How many surfaces each mode holds; ``guard`` numbers them behind the guards."""
        return self.written.held

    @property
    def steep(self) -> tuple[tuple[Steep, ...], ...]:
        """Operations of each mode that are watched; ``watch`` gives what they are applied to."""
        return self.written.steep

    @property
    def rows(self) -> int:
        """Workspace rows before those of the tangents."""
        return self.written.rows

    @property
    def own_jacobian(self) -> bool:
        """Whether the Jacobian needs series that the jet does not hold."""
        return self.written.own_jacobian

    @cached_property
    def lanes(self) -> tuple[Any, ...]:
        """The functions of ``codegen.signatures.LANE_SIGNATURES``, compiled on first use."""
        with _loading:
            found = self.written.lanes().functions(LANE_SIGNATURES)
        return tuple(found[name] for name in LANE_SIGNATURES)

    def constants(self, parameters: dict[str, float]) -> np.ndarray:
        """Parameters and the derived constants that the kernels read."""
        c = np.empty(max(self.written.constants, 1))
        self.fill_constants(np.array([*parameters.values(), 0.0], dtype=float), c)
        return c


def _functions(codes: tuple[Code, ...], signatures: dict[str, Any]) -> dict[str, NativeFunction]:
    return {name: found for code in codes for name, found in code.functions(signatures).items()}


def kernels_of(system: "HybridSystem") -> Kernels:
    """The compiled functions of a system, compiled on first use.

    Copies with other numbers share them, unless a number is a whole exponent here and another one there.

    Raises
    ------
    ModelError
        If an expression has no numerical code.
    """
    own = system.parameters
    key = tuple((name, int(own[name])) for name in system.exponent_parameters if own[name].is_integer())
    if key not in system.shared:
        # several threads may ask for the kernels of one system at once, and each would compile them
        with _compiling:
            if key not in system.shared:
                places = places_of(system)
                whole = {places[parameter(name)].name: value for name, value in key}
                system.shared[key] = _compiled(specialise(system.placed, whole) if whole else system.placed)
    found: Kernels = system.shared[key]
    return found


def _compiled(system: "HybridSystem") -> Kernels:
    """Write, compile and load the kernels of a system."""
    written = write(system)
    found = _functions(written.single, {**SIGNATURES, "constants": CONSTANTS})
    guards = max((len(e) for e in written.events), default=0)
    mode_table = np.zeros((len(written.events), 1 + guards), dtype=np.int64)
    for row, events in zip(mode_table, written.events, strict=True):
        row[0] = len(events)
        row[1 : 1 + len(events)] = [e.direction for e in events]
    key_table = np.full((len(written.events), guards), -1, dtype=np.int64)
    surface_table = key_table.copy()
    for keys, surfaces, events in zip(key_table, surface_table, written.events, strict=True):
        keys[: len(events)] = [e.key for e in events]
        surfaces[: len(events)] = [e.surface for e in events]
    return Kernels(
        functions=tuple(found.get(name, NoFunction) for name in SIGNATURES),
        fill_constants=found["constants"],
        written=written,
        mode_table=mode_table,
        key_table=key_table,
        surface_table=surface_table,
        moves_table=_moves_table(system),
        transition_table=_transition_table(system),
    )


def _transition_table(system: "HybridSystem") -> np.ndarray:
    modes = list(system.modes)
    table = np.zeros((max(len(system.transitions), 1), 2), dtype=np.int64)
    for row, transition in zip(table, system.transitions, strict=False):
        row[:] = modes.index(transition.target), int(transition.marks_only())
    return table


def _moves_table(system: "HybridSystem") -> np.ndarray:
    keys = guard_keys(system)
    table = np.zeros((max(len(system.transitions), 1), len(keys)), dtype=np.int64)
    for row, transition in zip(table, system.transitions, strict=False):
        reset = {state for state, image in transition.reset.items() if image != state}
        row[:] = [bool(guard.free_symbols & reset) for guard, _ in keys]
    return table

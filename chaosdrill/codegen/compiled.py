"""The compiled functions of a system and the tables that the engine reads with them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen import record
from chaosdrill.codegen.code import kept_functions
from chaosdrill.codegen.layout import Layout
from chaosdrill.codegen.machine import processor
from chaosdrill.codegen.signatures import CONSTANTS, LANE_SIGNATURES, SIGNATURES, Functions, LaneFunctions
from chaosdrill.errors import ModelError

if TYPE_CHECKING:
    from chaosdrill.codegen.kernels import SystemCode
    from chaosdrill.model.system import HybridSystem

_compiling, _loading = RLock(), RLock()
_SINGLE = {**SIGNATURES, "constants": CONSTANTS}


class NoFunction:
    """A function that a system does not have, and no method calls that it has."""

    address = 0


@dataclass(frozen=True)
class Kernels:
    """Compiled functions of a system and the layout of what they fill; tables are of int64."""

    functions: Functions  # of SIGNATURES; a system of Python functions has no series
    fill_constants: Any
    layout: Layout
    mode_table: np.ndarray  # shape (modes, 1 + guards): number of guards, then their directions
    key_table: np.ndarray  # shape (modes, guards): number of a guard with its direction; -1 behind the last guard
    surface_table: np.ndarray  # the same shape: number of the surface on which a guard is zero
    moves_table: np.ndarray  # shape (transitions, keys): 1 where one resets a state that the guard depends on
    transition_table: np.ndarray  # shape (transitions, 2): target mode; 1 if it only marks a section
    write: "Callable[[], SystemCode]"  # what writes their code
    single: tuple[record.KeptCode, ...]  # where the code of functions is
    of_lanes: list[record.KeptCode]  # where the code of lanes is; empty as long as that is not known

    @cached_property
    def written(self) -> "SystemCode":
        """Their code, with the expressions that it is made of."""
        return self.write()

    @property
    def holds(self) -> record.Held:
        """What a record keeps of them."""
        return record.Held(self.layout, self.single, self.of_lanes[0] if self.of_lanes else None, processor())

    @cached_property
    def lanes(self) -> LaneFunctions:
        """The functions of ``codegen.signatures.LANE_SIGNATURES``, compiled on first use."""
        with _loading:
            found = kept_functions(self.of_lanes[0], LANE_SIGNATURES) if self.of_lanes else None
            if found is None:
                code = self.written.lanes()
                found = code.functions(LANE_SIGNATURES)
                self.of_lanes[:] = [code.kept()]
        return LaneFunctions(**{name: found[name] for name in LANE_SIGNATURES})

    def constants(self, parameters: Mapping[str, float]) -> np.ndarray:
        """Parameters and the derived constants that the kernels read."""
        c = np.empty(max(self.layout.constants, 1))
        self.fill_constants(np.array([*parameters.values(), 0.0], dtype=float), c)
        return c


def kernels_of(system: "HybridSystem") -> Kernels:
    """The compiled functions of a system, compiled on first use.

    Copies with other numbers share them, unless a number is a whole exponent here and another one there. Raises
    `ModelError` if an expression has no numerical code, or a guard nothing that moves.
    """
    own = system.parameters
    key = tuple((name, int(own[name])) for name in system.exponent_parameters if own[name].is_integer())
    if key not in system.shared:
        # several threads may ask for the kernels of one system at once, and each would compile them
        with _compiling:
            if key not in system.shared:
                if system.shared.key is not None and not system.shared.held:
                    record.recall(system.shared)
                write = partial(_write, system, key)
                system.shared[key] = _loaded(system.shared.held.get(key), write) or _compiled(write)
    found: Kernels = system.shared[key]
    return found


def _write(system: "HybridSystem", key: tuple[tuple[str, int], ...]) -> "SystemCode":
    """The code of a system with these whole numbers in its exponents."""
    from chaosdrill.codegen.kernels import write
    from chaosdrill.model.exponents import specialise, specialised
    from chaosdrill.model.places import parameter, places_of

    whole = system.built
    for k, told in whole.unmoved():
        raise ModelError(f"{system.name}: transitions.{whole.transitions[k].name}.guard: {told}")
    places = places_of(system)
    numbers = {places[parameter(name)].name: value for name, value in key}
    guards = [specialised(t.guard.xreplace(places), numbers) for t in whole.transitions]
    return write(specialise(system.placed, numbers) if numbers else system.placed, guards)


def _loaded(held: record.Held | None, write: "Callable[[], SystemCode]") -> Kernels | None:
    """Kernels that were compiled before; None if their code is there no more."""
    if held is None or held.processor != processor():
        return None
    found = [kept_functions(code, _SINGLE) for code in held.single]
    known = [one for one in found if one is not None]
    return None if len(known) < len(found) else _kernels(known, held, write)


def _compiled(write: "Callable[[], SystemCode]") -> Kernels:
    """Write, compile and load the kernels of a system."""
    written = write()
    found = [code.functions(_SINGLE) for code in written.single]
    kernels = _kernels(
        found, record.Held(written.layout, tuple(code.kept() for code in written.single), None, processor()), write
    )
    vars(kernels)["written"] = written
    return kernels


def _kernels(compiled: Sequence[Mapping[str, Any]], held: record.Held, write: "Callable[[], SystemCode]") -> Kernels:
    functions = {name: found for one in compiled for name, found in one.items()}
    layout = held.layout
    guards = max(map(len, layout.events), default=0)
    mode_table = np.zeros((len(layout.events), 1 + guards), dtype=np.int64)
    for row, events in zip(mode_table, layout.events, strict=True):
        row[0] = len(events)
        row[1 : 1 + len(events)] = [e.direction for e in events]
    key_table = np.full((len(layout.events), guards), -1, dtype=np.int64)
    surface_table = key_table.copy()
    for keys, surfaces, events in zip(key_table, surface_table, layout.events, strict=True):
        keys[: len(events)] = [e.key for e in events]
        surfaces[: len(events)] = [e.surface for e in events]
    moves, targets = layout.moves, layout.targets
    return Kernels(
        functions=Functions(**{name: functions.get(name, NoFunction) for name in SIGNATURES}),
        fill_constants=functions["constants"],
        layout=layout,
        mode_table=mode_table,
        key_table=key_table,
        surface_table=surface_table,
        moves_table=np.array(moves, dtype=np.int64) if moves else np.zeros((1, 0), dtype=np.int64),
        transition_table=np.array(targets, dtype=np.int64) if targets else np.zeros((1, 2), dtype=np.int64),
        write=write,
        single=held.single,
        of_lanes=[] if held.lanes is None else [held.lanes],
    )

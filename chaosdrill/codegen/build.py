"""A system's kernels: generated, written to a real file, compiled and cached by content."""

import hashlib
import importlib.util
import sys
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen.ahead import compile_one_run_ahead
from chaosdrill.codegen.cache import cache_folder, code_key, write_private
from chaosdrill.codegen.source import Event, SystemSource, guard_keys, write_source

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_loading = RLock()


@dataclass(frozen=True)
class Kernels:
    """Compiled functions of a system and the layout of what they fill.

    Attributes
    ----------
    functions : tuple
        The functions of ``codegen.signatures.SIGNATURES``, in order.
    path, lanes_path : pathlib.Path
        The generated source files.
    events : tuple of tuple of Event
        Per mode the guards it watches.
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
    lanes_path: Path
    fill_constants: Any
    constant_count: int
    path: Path
    events: tuple[tuple[Event, ...], ...]
    rows: int
    own_jacobian: bool
    mode_table: np.ndarray
    key_table: np.ndarray
    surface_table: np.ndarray
    moves_table: np.ndarray
    transition_table: np.ndarray

    @cached_property
    def lanes(self) -> tuple[Any, ...]:
        """The functions of ``codegen.signatures.LANE_SIGNATURES``, compiled on first use."""
        from chaosdrill.codegen.signatures import LANE_SIGNATURES

        module = _load(self.lanes_path)
        return tuple(getattr(module, name) for name in LANE_SIGNATURES)

    def constants(self, parameters: dict[str, float]) -> np.ndarray:
        """Parameters and the derived constants that the kernels read."""
        c = np.empty(max(self.constant_count, 1))
        self.fill_constants(np.array([*parameters.values(), 0.0], dtype=float), c)
        return c


def compile_system(system: "HybridSystem") -> Kernels:
    """Generate, write, compile and load the kernels of a system."""
    from chaosdrill.codegen.signatures import SIGNATURES

    source = write_source(system)
    path = _write(source.text)
    compile_one_run_ahead()
    module = _load(path)
    guards = max((len(e) for e in source.events), default=0)
    mode_table = np.zeros((len(source.events), 1 + guards), dtype=np.int64)
    for row, events in zip(mode_table, source.events, strict=True):
        row[0] = len(events)
        row[1 : 1 + len(events)] = [e.direction for e in events]
    key_table = np.full((len(source.events), guards), -1, dtype=np.int64)
    surface_table = key_table.copy()
    for keys, surfaces, events in zip(key_table, surface_table, source.events, strict=True):
        keys[: len(events)] = [e.key for e in events]
        surfaces[: len(events)] = [e.surface for e in events]
    return Kernels(
        functions=tuple(getattr(module, name) for name in SIGNATURES),
        fill_constants=module.constants,
        constant_count=source.constants,
        path=path,
        lanes_path=_write(source.lanes),
        events=source.events,
        rows=source.rows,
        own_jacobian=source.own_jacobian,
        mode_table=mode_table,
        key_table=key_table,
        surface_table=surface_table,
        moves_table=_moves_table(system),
        transition_table=_transition_table(system, source),
    )


def _transition_table(system: "HybridSystem", source: SystemSource) -> np.ndarray:
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


def _write(text: str) -> Path:
    key = hashlib.sha256((code_key() + text).encode()).hexdigest()[:20]
    name = f"system_{key}.py"
    try:
        return _written(cache_folder() / "kernels" / name, text)
    except OSError:
        # a disk that is full keeps nothing, and the run goes on
        return _written(Path(tempfile.mkdtemp(prefix="chaosdrill-")) / name, text)


def _written(path: Path, text: str) -> Path:
    """The file with this text; one that holds another text is replaced."""
    content = text.encode()
    if path.exists() and path.read_bytes() == content:
        return path
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_private(path, content)
    return path


def _load(path: Path) -> ModuleType:
    name = f"chaosdrill_{path.stem}"
    # to another thread a module that is being compiled looks like one without its functions
    with _loading:
        if name not in sys.modules:
            spec = importlib.util.spec_from_file_location(name, path)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            sys.modules[name] = module
            try:
                spec.loader.exec_module(module)
            except BaseException:
                del sys.modules[name]
                raise
        return sys.modules[name]

"""The engine is compiled by a process of its own while a system's kernels are compiled by this one.

Both take seconds with empty caches, and compilation runs one at a time in a process; the memory that it takes is that
process's, too. Where that process cannot be started or fails, this one compiles everything.
"""

import contextlib
import os
import subprocess
import sys
from importlib import import_module

from chaosdrill.codegen.cache import lasting_folder
from chaosdrill.codegen.kept import engine_path, places
from chaosdrill.engine.jit import COMPILED, Unit
from chaosdrill.progress import compiling, tell_of_compilation

ONE_RUN = "chaosdrill.engine.flow"
"""Functions that step a single run."""

LANES = "chaosdrill.engine.lane_flow"
"""Functions that step many runs at once."""

_WITH = {LANES: ("chaosdrill.engine.first_event",)}
"""Functions called by address, and compiled beside their callers."""

_started: dict[str, subprocess.Popen[bytes]] = {}


def compile_ahead(part: str) -> None:
    """Start to compile a part of the engine and what it calls by address, unless both are cached.

    A part is a module and its function of the same name. Nothing is begun where nothing would last.
    """
    for one in (part, *_WITH.get(part, ())):
        _begin(one)


def _begin(part: str) -> None:
    if part in _started or (os.cpu_count() or 1) < 2 or not sys.executable or lasting_folder() is None:
        return
    function = part.rpartition(".")[2]
    if any(place.exists() for place in places(part, engine_path(part, function))):
        return
    tell_of_compilation()
    script = f"import {part}; {part}.{function}.compile()"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    with contextlib.suppress(OSError):
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        # nothing is imported from the working directory, whose files may be anybody's
        command = [sys.executable, "-P", "-c", script]
        _started[part] = subprocess.Popen(command, env=environment, **quiet)  # type: ignore[call-overload]


def await_part(part: str) -> None:
    """Wait for any processes that compile a part; this one compiles meanwhile what is called seldom."""
    started = [_started[one] for one in (part, *_WITH.get(part, ())) if one in _started]

    def working() -> list[subprocess.Popen[bytes]]:
        return [process for process in started if process.poll() is None]

    if working():
        import_module(part)
    for one in COMPILED:
        if isinstance(one, Unit) and working():
            one.compile()
    for process in working():
        with compiling():
            process.wait()

"""The engine is compiled by a process of its own while a system's kernels are compiled by this one.

Both take seconds with empty caches, and compilation runs one at a time in a process; the memory that it takes is that
process's, too. Where that process cannot be started or fails, this one compiles everything.
"""

import contextlib
import os
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module

from chaosdrill.codegen.cache import lasting_folder
from chaosdrill.codegen.kept import engine_path, is_own, places
from chaosdrill.engine.jit import COMPILED, Unit
from chaosdrill.progress import compiling, tell_of_compilation

ONE_RUN = "chaosdrill.engine.flow"
"""Functions that step a single run."""

LANES = "chaosdrill.engine.lane_flow"
"""Functions that step many runs at once."""

_WITH = {LANES: ("chaosdrill.engine.first_event",)}
"""Functions called by address, and compiled beside their callers."""

_started: dict[str, subprocess.Popen[bytes]] = {}


@cache
def _turns() -> int:
    """A pipe that holds the numbers of units: whoever has time takes the next one, this process or those it started."""
    end, begin = os.pipe()
    os.write(begin, bytes(range(256)))
    os.close(begin)
    return end


def _take_turns(turns: int, wanted: Callable[[], object]) -> None:
    """Compile the units of a single run whose turn it is, as long as any are left and wanted."""
    import_module(ONE_RUN)
    # they and their order are the same in every process, which begins with the longest
    own = (one for one in COMPILED if isinstance(one, Unit) and is_own(one.py_func))
    units = sorted(own, key=lambda one: one.symbol, reverse=True)
    while wanted() and (number := os.read(turns, 1)) and number[0] < len(units):
        units[number[0]].compile()


def compile_for_another(part: str) -> None:
    """Compile a part, and then units in turn with the process that has started this one, which ends here."""
    # numba would import it to ask for matrix products, which the engine has by itself
    sys.modules["scipy.linalg"] = None  # type: ignore[assignment]
    getattr(import_module(part), _function(part)).compile()
    _take_turns(sys.stdin.fileno(), lambda: True)
    # to clear up what numba has made takes a while
    os._exit(0)


def _function(part: str) -> str:
    return part.rpartition(".")[2]


def compile_ahead(part: str) -> None:
    """Start to compile a part of the engine and what it calls by address, unless both are cached.

    A part is a module and its function of the same name. Nothing is begun where nothing would last.
    """
    for one in (part, *_WITH.get(part, ())):
        _begin(one)


def _begin(part: str) -> None:
    if part in _started or (os.cpu_count() or 1) < 2 or not sys.executable or lasting_folder() is None:
        return
    if any(place.exists() for place in places(part, engine_path(part, _function(part)))):
        return
    tell_of_compilation()
    script = f"from {__name__} import compile_for_another; compile_for_another({part!r})"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    with contextlib.suppress(OSError):
        quiet = {"stdin": _turns(), "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        # nothing is imported from the working directory, whose files may be anybody's
        command = [sys.executable, "-P", "-c", script]
        _started[part] = subprocess.Popen(command, env=environment, **quiet)  # type: ignore[call-overload]


def await_part(part: str) -> None:
    """Wait for any processes that compile a part; all of them compile meanwhile what is called seldom."""
    started = [_started[one] for one in (part, *_WITH.get(part, ())) if one in _started]

    def working() -> list[subprocess.Popen[bytes]]:
        return [process for process in started if process.poll() is None]

    if working():
        _take_turns(_turns(), working)
    for process in working():
        with compiling():
            process.wait()

"""The engine is compiled by a process of its own while a system's kernels are compiled by this one.

Both take seconds with empty caches, and compilation runs one at a time in a process. A mark beside the generated
sources tells that the engine's code is in the disk cache; where that process cannot be started or fails, this one
compiles everything.
"""

import contextlib
import os
import subprocess
import sys

from chaosdrill.codegen.cache import code_key, lasting_folder

ENGINE = "chaosdrill.engine.flow"

_started: list[subprocess.Popen[bytes]] = []


def compile_ahead() -> None:
    """Begin to compile the engine, unless it is loaded or cached, or nothing of it would last."""
    folder = lasting_folder()
    if folder is None:
        return
    mark = folder / f"engine-{code_key()}"
    if _started or ENGINE in sys.modules or mark.exists() or (os.cpu_count() or 1) < 2 or not sys.executable:
        return
    script = f"import {ENGINE}, pathlib, sys; pathlib.Path(sys.argv[1]).touch()"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    with contextlib.suppress(OSError):
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        command = [sys.executable, "-c", script, str(mark)]
        _started.append(subprocess.Popen(command, env=environment, **quiet))  # type: ignore[call-overload]


def await_engine() -> None:
    """Wait for the process that compiles the engine, if there is one; several threads may."""
    for process in tuple(_started):
        process.wait()
    _started.clear()

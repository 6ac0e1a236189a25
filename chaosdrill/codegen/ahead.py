"""The engine is compiled by a process of its own while a system's kernels are compiled by this one.

Both take seconds with empty caches, and compilation runs one at a time in a process; the memory that it takes is that
process's, too. A mark beside the generated sources tells that a part's code is in the disk cache; where that process
cannot be started or fails, this one compiles everything.
"""

import contextlib
import os
import subprocess
import sys

from chaosdrill.codegen.cache import code_key, lasting_folder

ONE_RUN = "chaosdrill.engine.flow"
"""What steps a single run."""

LANES = "chaosdrill.engine.lane_flow"
"""What steps many at once."""

_started: dict[str, subprocess.Popen[bytes]] = {}


def compile_ahead(part: str) -> None:
    """Begin to compile a part of the engine, unless it is loaded or cached, or nothing of it would last."""
    folder = lasting_folder()
    if folder is None:
        return
    mark = folder / f"{part.rpartition('.')[2]}-{code_key()}"
    if part in _started or part in sys.modules or mark.exists() or (os.cpu_count() or 1) < 2 or not sys.executable:
        return
    script = f"import {part}, pathlib, sys; pathlib.Path(sys.argv[1]).touch()"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    with contextlib.suppress(OSError):
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        # nothing is imported from the working directory, whose files may be anybody's
        command = [sys.executable, "-P", "-c", script, str(mark)]
        _started[part] = subprocess.Popen(command, env=environment, **quiet)  # type: ignore[call-overload]


def compile_one_run_ahead() -> None:
    """The same for single runs, unless something else is wanted first."""
    if not _started:
        compile_ahead(ONE_RUN)


def await_part(part: str) -> None:
    """Wait for the process that compiles a part, if there is one."""
    process = _started.get(part)
    if process is not None:
        process.wait()

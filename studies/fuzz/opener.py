"""Open a file in a process of its own, and measure what that takes."""

import os
import resource
import signal
import time
from dataclasses import replace
from multiprocessing.connection import Pipe
from pathlib import Path
from typing import Any

import numpy as np

import chaosdrill as cd
from chaosdrill.archive import trial
from chaosdrill.errors import ArchiveError

MOST_S = 60.0
"""Of processor time, or of a time in which no process works or waits for a processor: load makes neither longer."""

MOST_BYTES = 2**30

SECRET = "of somebody else"
"""What stands in a file beside the archive, and may not be read."""


class Opener:
    """A process that opens files, one after the other; another one takes its place when it fails."""

    def __init__(self) -> None:
        self._child = 0

    def open(self, path: Path) -> tuple[str, float, int]:
        """Open a file.

        Returns
        -------
        outcome : str
            "opened", "refused: ...", or what is wrong, which begins with "WRONG".
        seconds : float
            Of processor time.
        size : int
            Bytes of memory by which the process has grown, or that those have taken which it started, at most.
        """
        if not self._child:
            self._begin()
        begun = _worked(self._child)
        self._line.send(path)
        outcome, size = self._answer(begun)
        took = _worked(self._child) - begun
        if size > MOST_BYTES and not outcome.startswith("WRONG"):
            outcome = f"WRONG: {size / 2**20:.0f} MB"
        if outcome.startswith("WRONG"):
            self.close()
        return outcome, took, size

    def _answer(self, begun: float) -> tuple[str, int]:
        since = time.monotonic()
        while not self._line.poll(0.5):
            if _worked(self._child) - begun > MOST_S:
                return f"WRONG: no answer after {MOST_S:.0f} s of processor time", 0
            if _at_work(self._child):
                since = time.monotonic()
            elif time.monotonic() - since > MOST_S:
                return f"WRONG: has waited for {MOST_S:.0f} s", 0
        try:
            return self._line.recv()
        except EOFError:
            return "WRONG: the process died", 0

    def close(self) -> None:
        """End the process."""
        if self._child:
            self._line.close()
            os.kill(self._child, signal.SIGKILL)
            os.waitpid(self._child, 0)
            self._child = 0

    def _begin(self) -> None:
        self._line, theirs = Pipe()
        self._child = os.fork()
        if self._child:
            theirs.close()
            return
        self._line.close()
        # the parent tells a machine that is slow from a process that waits
        trial.TUNING = replace(trial.TUNING, patience_s=86_400.0)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        while True:
            try:
                path = theirs.recv()
            except EOFError:
                os._exit(0)
            outcome = _opened(path)
            own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
            ended = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
            theirs.send((outcome, 1024 * max(own, ended, *map(_most_taken, _started(os.getpid())))))


def _worked(process: int) -> float:
    """Processor time that a process has taken, with those that it has started, in seconds."""
    own = sum(map(int, _status(process)[11:15])) / os.sysconf("SC_CLK_TCK")
    return own + sum(map(_worked, _started(process)))


def _at_work(process: int) -> bool:
    """Whether a process, or one that it has started, runs or waits for a processor or a disk."""
    return _status(process)[:1] in (["R"], ["D"]) or any(map(_at_work, _started(process)))


def _status(process: int) -> list[str]:
    """What the system tells of a process, beginning with its state; nothing of one that has ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text(errors="replace").rpartition(")")[2].split()
    except OSError:
        return []


def _started(process: int) -> list[int]:
    """Processes that a process has started and that go on."""
    try:
        told = [Path(thread, "children").read_text() for thread in Path(f"/proc/{process}/task").iterdir()]
    except OSError:
        return []
    return list(map(int, " ".join(told).split()))


def _most_taken(process: int) -> int:
    """The most memory that a process has taken, in kB."""
    try:
        lines = Path(f"/proc/{process}/status").read_text(errors="replace").splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in lines if line.startswith("VmHWM:")), 0)


def _opened(path: Path) -> str:
    """What comes of a file."""
    try:
        tree = cd.open(path)
    except ArchiveError as fault:
        return f"refused: {str(fault).removeprefix(f'{path}: '):.200}"
    except BaseException as fault:
        return f"WRONG: {type(fault).__name__}: {fault!s:.300}"
    return "WRONG: reads another file" if _holds_secret(tree) else "opened"


def _holds_secret(tree: Any) -> bool:
    """Whether any texts or numbers are those of the file beside."""
    word = SECRET.encode()
    if any(SECRET in repr(node.attrs) for node in tree.subtree):
        return True
    arrays = (np.asarray(v.values) for node in tree.subtree for v in node.variables.values())
    return any(word in array.tobytes() for array in arrays if array.dtype.kind in "iufS" and array.nbytes < 10**7)

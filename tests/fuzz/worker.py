"""Processes in which inputs are tried, one after the other, with bounded memory; they tell what code was reached."""

import os
import resource
import shutil
import signal
import sys
import threading
import time
import traceback
from contextlib import nullcontext
from multiprocessing.connection import Pipe
from pathlib import Path
from typing import ClassVar

from guard import Guard
from matplotlib import get_cachedir, get_configdir

import chaosdrill
from chaosdrill.codegen.cache import cache_folder

PACKAGE = str(Path(chaosdrill.__file__).parent) + os.sep
MOST_CPU_S = 15.0
"""Untraced: an input that takes longer while its lines are told is tried once more without."""

GIVEN_UP_CPU_S = 150.0
GIVEN_UP_S = 400.0
"""After which an input is given up, by the processor's time or by the clock: tracing takes up to ten times as long, and
other programs may have the processors."""

MOST_BYTES = 2**30
"""By how much a process may grow over all of its inputs."""

MOST_INPUTS = 400
"""After which a process is replaced: what sympy remembers is no fault of an input."""


class Worker:
    """A process that tries inputs of one kind.

    Parameters
    ----------
    kind : module
        `scenes` or one of its like.
    home : pathlib.Path
        Folder that it may fill; it is emptied before every input.
    """

    lines: ClassVar[set] = set()
    """Of all workers of this process."""

    def __init__(self, kind, home):
        self.kind, self.home = kind, home
        self._child = None
        self._tried = 0

    def ask(self, data, traced=True):
        """Try an input.

        Parameters
        ----------
        data : bytes
        traced : bool
            Whether to tell the lines, which takes several times as long.

        Returns
        -------
        outcome : str
        wrong : list of str
        lines : list of tuple
            Lines of the package that this process had not reached before.
        """
        if self._child is None or self._tried >= MOST_INPUTS:
            self.close()
            self._start()
        self._tried += 1
        self._line.send((data, traced))
        try:
            begun, begun_cpu = time.monotonic(), self._cpu_s()
            while not self._line.poll(1.0):
                took, took_cpu = time.monotonic() - begun, self._cpu_s() - begun_cpu
                if took > GIVEN_UP_S or took_cpu > GIVEN_UP_CPU_S:
                    wrong = f"no answer within {took:.0f} s, {took_cpu:.0f} s of them at work"
                    os.kill(self._child, signal.SIGKILL)
                    break
            else:
                return self._line.recv()
        except (EOFError, ConnectionResetError):
            wrong = "the process died"
        code = self.close()
        return "none", [f"{wrong}, exit code {code}"], []

    def close(self):
        """End the process; its exit code, or None."""
        if self._child is None:
            return None
        self.lines.remove(self._line)
        self._line.close()
        code = os.waitstatus_to_exitcode(os.waitpid(self._child, 0)[1])
        self._child = None
        return code

    def _cpu_s(self):
        """Processor time of the process, and of those that it has waited for."""
        stat = Path(f"/proc/{self._child}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, stat[11:15])) / os.sysconf("SC_CLK_TCK")

    def _start(self):
        self._line, theirs = Pipe()
        self._tried = 0
        self._child = os.fork()
        self.lines.add(self._line)
        if self._child:
            theirs.close()
            return
        # a process ends when nobody holds the other end of its line any more
        for line in self.lines:
            line.close()
        try:
            _serve(self.kind, self.home, theirs)
        except BaseException:
            traceback.print_exc()
            os._exit(1)


def _serve(kind, home, line):
    guard = Guard(_is_trial, [cache_folder(), *Path(PACKAGE).rglob("__pycache__"), get_configdir(), get_cachedir()])
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MOST_BYTES, size + MOST_BYTES))
    reached = Reached()
    while True:
        try:
            data, traced = line.recv()
        except EOFError:
            os._exit(0)
        shutil.rmtree(home, ignore_errors=True)
        for name in ("in", "out"):
            (home / name).mkdir(parents=True)
        os.chdir(home / "in")
        (home / "neighbour.nc").write_bytes(b"of somebody else")
        outcome, wrong, took = _attempted(kind, data, home, guard, reached if traced else nullcontext())
        if traced and took > MOST_CPU_S:
            outcome, wrong, took = _attempted(kind, data, home, guard, nullcontext())
        if took > MOST_CPU_S:
            wrong.append(f"took {took:.1f} s")
        wrong += guard.said()
        if (home / "neighbour.nc").read_bytes() != b"of somebody else":
            wrong.append("a neighbour was changed")
        line.send((outcome, wrong, reached.news()))


def _attempted(kind, data, home, guard, watch):
    start = time.process_time()
    try:
        with watch:
            outcome, wrong = kind.attempt(data, home, guard)
    except BaseException:
        outcome, wrong = "raised", [traceback.format_exc()[-4000:]]
    return outcome, wrong, time.process_time() - start


def _is_trial(command):
    """Whether a command is the package's own, which reads an archive without its seal."""
    from chaosdrill.archive.trial import source

    return command[:5] == [sys.executable, "-I", "-S", "-c", source()]


class Reached:
    """Lines of the package that were reached while it is entered."""

    def __init__(self):
        self._left = {}
        self._new = []

    def __enter__(self):
        sys.settrace(self._called)
        threading.settrace(self._called)

    def __exit__(self, *_):
        sys.settrace(None)
        threading.settrace(None)

    def news(self):
        """Those that are new since the last call."""
        new, self._new = self._new, []
        return new

    def _called(self, frame, event, argument):
        code = frame.f_code
        left = self._left.get(code)
        if left is None:
            ours = code.co_filename.startswith(PACKAGE)
            left = self._left[code] = {line for _, _, line in code.co_lines() if line} if ours else set()
        return self._traced if left else None

    def _traced(self, frame, event, argument):
        left = self._left[frame.f_code]
        if event == "line" and frame.f_lineno in left:
            left.discard(frame.f_lineno)
            self._new.append((frame.f_code.co_filename[len(PACKAGE) :], frame.f_lineno))
        return self._traced if left else None

"""What an input may not do, by Python's own audit events: run code, start programs, reach the net, write elsewhere.

A process watched once is watched to its end, and so are those that it forks.
"""

import ast
import os
import socket
import sys
import traceback
from contextlib import contextmanager

from values import OWNED

NEVER = {
    *("os.system", "os.exec", "os.posix_spawn", "os.spawn", "pty.spawn", "os.startfile", "ctypes.dlopen"),
    *("socket.connect", "socket.bind", "socket.getaddrinfo", "socket.sendto", "urllib.Request", "webbrowser.open"),
    *("os.chown", "os.setxattr"),
}
CHANGES = {
    **dict.fromkeys(("os.remove", "os.rmdir"), ((0, 1),)),
    **dict.fromkeys(("os.truncate", "shutil.rmtree"), ((0, None),)),
    "os.mkdir": ((0, 2),),
    "os.utime": ((0, 3),),
    "os.chmod": ((0, 2),),
    **dict.fromkeys(("os.rename", "os.link"), ((0, 2), (1, 3))),
    "shutil.move": ((0, None), (1, None)),
    "os.symlink": ((1, 2),),
}
"""Events by which files change: which of their arguments name them, and which the folder that these names lie in."""

NO_LINK = getattr(os, "O_NOFOLLOW", 0)
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


class Forbidden(BaseException):
    """An input was about to do what none may do."""


class Guard:
    """Watches over this process while `watching`.

    Parameters
    ----------
    allowed_commands : function
        Given the arguments of a process that is to be started, whether it may be.
    always : sequence of path-like
        Folders that may always be written: those of caches.
    """

    def __init__(self, allowed_commands, always=()):
        self.folders = None
        self.allowed_commands = allowed_commands
        self.always = (os.devnull, *always)
        # what a process forked from this one does is written there too
        reading, self._writing = os.pipe()
        self._said = os.fdopen(reading, "rb", buffering=0)
        os.set_blocking(reading, False)
        sys.addaudithook(self._hear)

    @contextmanager
    def watching(self, *folders):
        """Only what lies in these folders may be written while the block runs."""
        self.folders = tuple(os.path.realpath(folder) for folder in (*folders, *self.always))
        try:
            yield
        finally:
            self.folders = None

    def said(self):
        """What was forbidden since the last call."""
        return (self._said.read() or b"").decode(errors="replace").splitlines()

    def _hear(self, event, given):
        if self.folders is None:
            return
        wrong = None
        if event == "open":
            path, _, flags = given
            if isinstance(path, str | bytes | os.PathLike) and flags & WRITING and not self._is_inside(path, flags):
                wrong = f"opens {os.fsdecode(path)!r} for writing"
        elif event in CHANGES:
            entries = [_entry(given[i], -1 if j is None else given[j]) for i, j in CHANGES[event]]
            wrong = next((f"{event} {path!r}" for path in entries if path and not self._lies_inside(path)), None)
        elif event == "os.kill":
            wrong = None if given[1] == 0 or _is_child(given[0]) else f"{event} {given!r:.200}"
        elif event in NEVER:
            wrong = f"{event} {given!r:.200}"
        elif event == "socket.__new__":
            wrong = None if given[1] in (-1, socket.AF_UNIX) else f"{event} {given!r:.200}"
        elif event == "subprocess.Popen" and not self.allowed_commands(given[1]):
            wrong = f"{event} {given!r:.200}"
        elif event == "import":
            wrong = f"imports {given[0]!r:.200}" if OWNED in given[0] else None
        elif event == "compile":
            source = given[0] if isinstance(given[0], bytes) else str(given[0] or "").encode(errors="replace")
            # what is read as a tree is told of when code of it is run
            reads = sys._getframe(1).f_code is ast.parse.__code__
            wrong = "compiles text of the input" if OWNED.encode() in source and not reads else None
        elif event == "exec":
            wrong = f"runs text of the input, from {given[0].co_filename!r:.100}" if _holds(given[0]) else None
        if wrong:
            wrong += f" ({_callers()})"
            os.write(self._writing, f"{wrong}\n".encode(errors="replace")[:1000])
            raise Forbidden(wrong)

    def _is_inside(self, path, flags):
        # what is not to follow a link stays where it is
        return self._lies_inside(_entry(path, -1) if flags & NO_LINK else os.path.realpath(os.fsdecode(path)))

    def _lies_inside(self, real):
        return any(real == folder or real.startswith(folder + os.sep) for folder in self.folders)


def _is_child(process):
    """Whether this process has started another one, such as that which reads archives."""
    try:
        with open(f"/proc/{process}/stat", "rb") as file:
            return int(file.read().rpartition(b")")[2].split()[1]) == os.getpid()
    except OSError:
        return False


def _callers():
    """Who is at work, the innermost first."""
    frames = traceback.extract_stack(sys._getframe(2), limit=6)
    return ", ".join(f"{os.path.basename(frame.filename)}:{frame.lineno}" for frame in reversed(frames))


def _entry(name, handle):
    """Where an entry of a folder lies, wherever it leads; None for an open file."""
    if isinstance(name, int):
        return None
    folder, last = os.path.split(os.fsdecode(name))
    above = os.readlink(f"/proc/self/fd/{handle}") if handle >= 0 else "."
    return os.path.join(os.path.realpath(os.path.join(above, folder)), last)


def _holds(code):
    """Whether a name or constant of compiled code is the word of the inputs."""
    names = (*code.co_names, *code.co_varnames, code.co_name, *(c for c in code.co_consts if isinstance(c, str)))
    inner = (c for c in code.co_consts if hasattr(c, "co_code"))
    return any(OWNED in name for name in names) or any(map(_holds, inner))

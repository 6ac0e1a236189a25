"""Read files in a separate, bounded process: no library of this process ever opens an untrusted file."""

import atexit
import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from math import prod
from pathlib import Path
from typing import Any

from chaosdrill.annotations import Dataset
from chaosdrill.archive import inside
from chaosdrill.archive.tuning import TUNING
from chaosdrill.errors import ArchiveError
from chaosdrill.files import reason_of


class DamagedError(ArchiveError):
    """A fault of the file itself, not of this machine's resources."""


class TruncatedError(DamagedError):
    """Bytes are missing or altered; another copy of the file may be intact."""


_spare: list["FileReader"] = []
"""A process that has sent a file, or the reason why it cannot, waits for the next one, so that none need be started."""


@contextmanager
def borrowed() -> "Iterator[FileReader]":
    """A process that reads one file."""
    reader = FileReader()
    with suppress(IndexError):
        waiting = _spare.pop()
        if waiting.may_go_on():
            reader = waiting
        else:
            waiting.end()
    try:
        yield reader
    finally:
        if not _spare and reader.may_go_on():
            _spare.append(reader)
        else:
            reader.end()


def _end_spare() -> None:
    while _spare:
        _spare.pop().end()


def _leave_spare() -> None:
    """After a fork the reading process belongs to the parent; the child must not use it."""
    while _spare:
        _spare.pop().leave()


atexit.register(_end_spare)
os.register_at_fork(after_in_child=_leave_spare)


class FileReader:
    """A process that reads files, one after the other.

    Raises `ArchiveError` if it cannot be started, with the name of the file that is to be read.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._ready = self._in_step = False
        self._allowed = self._files = 0

    def begin(self, file: Path) -> None:
        """Start the process, unless it is at work already."""
        if self._process is not None:
            return
        command = [sys.executable, "-I", "-S", "-c", source(), *(os.path.abspath(path) for path in sys.path if path)]
        # no programs of the reader's machine are looked for to read what a stranger has written
        environment = {name: text for name, text in os.environ.items() if not name.startswith("HDF5_PLUGIN")}
        environment |= {"HDF5_PLUGIN_PRELOAD": "::", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        # whoever has it open for writing elsewhere has locked a file that is as whole as before
        environment["HDF5_USE_FILE_LOCKING"] = "FALSE"
        pipes: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
        try:
            # in a session of its own it hears no Ctrl-C of the terminal; this process ends it
            self._process = subprocess.Popen(
                command, env=environment, cwd="/", bufsize=0, start_new_session=True, **pipes
            )
        except (OSError, ValueError) as fault:
            raise ArchiveError(
                f"{file}: the process that reads it cannot be started: {reason_of(fault)}; try again"
            ) from fault
        self._ready, self._files = False, 0

    def may_go_on(self) -> bool:
        """Whether the process can read another file."""
        process = self._process
        return process is not None and self._in_step and self._files < TUNING.files_each and process.poll() is None

    def end(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        self.leave()

    def leave(self) -> None:
        """Close the pipes to the process, which then ends by itself."""
        process, self._process = self._process, None
        if process is not None:
            for pipe in (process.stdin, process.stdout, process.stderr):
                if pipe is not None:
                    pipe.close()
            # nobody else waits for it
            process.returncode = process.returncode or 0

    def read(self, file: Path, *, decoded: bool) -> dict[str, Dataset]:
        """The groups of a file, by path.

        ``file``: an ordinary file. ``decoded``: whether missing values become NaN, and scales are applied.

        Raises `ArchiveError` if it cannot be read, with the reason: a `DamagedError` if that is the file.
        """
        self._in_step = False
        self._files += 1
        try:
            self.begin(file)
            return {path: _dataset(*held, decoded=decoded) for path, held in self._groups(file).items()}
        except ArchiveError:
            raise
        except MemoryError as fault:
            raise ArchiveError(f"{file}: not enough memory to read it: {fault}") from fault
        # names and sizes that contradict each other make xarray fail in ways of its own
        except Exception as fault:
            raise _truncated(file, f"{fault!s:.500}") from fault
        finally:
            # a process that has not sent a file to its end would mix it with the next
            if not self._in_step:
                self.end()

    def _groups(self, file: Path) -> dict[str, tuple[dict[str, Any], dict[str, Any]]]:
        """Variables and attributes of each group."""
        import xarray as xr

        process = self._process
        assert process is not None
        assert process.stdin is not None
        self._allowed = inside.most_bytes(os.stat(file).st_size)
        if not self._ready:
            self._ready = "ready" in self._plain(file)
        try:
            process.stdin.write(os.fsencode(os.path.abspath(file)).hex().encode() + b"\n")
        except BrokenPipeError:
            self._ended(file)
        groups: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {}
        while not self._in_step:
            told = self._plain(file)
            if "end" in told:
                self._in_step = True
                continue
            if "group" in told:
                groups[told["group"]] = variables, _ = {}, _attributes(told["attributes"])
                continue
            values = self._values(file, told["type"], tuple(told["shape"]))
            stored = {"dtype": str if told["type"] == inside.TEXT else values.dtype}
            attributes = _attributes(told["attributes"])
            variables[told["variable"]] = xr.Variable(told["dimensions"], values, attributes, stored)
        return groups

    def _values(self, file: Path, kind: str, shape: tuple[int, ...]) -> Any:
        """Values of a variable, which follow its description."""
        import numpy as np

        self._take(file, 8 * prod(shape) if kind == inside.TEXT else np.dtype(kind).itemsize * prod(shape))
        if kind == inside.TEXT:
            texts: list[str] = []
            while len(texts) < prod(shape):
                texts += self._plain(file)["texts"]
            # xarray gives all the room of the longest
            self._take(file, inside.LETTER * len(texts) * max(map(len, texts), default=0))
            values = np.empty(len(texts), object)
            values[:] = texts
            return values.reshape(shape)
        values = np.empty(shape, kind)
        data = values.reshape(-1).view("u1").data
        while len(data):
            letter, size = self._head(file)
            if letter == b"J":
                self._document(file, size)
            if letter != b"D" or not 0 < size <= len(data):
                raise _truncated(file)
            self._receive(file, data[:size])
            data = data[size:]
        return values

    def _take(self, file: Path, size: int) -> None:
        self._allowed -= size
        if self._allowed < 0:
            raise _truncated(file, "it declares more than it can hold")

    def _plain(self, file: Path) -> dict[str, Any]:
        letter, size = self._head(file)
        if letter != b"J":
            raise _truncated(file)
        return self._document(file, size)

    def _document(self, file: Path, size: int) -> dict[str, Any]:
        if size > TUNING.told_bytes:
            raise _truncated(file)
        data = bytearray(size)
        self._receive(file, memoryview(data))
        told: dict[str, Any] = json.loads(data)
        self._in_step = not told.keys().isdisjoint(("fault", "truncated", "memory"))
        if "fault" in told:
            raise DamagedError(f"{file}: {told['fault']}")
        if "truncated" in told:
            raise _truncated(file, told["truncated"])
        if "memory" in told:
            raise ArchiveError(
                f"{file}: reading it takes more memory than is free, or than the {inside.told(inside.MEMORY)} that "
                "any archive needs"
            )
        return told

    def _head(self, file: Path) -> tuple[bytes, int]:
        head = bytearray(9)
        self._receive(file, memoryview(head))
        return bytes(head[:1]), int.from_bytes(head[1:], "little")

    def _receive(self, file: Path, data: memoryview) -> None:
        """Fill ``data`` with what the process sends next."""
        assert self._process is not None
        assert self._process.stdout is not None
        pipe = self._process.stdout.fileno()
        waiting = select.poll()
        waiting.register(pipe, select.POLLIN)
        while len(data):
            if not waiting.poll(1000 * TUNING.patience_s):
                raise ArchiveError(
                    f"{file}: the process that reads it has sent nothing for {TUNING.patience_s:.0f} s; is the machine "
                    "busy, or the disk slow? Try again"
                )
            count = os.readv(pipe, [data])
            if not count:
                self._ended(file)
            data = data[count:]

    def _ended(self, file: Path) -> None:
        """Say why the process has ended."""
        assert self._process is not None
        assert self._process.stderr is not None
        code = self._process.wait()
        said = self._process.stderr.read(10_000).decode(errors="replace").strip().splitlines()
        if not self._ready:
            raise ArchiveError(
                f"{file}: the process that reads it cannot work ({said[-1] if said else f'code {code}':.300}); is "
                "there too little memory, or are too many files open?"
            )
        reason = "reading it never ends" if code == -signal.SIGXCPU else "the HDF5 library crashes on it"
        raise _truncated(file, reason)


def _truncated(file: Path, reason: str = "") -> TruncatedError:
    return TruncatedError(f"{file}: truncated or damaged{reason and f': {reason}'}")


def source() -> str:
    """The text of what the process runs."""
    found = find_spec(inside.__name__)
    text = found.loader.get_source(inside.__name__) if found and found.loader else None  # type: ignore[attr-defined]
    if text is None:
        raise ArchiveError(f"{inside.__name__}: the source of the package is missing")
    return str(text)


def _attributes(told: list[list[Any]]) -> dict[str, Any]:
    """Attributes as the NetCDF library gives them: a list of one entry is that entry."""
    import numpy as np

    found: dict[str, Any] = {}
    for name, kind, held in told:
        values = held if kind == inside.TEXT else np.frombuffer(bytes.fromhex(held), kind).copy()
        found[name] = values[0] if len(values) == 1 else values
    return found


def _dataset(variables: dict[str, Any], attributes: dict[str, Any], *, decoded: bool) -> Dataset:
    import xarray as xr

    # numbers shall not become spans of time
    plain = xr.Dataset(variables, attrs=attributes)
    return xr.decode_cf(plain, decode_times=decoded, decode_timedelta=False, mask_and_scale=decoded).load()

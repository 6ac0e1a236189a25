"""Results of a sweep while it runs: in memory, or in a folder from which a later run goes on.

The folder holds three files. ``manifest.json`` says what the numbers are results of. ``results.bin`` holds the arrays
of all units one after the other, reserved whole before the work begins, so that a disk that is too small is noticed
then. ``journal.txt`` has a line a finished chunk, written after the chunk's results are on the disk, with their
checksum: whatever a kill leaves half-written or a disk damages does not fit its line, and is computed again.
No time of a file or of a clock is ever looked at.
"""

import errno
import json
import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from hashlib import sha256
from math import prod
from pathlib import Path
from typing import Any, Literal

import numpy as np

from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.files import open_ordinary, open_own, read_json, replacing
from chaosdrill.sweep.chunks import Gaps
from chaosdrill.sweep.fingerprint import changes, plain
from chaosdrill.sweep.task import Arrays, Task

MANIFEST, RESULTS, JOURNAL = "manifest.json", "results.bin", "journal.txt"
FORMAT = 1
_ALIGNMENT = 64

MOST_BYTES = 16_000_000_000
"""Size of the results of a sweep, at most: a slip of the pen must not fill a disk."""

MOST_JOURNAL_BYTES = 2**28

MOST_LOOKS = 16
"""How often results are read to compare them with a line of the journal, on average over all of them."""


class Memory:
    """Results of all units in memory.

    Parameters
    ----------
    task : Task
        Whose results.

    Raises
    ------
    SettingsError
        If the results are larger than ``MOST_BYTES``.
    """

    def __init__(self, task: Task) -> None:
        self.columns = {name: (np.dtype(dtype), tuple(shape)) for name, (dtype, shape) in task.columns().items()}
        self.units, self.points_per_unit = task.units, task.points_per_unit
        self.finished: list[tuple[int, int]] = []
        size = self.units * self.unit_bytes
        if size > MOST_BYTES:
            points = self.units * task.points_per_unit
            raise SettingsError(
                f"the results of {points} points would take {1e-9 * size:.3g} GB, {size // points} bytes a point; "
                f"at most {1e-9 * MOST_BYTES:.3g} GB are kept: give fewer points, seeds or recorded periods"
            )
        self._arrays = self._reserve()

    def __enter__(self) -> "Memory":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @property
    def unit_bytes(self) -> int:
        """Bytes of the results of one unit."""
        return sum(dtype.itemsize * prod(shape) for dtype, shape in self.columns.values())

    def put(self, first: int, count: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Keep the results of one chunk."""
        for name, array in self._checked(count, arrays).items():
            self._arrays[name][first : first + count] = array
        self.finished.append((first, count))

    def part(self, first: int, count: int) -> Arrays:
        """Results of one chunk that was kept."""
        return {name: array[first : first + count] for name, array in self._arrays.items()}

    def arrays(self) -> Arrays:
        """Results of all units."""
        return self._arrays

    def _reserve(self) -> Arrays:
        return {name: np.zeros((self.units, *shape), dtype) for name, (dtype, shape) in self.columns.items()}

    def _checked(self, count: int, arrays: Mapping[str, np.ndarray]) -> Arrays:
        given = {name: (array.dtype, array.shape) for name, array in arrays.items()}
        declared = {name: (dtype, (count, *shape)) for name, (dtype, shape) in self.columns.items()}
        if given != declared:
            raise TypeError(f"a chunk of the sweep returned {given}; its task declares {declared}")
        return {name: np.ascontiguousarray(arrays[name]) for name in self.columns}


class Store(Memory):
    """Results of all units in a folder; finished chunks of an earlier run of the same task are taken over.

    Parameters
    ----------
    folder : path-like
        Made if it is not there.
    task : Task
        Whose results.

    Raises
    ------
    SettingsError
        If the folder holds results of another task, with what differs, or if they are larger than ``MOST_BYTES``.
    ArchiveError
        If the folder cannot be read or written, also by the methods.
    """

    def __init__(self, folder: str | os.PathLike[str], task: Task) -> None:
        self.folder = Path(folder)
        self._handles: list[int] = []
        self._manifest = {
            "format": FORMAT,
            "units": task.units,
            "points_per_unit": task.points_per_unit,
            "columns": {name: [str(dtype), list(shape)] for name, (dtype, shape) in task.columns().items()},
            "fingerprint": task.fingerprint(),
        }
        super().__init__(task)

    def __exit__(self, *_: object) -> None:
        while self._handles:
            os.close(self._handles.pop())

    def put(self, first: int, count: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Keep the results of one chunk: first the results, then the line that vouches for them."""
        results, journal = self._handles
        digest = _digest(first, count)
        with self._told("cannot keep a finished chunk"):
            self._look_for_itself()
            for name, array in self._checked(count, arrays).items():
                if array.size:
                    block = array.data.cast("B")
                    digest.update(block)
                    _write(results, block, self._offsets[name] + first * (array.nbytes // count))
            os.fsync(results)
            line = {"first": first, "count": count, "sha256": digest.hexdigest()}
            _write(journal, f"{json.dumps(line)}\n".encode(), None)
            os.fsync(journal)
        self.finished.append((first, count))

    def arrays(self) -> Arrays:
        """Results of all units; whoever changes them changes them in memory only."""
        with self._told("cannot read the results"):
            return self._map("c")

    def _reserve(self) -> Arrays:
        """Open the folder, and map its results into memory: pages of a file, which the system can drop."""
        self._offsets: dict[str, int] = {}
        size = 0
        for name, (dtype, shape) in self.columns.items():
            self._offsets[name] = size
            size += -(-self.units * dtype.itemsize * prod(shape) // _ALIGNMENT) * _ALIGNMENT
        with self._told("cannot be used for finished chunks"):
            self.folder.mkdir(parents=True, exist_ok=True)
            self._check_manifest()
        try:
            with self._told(f"cannot reserve {size / 1e6:.3g} MB for the results"):
                self._handles.append(open_own(self.folder / RESULTS, os.O_RDWR))
                _reserve(self._handles[0], size)
                self._handles.append(open_own(self.folder / JOURNAL, os.O_RDWR | os.O_APPEND))
                arrays = self._map("r")
                self.finished = self._vouched(arrays)
        except BaseException:
            self.__exit__()
            raise
        return arrays

    def _map(self, mode: Literal["r", "c"]) -> Arrays:
        arrays = {}
        for name, (dtype, shape) in self.columns.items():
            whole = (self.units, *shape)
            if prod(whole):
                arrays[name] = np.asarray(np.memmap(self.folder / RESULTS, dtype, mode, self._offsets[name], whole))
            else:
                arrays[name] = np.zeros(whole, dtype)
        return arrays

    def _check_manifest(self) -> None:
        path = self.folder / MANIFEST
        now = plain(self._manifest)
        if not _entries(self.folder / JOURNAL):
            with replacing(path) as draft:
                draft.write_text(json.dumps(now), encoding="utf-8")
            return
        try:
            before = read_json(path)
        except (OSError, ValueError):
            raise ArchiveError(
                f"{path}: missing or damaged, so that nobody can tell what the finished chunks beside it are; "
                "remove the folder to start over"
            ) from None
        if found := changes(before, now):
            raise SettingsError(
                f"{self.folder}: holds finished chunks of other work; nothing was done. What differs:\n  "
                + "\n  ".join(line.removeprefix("fingerprint.") for line in found)
                + "\nRestore what has changed, or remove the folder to start over"
            )

    def _vouched(self, arrays: Arrays) -> list[tuple[int, int]]:
        """Chunks of which journal and results agree; what others held is told."""
        journal = self.folder / JOURNAL
        size = os.fstat(self._handles[1]).st_size
        if size and os.pread(self._handles[1], 1, size - 1) != b"\n":
            # a kill cut the last line short; the next one is not to be appended to it
            _write(self._handles[1], b"\n", None)
        found: list[tuple[int, int]] = []
        looks = MOST_LOOKS * self.units
        entries = [entry for entry in _entries(journal) if entry[0] + entry[1] <= self.units]
        for first, count, expected in entries:
            if count > looks:
                continue
            looks -= count
            digest = _digest(first, count)
            for array in arrays.values():
                if array.size:
                    digest.update(array[first : first + count].data.cast("B"))
            if digest.hexdigest() == expected:
                found.append((first, count))
        named = [(first, count) for first, count, _ in entries]
        if lost := Gaps(self.units, found).left - Gaps(self.units, named).left:
            told = f"{lost * self.points_per_unit} finished points are damaged, or the digests beside them"
            warnings.warn(f"{self.folder}: {told}; they are computed again", stacklevel=2)
        return found

    def _look_for_itself(self) -> None:
        """A file that was removed can still be written; the results would be gone without a word."""
        for name, handle in zip((RESULTS, JOURNAL), self._handles, strict=True):
            if not os.path.samestat(os.stat(self.folder / name), os.fstat(handle)):
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))

    @contextmanager
    def _told(self, what: str) -> Iterator[None]:
        try:
            yield
        except FileNotFoundError as fault:
            raise ArchiveError(f"{self.folder}: {what}: the folder was removed or renamed during the work") from fault
        except OSError as fault:
            reason = fault.strerror or str(fault)
            raise ArchiveError(f"{self.folder}: {what}: {reason}; what was finished before is kept") from fault


def kept_points(folder: Path) -> tuple[int, int]:
    """Points that the journal in a folder names as finished, and points in all; (0, 0) if there is none."""
    try:
        manifest = read_json(folder / MANIFEST)
        units, each = int(manifest["units"]), int(manifest["points_per_unit"])
    except (OSError, ValueError, KeyError, TypeError, OverflowError):
        return 0, 0
    spans = [(first, count) for first, count, _ in _entries(folder / JOURNAL) if first + count <= units]
    return (units - Gaps(units, spans).left) * each, units * each


def _entries(journal: Path) -> list[tuple[int, int, Any]]:
    """First unit, number of units and checksum of the lines of a journal that can be read."""
    found: list[tuple[int, int, Any]] = []
    try:
        file = open_ordinary(journal, MOST_JOURNAL_BYTES)
    except FileNotFoundError:
        return found
    with file:
        for line in file:
            try:
                entry = json.loads(line)
                first, count, digest = entry["first"], entry["count"], entry["sha256"]
            except (ValueError, TypeError, KeyError, RecursionError):
                continue
            if isinstance(first, int) and isinstance(count, int) and first >= 0 < count:
                found.append((first, count, digest))
    return found


def _digest(first: int, count: int) -> Any:
    return sha256(f"{first} {count}\n".encode())


def _write(handle: int, data: Any, offset: int | None) -> None:
    """Write all of it, at an offset or at the end: the system may take it in parts."""
    view = memoryview(data)
    while len(view):
        written = os.write(handle, view) if offset is None else os.pwrite(handle, view, offset)
        view = view[written:]
        offset = None if offset is None else offset + written


def _reserve(handle: int, size: int) -> None:
    """Reserve room in a file, or leave the file and the disk as they were."""
    before = os.fstat(handle).st_size
    there = os.fstatvfs(handle)
    # a file system may take all that is left before it says that this is not enough
    if size - before > there.f_bavail * there.f_frsize:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    try:
        os.posix_fallocate(handle, 0, size)
    # not every system and file system can
    except (AttributeError, OSError) as fault:
        os.ftruncate(handle, before)
        if isinstance(fault, OSError) and fault.errno not in (errno.EOPNOTSUPP, errno.EINVAL):
            raise
        os.ftruncate(handle, size)

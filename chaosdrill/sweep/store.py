"""Results of a running sweep: in memory, or in a folder from which a later run can continue.

The folder holds ``manifest.json``, which says what the numbers are results of, and a file a finished chunk, moved into
place whole and on the disk: its name gives the units, its first bytes are the digest of the name and of the results
that follow. Whatever a kill leaves is not there; what a disk damages does not fit its digest, and is computed again.
No time of a file or of a clock is ever looked at.
"""

import errno
import json
import os
import re
import shutil
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from hashlib import sha256
from math import prod
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np

from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.files import open_ordinary, read_json, replacing
from chaosdrill.sweep.fingerprint import changes, plain
from chaosdrill.sweep.task import Arrays, ChunkSizes, Gaps, Task
from chaosdrill.sweep.tuning import TUNING

MANIFEST = "manifest.json"
FORMAT = 2

_CHUNK = re.compile(r"(0|[1-9][0-9]{0,15})-([1-9][0-9]{0,15})\.chunk")
_DIGEST = sha256().digest_size


class Memory:
    """Results of all units in memory.

    ``task``: whose results.

    Raises `SettingsError` if the results are larger than ``TUNING.result_bytes``.
    """

    def __init__(self, task: Task) -> None:
        self.columns = {name: (np.dtype(dtype), tuple(shape)) for name, (dtype, shape) in task.columns().items()}
        self.units, self.points_per_unit = task.units, task.points_per_unit
        self.finished: list[tuple[int, int]] = []
        self.bytes = size = self.units * self.unit_bytes
        if size > TUNING.result_bytes:
            points = self.units * task.points_per_unit
            raise SettingsError(
                f"the results of {points} points would take {1e-9 * size:.3g} GB, {size // points} bytes a point; "
                f"at most {1e-9 * TUNING.result_bytes:.3g} GB are kept: give fewer points, seeds or recorded periods"
            )
        self._arrays = self._reserve()

    @property
    def unit_bytes(self) -> int:
        """Bytes of the results of one unit."""
        return sum(dtype.itemsize * prod(shape) for dtype, shape in self.columns.values())

    def put(self, first: int, count: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Store the results of one chunk."""
        for name, array in self._checked(count, arrays).items():
            self._arrays[name][first : first + count] = array

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

    ``folder``: created if it does not exist. ``task``: whose results.

    Raises `SettingsError` if the folder holds results of another task, with what differs, or if they are too large.
    Raises `ArchiveError` if the folder cannot be read or written, also by the methods.
    """

    def __init__(self, folder: str | os.PathLike[str], task: Task) -> None:
        self.folder = Path(folder)
        super().__init__(task)
        manifest = {
            "format": FORMAT,
            "units": task.units,
            "points_per_unit": task.points_per_unit,
            "columns": {name: [str(dtype), list(shape)] for name, (dtype, shape) in task.columns().items()},
            "fingerprint": task.fingerprint(),
        }
        self._most = ChunkSizes(self.unit_bytes).most
        _make(self.folder)
        with explained(self.folder, "cannot be used for finished chunks"):
            self._check_manifest(plain(manifest))
            self.finished = self._vouched()
        self._check_room()

    def put(self, first: int, count: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Store the results of one chunk on disk."""
        data = b"".join(array.tobytes() for array in self._checked(count, arrays).values())
        path = self.folder / _name(first, count)
        with explained(self.folder, "cannot keep a finished chunk"), replacing(path) as draft:
            draft.write_bytes(_digest(path.name, data) + data)
        self.finished.append((first, count))

    def part(self, first: int, count: int) -> Arrays:
        """Results of one stored chunk."""
        with explained(self.folder, "cannot read a finished chunk"):
            data = self._read(first, count)
        arrays, offset = {}, 0
        for name, (dtype, shape) in self.columns.items():
            arrays[name] = np.ndarray((count, *shape), dtype, data, offset)
            offset += arrays[name].nbytes
        return arrays

    def arrays(self) -> Arrays:
        """Results of all units, in files without a name that are mapped into memory; changes stay in memory only."""
        with explained(self.folder, "cannot put the results together"), ExitStack() as stack:
            files = {name: stack.enter_context(TemporaryFile(dir=self.folder)) for name in self.columns}
            for first, count in self.finished:
                for name, array in self.part(first, count).items():
                    files[name].seek(first * (array.nbytes // count))
                    files[name].write(array.data)
            arrays = {}
            for name, (dtype, shape) in self.columns.items():
                files[name].flush()
                whole = (self.units, *shape)
                # a file without a byte cannot be mapped
                mapped = np.memmap(files[name], dtype, "c", 0, whole) if prod(whole) else np.zeros(whole, dtype)
                arrays[name] = np.asarray(mapped)
            return arrays

    def _reserve(self) -> Arrays:
        return {}

    def _check_manifest(self, now: Mapping[str, object]) -> None:
        path = self.folder / MANIFEST
        if not _named(self.folder):
            with replacing(path) as draft:
                draft.write_text(json.dumps(now), encoding="utf-8")
            return
        try:
            before = read_json(path)
        except (OSError, ValueError):
            raise ArchiveError(
                f"{path}: missing or damaged, so it is unknown what the finished chunks beside it are; "
                "remove the folder to start over"
            ) from None
        if found := changes(before, now):
            raise SettingsError(
                f"{self.folder}: holds finished chunks of other work; nothing was done. What differs:\n  "
                + "\n  ".join(line.removeprefix("fingerprint.") for line in found)
                + "\nRestore what has changed, or remove the folder to start over"
            )

    def _vouched(self) -> list[tuple[int, int]]:
        """Chunks that match their digests; damaged ones are reported."""
        for draft in self.folder.glob(".*.part"):
            draft.unlink(missing_ok=True)
        named = [(first, count) for first, count in _named(self.folder) if first + count <= self.units]
        found, looks = [], TUNING.looks * self.units
        for first, count in named:
            # it writes no larger ones
            if count <= min(looks, self._most):
                looks -= count
                with suppress(OSError):
                    self._read(first, count)
                    found.append((first, count))
        if lost := Gaps(self.units, found).left - Gaps(self.units, named).left:
            told = f"{lost * self.points_per_unit} finished points are damaged, or the digests beside them"
            warnings.warn(f"{self.folder}: {told}; they are recomputed", stacklevel=2)
        return found

    def _read(self, first: int, count: int) -> bytes:
        """Results in the file of a chunk; OSError if it is not as it was written."""
        path, size = self.folder / _name(first, count), count * self.unit_bytes
        with open_ordinary(path, _DIGEST + size) as file:
            digest, data = file.read(_DIGEST), file.read()
        if len(data) != size or digest != _digest(path.name, data):
            raise OSError(errno.EIO, f"{path.name} is damaged")
        return data

    def _check_room(self) -> None:
        """Refuse a disk without room for the chunks to come, and for all results when they are put together."""
        needed = self.bytes + Gaps(self.units, self.finished).left * self.unit_bytes
        if needed > shutil.disk_usage(self.folder).free:
            with explained(self.folder, f"cannot keep {needed / 1e6:.3g} MB of results"):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _make(folder: Path) -> None:
    """Make a folder unless it is there; ArchiveError where there can be none."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as fault:
        raise ArchiveError(f"{folder}: is not a folder and cannot hold finished chunks; name another one") from fault
    except UnicodeError as fault:
        raise ArchiveError(f"{str(folder)!a}: has characters that file names cannot have; name another one") from fault
    except OSError as fault:
        raise ArchiveError(f"{folder}: this folder cannot be made ({fault.strerror}); name a writable one") from fault


@contextmanager
def explained(folder: Path, what: str) -> Iterator[None]:
    """Turn a fault of the file system into an `ArchiveError` that says what was attempted in a folder."""
    try:
        yield
    except FileNotFoundError as fault:
        raise ArchiveError(f"{folder}: {what}: removed or renamed during the run, or takes no files") from fault
    except (OSError, RuntimeError) as fault:
        reason = (isinstance(fault, OSError) and fault.strerror) or f"{fault} (is the disk full?)"
        kept = any(_CHUNK.fullmatch(name) for _, _, names in os.walk(folder) for name in names)
        raise ArchiveError(f"{folder}: {what}: {reason}{'; finished chunks are kept' if kept else ''}") from fault


def kept_points(folder: Path) -> tuple[int, int]:
    """Points of the chunks in a folder, by their names, and points in all; (0, 0) without any."""
    try:
        manifest = read_json(folder / MANIFEST)
        units, each = int(manifest["units"]), int(manifest["points_per_unit"])
        spans = [(first, count) for first, count in _named(folder) if first + count <= units]
    except (OSError, ValueError, KeyError, TypeError, OverflowError):
        return 0, 0
    return (units - Gaps(units, spans).left) * each, units * each


def _name(first: int, count: int) -> str:
    return f"{first}-{count}.chunk"


def _named(folder: Path) -> list[tuple[int, int]]:
    """First unit and number of units of the chunks in a folder."""
    found = map(_CHUNK.fullmatch, os.listdir(folder))
    return sorted((int(name[1]), int(name[2])) for name in found if name)


def _digest(name: str, data: bytes) -> bytes:
    digest = sha256(name.encode())
    digest.update(data)
    return digest.digest()

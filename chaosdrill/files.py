"""Files that are written whole or not at all."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path
from uuid import uuid4


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Name of a file to write beside ``target``; it takes the target's place when the block ends without a fault.

    The file is flushed to the disk before, so that a full disk, an interrupt or a kill leaves the earlier file whole.
    """
    beside = draft_of(target)
    try:
        yield beside
        flush(beside)
        os.replace(beside, target)
        flush(target.parent)
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def draft_of(target: Path) -> Path:
    """A name in the same folder, so that the move into place is one step of the file system.

    Raises
    ------
    OSError
        If the target can be no file: it has no name, as a folder, or its name holds a zero byte.
    """
    if not target.name:
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    if "\0" in str(target):
        raise OSError(errno.EINVAL, "the name holds a zero byte", str(target))
    return target.with_name(f".{target.name[:80]}.{uuid4().hex[:12]}.part")


def remove_drafts(target: Path) -> None:
    """Remove what processes that were killed while writing ``target`` have left beside it."""
    for draft in target.parent.glob(f".{escape(target.name[:80])}.{'[0-9a-f]' * 12}.part"):
        draft.unlink(missing_ok=True)


def flush(path: Path) -> None:
    """Have the file system write a file or folder to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def small_netcdf_cache() -> Iterator[None]:
    """Have the NetCDF library hold a megabyte of a variable that it writes, not all of it until the file is closed."""
    import netCDF4

    size, slots, preemption = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(min(size, 2**20))
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(size, slots, preemption)

"""Files that are written whole or not at all."""

import errno
import json
import os
import platform
import shutil
import signal
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from glob import escape
from hashlib import sha256
from io import BufferedReader
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import RLock
from types import FrameType
from typing import Any
from uuid import getnode, uuid4

from chaosdrill.tuning import TUNING

HDF5 = b"\x89HDF\r\n\x1a\n"
"""What files of HDF5 begin with, and so of NetCDF-4."""

_BEGINNINGS = {
    HDF5: "NetCDF-4 or HDF5",
    b"CDF\x01": "NetCDF-3",
    b"CDF\x02": "NetCDF-3",
    b"CDF\x05": "NetCDF-3",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"%PDF": "a PDF document",
    b"PK\x03\x04": "a zip file, to be unpacked first",
    b"\x1f\x8b": "compressed by gzip, to be unpacked first",
    b"BZh": "compressed by bzip2, to be unpacked first",
    b"\xfd7zXZ": "compressed by xz, to be unpacked first",
    b"(\xb5/\xfd": "compressed by zstd, to be unpacked first",
    b"\x93NUMPY": "an array of numpy",
    b"\xff\xfe": "text in UTF-16",
    b"\xfe\xff": "text in UTF-16",
}

netcdf = RLock()
"""Held for every call into the NetCDF library, which threads that call it at once bring down."""

# a process that is forked while another thread writes would find the locks of the libraries held for ever
os.register_at_fork(before=netcdf.acquire, after_in_parent=netcdf.release, after_in_child=netcdf.release)


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Name of a file to write beside ``target``; it takes the target's place when the block ends without a fault.

    The file is flushed to the disk before, so that a full disk, an interrupt or a kill leaves the earlier file whole.
    A link is replaced itself. Who may read and write the earlier file may do so with the new one.
    """
    beside = draft_of(target)
    try:
        yield beside
        flush(beside)
        with suppress(OSError):
            if stat.S_ISREG(earlier := os.lstat(target).st_mode):
                os.chmod(beside, stat.S_IMODE(earlier) & 0o777)
        os.replace(beside, target)
        flush(target.parent)
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def followed(target: Path) -> Path:
    """The file that a target named by the user leads to, over the links in its name.

    Raises `OSError` for one that leads over a link that another user has made in a folder where everyone may write,
    such as /tmp: it may be newer than the name that the user gave.
    """
    place, names, links = Path(target.anchor), [*target.relative_to(target.anchor).parts], 0
    while names:
        path = place / names.pop(0)
        if not os.path.islink(path):
            place = path
            continue
        links += 1
        if links > TUNING.most_links:
            raise OSError(errno.ELOOP, f"the name leads in a circle, or over more than {TUNING.most_links} links")
        folder, maker = os.stat(place), os.lstat(path).st_uid
        if folder.st_mode & stat.S_IWOTH and maker not in (os.geteuid(), folder.st_uid):
            raise OSError(errno.EACCES, f"another user has made the link {path} in a folder where everyone may write")
        goal = Path(os.readlink(path))
        place, names = place / goal.anchor, [*goal.relative_to(goal.anchor).parts, *names]
    return place


def is_read_only(target: Path) -> bool:
    """Whether a file is there that this user has been kept from changing."""
    there = os.path.exists(target)
    return there and not os.access(target, os.W_OK, effective_ids=os.access in os.supports_effective_ids)


def draft_of(target: Path) -> Path:
    """A name in the same folder, so that the move into place is one step of the file system.

    Raises `OSError` if the target can be no file: it has no name, as a folder, or its name holds a zero byte or unknown
    letters.
    """
    if not target.name:
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    if "\0" in str(target):
        raise OSError(errno.EINVAL, "the name holds a zero byte", str(target))
    try:
        os.fsencode(target)
    except UnicodeEncodeError:
        letters = f"the name has characters that file names cannot have here ({sys.getfilesystemencoding()})"
        raise OSError(errno.EILSEQ, letters, ascii(str(target))) from None
    owner = f"{_machine()}-{os.getpid()}-{_told(os.getpid())[1]}"
    return target.with_name(f"{_stem(target)}.{owner}-{uuid4().hex[:8]}.part")


def drafts_of(target: Path) -> Iterator[Path]:
    """What was begun beside ``target`` and did not take its place, by whomever."""
    return target.parent.glob(f"{escape(_stem(target))}.*.part")


def remove_drafts(target: Path) -> None:
    """Remove what processes that were killed while writing or removing ``target`` have left beside it.

    What another process is at work on stays, and what a process of another machine has left, until it is a month old.
    """
    for draft in drafts_of(target):
        # another process may be about it
        with suppress(OSError):
            if _is_left(draft):
                remove(draft)


def _is_left(draft: Path) -> bool:
    """Whether a draft is abandoned."""
    machine, *owner = draft.name.split(".")[-2].split("-")
    if machine == _machine() and len(owner) == 3 and owner[0].isascii() and owner[0].isdigit():
        number = int(owner[0])
        try:
            os.kill(number, 0)
        except ProcessLookupError:
            return True
        except (OSError, OverflowError):
            pass
        state, started = _told(number)
        # what has ended keeps its number until the process that started it asks how, and then others get it
        if state in ("Z", "X") or (owner[1] != started and "" not in (owner[1], started)):
            return True
    return time.time() - draft.lstat().st_mtime > TUNING.old_s


@cache
def _machine() -> str:
    """The scope in which a number identifies a process: this machine since its start, and its namespace."""
    told = [platform.node(), str(getnode())]
    with suppress(OSError):
        told = [Path("/proc/sys/kernel/random/boot_id").read_text(), str(os.stat("/proc/self/ns/pid").st_ino)]
    return sha256("\n".join(told).encode(errors="replace")).hexdigest()[:12]


def _told(number: int) -> tuple[str, str]:
    """State of a process, a letter, and when it has begun, as its system counts; empty where this tells nothing."""
    with suppress(OSError, IndexError):
        told = Path(f"/proc/{number}/stat").read_text(errors="replace").rpartition(")")[2].split()
        return told[0], told[19]
    return "", ""


@contextmanager
def signals_wait() -> Iterator[None]:
    """Signals wait until the block has ended, as Ctrl-C does, and are then heard as they would have been.

    What they raise would leave the locks of the libraries that write held for ever. Other threads than the main one
    hear none.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: dict[int, FrameType | None] = {}
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    ours = {number: handler for number, handler in handlers.items() if callable(handler)}
    try:
        for number in ours:
            signal.signal(number, heard.setdefault)
        yield
    finally:
        # what raises an exception comes last
        for number in sorted(ours, key=lambda number: number == signal.SIGINT):
            signal.signal(number, ours[number])
        for told, frame in heard.items():
            ours[signal.Signals(told)](told, frame)


def remove(path: Path) -> None:
    """Remove a file, or a folder with all that it holds; of a link, the link alone."""
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def reason_of(fault: Exception) -> str:
    """What a message says of a fault in reading or writing: the words of the system, where it has some."""
    return getattr(fault, "strerror", None) or str(fault)


def _stem(target: Path) -> str:
    """What the names of a target's drafts begin with, short and its own alone."""
    return f".{target.name[:40]}.{sha256(os.fsencode(target.name)).hexdigest()[:12]}"


def open_own(path: Path, flags: int) -> int:
    """A handle of a file that is made if it is not there, and is the only name of its contents.

    Raises `OSError`, also if it is a link, or no ordinary file: what is written into it would change another file.
    """
    return _checked(path, flags | os.O_CREAT, lambda found: "a link to another file" if found.st_nlink > 1 else "")


def read_json(path: Path) -> Any:
    """What stands in a file of JSON of bounded size and depth.

    Raises `OSError`, as `open_ordinary`. Raises `ValueError` if it is no JSON, or nested too deeply.
    """
    with open_ordinary(path, TUNING.json_bytes) as file:
        try:
            found = json.load(file)
        except RecursionError:
            raise ValueError(f"{path}: nested too deeply") from None
    level = [found]
    for _ in range(TUNING.json_depth):
        level = [
            inner
            for part in level
            if isinstance(part, dict | list)
            for inner in (part.values() if isinstance(part, dict) else part)
        ]
        if not level:
            return found
    raise ValueError(f"{path}: nested too deeply")


def format_of_bytes(start: bytes) -> str:
    """What a file is by its first bytes, in words; empty if they do not tell."""
    told = next((words for beginning, words in _BEGINNINGS.items() if start.startswith(beginning)), "")
    if told or not start:
        return told
    # a letter may be cut at the end
    text = start.decode("utf-8", "ignore")
    plain = len(text.encode()) > len(start) - 4 and all(letter >= " " or letter in "\t\n\r\f" for letter in text)
    return "text" if plain else ""


def open_target(path: Path) -> BufferedReader:
    """An ordinary file that is named, or to which a link of that name leads, open for reading.

    Raises `OSError`, also if it is a pipe or a device, at whose opening one may wait for ever.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    if not stat.S_ISREG(mode := os.fstat(handle).st_mode):
        os.close(handle)
        folder = stat.S_ISDIR(mode)
        code = errno.EISDIR if folder else errno.EINVAL
        raise OSError(code, os.strerror(code) if folder else "not an ordinary file", str(path))
    return open(handle, "rb")


def open_ordinary(path: Path, most: int) -> BufferedReader:
    """An ordinary file of at most ``most`` bytes, open for reading.

    Raises `OSError`, also if it is larger, or a link, a pipe or a device, which may give bytes without an end, or none
    for ever.
    """
    refused = f"larger than {most} bytes"
    return open(_checked(path, os.O_RDONLY, lambda found: refused if found.st_size > most else ""), "rb")


def _checked(path: Path, flags: int, refuse: Callable[[os.stat_result], str]) -> int:
    """A handle of an ordinary file that no link leads to, unless it is refused."""
    try:
        # the opening of a pipe may wait for its other end, or for ever
        handle = os.open(path, flags | os.O_NONBLOCK | os.O_NOFOLLOW, 0o666)
    except OSError as fault:
        if fault.errno != errno.ELOOP:
            raise
        raise OSError(errno.ELOOP, f"{path.name} is a link to another file", str(path)) from None
    found = os.fstat(handle)
    what = refuse(found) if stat.S_ISREG(found.st_mode) else "not an ordinary file"
    if what:
        os.close(handle)
        raise OSError(errno.EINVAL, f"{path.name} is {what}", str(path))
    return handle


def flush(path: Path) -> None:
    """Flush a file or folder to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def name_text(name: str) -> str:
    """A name of a file as text, in any locale: bytes of it that are no UTF-8 appear as ``\\xff``."""
    try:
        held = name.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        held = name.encode("utf-8", "backslashreplace")
    return held.decode("utf-8", "backslashreplace")


@contextmanager
def netcdf_name(file: Path) -> Iterator[Path]:
    """A name of a file that the NetCDF library takes, which knows those alone that are text in the present locale.

    It is the file's own, from the root on, since a relative one might be an address ("file:") or a home ("~") to it, or
    that of a link to the file, which is there while the block runs.

    Raises `OSError` if the folder of temporary files cannot be used for the link.
    """
    if _is_text(file):
        yield file.absolute()
        return
    with TemporaryDirectory(prefix="chaosdrill-") as folder:
        link = Path(folder) / "file.nc"
        if not _is_text(link):
            raise OSError(
                errno.EILSEQ, "neither this name nor that of the folder of temporary files is text", str(file)
            )
        link.symlink_to(file.absolute())
        yield link


def _is_text(name: Path) -> bool:
    try:
        str(name).encode(sys.getfilesystemencoding())
    except UnicodeEncodeError:
        return False
    return True


@contextmanager
def small_netcdf_cache() -> Iterator[None]:
    """Have the NetCDF library hold a megabyte of a variable that it writes, not all of it until the file is closed.

    The library is one thread's alone until then.
    """
    import netCDF4

    with netcdf:
        size, slots, preemption = netCDF4.get_chunk_cache()
        netCDF4.set_chunk_cache(min(size, 2**20))
        try:
            yield
        finally:
            netCDF4.set_chunk_cache(size, slots, preemption)

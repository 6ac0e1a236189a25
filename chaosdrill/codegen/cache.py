"""Cache of compiled code and of what was derived: one folder per user, keyed by content, and its files.

A file holds a digest of what follows it and is renamed into place. One that was cut, emptied or altered is noticed, and
its content is made anew; a disk that is full costs the keeping and nothing else. The digest tells damage. It is no
proof of where a file comes from: that nobody else can write into the folder is.
"""

import atexit
import contextlib
import hashlib
import os
import shutil
import stat
import tempfile
import time
import warnings
from functools import cache
from pathlib import Path
from pwd import getpwuid

from chaosdrill.codegen.tuning import TUNING
from chaosdrill.package import modules, source

SUFFIX, RECORD = ".code", ".record"

DAY_S = 86400.0

_swept: set[Path] = set()


def lasting_folder() -> Path | None:
    """``CHAOSDRILL_CACHE_DIR``, else the user's cache folder; None if it cannot be written, or if others can.

    What lies there is run, so that whoever can write there could have code of their own run.
    """
    try:
        folder = _named_folder()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if others := _others_who_write(folder):
            warnings.warn(f"{folder} is not used to keep compiled code: {others}", stacklevel=2)
            return None
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, KeyError):
        return None


def _named_folder() -> Path:
    """Where compiled code is kept; KeyError for a user without a home."""
    if named := os.environ.get("CHAOSDRILL_CACHE_DIR"):
        return Path(named)
    caches = Path(os.environ.get("XDG_CACHE_HOME", ""))
    # a relative folder would be another one in every working directory
    if not caches.is_absolute():
        home = Path(os.environ.get("HOME", ""))
        caches = (home if home.is_absolute() else Path(getpwuid(os.getuid()).pw_dir)) / ".cache"
    return caches / "chaosdrill"


def _others_who_write(folder: Path) -> str:
    """Who but the user, and root, can put something into a folder, or another one in its place; empty if nobody can."""
    if not hasattr(os, "getuid"):
        return ""
    real = Path(os.path.realpath(folder))
    # who can write into a folder around it can exchange it, unless only the owner of an entry may, as in /tmp
    for place in dict.fromkeys((*Path(os.path.abspath(folder)).parents, *real.parents)):
        found = place.stat()
        if not is_trusted(found.st_uid):
            return f"{place}, in which it lies, belongs to another user"
        if _is_open(found) and not found.st_mode & stat.S_ISVTX:
            return f"others can write into {place}, in which it lies; chmod go-w would keep them out"
    for place in (folder, folder / "kernels", folder / "engine"):
        try:
            found = place.stat()
        except FileNotFoundError:
            continue
        if not is_trusted(found.st_uid):
            return f"{place} belongs to another user"
        if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            return f"others can write into {place}; chmod go-w would keep them out"
        if place == folder and not found.st_mode & (stat.S_IXGRP | stat.S_IXOTH):
            break
    return ""


def is_trusted(owner: int) -> bool:
    """Whether what a user owns may be run: the user's own, and what root owns, who may do anything."""
    return not hasattr(os, "getuid") or owner in (os.getuid(), 0)


def _is_open(found: os.stat_result) -> bool:
    """Whether others than the owner may write; a group that holds nobody else does not count."""
    return bool(found.st_mode & stat.S_IWOTH or (found.st_mode & stat.S_IWGRP and not _is_own_group(found.st_gid)))


@cache
def _is_own_group(number: int) -> bool:
    import grp
    import pwd

    try:
        user, group = pwd.getpwuid(os.getuid()), grp.getgrgid(number)
    except KeyError:
        return False
    own = user.pw_gid == number and group.gr_name == user.pw_name
    return own and not set(group.gr_mem) - {user.pw_name}


@cache
def warm_folder() -> Path | None:
    """``CHAOSDRILL_WARM_DIR``, which ``chaosdrill warm`` has filled; None without one, or if others can write there.

    It is read and never written, so that it may be part of a read-only installation that belongs to root.
    """
    named = os.environ.get("CHAOSDRILL_WARM_DIR")
    if not named or not os.path.isdir(named):
        return None
    if told := _others_who_write(Path(named)):
        warnings.warn(f"{named} is not used for compiled code: {told}", stacklevel=2)
        return None
    return Path(named)


def write_private(path: Path, content: bytes) -> None:
    """Write a file atomically, with write access for the user alone."""
    handle, draft = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(draft, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(draft)
        raise


@cache
def cache_folder() -> Path:
    """A writable folder: the permanent one, otherwise one that goes with the process."""
    if lasting := lasting_folder():
        return lasting
    folder = Path(tempfile.mkdtemp(prefix="chaosdrill-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def read(path: Path) -> bytes | None:
    """Content of a file of compiled code, or None if it is missing or damaged.

    A file that is used takes the present time, once a day, and so does not become an old one.
    """
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
    except OSError:
        return None
    with open(handle, "rb") as file:
        found = os.fstat(handle)
        if not is_trusted(found.st_uid) or _is_open(found):
            warnings.warn(f"{path} belongs to another user, or others can write it; it is compiled anew", stacklevel=2)
            return None
        held = file.read()
    with contextlib.suppress(OSError):
        if _age(path) > DAY_S:
            path.touch()
    digest, content = held[:32], held[32:]
    if hashlib.sha256(content).digest() == digest:
        return content
    warnings.warn(f"{path} is damaged; it is compiled anew", stacklevel=2)
    with contextlib.suppress(OSError):
        path.unlink()
    return None


def put(path: Path, content: bytes) -> None:
    """Write compiled code with its digest; raises `OSError` if it cannot be written."""
    write_private(path, hashlib.sha256(content).digest() + content)


def keep(path: Path, content: bytes) -> None:
    """Keep compiled code, if the disk lets it; what is old in the folder goes."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        put(path, content)
    if path.parent not in _swept:
        _swept.add(path.parent)
        remove_old(path.parent)


def remove_old(folder: Path) -> None:
    """Remove compiled code that has not been used for long.

    Another process may do so at the same time, or be about to read a file that goes: it then compiles anew.
    """
    for path in (*folder.glob(f"*{SUFFIX}"), *folder.glob(f"*{RECORD}")):
        with contextlib.suppress(OSError):
            if _age(path) > TUNING.old_s:
                path.unlink()


def _age(path: Path) -> float:
    return time.time() - path.stat().st_mtime


@cache
def code_key() -> str:
    """Key of the engine's code: a change of any of it, or of how it calls a system, invalidates what was compiled."""
    from importlib.metadata import version

    digest = hashlib.sha256(f"{version('numba')} {version('llvmlite')}".encode())
    compiling = [f"codegen.{name}" for name in ("kinds", "signatures", "layout", "machine", "contacts", "special")]
    for name in (*compiling, *(f"engine.{name}" for name in modules("engine"))):
        digest.update(source(f"chaosdrill.{name}"))
    return digest.hexdigest()[:16]

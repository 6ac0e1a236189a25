"""Compiled code on disk: one file per function, used only if it is intact.

A file holds a digest of what follows it and is renamed into place. One that was cut, emptied or altered is noticed and
compiled anew; a disk that is full costs the keeping and nothing else. The digest tells damage. It is no proof of where
a file comes from: that nobody else can write into the folder is, see `chaosdrill.codegen.cache`.
"""

import contextlib
import hashlib
import os
import stat
import time
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import llvmlite

from chaosdrill.codegen import machine
from chaosdrill.codegen.cache import cache_folder, code_key, is_trusted, warm_folder, write_private
from chaosdrill.codegen.machine import processor
from chaosdrill.package import source
from chaosdrill.progress import compiling, tell_of_compilation

SUFFIX = ".code"

DAY_S = 86400.0

OLD_S = 30 * DAY_S
"""Seconds for which code is kept that nobody uses, as several versions of the package and of systems share a folder."""

_swept: set[Path] = set()


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
        if not is_trusted(found.st_uid) or found.st_mode & stat.S_IWOTH:
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
    """Write compiled code with its digest.

    Raises
    ------
    OSError
        If it cannot be written.
    """
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
    for path in folder.glob(f"*{SUFFIX}"):
        with contextlib.suppress(OSError):
            if _age(path) > OLD_S:
                path.unlink()


def _age(path: Path) -> float:
    return time.time() - path.stat().st_mtime


def object_code(text: str) -> bytes:
    """Machine code of LLVM code for this processor, from the disk or compiled; see `machine.compile_object`."""
    key = hashlib.sha256("\n".join((llvmlite.__version__, *processor(), text)).encode())
    key.update(source(machine.__name__))
    path = cache_folder() / "kernels" / f"{key.hexdigest()[:32]}{SUFFIX}"
    code = read(path)
    if code is None:
        with compiling():
            code = machine.compile_object(text)
        keep(path, code)
    return code


def engine_path(module: str, name: str) -> Path:
    """Where the code of a compiled function of the package is kept: beside the module, or in the user's folder.

    Its name has the content of the package's numerical code, the processor, and what compiles.
    """
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    file = Path(spec.origin)
    key = hashlib.sha256("\n".join((code_key(), *processor())).encode() + source(module))
    beside = file.parent / "__pycache__"
    writable = os.access(beside if beside.exists() else file.parent, os.W_OK)
    folder = beside if writable else cache_folder() / "engine"
    return folder / f"{file.stem}.{name}.{key.hexdigest()[:20]}{SUFFIX}"


def engine_code(module: str, name: str, compile_it: Callable[[], bytes]) -> bytes:
    """Object code of a compiled function of the package, from the disk or compiled."""
    path = engine_path(module, name)
    code = next(filter(None, map(read, places(module, path))), None)
    if code is None:
        tell_of_compilation()
        code = compile_it()
        keep(path, code)
    return code


def places(module: str, path: Path) -> list[Path]:
    """Where the code of a function of the package may be that is kept at a path: an installation may bring it."""
    spec = find_spec(module)
    beside = [] if spec is None or spec.origin is None else [Path(spec.origin).parent / "__pycache__" / path.name]
    warmed = warm_folder()
    return list(dict.fromkeys([*beside, *([] if warmed is None else [warmed / path.name]), path]))


def is_own(function: Callable[..., object]) -> bool:
    """Whether a function is one of the package's modules, whose code is kept by its name."""
    return function.__module__.startswith("chaosdrill.") and "<locals>" not in function.__qualname__

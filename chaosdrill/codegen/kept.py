"""Compiled code on the disk: one file a function, which is whole or is not used.

A file holds a digest of what follows it and is renamed into place. One that was cut, emptied or altered is noticed and
compiled anew; a disk that is full costs the keeping and nothing else. The digest tells damage. It is no proof of where
a file comes from: that nobody else can write into the folder is, see `chaosdrill.codegen.cache`.
"""

import contextlib
import hashlib
import pickle
import time
import warnings
from pathlib import Path
from typing import Any

import llvmlite
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from chaosdrill.codegen.cache import cache_folder, code_key, write_private
from chaosdrill.codegen.machine import compile_object, processor

SUFFIX = ".code"

DAY_S = 86400.0

OLD_S = 30 * DAY_S
"""Seconds for which code is kept that nobody uses, as several versions of the package and of systems share a folder."""

_swept: set[Path] = set()


def read(path: Path) -> bytes | None:
    """The content of a file of compiled code, or None if there is none that is whole.

    A file that is used takes the present time, once a day, and so does not become an old one.
    """
    try:
        held = path.read_bytes()
    except OSError:
        return None
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


def keep(path: Path, content: bytes) -> None:
    """Keep compiled code, if the disk lets it; what is old in the folder goes."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_private(path, hashlib.sha256(content).digest() + content)
    if path.parent not in _swept:
        _swept.add(path.parent)
        remove_old(path.parent)


def remove_old(folder: Path) -> None:
    """Remove compiled code that nobody has used for long.

    Another process may do so at the same time, or be about to read a file that goes: it then compiles anew.
    """
    for path in folder.glob(f"*{SUFFIX}"):
        with contextlib.suppress(OSError):
            if _age(path) > OLD_S:
                path.unlink()


def _age(path: Path) -> float:
    return time.time() - path.stat().st_mtime


def object_code(text: str, *, packed: bool) -> bytes:
    """Machine code of LLVM code for this processor, from the disk or compiled; see `machine.compile_object`."""
    key = hashlib.sha256("\n".join((llvmlite.__version__, *processor(), str(packed), text)).encode())
    path = cache_folder() / "kernels" / f"{key.hexdigest()[:32]}{SUFFIX}"
    code = read(path)
    if code is None:
        code = compile_object(text, packed=packed)
        keep(path, code)
    return code


class CodeFiles:
    """Compiled code of one function of the engine by signature, in the place of numba's index and data files.

    Parameters
    ----------
    folder : str
    name : str
        What the names of the files begin with.
    """

    def __init__(self, folder: str, name: str) -> None:
        self.folder, self.name = Path(folder), name

    def path(self, key: Any) -> Path:
        """The file of a key."""
        return self.folder / f"{self.name}.{hashlib.sha256(repr(key).encode()).hexdigest()[:20]}{SUFFIX}"

    def load(self, key: Any) -> Any:
        """What was saved, or None if there is nothing that is whole."""
        content = read(self.path(key))
        return None if content is None else pickle.loads(content)

    def save(self, key: Any, data: Any) -> None:
        """Keep something, if the disk lets it."""
        keep(self.path(key), dumps(data))


class CodeCache(FunctionCache):
    """numba's disk cache, with the content of the package's numerical code in its key and files that tell damage."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file = CodeFiles(self._cache_path, self._impl.filename_base)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (*super()._index_key(sig, codegen), code_key())

    def _save_overload(self, sig: Any, data: Any) -> None:
        # the folder may have become one that cannot be written
        with contextlib.suppress(OSError):
            super()._save_overload(sig, data)

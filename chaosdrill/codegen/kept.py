"""Compiled code on disk: one file per function, used only if it is intact, see `chaosdrill.codegen.cache`."""

import hashlib
import os
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import llvmlite

from chaosdrill.codegen import machine
from chaosdrill.codegen.cache import SUFFIX, cache_folder, code_key, keep, read, warm_folder
from chaosdrill.codegen.machine import processor
from chaosdrill.package import source
from chaosdrill.progress import compiling, tell_of_compilation


def key_of(text: str) -> str:
    """Key of the machine code of LLVM code for this processor."""
    key = hashlib.sha256("\n".join((llvmlite.__version__, *processor(), text)).encode())
    key.update(source(machine.__name__))
    return key.hexdigest()[:32]


def kept_code(key: str) -> bytes | None:
    """Machine code that was compiled before, by its key."""
    return read(cache_folder() / "kernels" / f"{key}{SUFFIX}")


def object_code(text: str) -> bytes:
    """Machine code of LLVM code for this processor, from the disk or compiled; see `machine.compile_object`."""
    key = key_of(text)
    code = kept_code(key)
    if code is None:
        with compiling():
            code = machine.compile_object(text)
        keep(cache_folder() / "kernels" / f"{key}{SUFFIX}", code)
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

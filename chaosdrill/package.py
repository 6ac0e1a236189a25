"""The package's own files, which may lie in a folder or in a zip file, and with or without docstrings."""

import ast
from collections.abc import Callable
from functools import cache
from pathlib import PurePath
from pkgutil import get_data, iter_modules
from typing import Any

_HOME = PurePath(__file__).parent


def modules(folder: str) -> list[str]:
    """Names of the modules in a folder of the package, such as ``"engine"``, in order, without private ones."""
    found = iter_modules([str(_HOME / folder)])
    return sorted(one.name for one in found if not one.name.startswith("_") and not one.ispkg)


def source(module: str) -> bytes:
    """The source of a module, such as ``"chaosdrill.engine.jit"``."""
    held = get_data("chaosdrill", f"{module.partition('.')[2].replace('.', '/')}.py")
    assert held is not None
    return held


def docstring(function: Callable[..., Any]) -> str:
    """The docstring of a function at the top of a module, which Python leaves out if it is to optimise."""
    if function.__doc__:
        return function.__doc__
    found = _docstrings(function.__module__)
    return found.get(function.__name__, "")


@cache
def _docstrings(module: str) -> dict[str, str]:
    body = ast.parse(source(module)).body
    return {one.name: ast.get_docstring(one) or "" for one in body if isinstance(one, ast.FunctionDef)}

"""Where the code is of functions that the code of kernels calls and no library has."""

import ctypes
import math
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from chaosdrill.codegen.kept import engine_code, engine_path
from chaosdrill.codegen.kinds import UNCOMPILED
from chaosdrill.codegen.machine import Library, callback_object, load
from chaosdrill.progress import compiling

PREFIX = "chaosdrill_"
EXPANDED = "_expanded"
OF_PYTHON = "python_"

ARGUMENTS = {
    "hunt_crossley_exit": 2,
    "hunt_crossley_exit_lam": 2,
    "positive_power": 2,
    **{f"hunt_crossley_{of}": 4 for of in ("peak", "duration", "duration_lam", "duration_n")},
    **{f"hunt_crossley_duration_lam_{of}": 4 for of in ("lam", "n")},
    "gate": 4,
    "log_sum": 3,
    "log_cosh": 1,
    "bernoulli_ratio": 3,
    "taylor_rest": 4,
    "power_rest": 4,
    "even_rest": 4,
}
"""How many numbers the special functions take that have code of their own."""

_MAKES_ARRAYS = f"hunt_crossley_duration{EXPANDED}"
"""A function that makes arrays, by numba's own code, which is there with numba alone."""

_HOME = "chaosdrill.codegen.special"


@cache
def called_back(function: Callable[..., Any], result: Any, *arguments: Any) -> Any:
    """What lets machine code call a function that Python runs, with NaN for what Python refuses to compute."""

    def found(*given: Any) -> Any:
        try:
            return function(*given)
        except (ArithmeticError, ValueError):
            if result is None:
                count, target, stride = given[-3:]
                for m in range(count):
                    target[m * stride] = math.nan
            return math.nan

    return ctypes.CFUNCTYPE(result, *arguments)(found)


@cache
def address(name: str) -> int:
    """Where the code of a special function, or of one of Python, is."""
    title = name.removeprefix(PREFIX)
    if title.startswith(OF_PYTHON):
        from chaosdrill.codegen import python

        return python.address(name)
    if UNCOMPILED:
        return _called_back(title)
    if title == _MAKES_ARRAYS:
        return int(_callback(title, cache=True).address)
    library = load(code_of(title), {})
    _libraries.append(library)
    return library.address(title)


@cache
def python_function(title: str) -> Callable[..., float]:
    """A special function for Python to call, by its machine code."""
    return ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * ARGUMENTS[title])(address(PREFIX + title))


def kept_codes() -> dict[Path, Callable[[], bytes]]:
    """What gives the code of special functions, by where it is kept."""
    from chaosdrill.codegen.special import CODE

    return {engine_path(_HOME, title): partial(code_of, title) for title in CODE}


def code_of(title: str) -> bytes:
    """Object code of a special function, from the disk or compiled."""
    return engine_code(_HOME, title, partial(_compile, title))


_libraries: list[Library] = []
"""Whose functions are called by their addresses for as long as the process lives."""


def _found(title: str) -> tuple[Any, int, bool]:
    """A special function, how many numbers it takes, and whether it is one that gives an expansion."""
    from chaosdrill.codegen.special import CODE, EXPANSIONS

    function = title.removesuffix(EXPANDED)
    expands = function != title
    return (EXPANSIONS if expands else CODE)[function], ARGUMENTS[function], expands


def _called_back(title: str) -> int:
    found, count, expands = _found(title)
    double, whole = ctypes.c_double, ctypes.c_int64
    more = (whole, whole, ctypes.POINTER(double), whole) if expands else ()
    made = called_back(found, None if expands else double, *[double] * count, *more)
    return ctypes.cast(made, ctypes.c_void_p).value or 0


def _callback(title: str, **options: bool) -> Any:
    import numba
    from numba import types

    found, count, expands = _found(title)
    further = (types.int64, types.int64, types.CPointer(types.float64), types.int64) if expands else ()
    signature = (types.void if expands else types.float64)(*[types.float64] * count, *further)
    return numba.cfunc(signature, error_model="numpy", **options)(found.py_func)


def _compile(title: str) -> bytes:
    with compiling():
        made = _callback(title, _nrt=False)
        return callback_object(made.inspect_llvm(), made._wrapper_name, title)

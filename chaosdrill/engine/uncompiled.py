"""The engine as plain Python, where ``NUMBA_DISABLE_JIT=1`` is set: for debuggers, and for the coverage of its lines.

A step takes ten thousand times as long. Functions of a system stay machine code, and what the engine has written in
LLVM code has a twin in Python each. Results agree up to rounding, since compiled series may fuse operations.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from chaosdrill.codegen.kinds import UNCOMPILED
from chaosdrill.codegen.machine import NativeFunction
from chaosdrill.codegen.signatures import LANES


def numbers_of_numpy(function: Any) -> Any:
    """Make the numbers in the code of a function doubles of numpy, whose division by zero is no error."""
    code = function.__code__
    numbers = (np.float64(each) if isinstance(each, float) else each for each in code.co_consts)
    function.__code__ = code.replace(co_consts=tuple(numbers))
    return function


def in_python(function: Any) -> Callable[..., Any]:
    """The function that Python runs, of one that compiled functions call."""
    found: Callable[..., Any] = getattr(function, "py_func", function)
    return found


def machine_code(twin: Callable[..., Any]) -> Callable[[Any], Any]:
    """Make an intrinsic of a function that writes LLVM code; ``twin`` does the same in Python, to the bit."""

    def made(function: Any) -> Any:
        if UNCOMPILED:
            return twin
        from numba.extending import intrinsic

        found = intrinsic(function)
        found.twin = twin
        return found

    return made


class Lanes(np.ndarray):
    """Eight doubles that no operation changes in place."""

    def __iadd__(self, other: Any) -> Any:
        return self + other

    def __isub__(self, other: Any) -> Any:
        return self - other

    def __imul__(self, other: Any) -> Any:
        return self * other

    def __itruediv__(self, other: Any) -> Any:
        return self / other


def as_lanes(value: Any) -> Any:
    """Lanes of eight doubles, or of one for all."""
    return np.array(np.broadcast_to(value, (LANES,)), dtype=float).view(Lanes)


class Row:
    """Lanes in an array of shape (k, 8)."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array.reshape(-1, LANES)

    def __getitem__(self, k: int) -> Any:
        return as_lanes(self.array[k])

    def __setitem__(self, k: int, value: Any) -> None:
        self.array[k] = value


class Table:
    """Rows in an array of shape (rows, k, 8)."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def __getitem__(self, i: int) -> Row:
        return Row(self.array[i])


def visible(value: Any) -> Any:
    """What the engine is given, as compiled code sees it: records with fields, functions that take their numbers."""
    if isinstance(value, tuple):
        parts = map(visible, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    if isinstance(value, np.ndarray) and value.dtype.names:
        return value.view(np.recarray)
    if isinstance(value, NativeFunction):
        return lambda *given: value(*(int(each) if isinstance(each, np.integer) else each for each in given))
    return value


class Uncompiled:
    """A function of the engine that Python runs itself; as `chaosdrill.engine.jit.Compiled` for who calls it."""

    address = 0
    code = b""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.py_func = numbers_of_numpy(function)
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__

    def __call__(self, *arguments: Any) -> Any:
        with np.errstate(all="ignore"):
            return self.py_func(*map(visible, arguments))

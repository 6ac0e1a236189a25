"""Python functions of a system, compiled by numba, as functions that the code of kernels calls.

Each is a cfunc of pointers, made when code that calls it is loaded; none is kept on disk. They return what the
function gives (``value``), its derivative along a direction (``along``) and along two (``second``), and how far
rounding may take the first two (``doubt``, ``doubt_along``); all of them NaN where the function raises an exception.
"""

import ctypes
import math
from collections import namedtuple
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy
from llvmlite import ir

from chaosdrill.codegen.emitter import DOUBLE, Function, Number, Row
from chaosdrill.errors import ModelError
from chaosdrill.model.python import DIGITS, Along, Called, Doubt, Source
from chaosdrill.progress import hear_numba

if TYPE_CHECKING:
    from numba.core.types import Type

PREFIX = "chaosdrill_python_"

_sources: dict[str, Source] = {}


NAMES = {Called: ("value", "along", "second"), Doubt: ("doubt", "doubt_along"), Along: ("along",)}
"""What computes them and their derivatives."""


@dataclass(frozen=True)
class _Kind:
    """How one of the compiled functions carries: arrays beside that of the arguments, and what it asks of a result."""

    rows: int
    argument: str
    result: str


_KINDS = {
    "value": _Kind(0, "{0}", "value_of({0})"),
    "along": _Kind(1, "dual({0}, {1})", "part_of({0})"),
    "second": _Kind(2, "second(dual({0}, {1}), dual({2}, 0.0))", "part_of(part_of({0}))"),
    "doubt": _Kind(1, "bounded({0}, {1})", "part_of({0})"),
    "doubt_along": _Kind(2, "dual_bounded(bounded({0}, {1}), bounded({2}, 0.0))", "part_of(part_of({0}))"),
}


def write_call(f: Function, e: Any, value: Callable[[Any], Number]) -> dict[Any, Number]:
    """Write the call that an expression of a Python function asks for; returns all that it gives, by expression."""
    source, _, *rest = e.args
    by: Sequence[Any] = ()
    if not isinstance(e, Along):
        by, *rest = rest
    rows = [rest]
    if isinstance(e, Along | Doubt):
        half = len(rest) // 2
        rows = [rest[:half], rest[half:]]
    rows += [[sympy.Integer(i == k) for i in range(len(rows[0]))] for k in by]
    names = NAMES[type(e)]
    if len(by) >= len(names):
        raise ModelError(f"{source.name}: derivatives of order {len(by)} are needed; write it as expressions")
    symbol = f"{PREFIX}{source.digest[:DIGITS]}_{names[len(by)]}"
    _sources[source.digest[:DIGITS]] = source
    given = [_row(f, [value(one) for one in row]) for row in rows]
    count = max(source.count, 1)
    out = f.scratch(count)
    pointer = DOUBLE.as_pointer()
    made = f.module.declared(symbol, [pointer] * (len(given) + 1), ir.VoidType(), pure=False)
    f.builder.call(made, [row.data for row in (*given, out)])
    return {e.func(source, sympy.Integer(i), *e.args[2:]): out[i] for i in range(count)}


def evaluate(digest: str, place: int, by: tuple[int, ...], *numbers: float) -> float:
    """One number that a Python function returns, or a derivative of it, as a Python function of numbers itself."""
    source = _sources[digest[:DIGITS]]
    rows = [np.array(numbers, dtype=float), *(np.eye(len(numbers))[k] for k in by), np.empty(max(source.count, 1))]
    at = address(f"{PREFIX}{digest[:DIGITS]}_{NAMES[Called][len(by)]}")
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(rows))(at)(*(row.ctypes.data for row in rows))
    return float(rows[-1][place])


def _row(f: Function, numbers: list[Number]) -> Row:
    made = f.scratch(len(numbers))
    for i, number in enumerate(numbers):
        made[i] = number
    return made


@cache
def address(symbol: str) -> int:
    """Where a function that `write_call` has named is."""
    digest, _, kind = symbol.removeprefix(PREFIX).partition("_")
    source = _sources[digest]
    if not source.is_what_it_was():
        raise ModelError(
            f"{source.name}: this Python function reads data that have changed since the system was defined; define "
            "the system again, or pass what changes as parameters"
        )
    made = _compiled(source, kind)
    _kept.append(made)
    return int(made.address)


_kept: list[Any] = []
"""Compiled functions, which are called by their addresses for as long as the process lives."""


def _compiled(source: Source, kind: str) -> Any:
    import numba
    from numba import types

    from chaosdrill.codegen import carried

    hear_numba()
    one = _KINDS[kind]
    arrays = "abc"[: one.rows + 1]

    def tuple_of(name: str, first: int, count: int) -> str:
        numbers = (one.argument.format(*(f"{a}[{first + i}]" for a in arrays)) for i in range(count))
        return f"{name}({', '.join(numbers)})"

    n, m, count = len(source.states), len(source.parameters), max(source.count, 1)
    time = one.argument.format(*(f"{a}[0]" for a in arrays))
    found = [f"r[{i}]" for i in range(count)] if source.count else ["r"]
    lines = [
        f"def kernel({', '.join(arrays)}, out):",
        f"    given = {time}, {tuple_of('X', 1, n)}, {tuple_of('P', 1 + n, m)}",
        # every statement within takes numba a good part of a second
        "    try:",
        "        r = f(*given)",
        "    except Exception:",
        f"        for i in range({count}):",
        "            out[i] = nan",
        "        return",
        *(f"    out[{i}] = {one.result.format(entry)}" for i, entry in enumerate(found)),
    ]
    function, tuples = _dispatcher(source)
    known = {
        "f": function,
        "X": tuples[0],
        "P": tuples[1],
        "nan": math.nan,
        "part_of": carried.part_of,
        "value_of": carried.value_of,
        "dual": carried.carry(carried.DUAL),
        "second": carried.carry(carried.SECOND),
        "bounded": carried.carry(carried.BOUNDED),
        "dual_bounded": carried.carry(carried.DUAL_BOUNDED),
    }
    exec("\n".join(lines), known)
    pointer = types.CPointer(types.float64)
    try:
        return numba.cfunc(types.void(*[pointer] * (len(arrays) + 1)), error_model="numpy")(known["kernel"])
    except numba.core.errors.NumbaError as fault:
        raise ModelError(
            f"{source.name}: this Python function can be compiled for doubles, but not for the dual numbers that its "
            f"derivatives are made of: {_cause(fault)}. It may hold operators, branches, loops, tuples, functions of "
            "math, and arrays of constants by index or np.interp, but no arrays of what is made of t, x or p"
        ) from None


@cache
def _dispatcher(source: Source) -> tuple[Any, tuple[Any, Any]]:
    """The function as numba compiles it, and the named tuples that it is given."""
    import numba
    from numba import types

    hear_numba()
    tuples = (
        namedtuple("x", source.states, rename=True),  # type: ignore[misc]
        namedtuple("p", source.parameters, rename=True),  # type: ignore[misc]
    )
    function = source.function
    if not hasattr(function, "py_func"):
        function = numba.njit(error_model="numpy")(function)
    given = (types.float64, *(types.NamedUniTuple(types.float64, len(t._fields), t) for t in tuples))
    try:
        function.compile(given)
    # numba raises the other one where a signature was given with the decorator
    except (numba.core.errors.NumbaError, RuntimeError) as fault:
        raise ModelError(f"{source.name}: numba cannot compile this Python function: {_cause(fault)}") from None
    if told := _wrong(function.overloads[given].signature.return_type, source.count):
        raise ModelError(f"{source.name}: this Python function {told}")
    return function, tuples


def _wrong(returned: "Type", count: int) -> str | None:
    """Why what a function returns is not what is wanted; None if it is."""
    from numba import types

    def is_number(one: Any) -> bool:
        return isinstance(types.unliteral(one), types.Integer | types.Float | types.Boolean)

    if count == 0:
        return None if is_number(returned) else f"returns {returned}; it must return one number"
    if not isinstance(returned, types.BaseTuple) or not all(map(is_number, returned)):
        return f"returns {returned}; it must return a tuple of {count} numbers, one for every state"
    return None if len(returned) == count else f"returns {len(returned)} numbers; it must return {count}, one a state"


def _cause(fault: Exception) -> str:
    """The first sentence of an error of numba beside its headings, and the call that it is about."""
    lines = [line.strip() for line in str(fault).splitlines()]
    told = [line for line in lines if line and not line.startswith(("Failed in", "-"))]
    calls = [line for line in told[1:] if line.startswith(">>>")]
    return " ".join((*told[:1], *calls[:1]))[:300] or type(fault).__name__

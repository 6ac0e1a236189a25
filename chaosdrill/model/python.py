"""Python functions as rates, guards, resets and conditions: ``f(t, x, p)``, which no text can hold.

In expressions such a function is a sympy function that knows its derivatives by name alone, so that whatever is derived
from expressions is derived from it too. What computes it and them is `chaosdrill.codegen.python`.
"""

import dis
import hashlib
import inspect
import types
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from uuid import uuid4

import sympy

from chaosdrill.model.special import SPECIAL, WithFormula
from chaosdrill.model.tuning import TUNING

LIBRARIES = ("builtins", "math", "numpy", "numba", "cmath", "operator")
"""Modules whose names stand for what they hold."""

UNKNOWN = "unknown"
"""Marks data of a function that cannot be compared."""

DERIVATIVES = "of Python functions by dual numbers, exact but for rounding; of expressions symbolic"
"""How the derivatives of a system with Python functions come about."""

HIGHEST = 2
"""Order of the derivatives of a Python function that are computed, at most."""

DIGITS = 16
"""Of the digest, where it is a name."""


class Source(sympy.Atom):
    """A Python function and its arguments.

    Two are equal if they hold the same code, constants and data under the same names, wherever they stand.

    ``states``, ``parameters``: names of the numbers that it finds in ``x`` and ``p``. ``count``: how many numbers it
    returns in a tuple; 0 for one number alone. ``digest``: SHA-256, in hexadecimal digits, of all this and of the data
    that the function reads.
    """

    __slots__ = ("_seen", "count", "digest", "function", "name", "parameters", "states")

    def __new__(
        cls, function: Any, states: Sequence[str], parameters: Sequence[str], count: int, digest: str | None = None
    ) -> "Source":
        made: Source = super().__new__(cls)
        made.function = function if hasattr(function, "py_func") else plain_function(function)
        made.name = plain_function(function).__name__
        made.states, made.parameters, made.count = tuple(states), tuple(parameters), count
        made._seen = list(_content(made.function, []))
        told = [repr((made.name, made.states, made.parameters, count)), *made._seen]
        # what is not known to be the same is another one
        told += [uuid4().hex for part in made._seen if part == UNKNOWN]
        made.digest = digest or hashlib.sha256("\n".join(told).encode()).hexdigest()
        return made

    def is_what_it_was(self) -> bool:
        """Whether the data that the function reads are those of its definition."""
        return self._seen == list(_content(self.function, []))

    def _hashable_content(self) -> tuple[Any, ...]:
        return (self.digest,)

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        from numba.core import serialize

        return _unpacked, (serialize.dumps(self.function), self.states, self.parameters, self.count, self.digest)

    def sort_key(self, order: Any = None) -> Any:
        """By what the function does: no sum is added up in the order of names."""
        return self.class_key(), (len(self._seen), tuple(self._seen)), sympy.S.One.sort_key(), sympy.S.One

    def _sympystr(self, printer: Any) -> str:
        return f"{self.name} {self.digest[:DIGITS]}"


def _unpacked(packed: bytes, *others: Any) -> Source:
    from numba.core import serialize

    return Source(serialize.loads(packed), *others)


class _Opaque(sympy.Function):
    """A real number that a Python function computes; the first argument is its source."""

    is_real = True
    is_commutative = True

    @property
    def source(self) -> Source:
        """The Python function."""
        found: Source = self.args[0]
        return found

    def _eval_evalf(self, prec: int) -> Any:
        return None

    def _sympystr(self, printer: Any) -> str:
        return f"{type(self).__name__}({', '.join(map(printer._print, self.args))})"


class Called(_Opaque):
    """One number that a Python function returns, or a derivative of it.

    Arguments: source, place of the number, places of the arguments by which it is derived, and the arguments: time, the
    states, the parameters.
    """

    @property
    def place(self) -> Any:
        """Which of the numbers that the function returns."""
        return self.args[1]

    @property
    def by(self) -> tuple[Any, ...]:
        """Places of the arguments by which it is derived."""
        return tuple(self.args[2])

    @property
    def numbers(self) -> tuple[Any, ...]:
        """The arguments of the function."""
        found: tuple[Any, ...] = self.args[3:]
        return found

    def _eval_derivative(self, symbol: Any) -> Any:
        def slope(k: int) -> Any:
            return Called(self.source, self.place, sympy.Tuple(*sorted((*self.by, sympy.Integer(k)))), *self.numbers)

        moved = [k for k, number in enumerate(self.numbers) if symbol in number.free_symbols]
        return sympy.Add(*(self.numbers[k].diff(symbol) * slope(k) for k in moved))

    def _pythoncode(self, printer: Any) -> str:
        by, numbers = tuple(map(int, self.by)), map(printer._print, self.numbers)
        return f"Called({self.source.digest!r}, {int(self.place)}, {by}, {', '.join(numbers)})"

    def _latex(self, printer: Any, exp: Any = None) -> str:
        name = "".join(c if c.isalnum() else r"\_" if c == "_" else " " for c in self.source.name)
        under = [str(self.place + 1)] if self.source.count else []
        under += [printer._print(self.numbers[int(k)]) for k in self.by]
        told = [s for s in self.numbers if s.free_symbols]
        shown = ", ".join(map(printer._print, told[: TUNING.arguments_shown]))
        shown += r", \ldots" if len(told) > TUNING.arguments_shown else ""
        text = rf"\operatorname{{{name}}}" + (f"_{{{', '.join(under)}}}" if under else "") + rf"\left({shown}\right)"
        return text if exp is None else rf"\left({text}\right)^{{{exp}}}"


class Along(_Opaque):
    """The derivative of a number along a direction: source, place, the arguments, and how each of them changes."""


class Doubt(_Opaque):
    """How far rounding may take a number, or a derivative of it, in rounding units.

    Arguments: source, place, places of the arguments by which it is derived, the arguments, and their own bounds.
    """


def is_python(value: Any) -> bool:
    """Whether a value is a function of Python, compiled by numba or not."""
    return inspect.isfunction(plain_function(value))


def plain_function(function: Any) -> Any:
    """The function that numba compiles, of what ``numba.njit`` or ``numba.cfunc`` has made as well."""
    if type(function).__module__ == "numba.core.ccallback":
        return function.__wrapped__
    return getattr(function, "py_func", function)


def fault_of(function: Any) -> str | None:
    """Why a function cannot be called as ``f(t, x, p)``; None if it can."""
    code = plain_function(function).__code__
    flags = inspect.CO_VARARGS | inspect.CO_VARKEYWORDS | inspect.CO_GENERATOR | inspect.CO_COROUTINE
    if code.co_argcount != 3 or code.co_kwonlyargcount or code.co_flags & flags:
        found = inspect.signature(plain_function(function))
        return f"the Python function {code.co_name!r:.60} takes {found!s:.60}; it must be f(t, x, p)"
    return None


def reads_time(function: Any) -> bool:
    """Whether a function looks at its first argument."""
    code = plain_function(function).__code__
    time = code.co_varnames[0]
    return any(time in (i.argval if isinstance(i.argval, tuple) else (i.argval,)) for i in dis.get_instructions(code))


def called(source: Source, numbers: Sequence[Any]) -> list[Called]:
    """Values that a function returns for these arguments."""
    return [Called(source, sympy.Integer(i), sympy.Tuple(), *numbers) for i in range(max(source.count, 1))]


def opaque(expression: Any) -> set[Any]:
    """Calls of functions that numpy does not know."""
    return {
        f
        for f in expression.atoms(sympy.Function)
        if isinstance(f, Called) or (type(f).__name__ in SPECIAL and not isinstance(f, WithFormula))
    }


def _content(value: Any, seen: list[Any]) -> Iterator[str]:
    """All that a value is made of, as far as compiled code can depend on it."""
    import numpy as np

    if isinstance(value, types.ModuleType) and value.__name__.partition(".")[0] not in LIBRARIES:
        looked_up = (_names(one.__code__, "LOAD_ATTR", "LOAD_METHOD") for one in seen if inspect.isfunction(one))
        names = set[str]().union(*looked_up)
        if (value, names) in seen:
            yield f"module {seen.index((value, names))};"
        else:
            seen.append((value, names))
            yield from _named(names, vars(value), seen)
    elif inspect.isfunction(value) and value in seen:
        yield f"function {seen.index(value)};"
    elif inspect.isfunction(value):
        seen.append(value)
        yield from _content((value.__defaults__, value.__code__), seen)
        for cell in value.__closure__ or ():
            try:
                held = cell.cell_contents
            except ValueError:
                yield UNKNOWN
                continue
            yield from _content(held, seen)
        yield from _named(_names(value.__code__, "LOAD_GLOBAL", "LOAD_NAME"), value.__globals__, seen)
    elif inspect.isfunction(plain_function(value)):
        yield f"{sorted(getattr(value, 'targetoptions', {}).items())!r};"
        yield from _content(plain_function(value), seen)
    elif isinstance(value, types.CodeType):
        yield f"code {value.co_argcount} {value.co_flags} {value.co_names} {value.co_freevars} {value.co_cellvars};"
        yield value.co_code.hex()
        yield from _content(value.co_consts, seen)
    elif isinstance(value, tuple | list):
        yield f"{type(value).__name__} {len(value)} {getattr(value, '_fields', '')};"
        for one in value:
            yield from _content(one, seen)
    elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
        yield f"array {value.dtype} {value.shape};"
        yield hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
    elif value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        yield f"{type(value).__name__} {value!r};"
    elif isinstance(value, types.ModuleType):
        yield f"module {value.__name__};"
    elif (getattr(value, "__module__", None) or "numpy").partition(".")[0] in LIBRARIES and hasattr(value, "__name__"):
        yield f"{getattr(value, '__module__', None)} {value.__name__};"
    else:
        yield UNKNOWN


def _named(names: set[str], held: Mapping[str, Any], seen: list[Any]) -> Iterator[str]:
    """What stands under those of some names that a module has."""
    for name in sorted(names & held.keys()):
        yield f"global {name};"
        yield from _content(held[name], seen)


def _names(code: types.CodeType, *how: str) -> set[str]:
    """Names that a function and those within it look up so."""
    inner = (_names(one, *how) for one in code.co_consts if isinstance(one, types.CodeType))
    return {i.argval for i in dis.get_instructions(code) if i.opname in how}.union(*inner)

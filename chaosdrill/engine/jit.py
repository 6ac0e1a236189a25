"""Decorators for compiled code.

The engine is compiled once a machine and kept on the disk, by the content of all numerical code: an edited helper must
not leave stale code in its callers. A compiled function holds all that it calls, optimised once and together with it,
so that its machine code is the same whatever was compiled before. Where no folder can be written, nothing is kept.
"""

import ctypes
import struct
import threading
from collections.abc import Callable
from functools import cache, cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from chaosdrill.codegen import kept
from chaosdrill.codegen.kinds import (
    UNCOMPILED,
    Array,
    Kind,
    Late,
    Pointer,
    Signature,
    Tuple,
    float64,
    numpy_type,
    uint64,
    void,
)
from chaosdrill.codegen.machine import FROM_WORDS, address_of, load, optimised_object
from chaosdrill.engine import lanes
from chaosdrill.engine.uncompiled import Uncompiled, numbers_of_numpy, visible
from chaosdrill.progress import compiling

RECIPROCAL = np.concatenate([[np.inf], 1.0 / np.arange(1, 64)])
"""1/k, a table because every order of every series divides by its number."""

_rare: set[str] = set()
"""Parts of the compiled names of functions that stay calls."""

COMPILED: list["Compiled"] = []
"""All compiled functions."""

_compiling = threading.RLock()

_names: dict[int, dict[str, Any]] = {id(vars(lanes)): vars(lanes)}
"""Where compiled functions find what they name: the names of their modules, and what functions around them hold."""

_cells: list[Any] = []

_Writer = Callable[[Any, list[Any]], None]

_T = TypeVar("_T")


class _Once(Generic[_T]):
    """A property that is made on first use, under the one lock of all compilation.

    Functions ask for one another's. A `cached_property` of Python 3.11 has a lock of its own, so that of two threads
    each could hold what the other one waits for.
    """

    def __init__(self, make: Callable[[Any], _T]) -> None:
        self._make = make
        self.__doc__ = make.__doc__

    def __get__(self, one: Any, owner: type) -> _T:
        name = self._make.__name__
        with _compiling:
            if name not in vars(one):
                vars(one)[name] = self._make(one)
            return vars(one)[name]  # type: ignore[no-any-return]


class Compiled:
    """A function of machine code: Python calls it, compiled functions find it at its address.

    It is compiled, or its code is read from the disk, on first use. A call releases the interpreter lock.

    ``function`` is one that numba can compile, ``loops`` whether loops of independent turns become vector instructions,
    ``symbol`` the name of its machine code, by default its own.
    """

    def __init__(self, function: Callable[..., Any], signature: Signature, loops: bool, symbol: str = "") -> None:
        self.py_func = _heard_of(function)
        self.signature = signature
        self._loops = loops
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.symbol = symbol or self.__name__
        self._writers = [_writer(kind) for kind in signature.args]
        self._format = struct.Struct("".join(map(_format, signature.args)))
        self._result = struct.Struct("" if signature.return_type is void else _format(signature.return_type))
        COMPILED.append(self)

    @_Once
    def code(self) -> bytes:
        """Its object code; that of a function of the package is kept."""
        if not kept.is_own(self.py_func):
            return self._object_code()
        return kept.engine_code(self.py_func.__module__, self.__name__, self._object_code)

    def compile(self) -> bytes:
        """Have its code, unless it is there."""
        return self.code

    def _object_code(self) -> bytes:
        # what pays to be packed is written with lanes; to pack more costs a twentieth of a run in shuffles
        with compiling():
            from chaosdrill.engine.front_end import llvm_module

            put_real()
            module = llvm_module(self.py_func, self.symbol, self.signature.real, _rare)
            return optimised_object(module, loops=self._loops)

    @_Once
    def _library(self) -> Any:
        units = (one for one in COMPILED if isinstance(one, Unit) and one is not self)
        return load(self.code, {one.symbol: one.address for one in units if one.symbol.encode() in self.code})

    @_Once
    def address(self) -> int:
        """Where compiled functions call it."""
        return int(self._library.address(self.symbol))

    @_Once
    def _call(self) -> Any:
        return ctypes.CFUNCTYPE(None, ctypes.c_void_p)(self._library.address(self.symbol + FROM_WORDS))

    def __call__(self, *arguments: Any) -> Any:
        flat: list[Any] = []
        for write, value in zip(self._writers, arguments, strict=True):
            write(value, flat)
        words = ctypes.create_string_buffer(self._format.size + self._result.size)
        self._format.pack_into(words, 0, *flat)
        self._call(words)
        found = self._result.unpack_from(words, self._format.size)
        return found if len(found) > 1 else found[0] if found else None


class Laid(tuple):
    """A tuple that is given to compiled functions again and again: its words are written once."""

    words: list[Any] | None = None


class Unit(Compiled, Late):
    """One that compiled functions call by its name, for what happens seldom: it is a part of none of them."""

    def __init__(self, function: Callable[..., Any], signature: Signature) -> None:
        super().__init__(function, signature, loops=False, symbol=f"unit.{function.__module__}.{function.__name__}")

    @cached_property
    def real(self) -> Any:
        from chaosdrill.engine.front_end import at_symbol

        return at_symbol(self.symbol, self.signature.real)


class Layout:
    """How named tuples of a type stand in memory, looked up once: to look a type up takes as long as a short run."""

    def __init__(self, kind: Kind) -> None:
        self.write = _writer(kind)
        self.words = struct.Struct(_format(kind))


class Record:
    """A named tuple in memory as compiled functions read it there; its arrays stay where they are.

    It is given to a function that takes an address, and has to live as long as that is used.
    """

    def __init__(self, layout: Layout, value: Any) -> None:
        self.value = value
        flat: list[Any] = []
        layout.write(value, flat)
        self._words = ctypes.create_string_buffer(layout.words.pack(*flat))
        self._address = ctypes.addressof(self._words)

    def __int__(self) -> int:
        return self._address


@cache
def _format(kind: Kind) -> str:
    """The words of a type, as `struct` names them."""
    if isinstance(kind, Tuple):
        return "".join(map(_format, kind.parts))
    if isinstance(kind, Array):
        return "q" * (5 + 2 * kind.ndim)
    return "d" if kind is float64 else "q"


@cache
def _writer(kind: Kind) -> _Writer:
    """Function that appends the words of a value to a list."""
    if isinstance(kind, Tuple):
        writers = [_writer(part) for part in kind.parts]

        def of_tuple(value: Any, flat: list[Any]) -> None:
            if isinstance(value, Laid) and value.words is not None:
                flat += value.words
                return
            begun = len(flat)
            for write, part in zip(writers, value, strict=True):
                write(part, flat)
            if isinstance(value, Laid):
                value.words = flat[begun:]

        return of_tuple
    if isinstance(kind, Array):
        dtype, dimensions = numpy_type(kind.dtype), kind.ndim

        def of_array(value: Any, flat: list[Any]) -> None:
            if value.ndim != dimensions or value.dtype != dtype or not value.flags.c_contiguous:
                raise TypeError(f"expected an array of {dimensions} dimensions of {dtype} in order, not {value!r}")
            flat += (0, 0, value.size, dtype.itemsize, address_of(value), *value.shape, *value.strides)

        return of_array
    if isinstance(kind, Pointer):
        return lambda value, flat: flat.append(value.address)
    number = float if kind is float64 else int
    return lambda value, flat: flat.append(number(value))


def compiled(signature: Signature, *, loops: bool = True) -> Callable[[Any], Any]:
    """Compile for one signature; see `Compiled`."""

    def wrap(function: Any) -> Any:
        return Uncompiled(function) if UNCOMPILED else Compiled(function, signature, loops)

    return wrap


def unit(function: Any, signature: Signature) -> Any:
    """Compile by itself what compiled functions call seldom; see `Unit`."""
    return numbers_of_numpy(function) if UNCOMPILED else Unit(function, signature)


class Part(Late):
    """A function that becomes a part of compiled ones; see `inlined` and those below it."""

    def __init__(self, function: Callable[..., Any], framed: bool, options: dict[str, Any]) -> None:
        self.py_func = _heard_of(function)
        self.__doc__ = function.__doc__
        self._framed, self._options = framed, options

    @cached_property
    def real(self) -> Any:
        from chaosdrill.engine.front_end import part

        return part(self.py_func, self._options, framed=self._framed)


class _AtAddress(Late):
    def __init__(self, kind: Kind) -> None:
        self._kind = kind

    @cached_property
    def real(self) -> Any:
        from chaosdrill.engine.front_end import at_address

        return at_address(self._kind.real)


class Written(Late):
    """A compiled function that is written as LLVM code in `chaosdrill.engine.front_end`, by its name there."""

    def __init__(self, name: str) -> None:
        self._name = name

    @cached_property
    def real(self) -> Any:
        from chaosdrill.engine import front_end

        return getattr(front_end, self._name)


in_frame: Any = (lambda record: record) if UNCOMPILED else Written("in_frame")
"""What `at_address` gives, with a copy of its words in the frame, of which the compiler makes values.

Of a record in memory each word is loaded where it is named, by way of an address that may have to be loaded itself,
which costs runs a twentieth.
"""


def at_address(kind: Kind) -> Any:
    """A compiled function that gives the value of a type whose words begin at an address."""
    return (lambda record: visible(record.value)) if UNCOMPILED else _AtAddress(kind)


def _heard_of(function: Callable[..., Any]) -> Callable[..., Any]:
    _names[id(function.__globals__)] = function.__globals__
    _cells.extend(function.__closure__ or ())
    return function


def put_real() -> None:
    """Put what numba makes in the place of what stands for it, where compiled functions find it."""

    def stands_for_it(value: Any) -> bool:
        # of types compiled functions name the one of places in arrays
        return isinstance(value, Part | Unit | lanes.Operation | _AtAddress | Written) or value is uint64

    for names in list(_names.values()):
        names |= {name: value.real for name, value in list(names.items()) if stands_for_it(value)}
    for cell in _cells:
        if stands_for_it(cell.cell_contents):
            cell.cell_contents = cell.cell_contents.real


def _part(function: Any, *, framed: bool = False, **options: Any) -> Any:
    return numbers_of_numpy(function) if UNCOMPILED else Part(function, framed, options)


def inlined(function: Any) -> Any:
    """A part of the engine's loop: a call would push every array that it is given.

    This one and those below belong to compiled functions, and are called by nothing else.
    """
    return _part(function, framed=True, forceinline=True)


def series(function: Any) -> Any:
    """A function of the engine that evaluates polynomials, where multiplications and additions may be fused."""
    return _part(function, fastmath={"contract"}, forceinline=True)


def inner(function: Any) -> Any:
    """A function of the engine, compiled into its caller with strict rounding."""
    return _part(function, forceinline=True)


def rare(function: Any) -> Any:
    """As ``inner``, for what happens seldom: it stays a call, so that the code of every step stays small."""
    _rare.add("".join(f"{len(part)}{part}" for part in (*function.__module__.split("."), function.__name__)))
    return _part(function)

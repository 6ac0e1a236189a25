"""LLVM code becomes machine code of this processor, and functions that can be called."""

import ctypes
import itertools
import threading
from functools import cache
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from chaosdrill.codegen.kinds import Kind, Signature, float64, void

_lock = threading.RLock()
_numbers = itertools.count()


FROM_PYTHON = "_from_python"
"""Behind the name of a function: the same with pointers for vectors."""

FROM_WORDS = "_from_words"
"""Behind the name of a function: the same, with its arguments and then its result in memory, every number a word."""


class NativeFunction:
    """A function of machine code, which the engine calls by its address and Python can call, too.

    ``library``: where it is.
    """

    def __init__(self, name: str, signature: Signature, library: "Library") -> None:
        self.address = library.address(name)
        self.library = library
        self._signature = signature
        self._dimensions = [kind.ndim for kind in signature.args]
        self._at = library.address(name + FROM_PYTHON) if max(self._dimensions) == 1 else 0
        kinds = [kind for argument in signature.args for kind in _kinds(argument, whole=self._at == 0)]
        result = None if signature.return_type is void else _kinds(signature.return_type, whole=False)[0]
        self._call = ctypes.CFUNCTYPE(result, *kinds)(self._at or self.address)

    def signature(self) -> Any:
        """Types of arguments and result."""
        return self._signature

    def __call__(self, *arguments: Any) -> Any:
        flat: list[Any] = []
        for dimensions, value in zip(self._dimensions, arguments, strict=True):
            if dimensions == 0:
                flat.append(value)
                continue
            if value.ndim != dimensions or value.dtype.char != "d" or not value.flags.c_contiguous:
                raise TypeError(f"expected an array of {dimensions} dimensions of doubles in order, not {value!r}")
            data = address_of(value)
            flat += [data] if self._at else [None, None, value.size, 8, data, *value.shape, *value.strides]
        return self._call(*flat)


_address, _bytes_of = ctypes.addressof, ctypes.c_char.from_buffer


def address_of(array: np.ndarray) -> int:
    """Where the numbers of an array are."""
    return _address(_bytes_of(array)) if array.size and array.flags.writeable else int(array.ctypes.data)


def _kinds(kind: Kind, *, whole: bool) -> list[Any]:
    if kind.ndim:
        places = [ctypes.c_int64] * kind.ndim
        head = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p]
        return [*head, *places, *places] if whole else [ctypes.c_void_p]
    return [ctypes.c_double if kind is float64 else ctypes.c_int64]


@cache
def processor() -> tuple[str, str]:
    """Name and features of this machine's processor."""
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def register_width() -> int:
    """How many doubles a register is taken to hold.

    Registers of two doubles count as pairs: there are as many pairs of them, on one processor, as there are registers
    of four on another.
    """
    return 8 if "+avx512f" in processor()[1] else 4


@cache
def _target() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name, features = processor()
    target = llvm.Target.from_default_triple()
    # what lies close by is addressed from where the code is: the default for code in memory names 64 bits each time
    return target.create_target_machine(name, features, opt=3, reloc="pic", codemodel="small", jit=True)


@cache
def _loader() -> Any:
    # it puts all of one object side by side, and reaches functions elsewhere by a table
    return llvm.create_lljit_compiler(_target(), use_jit_link=True, suppress_errors=False)


def _options(level: int, *, loops: bool) -> Any:
    options = llvm.create_pipeline_tuning_options(level)
    options.slp_vectorization, options.loop_vectorization = False, loops
    return options


def _each_function(module: Any, options: Any) -> None:
    """Simplify the functions of a module, each by itself."""
    builder = llvm.create_pass_builder(_target(), options)
    passes = builder.getFunctionPassManager()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


def compile_object(text: str) -> bytes:
    """Machine code of LLVM code that is written as it is to run, as that of a system.

    Its functions are simplified, each by itself, and that is all: they call what shall stay a call, and have vectors
    and unrolled loops where these pay. What compilers do besides takes several times as long and makes nothing faster.
    """
    with _lock:
        machine = _target()
        module = llvm.parse_assembly(text)
        module.verify()
        module.triple = llvm.get_process_triple()
        options = _options(1, loops=False)
        options.loop_unrolling = False
        _each_function(module, options)
        code: bytes = machine.emit_object(module)
        return code


def optimised_object(module: Any, *, loops: bool) -> bytes:
    """Machine code of a module of LLVM code with all that the compiler can do for it, as that of the engine.

    ``loops`` says whether loops are unrolled and those of independent turns become vector instructions: of functions
    larger than the cache for instructions neither pays, since all of their code is run in turn. Theirs are unrolled
    where the number of turns is known once all that they call is a part of them. No single operations are packed.
    """
    with _lock:
        machine = _target()
        module.triple = llvm.get_process_triple()
        options = _options(3, loops=loops)
        options.loop_unrolling = loops
        builder = llvm.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
        if not loops:
            _each_function(module, _options(3, loops=False))
        code: bytes = machine.emit_object(module)
        return code


_OF_ERRORS = {
    f"numba_{name}" for name in ("gil_ensure", "gil_release", "unpickle", "runtime_build_excinfo_struct", "do_raise")
}


def callback_object(text: str, wrapped: str, name: str) -> bytes:
    """Machine code of a callback for C that numba has written and optimised, whose function is to have a name.

    It tells Python of errors, of which there are none, by functions that numba alone knows.

    Raises `LookupError` if it calls another function that numba alone knows.
    """
    with _lock:
        machine = _target()
        module = llvm.parse_assembly(text)
        never = [f for f in module.functions if f.is_declaration and f.name.startswith("numba_")]
        if others := {f.name for f in never} - _OF_ERRORS:
            raise LookupError(f"{name} calls {', '.join(sorted(others))}")
        module.link_in(llvm.parse_assembly("\n".join(map(_unreachable, never))))
        module.get_function(wrapped).name = name
        module.triple = llvm.get_process_triple()
        code: bytes = machine.emit_object(module)
        return code


def _unreachable(function: Any) -> str:
    """The definition of a function that is declared, and never called."""
    declared = str(function).strip().splitlines()[-1].partition(") ")[0].removeprefix("declare ")
    return f"define {declared.removesuffix(')')}) {{ unreachable }}"


class Library:
    """Machine code in memory, which stays there as long as this does."""

    def __init__(self, name: str, tracker: Any) -> None:
        self._name = name
        self._trackers = [tracker]

    def address(self, function: str) -> int:
        """Where a function is."""
        with _lock:
            found = _loader().lookup(self._name, function)
        self._trackers.append(found)
        return int(found[function])


def load(code: bytes, imports: dict[str, int]) -> Library:
    """Machine code is put into memory.

    Parameters
    ----------
    code : bytes
    imports : dict of str to int
        Addresses of functions that the code calls and the process does not know by name.
    """
    with _lock:
        builder = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
        for name, address in imports.items():
            builder.import_symbol(name, address)
        name = f"system_{next(_numbers)}"
        return Library(name, builder.link(_loader(), name))

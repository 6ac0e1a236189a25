"""numba as a front end: from a function of the engine, and what it calls, to one module of LLVM code.

What numba does by itself with a function that others call is to optimise it and to make it machine code, and to do so
again with every function that it becomes a part of: a tree of calls is compiled once a level, which was two thirds of
the engine's time to start. Here a function is typed and lowered alone, and what comes of it is optimised once, together
with all that it calls. No public part of numba does that. What is used of its inner parts stands in this file alone,
and ``tests/engine/test_front_end.py`` says which of them a new numba has changed.
"""

import contextlib
import ctypes
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import _dynfunc, types
from numba.core import codegen, cpu, registry, typing
from numba.core.compiler_lock import global_compiler_lock
from numba.np import arrayobj

from chaosdrill.engine.uncompiled import machine_code, visible

WORD = ir.IntType(64)
WORDS = WORD.as_pointer()
FROM_WORDS = "_from_words"
"""Behind the name of a function: the same, with its arguments and then its result in memory, every number a word."""

PLAIN = {"error_model": "numpy", "_nrt": False}
"""How numba compiles all of the engine: errors are none of arithmetic, nothing is allocated."""


class _Library(codegen.JITCodeLibrary):  # type: ignore[misc]
    """LLVM code that is linked, and neither optimised nor made machine code."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0


class _Codegen(codegen.JITCPUCodegen):  # type: ignore[misc]
    _library_class = _Library

    def set_env(self, env_name: str, env: Any) -> None:
        pass


class _Context(cpu.CPUContext):  # type: ignore[misc]
    """A target of its own, so that nothing of it is found by other code that numba compiles."""

    def init(self) -> None:
        super().init()
        self._internal_codegen = _Codegen("chaosdrill")

    def create_cpython_wrapper(self, *given: Any, **more: Any) -> None:
        pass

    def create_cfunc_wrapper(self, *given: Any, **more: Any) -> None:
        pass

    def get_executable(self, library: Any, fndesc: Any, env: Any) -> Any:
        """What stands for a function in numba's tables; where Python calls it there is a TypeError."""
        refuse = ctypes.cast(ctypes.pythonapi.PyErr_BadArgument, ctypes.c_void_p).value
        name = fndesc.qualname
        return _dynfunc.make_function(fndesc.lookup_module(), name.split(".")[-1], name, refuse, env, (library,))


def _index(context: Any, builder: Any, kind: Any, index: Any, size: Any) -> Any:
    """An index as it is: none of the engine's counts from the end, and to ask each costs a twentieth of a run."""
    return context.cast(builder, index, kind, types.intp)


@cache
def _contexts() -> tuple[Any, Any]:
    typed = typing.Context()
    return typed, _Context(typed, "cpu")


@contextlib.contextmanager
def _own_contexts() -> Iterator[Any]:
    """Let numba compile for the target of this file; no other compilation runs meanwhile."""
    with global_compiler_lock:
        target = registry.cpu_target
        before = {"_toplevel_typing_context": target.typing_context, "_toplevel_target_context": target.target_context}
        typed, context = _contexts()
        target.__dict__.update(_toplevel_typing_context=typed, _toplevel_target_context=context)
        counted, arrayobj.fix_integer_index = arrayobj.fix_integer_index, _index
        try:
            yield context
        finally:
            arrayobj.fix_integer_index = counted
            target.__dict__.update(before)


def function_pointer(name: str, signature: Any) -> Any:
    """The type of a function that is called by its address; the name keeps the names of compiled functions short."""
    kind = types.ExternalFunctionPointer(signature, None)
    kind.name = name
    return kind


def named_tuple(kinds: Any, cls: Any) -> Any:
    """The type of a named tuple, with a short name."""
    kind = types.NamedTuple(tuple(kinds), cls)
    kind.name = cls.__name__
    return kind


def _load(builder: Any, words: Any, place: int, kind: Any) -> tuple[Any, int]:
    """A value from memory that begins at a place, and the place behind it."""
    if isinstance(kind, ir.BaseStructType | ir.ArrayType):
        value = ir.Constant(kind, ir.Undefined)
        for i in range(len(kind)):
            part, place = _load(builder, words, place, kind.elements[i])
            value = builder.insert_value(value, part, i)
        return value, place
    pointer = builder.gep(words, [WORD(place)])
    return builder.load(builder.bitcast(pointer, kind.as_pointer())), place + 1


def _store(builder: Any, words: Any, place: int, value: Any) -> int:
    if isinstance(value.type, ir.BaseStructType | ir.ArrayType):
        for i in range(len(value.type)):
            place = _store(builder, words, place, builder.extract_value(value, i))
        return place
    pointer = builder.gep(words, [WORD(place)])
    builder.store(value, builder.bitcast(pointer, value.type.as_pointer()))
    return place + 1


def at_address(kind: Any) -> Any:
    """A compiled function that gives the value of a type whose words begin at an address."""

    @machine_code(lambda record: visible(record.value))
    def value_at(typingctx: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            words = builder.inttoptr(arguments[0], WORDS)
            return _load(builder, words, 0, context.get_value_type(kind))[0]

        return kind(types.int64), code

    return value_at


def _entries(context: Any, descriptor: Any, name: str, signature: Any) -> str:
    """LLVM code of a function by the name that others call it by: with values, and from words in memory."""
    module = context.create_module("entries")
    kinds = [context.get_value_type(kind) for kind in signature.args]
    nothing = signature.return_type == types.void
    result = ir.VoidType() if nothing else context.get_value_type(signature.return_type)
    convention = context.call_conv
    called = ir.Function(
        module, convention.get_function_type(descriptor.restype, descriptor.argtypes), descriptor.llvm_func_name
    )
    by_value = ir.Function(module, ir.FunctionType(result, kinds), name)
    builder = ir.IRBuilder(by_value.append_basic_block())
    _, value = convention.call_function(builder, called, descriptor.restype, descriptor.argtypes, list(by_value.args))
    builder.ret_void() if nothing else builder.ret(value)
    from_words = ir.Function(module, ir.FunctionType(ir.VoidType(), [WORDS]), name + FROM_WORDS)
    builder = ir.IRBuilder(from_words.append_basic_block())
    given, place = [], 0
    for kind in kinds:
        value, place = _load(builder, from_words.args[0], place, kind)
        given.append(value)
    value = builder.call(by_value, given)
    if not nothing:
        _store(builder, from_words.args[0], place, value)
    builder.ret_void()
    return str(module)


def llvm_module(function: Callable[..., Any], name: str, signature: Any, rare: set[str]) -> Any:
    """LLVM code of a function and of all that it calls, as one module that is not yet optimised.

    Only the two functions of `_entries` can be seen from outside: everything else is compiled for this caller alone,
    whatever was compiled before. Other names are numbers, so that the code is the same in every process. ``rare`` are
    parts of the names of functions that stay calls.
    """
    dispatcher = numba.njit(**PLAIN)(function)
    with _own_contexts() as context:
        dispatcher.compile(signature)
        (result,) = dispatcher.overloads.values()
        result.library.finalize()
        module = result.library._final_module
        module.link_in(llvm.parse_assembly(_entries(context, result.fndesc, name, result.signature)))
    for number, part in enumerate([*module.functions, *module.global_variables]):
        if part.is_declaration or part.name in (name, name + FROM_WORDS):
            continue
        part.linkage = "internal"
        if part.is_function and any(called in part.name for called in rare):
            part.add_function_attribute("noinline")
            part.add_function_attribute("cold")
        part.name = f"part.{number}"
    return module

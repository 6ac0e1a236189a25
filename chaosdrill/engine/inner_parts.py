"""The inner parts of numba that the engine takes, where they are as they were.

What numba does by itself with a function that others call is to optimise it and to make it machine code, and to do so
again with every function that it becomes a part of: a tree of calls is compiled once a level, which was two thirds of
the engine's time to start. Here a function is typed and lowered alone, and what comes of it is optimised once, together
with all that it calls. No public part of numba does that. What is used of its inner parts stands in this file alone,
and ``tests/engine/test_front_end.py`` says which of them a new numba has changed; meanwhile `front_end` does without.
"""

import contextlib
import ctypes
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba import _dynfunc, types
from numba.core import codegen, compiler, cpu, registry, typing
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.runtime import rtsys
from numba.np import arrayobj

_IDLE = {
    *("WithLifting", "MakeFunctionToJitFunction", "InlineClosureLikes", "InlineInlinables", "InlineOverloads"),
    *("RewriteSemanticConstants", "DeadBranchPrune", "RewriteDynamicRaises", "FindLiterallyCalls", "LiteralUnroll"),
    *("LiteralPropagationSubPipelinePass", "NopythonRewrites", "NoPythonSupportedFeatureValidation"),
    *("IRProcessing", "AnnotateTypes", "DumpParforDiagnostics"),
}
"""Passes of numba for what is not in the engine, as closures, blocks with objects, branches for constants, expressions
of whole arrays, for listings, and for what a later pass does again."""


class Compiler(compiler.Compiler):  # type: ignore[misc]
    """numba's own; for the target of this file without idle passes, which take a sixth of the time."""

    def define_pipelines(self) -> list[Any]:
        if not isinstance(self.state.targetctx, _Context):
            return list(super().define_pipelines())
        passes = PassManager("engine")
        # else numba checks after each of them what it has made
        passes._ENFORCING = False
        for one, told in compiler.DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            if one.__name__ not in _IDLE:
                passes.add_pass(one, told)
        passes.finalize()
        return [passes]


class _Library(codegen.JITCodeLibrary):  # type: ignore[misc]
    """LLVM code of one function as text, and what that calls: it is linked once all of a tree of calls are there."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self._texts: list[str] = []

    def add_linking_library(self, library: Any) -> None:
        # the one of another kind counts references, of which there are none
        if isinstance(library, _Library):
            self._linking_libraries.append(library)

    def add_ir_module(self, ir_module: Any) -> None:
        self._texts.append(str(ir_module))

    def finalize(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0


class _Codegen(codegen.JITCPUCodegen):  # type: ignore[misc]
    _library_class = _Library

    def set_env(self, env_name: str, env: Any) -> None:
        pass


class _Context(cpu.CPUContext):  # type: ignore[misc]
    """A target of its own, so that nothing of it is found by other code that numba compiles."""

    _known = False
    """Whether all of numba's declarations have been loaded."""

    def init(self) -> None:
        super().init()
        self._internal_codegen = _Codegen("chaosdrill")
        self._sizes: dict[ir.Type, int] = {}

    def load_additional_registries(self) -> None:
        """Look into those that are known: numba asks at most functions, and imports all of its parts each time."""
        if not self._known:
            super().load_additional_registries()
            self._known = True
        for known in list(self._registries):
            self.install_registry(known)

    def get_abi_sizeof(self, kind: Any) -> int:
        """Bytes of a type, asked once: LLVM reads a module to answer, and every access to an array asks."""
        if kind not in self._sizes:
            self._sizes[kind] = super().get_abi_sizeof(kind)
        return self._sizes[kind]

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


_type_of_call = types.Function.get_call_type
_types_of_calls: dict[Any, Any] = {}


def _call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
    """What an operator makes of types is looked up once: numba asks all templates that it knows of it, twice a use."""
    found = None if kws else _types_of_calls.get((function, args))
    if found is None:
        found = _type_of_call(function, context, args, kws)
        # what is compiled for a call depends on options of the caller
        if not kws and function.get_impl_key(found) is function.typing_key:
            _types_of_calls[function, args] = found
    return found


@cache
def _contexts() -> tuple[Any, Any]:
    # what counts references, of which other code takes what the first target makes
    rtsys.initialize(registry.cpu_target.target_context)
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
        types.Function.get_call_type = _call_type
        try:
            yield context
        finally:
            arrayobj.fix_integer_index = counted
            types.Function.get_call_type = _type_of_call
            target.__dict__.update(before)


def _linked(top: _Library) -> Any:
    """One module of a function and of all that it calls."""
    seen, waiting = set(), [top]
    while waiting:
        library = waiting.pop()
        if library not in seen:
            seen.add(library)
            for text in library._texts:
                top._final_module.link_in(llvm.parse_assembly(text))
            waiting += reversed(library._linking_libraries)
    top._final_module.data_layout = top._codegen._data_layout
    return top._final_module


def lowered(dispatcher: Any, signature: Any) -> tuple[Any, ir.Type, list[ir.Type], Callable[..., Any]]:
    """LLVM code of a function and of all that it calls, not optimised: its module, LLVM's types of the result and of
    the arguments, and what writes a call of it into a module, ``call(module, builder, values)``."""
    with _own_contexts() as context:
        dispatcher.compile(signature)
        (compiled,) = dispatcher.overloads.values()
        descriptor, convention = compiled.fndesc, context.call_conv
        kinds = [context.get_value_type(kind) for kind in compiled.signature.args]
        result = context.get_value_type(compiled.signature.return_type)

        def call(module: Any, builder: Any, values: list[Any]) -> Any:
            kind = convention.get_function_type(descriptor.restype, descriptor.argtypes)
            function = ir.Function(module, kind, descriptor.llvm_func_name)
            return convention.call_function(builder, function, descriptor.restype, descriptor.argtypes, values)[1]

        return _linked(compiled.library), result, kinds, call

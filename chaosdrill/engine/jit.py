"""Decorators for compiled code.

numba keys its disk cache by the file of the decorated function alone, so that an edited helper would leave stale code
in its callers; here the key holds the content of all numerical code. Where no folder can be written, nothing is cached.
"""

import contextlib
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numba
import numpy as np
from numba.core.codegen import CPUCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.errors import NumbaExperimentalFeatureWarning

from chaosdrill.codegen.kept import CodeCache

RECIPROCAL = np.concatenate([[np.inf], 1.0 / np.arange(1, 64)])
"""1/k, a table because every order of every series divides by its number."""

_rare: set[str] = set()
"""Parts of the compiled names of functions that stay calls."""


@contextlib.contextmanager
def _alone(name: str) -> Iterator[None]:
    """Compile one function so that its code depends on nothing that was compiled or loaded before it.

    The helpers that numba links into a function stay visible to all others, and the copy that was loaded first serves
    everybody: it is rounded as suited the function that it came with. Here each function keeps its helpers to itself.
    They are optimised in one way, whoever asked for them first, and once more with the function that they are part of.

    Equal operations on neighbouring numbers become vector instructions, which numba leaves off.
    """
    optimise = CPUCodeLibrary._optimize_final_module

    def optimise_alone(library: Any) -> None:
        own = library.name == name
        for function in library._final_module.functions:
            if not function.is_declaration and any(part in function.name for part in _rare):
                function.add_function_attribute("noinline")
                function.add_function_attribute("cold")
        for function in library._final_module.functions if own else ():
            if function.linkage.name == "linkonce_odr" and not function.is_declaration:
                function.linkage = "internal"
                # under its own name a search for the helper itself would find this copy, which has no address to give
                function.name = f"{name}.{function.name}"
        optimise(library)

    with global_compiler_lock:
        before = numba.config.SLP_VECTORIZE
        CPUCodeLibrary._optimize_final_module = optimise_alone
        numba.config.SLP_VECTORIZE = 1
        try:
            yield
        finally:
            CPUCodeLibrary._optimize_final_module = optimise
            numba.config.SLP_VECTORIZE = before


def compiled(signature: Any) -> Callable[[Any], Any]:
    """Compile for one signature, from the disk cache if it is there; releases the interpreter lock."""

    def decorate(function: Any) -> Any:
        dispatcher = numba.njit(nogil=True, error_model="numpy", _nrt=False)(function)
        with contextlib.suppress(RuntimeError):
            dispatcher._cache = CodeCache(function)
        with warnings.catch_warnings(), _alone(function.__qualname__):
            warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
            dispatcher.compile(signature)
        dispatcher.disable_compile()
        # every call that is given this function asks for its address, and numba would search for it each time
        result = dispatcher.get_compile_result(signature)
        result.library.get_pointer_to_function = cache(result.library.get_pointer_to_function)
        dispatcher.get_compile_result = lambda _: result
        return dispatcher

    return decorate


def inlined(function: Any) -> Any:
    """A part of the engine's loop: a call would push every array that it is given."""
    return numba.njit(error_model="numpy", _nrt=False, forceinline=True)(function)


def series(function: Any) -> Any:
    """A function of the engine that evaluates polynomials, where multiplications and additions may be fused."""
    return numba.njit(error_model="numpy", _nrt=False, fastmath={"contract"})(function)


def inner(function: Any) -> Any:
    """A function of the engine, compiled into its caller with strict rounding."""
    return numba.njit(error_model="numpy", _nrt=False)(function)


def rare(function: Any) -> Any:
    """As ``inner``, for what happens seldom: it stays a call, so that the code of every step stays small."""
    _rare.add("".join(f"{len(part)}{part}" for part in (*function.__module__.split("."), function.__name__)))
    return numba.njit(error_model="numpy", _nrt=False, forceinline=False)(function)

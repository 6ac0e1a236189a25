"""What a method offers that steps by evaluations of the right-hand side: four functions of fixed signature.

The engine takes them as arguments, so that it is compiled once, and a method when it is first used. The Taylor method
is part of the engine itself: three calls a step, a tenth of a microsecond each, would cost it a third of its speed.

* ``expand`` length of the next step; guards that have a polynomial on it fill rows ``first``, ... of the workspace
* ``locate`` first event of the step: (time or -1, guard, ties); where guards have polynomials, ``times`` holds what
  they say, which is made exact
* ``evaluate`` states and quadratures at s, into ``out``
* ``advance`` the same, and tangents in place

Their arguments are few on purpose: every array goes over the stack.
"""

import warnings
from functools import cache
from importlib import import_module
from typing import Any

from numba import float64, int64, types, void
from numba.core.errors import NumbaExperimentalFeatureWarning

from chaosdrill.codegen.signatures import SIGNATURES as KERNELS
from chaosdrill.codegen.signatures import matrix, vector
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.records import integers, run_record, settings_record, tables_type

with warnings.catch_warnings():
    warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
    field, variation, guard, guard_error = (
        types.FunctionType(KERNELS[name]) for name in ("field", "variation", "guard", "guard_error")
    )

SIGNATURES = {
    "expand": float64(
        *(field, variation, guard, guard_error, int64, int64, integers, settings_record, run_record),
        *(float64, vector, vector, vector, matrix, matrix, matrix, vector),
    ),
    "locate": types.Tuple((float64, int64, int64))(
        *(field, variation, guard, guard_error, int64, float64, float64, float64, tables_type),
        *(settings_record, run_record, vector, vector, integers, matrix, matrix, *[vector] * 5),
    ),
    "evaluate": void(field, variation, float64, vector, vector, float64, run_record, matrix, vector),
    "advance": void(field, variation, float64, vector, vector, float64, matrix, run_record, matrix, vector),
}

STEPPER_TYPES = tuple(types.FunctionType(s) for s in SIGNATURES.values())


def offered(function: Any) -> Any:
    """Compile one of the four functions of a method, by its name."""
    return compiled(SIGNATURES[function.__name__])(function)


@cache
def stepper(method: str) -> tuple[Any, ...]:
    """The four functions of a method; for the Taylor method functions that are never called."""
    module = import_module(f"chaosdrill.engine.{'idle' if method == 'taylor' else method}")
    return tuple(getattr(module, name) for name in SIGNATURES)

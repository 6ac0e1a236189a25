"""What can be asked for by name: kinds of analysis and numerical methods. Imports nothing heavy."""

import os
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Analysis

FUNCTIONS = tuple(
    sorted(
        file.removesuffix(".py")
        for file in os.listdir(os.path.join(os.path.dirname(__file__), "kinds"))
        if file.endswith(".py") and not file.startswith("_")
    )
)
"""Names of the analysis functions: every file in ``kinds`` is one, of that name."""

METHODS = {
    "taylor": "adaptive Taylor series of variable order; events are roots of the guards' polynomials",
    "dop853": "adaptive Runge-Kutta of order 8, for right-hand sides that are not analytic; events as for taylor",
    "rk4": "fixed-step Runge-Kutta of order 4 with bisection, the method of the paper",
}

FIXED_STEP = ("rk4",)
"""Methods that are told how many steps a period has."""


def function(name: str) -> Any:
    """The analysis function of a name."""
    return getattr(import_module(f"chaosdrill.analysis.kinds.{name}"), name)


@cache
def analyses() -> "dict[str, Analysis]":
    """All analyses by their kind."""
    found = (function(name).analysis for name in FUNCTIONS)
    return {entry.kind: entry for entry in found}

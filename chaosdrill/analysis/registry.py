"""What can be asked for by name: kinds of analysis and numerical methods. Imports nothing heavy."""

import os
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from chaosdrill.declared import DECLARED

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


def analyses() -> "Mapping[str, Analysis]":
    """All analyses by their kind."""
    return DECLARED


def _import_all() -> None:
    for name in FUNCTIONS:
        function(name)


DECLARED.completed_by(_import_all)

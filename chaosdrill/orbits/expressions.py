"""Expressions of a system as functions of numbers, for what is asked of a few points only."""

from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from chaosdrill.codegen import python
from chaosdrill.codegen.special import CODE
from chaosdrill.model.derive import differentiate
from chaosdrill.model.held import held_surfaces
from chaosdrill.model.places import TIME, arguments, parameter

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def function_of(placed: "HybridSystem", expression: Any) -> Any:
    """An expression of time, states and parameters as a function of numbers."""
    return sympy.lambdify(arguments(placed), expression, modules=[{**CODE, "Called": python.evaluate}, "math"])


def slopes_of_surfaces(
    system: "HybridSystem", mode: int, time: float, state: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of the surfaces that a mode holds, and their derivatives.

    Returns
    -------
    gradients : ndarray, shape (m, n)
        By the states.
    turned : ndarray, shape (m, n, n + 1 + P)
        The derivatives of these by states, time and parameters.
    """
    known = system.shared.setdefault("slopes of surfaces", {})
    if mode not in known:
        placed = system.placed
        surfaces = held_surfaces(placed)[placed.mode_names[mode]]
        gradients = [[differentiate(surface, x) for x in placed.states] for surface in surfaces]
        by = (*placed.states, TIME, *map(parameter, placed.parameters))
        turned = [[[differentiate(one, symbol) for symbol in by] for one in row] for row in gradients]
        known[mode] = function_of(placed, (gradients, turned))
    gradients, turned = known[mode](time, *state, *values)
    return np.array(gradients, dtype=float), np.array(turned, dtype=float)

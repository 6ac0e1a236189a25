"""Expressions of a system that are asked for at a few points of an orbit only."""

from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen.formulas import function_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def slopes_of_surfaces(
    system: "HybridSystem", mode: int, time: float, state: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of the surfaces that a mode holds, and their derivatives.

    Returns: ``gradients``, shape (m, n): by the states. ``turned``, shape (m, n, n + 1 + P): the derivatives of these
    by states, time and parameters.
    """
    gradients, turned = function_of(system, f"slopes {mode}", lambda placed: _slopes(placed, mode))(
        time, *state, *values
    )
    return np.array(gradients, dtype=float), np.array(turned, dtype=float)


def _slopes(placed: "HybridSystem", mode: int) -> Any:
    from chaosdrill.model.derive import differentiate
    from chaosdrill.model.held import held_surfaces
    from chaosdrill.model.places import TIME, parameter

    surfaces = held_surfaces(placed)[placed.mode_names[mode]]
    gradients = [[differentiate(surface, x) for x in placed.states] for surface in surfaces]
    by = (*placed.states, TIME, *map(parameter, placed.parameters))
    return gradients, [[[differentiate(one, symbol) for symbol in by] for one in row] for row in gradients]

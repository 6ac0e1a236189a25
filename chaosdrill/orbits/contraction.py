"""Volume of tangents around an orbit, from the expressions alone: divergence of the fields, determinants at events."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from chaosdrill.model.derive import jacobian, saltation
from chaosdrill.model.places import arguments
from chaosdrill.model.special import SPECIAL
from chaosdrill.orbits.arcs import arc_by_arc

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
"""Of the Gauss-Legendre quadrature of one piece of an arc."""

PIECES = 4
"""Pieces of an arc in the first quadrature; they are doubled until two agree."""

AGREE = 1e-11
"""Difference of two quadratures, relative to max(1, integral), that ends the doubling."""

DOUBLINGS = 6
"""Times that pieces are doubled, at most."""


def contraction(family: "Family", orbit: "Orbit") -> float:
    """Logarithm of |det| of the tangent map around an orbit.

    The integral of the divergence of the fields (Liouville) plus the logarithms of the determinants of the saltation
    matrices (Aizerman and Gantmakher, On the stability of periodic motions, J. Appl. Math. Mech. 22, 1065 (1958),
    doi:10.1016/0021-8928(58)90033-9), which are derived and evaluated as expressions: no tangent is followed.
    """
    system = family.plain
    values = np.array(list(system.parameters.values()))
    total = 0.0
    for one, before in arc_by_arc(family, orbit):
        mode, end, transition = one.arcs[0].tolist()
        divergence = _divergence(system, mode)
        if divergence is not None:
            total += _integral(family, one, divergence, values)
        if end >= 0:
            matrix = _saltation(system, transition, mode)(one.phase + one.durations[0], *before, *values)
            total += float(np.linalg.slogdet(np.array(matrix, dtype=float))[1])
    return total


def _integral(family: "Family", one: "Orbit", divergence: Any, values: np.ndarray) -> float:
    """Integral of the divergence along an arc."""
    length = float(one.durations[0])
    found = np.inf
    for doubling in range(DOUBLINGS + 1):
        pieces = PIECES * 2**doubling
        half = length / pieces / 2
        instants = (half * (2 * np.arange(pieces)[:, np.newaxis] + 1 + NODES)).ravel()
        states = family.at([one], instants[np.newaxis])[0][0]
        rates = [divergence(one.phase + s, *x, *values) for s, x in zip(instants, states.tolist(), strict=True)]
        before, found = found, half * float(np.tile(WEIGHTS, pieces) @ np.array(rates))
        if abs(found - before) <= AGREE * max(1.0, abs(found)):
            break
    return found


def _function(placed: "HybridSystem", expression: Any) -> Any:
    """An expression of time, states and parameters as a function of numbers."""
    return sympy.lambdify(arguments(placed), expression, modules=[_special(), "math"])


def _special() -> dict[str, Any]:
    found = {}
    for name, place in SPECIAL.items():
        module, _, function = place.partition(":")
        found[name] = getattr(import_module(module), function)
    return found


def _divergence(system: "HybridSystem", mode: int) -> Any:
    """Divergence of the field of a mode as a function; None where it is zero."""
    known = system.shared.setdefault("divergences", {})
    if mode not in known:
        placed = system.placed
        trace = jacobian(placed, placed.mode_names[mode]).trace()
        known[mode] = None if trace == 0 else _function(placed, trace)
    return known[mode]


def _saltation(system: "HybridSystem", transition: int, mode: int) -> Any:
    known = system.shared.setdefault("saltations", {})
    if (transition, mode) not in known:
        placed = system.placed
        matrix = saltation(placed, placed.transitions[transition], placed.mode_names[mode])
        known[transition, mode] = _function(placed, matrix.tolist())
    return known[transition, mode]

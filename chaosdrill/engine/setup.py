"""What a system and its numerics put into the engine's arrays, whatever the point at which it is run."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine import layout as at
from chaosdrill.engine.dop853_tables import stage_rows
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.roots import DEPTH
from chaosdrill.model.derive import pinned_states, pinned_values

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


ON_GUARD = 2e-15
"""Part of the size of the states below which a guard's value at the start of a phase is round-off."""


def integer_settings(
    system: "HybridSystem", numerics: Numerics, order: int, *, samples: int = 1, orthonormalise: bool = True
) -> np.ndarray:
    """Settings that are integers, in the order of ``engine.layout``; ``order`` is that of a guard's polynomial."""
    settings = np.zeros(at.SETTINGS_I, dtype=np.int64)
    settings[at.METHOD] = at.METHOD_CODES[numerics.method]
    settings[at.ORDER] = order
    settings[at.QUADRATURES] = len(system.quadratures)
    settings[at.SAMPLES] = samples
    settings[at.ORTHOGONALISE] = int(orthonormalise)
    settings[at.ABSOLUTE_TIME] = int(system.period is None)
    settings[at.JACOBIAN] = int(system.kernels.own_jacobian)
    settings[at.MAX_EVENTS] = 10_000 if system.period is not None else 10_000_000
    return settings


def real_settings(numerics: Numerics, order: int, periods: np.ndarray) -> np.ndarray:
    """Settings that are doubles, shape (P, settings), for the periods of P runs."""
    settings = np.zeros((len(periods), at.SETTINGS_F))
    settings[:, at.TOLERANCE] = numerics.tolerance
    # at this part of the radius of convergence the last term is a quarter of the tolerance
    settings[:, at.REACH] = (numerics.tolerance / 4) ** (1 / order)
    settings[:, at.PERIOD] = periods
    settings[:, at.ON_GUARD] = ON_GUARD
    settings[:, at.STEP] = periods / (numerics.steps or 200)
    return settings


def event_tables(system: "HybridSystem", deficient: Collection[int]) -> tuple[np.ndarray, np.ndarray]:
    """Marks of the guards of every mode, and the table of transitions; rank may be lost at those in ``deficient``."""
    kernels = system.kernels
    transitions = np.zeros((len(kernels.transition_table), 3), dtype=np.int64)
    transitions[:, :2] = kernels.transition_table
    transitions[sorted(deficient), at.RANK_DEFICIENT] = 1
    marks = np.zeros((len(kernels.events), kernels.mode_table.shape[1]), dtype=np.int64)
    for row, events in zip(marks, kernels.events, strict=True):
        for j, event in enumerate(events):
            only = all(kernels.transition_table[k, 1] for k in event.outcomes)
            losing = any(k in deficient for k in event.outcomes)
            row[j] = at.MARKS * only + at.LOSES_RANK * losing + at.AFFINE * event.affine
            row[j] += at.UNPROVEN * (not event.entire)
    return marks, transitions


def bounds_of(system: "HybridSystem") -> np.ndarray:
    """Lower and upper bounds of the states, shape (2, n)."""
    return np.array([system.bounds[s] for s in system.state_names]).T.copy()


def pins(system: "HybridSystem") -> np.ndarray:
    """Which states each mode leaves no freedom, shape (modes, n)."""
    table: np.ndarray | None = system.shared.get("pins")
    if table is None:
        table = np.zeros((len(system.modes), len(system.states)), dtype=np.int64)
        for row, mode in zip(table, system.modes, strict=True):
            row[list(pinned_states(system, mode))] = 1
        system.shared["pins"] = table
    return table


def values_of_pins(system: "HybridSystem", parameters: Mapping[str, Any], mode: int) -> dict[int, Any]:
    """What a mode pins its states to at the strobe: index of the state -> value, an array if a parameter is one."""
    known = system.shared.setdefault("values of pins", {})
    names = list(system.parameters)
    if mode not in known:
        symbols = [sympy.Symbol(name, real=True) for name in names]
        known[mode] = {
            i: sympy.lambdify(
                symbols, value if system.time is None else value.xreplace({system.time: sympy.Integer(0)})
            )
            for i, value in pinned_values(system, system.mode_names[mode]).items()
        }
    numbers = [parameters.get(name, system.parameters[name]) for name in names]
    return {i: value(*numbers) for i, value in known[mode].items()}


def begin(carried: np.ndarray, tangents: int) -> None:
    """Fill carried integers, shape (..., carried), for runs that are to begin with so many tangents."""
    carried[...] = 0
    carried[..., at.LIVE] = tangents
    carried[..., at.FRESH] = at.BEGIN
    carried[..., at.FIRED] = -1
    carried[..., at.QR_WAIT] = 1
    carried[..., at.RANK_CHECK] = 1


def workspace(system: "HybridSystem", m: int) -> tuple[np.ndarray, ...]:
    """Scratch arrays of the engine for a system with m tangents."""
    n, q, guards = len(system.states), len(system.quadratures), system.kernels.mode_table.shape[1]
    return (
        np.zeros((system.kernels.rows + (m + m % 2) * n, at.COLUMNS)), np.zeros(at.COLUMNS), np.zeros(at.COLUMNS),
        np.zeros((DEPTH, at.COLUMNS)), np.zeros((DEPTH, 2)), np.zeros(guards), np.zeros(n + 1), np.zeros(n + q),
        np.zeros(n + q), np.zeros(n + q), np.zeros(n), np.zeros(event_places(n).size), np.zeros(n),
        np.zeros((stage_rows(m), n + q)),
    )  # fmt: skip

"""Multipliers of orbits, those of lost rank exactly zero."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.engine.run import Run
from chaosdrill.engine.setup import pins
from chaosdrill.engine.structure import Structure, examine

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit

NEUTRAL = 1e-6
"""Distance from 1 within which the multiplier of the flow direction is recognised."""


def based(family: "Family", orbit: "Orbit") -> "Orbit":
    """The orbit told from the arc whose mode leaves the least freedom: what is lost there is zero in every entry."""
    table = pins(family.plain)
    first = int(np.argmax([table[mode].sum() for mode in orbit.arcs[:, at.ARC_MODE]]))
    return orbit.rotated(first, family.period_at(orbit)) if first else orbit


def structure_of(system: "HybridSystem") -> Structure:
    """What is known of the tangents of a system; examined once for all values of its parameters."""
    known: Structure | None = system.shared.get("structure of orbits")
    if known is None:
        known = system.shared["structure of orbits"] = examine(system)
    return known


def structural_rank(family: "Family", orbit: "Orbit", system: "HybridSystem") -> int:
    """Rank that the tangent map keeps however often the orbit is gone through, by what its events remove exactly.

    The ordinary engine carries as many independent tangents around it as there are states.
    """
    states, modes = family.strobes([orbit])
    d = family.states
    structure = structure_of(family.plain)
    period = family.period_at(orbit) if family.forced else float(orbit.durations.sum())
    assert period is not None
    start = dict(zip(system.state_names, states[0, 0].tolist(), strict=True))
    run = Run(
        system.with_initial(**start, mode=system.mode_names[modes[0, 0]]), period, family.numerics, tangents=np.eye(d),
        deficient=structure.deficient,
    )  # fmt: skip
    outcome = Outcome.OK
    for _ in range(d):
        outcome = run.advance(orbit.periods)[0] if outcome == Outcome.OK else outcome
        run.x[:] = states[0, 0]
    return run.live if outcome == Outcome.OK else d - int(pins(family.plain)[orbit.arcs[0, at.ARC_MODE]].sum())


def multipliers(family: "Family", orbit: "Orbit", monodromy: np.ndarray, rank: int) -> np.ndarray:
    """Eigenvalues of tangent maps around orbits of the same arcs, by falling modulus.

    Parameters
    ----------
    family : Family
    orbit : Orbit
        One of them: from the mode of its first arc follows which states are pinned.
    monodromy : ndarray, shape (..., d, d)
    rank : int
        So many are not zero.

    Returns
    -------
    ndarray of complex, shape (..., d)
    """
    free = np.flatnonzero(pins(family.plain)[orbit.arcs[0, at.ARC_MODE]] == 0)
    values = np.zeros(monodromy.shape[:-1], dtype=complex)
    values[..., : len(free)] = np.linalg.eigvals(monodromy[..., free[:, np.newaxis], free])
    order = np.argsort(-np.abs(values), axis=-1, kind="stable")
    values = np.take_along_axis(values, order, axis=-1)
    values[..., rank:] = 0.0
    return values


def free_multipliers(family: "Family", values: np.ndarray) -> np.ndarray:
    """The multipliers without the one of the flow direction, which is 1 on every orbit of a system without a period."""
    if family.forced:
        return values
    flow = np.abs(values - 1).argmin(axis=-1)[..., np.newaxis]
    kept = np.arange(values.shape[-1]) != flow
    return values[kept].reshape(*values.shape[:-1], values.shape[-1] - 1)

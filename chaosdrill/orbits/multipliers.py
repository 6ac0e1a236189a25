"""Multipliers of orbits, those of lost rank exactly zero."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.engine.setup import pins
from chaosdrill.engine.structure import Structure, examine
from chaosdrill.orbits.arcs import arc_by_arc
from chaosdrill.orbits.place import run_from, standpoint

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit

GRADED = 1e-3
"""Part of the norm of the tangent map below which a multiplier is not read off the map as a whole."""

MOST_LAPS = 64
"""Laps of simultaneous iteration, at most; multipliers of nearly one modulus are then taken together."""

TURNED = 1e-14
"""What is left of a wrong direction when two multipliers count as told apart."""

CONDITION = 1e4
"""Condition number of a piece of an arc that is not cut any further."""

DEEPEST = 10
"""Times that an arc is halved, at most."""


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


def structural_rank(family: "Family", orbit: "Orbit") -> int:
    """Rank that the tangent map keeps however often the orbit is gone through, by what its events remove exactly.

    The ordinary engine carries as many independent tangents around it as there are states, from within an arc, so that
    every round holds all events.
    """
    d = family.states
    arc, time, state = standpoint(family, orbit)
    structure = structure_of(family.plain)
    run = run_from(family, orbit, arc, time, state, tangents=np.eye(d), deficient=structure.deficient)
    outcome = Outcome.OK
    for _ in range(d):
        outcome = run.advance(orbit.periods if family.forced else 1)[0] if outcome == Outcome.OK else outcome
        run.x[:] = state
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


def graded(family: "Family", orbit: "Orbit", monodromy: np.ndarray, rank: int) -> np.ndarray:
    """The same of one orbit, every one to its own relative precision, however far apart they are.

    Eigenvalues of a product that was multiplied out know the smaller ones only to the round-off of the largest. Here
    the factors stay apart: simultaneous iteration around the orbit makes all of them triangular (periodic QR;
    Bojanczyk, Golub and Van Dooren 1992, doi:10.1117/12.130915).
    """
    plain = multipliers(family, orbit, monodromy, rank)
    if rank < 2 or abs(plain[rank - 1]) > GRADED * np.linalg.norm(monodromy, 2):
        return plain
    factors = pieces(family, orbit)
    d = family.states
    before = np.linalg.qr(np.random.default_rng(20260105).normal(size=(d, d)))[0]
    logs, apart = np.zeros(rank), np.zeros(rank - 1, dtype=bool)
    triangles: list[np.ndarray] = []
    for laps in range(1, MOST_LAPS + 1):
        turned = apart.all()
        basis, triangles = before, []
        for factor in factors:
            after, triangle = np.linalg.qr(factor @ basis)
            triangles.append(triangle)
            basis = after
        if turned or laps == MOST_LAPS:
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            logs += sum(np.log(np.abs(np.diagonal(t)[:rank])) for t in triangles)
            apart = -np.diff(logs) > -np.log(TURNED)
        before = basis
    values = np.zeros(d, dtype=complex)
    ends = [*(np.flatnonzero(apart) + 1).tolist(), rank]
    for first, end in zip([0, *ends[:-1]], ends, strict=True):
        block = np.eye(end - first)
        for triangle in triangles:
            block = triangle[first:end, first:end] @ block
        values[first:end] = np.linalg.eigvals(before[:, first:end].T @ basis[:, first:end] @ block)
    return values[np.argsort(-np.abs(values), kind="stable")]


def pieces(family: "Family", orbit: "Orbit") -> list[np.ndarray]:
    """Tangent maps of the arcs and events of an orbit in order, arcs cut so that none of them is ill conditioned."""
    found: list[np.ndarray] = []
    for one, before in arc_by_arc(family, orbit):
        flow = one.arcs.copy()
        flow[:, at.ARC_END] = at.PLANE
        _cut(family, replace(one, arcs=flow), found, 0)
        if one.arcs[0, at.ARC_END] >= 0:
            time = one.phase + float(one.durations[0])
            starts = np.concatenate([before, one.starts[0, family.states :]])[np.newaxis]
            found.append(family.lap(replace(one, starts=starts, phase=time, durations=np.zeros(1)), False).monodromy)
    return found


def _cut(family: "Family", one: "Orbit", found: list[np.ndarray], depth: int) -> None:
    """Tangent maps of an arc, halved until they are well conditioned."""
    matrix = family.lap(one, False).monodromy
    if depth == DEEPEST or np.linalg.cond(matrix) < CONDITION:
        found.append(matrix)
        return
    half = one.durations / 2
    middle = family.at([replace(one, durations=half)], half[np.newaxis])[0][0, 0]
    starts = np.concatenate([middle, one.starts[0, family.states :]])[np.newaxis]
    _cut(family, replace(one, durations=half), found, depth + 1)
    _cut(family, replace(one, starts=starts, phase=one.phase + float(half[0]), durations=half), found, depth + 1)

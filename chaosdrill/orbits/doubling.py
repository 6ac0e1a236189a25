"""From a period doubling onto the branch of doubled orbits, and where such a branch comes back."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine import branch
from chaosdrill.orbits.failures import admissible
from chaosdrill.orbits.special import ON_CHORD

if TYPE_CHECKING:
    from collections.abc import Sequence

    from chaosdrill.orbits.borders import WeightsOf
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit

LENGTHS = (1e-3, 3e-3, 3e-4, 1e-2, 1e-4, 3e-2)
"""Distances from the doubling at which the doubled orbit is tried, in the norm of the weights."""

SHORTER = 4
"""So many times a distance is tried shorter, where the parameter changes too much over it."""

REPEATED = 1e-6
"""Difference relative to the size of the states below which two turns of an orbit are one."""

APART = 0.01
"""Difference between the two halves of a doubled orbit, as a part of that distance, at least."""


def doubled(
    family: "Family", orbit: "Orbit", weights_of: "WeightsOf", scale: float, most: float
) -> tuple["Orbit", np.ndarray] | None:
    """An orbit of twice the period near a period doubling, and the direction that leads away from there.

    Of the two null vectors of the equations of the orbit gone through twice one is the direction of the old branch; the
    new branch starts across it. ``scale`` is a part by which distances are shortened, high up in a cascade; the
    parameter changes by ``most`` at most, so that no further doubling is jumped over.
    """
    d = family.states
    twice = orbit.repeated(2)
    lap = family.lap(twice, watched=False)
    weights = weights_of(twice)
    plane = family.null_space(twice, lap, weights, 2)
    old = family.direction(orbit, family.lap(orbit, watched=False), weights_of(orbit))
    times = np.tile(old[d + 1 : -1], 2) if len(twice) > len(orbit) else 2 * old[d + 1 : -1]
    old = weights * np.concatenate([old[: d + 1], times, old[-1:]])
    inside = plane @ old
    direction = np.array([-inside[1], inside[0]]) @ plane / np.linalg.norm(inside) / weights
    conditions = (direction * weights**2)[np.newaxis]
    for first in LENGTHS:
        length = scale * first
        for _ in range(SHORTER):
            start = family.moved(twice, lap, length * direction)
            code, found, seen, _ = family.solve(start, conditions, ON_CHORD)
            if code != branch.CONVERGED or not admissible(found, seen):
                break
            gap = np.abs(halves_apart(family, [found], weights)).max()
            if gap <= APART * length:
                break
            change = float(np.abs(found.starts[0, d:] - orbit.starts[0, d:]).max())
            if change <= most:
                return found, direction
            # the parameter changes with the square of the distance
            length *= 0.9 * np.sqrt(most / change)
    return None


def halves_apart(family: "Family", orbits: "Sequence[Orbit]", weights: np.ndarray) -> np.ndarray:
    """Weighted differences between the two halves of orbits, shape (P, m): starts and durations of their arcs.

    Of an orbit that is one arc: its states at the start and half its duration later.
    """
    d, count = family.states, len(orbits[0])
    if count == 1:
        halves = np.array([[0.0, 0.5 * o.durations.sum()] for o in orbits])
        states = family.at(orbits, halves)[0]
        return (states[:, 0] - states[:, 1]) * weights[:d]
    half = count // 2
    starts, durations = np.array([o.starts[:, :d] for o in orbits]), np.array([o.durations for o in orbits])
    moved = (starts[:, :half] - starts[:, half:]) * weights[:d]
    return np.hstack([moved.reshape(len(orbits), -1), (durations[:, :half] - durations[:, half:]) * weights[d + 1]])


def returns(family: "Family", orbits: "Sequence[Orbit]", weights: np.ndarray) -> int | None:
    """Number of the first orbit behind the point at which a branch of doubled orbits runs through its parent."""
    arcs = orbits[0].arcs
    half = len(arcs) // 2
    if len(orbits) < 2 or orbits[0].periods % 2:
        return None
    if len(arcs) > 1 and (len(arcs) % 2 or (arcs[:half] != arcs[half:]).any()):
        return None
    gaps = halves_apart(family, orbits, weights)
    flips = np.flatnonzero((gaps[1:] * gaps[:-1]).sum(axis=1) < 0) + 1
    small = [k for k in flips.tolist() if np.abs(gaps[k - 1 : k + 1]).max() < 0.5 * np.abs(gaps).max()]
    return int(small[0]) if small else None


def repeats(orbit: "Orbit") -> bool:
    """Whether an orbit goes through the same path several times."""
    count, periods = len(orbit), orbit.periods
    parts = [times for times in range(2, periods + 1) if count % times == 0 and periods % times == 0]
    return any(orbit.comes_again(count // times, REPEATED) for times in parts)

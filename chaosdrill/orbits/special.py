"""Special points of a branch: roots of scalar functions along it.

A sign change between two points is followed by Brent's method along the line between them, each trial being corrected
onto the branch by Newton's method, so that a root is as exact as the multipliers are.
"""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from chaosdrill.dataset.branches import Special
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.engine.setup import pins
from chaosdrill.orbits.multipliers import multipliers
from chaosdrill.orbits.stability import free_multipliers

if TYPE_CHECKING:
    from chaosdrill.engine.numerics import Numerics
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.stretch import Stretch

ON_CHORD = 0.2
"""Longest correction by one lap of a trial, in the norm of the weights."""

NOISE = 1e-13
"""Error of an entry of a tangent map, relative to its largest one."""


class LostError(Exception):
    """Newton's method failed between two points of a branch."""


def doubling_test(family: "Family", orbit: "Orbit", monodromy: np.ndarray) -> np.ndarray:
    """Function that vanishes where a multiplier is -1: the determinant of M + 1 in the free states."""
    free = np.flatnonzero(pins(family.plain)[orbit.arcs[0, at.ARC_MODE]] == 0)
    return np.linalg.det(monodromy[..., free[:, np.newaxis], free] + np.eye(len(free)))


def torus_test(values: np.ndarray) -> np.ndarray:
    """Function that vanishes where the product of two multipliers is 1: the product of 1 - mu_i mu_j over pairs."""
    m = values.shape[-1]
    first, second = np.triu_indices(m, 1)
    return np.prod(1 - values[..., first] * values[..., second], axis=-1).real


def fold_test(values: np.ndarray) -> np.ndarray:
    """Function that vanishes where a free multiplier is 1: the product of 1 - mu."""
    return np.prod(1 - values, axis=-1).real


def outside(values: np.ndarray) -> np.ndarray:
    """How many multipliers lie outside of the unit circle."""
    return np.asarray((np.abs(values) > 1).sum(axis=-1))


def pair_on_circle(values: np.ndarray) -> float:
    """Distance from the unit circle of the complex pair that is nearest to it; infinite without a pair."""
    pairs = values[np.abs(values.imag) > REAL * np.abs(values)]
    return float(np.abs(np.abs(pairs) - 1).min(initial=np.inf))


def special_points(family: "Family", stretch: "Stretch", rank: int) -> list[tuple[int, Special]]:
    """What happens between neighbours: (number of the point behind, what).

    Where a multiplier passes through 1 and the branch turns back it is a fold; where it does not, another branch
    crosses. On the branches that a lost symmetry leaves the multiplier only touches 1 while the branch turns. Two
    multipliers whose product passes through 1 are a pair on the unit circle, or two real ones with nothing to tell:
    which of them, is seen where they are located. All functions are products over multipliers or over pairs of them,
    so that none is hidden by another one that stays near to the unit circle.
    """
    if len(stretch) < 2:
        return []
    orbit = stretch.orbit(0)
    values = free_multipliers(multipliers(family, orbit, stretch.monodromies, rank), family.neutral.count)
    noise = noise_of(stretch.monodromies, len(orbit))
    doubling = doubling_test(family, orbit, stretch.monodromies)
    back, through = set(changes(stretch.directions[:, -1])), set(changes(fold_test(values), noise))
    found = [(k, Special.FOLD) for k in back]
    found += [(k, Special.BRANCH_POINT) for k in through - back]
    found += [(k, Special.PERIOD_DOUBLING) for k in changes(doubling, noise)]
    pairs = set(changes(torus_test(values), noise))
    # of two pairs that cross within a step the product of all pairs keeps its sign
    pairs |= set((np.flatnonzero(np.abs(np.diff(outside(values))) > 3) + 1).tolist())
    found += [(k, Special.NEIMARK_SACKER) for k in pairs]
    return sorted(found)


def noise_of(monodromy: np.ndarray, arcs: int) -> np.ndarray:
    """Error of the determinants of tangent maps, shape (..., d, d), around orbits of so many arcs."""
    return NOISE * arcs * np.maximum(1.0, np.abs(monodromy).max(axis=(-2, -1))) ** 2


def changes(values: np.ndarray, noise: np.ndarray | float = 0.0) -> list[int]:
    """Numbers of the values before which the sign changes; between values above their errors, shape (m,), only."""
    sure = np.flatnonzero(np.abs(values) > noise)
    found = []
    for before, after in pairwise(sure.tolist()):
        if values[before] * values[after] < 0:
            turned = values[before + 1 : after + 1] * np.sign(values[before]) <= 0
            found.append(before + 1 + int(turned.argmax()))
    return found


def accuracy(numerics: "Numerics") -> float:
    """Error of an orbit that the method leaves, relative to its size."""
    return (2 * np.pi / (numerics.steps or 200)) ** 4 if numerics.method == "rk4" else max(NOISE, numerics.tolerance)


def locate(
    family: "Family", before: "Orbit", after: "Orbit", kind: Special, weights: np.ndarray, rank: int
) -> tuple["Orbit", "Lap", Special, float]:
    """A special point between two orbits of a branch: (orbit, lap, what it is, error of the parameter).

    What looks like a fold may turn out to be a point at which branches cross.

    Raises
    ------
    LostError
        No orbit is found on the way, or what is found has no such multiplier.
    """
    chord = after.reduced(family.states) - before.reduced(family.states)
    conditions = (chord * weights**2)[np.newaxis]
    last: dict[str, tuple[Orbit, Lap]] = {}

    def value(part: float) -> float:
        try:
            orbit, lap = between(family, before, after, part, conditions)
        except LostError:
            # where branches cross the equations are singular, and on a straight branch exactly so
            orbit = before.between(after, part)
            lap = family.lap(orbit)
            if kind != Special.BRANCH_POINT or not lap.residual < STRAIGHT:
                raise
        last["found"] = orbit, lap
        if kind == Special.FOLD:
            return float(family.direction(orbit, lap, weights, chord)[-1])
        if kind == Special.PERIOD_DOUBLING:
            return float(doubling_test(family, orbit, lap.monodromy))
        test = fold_test if kind == Special.BRANCH_POINT else torus_test
        return float(test(_free(family, orbit, lap, rank)))

    low, high = value(0.0), value(1.0)
    if low * high > 0:
        raise LostError("the function has one sign at both ends")
    root = brentq(value, 0.0, 1.0, xtol=1e-15, rtol=1e-15)
    there = value(root)
    orbit, lap = last["found"]
    if abs(there) > JUMPS * max(abs(low), abs(high)) or _misses(_free(family, orbit, lap, rank), kind):
        raise LostError("the function jumps")
    if kind == Special.NEIMARK_SACKER and pair_on_circle(_free(family, orbit, lap, rank)) > MISSED:
        return orbit, lap, Special.REGULAR, 0.0
    if kind == Special.FOLD and _crossed(family, before, orbit, after, weights):
        kind = Special.BRANCH_POINT
    scale = accuracy(family.numerics)
    slope = abs(high - low) / max(abs(chord[-1]), 1e-300)
    if kind == Special.BRANCH_POINT:
        # the equations vanish there to third order across, so that the orbit is known to the root of its residual only
        error = 3 * scale ** (2 / 3) * max(1.0, abs(float(orbit.starts[0, -1])))
    elif kind == Special.FOLD:
        error = scale
    else:
        error = float(noise_of(lap.monodromy, len(orbit))) * scale / NOISE / slope + scale * abs(orbit.starts[0, -1])
    return orbit, lap, kind, float(error)


STRAIGHT = 1e-9
"""Residual between two points of a branch up to which the line between them is the branch."""

MISSED = 1e-3
"""Distance of a multiplier from the value that it is to have at a special point, at most."""

JUMPS = 0.1
"""What is left of a function where its sign changes, as a part of its values beside, if it jumps there."""

REAL = 1e-6
"""Imaginary part of a multiplier, as a part of it, up to which it may be one of two equal real ones."""

SINGULAR = 0.1
"""Smallest singular value of the equations, relative to that of the neighbours, where two branches cross."""


def _free(family: "Family", orbit: "Orbit", lap: "Lap", rank: int) -> np.ndarray:
    return free_multipliers(multipliers(family, orbit, lap.monodromy, rank), family.neutral.count)


def _misses(values: np.ndarray, kind: Special) -> bool:
    """Whether no multiplier is what it is to be."""
    if kind == Special.NEIMARK_SACKER:
        first, second = np.triu_indices(len(values), 1)
        return bool(np.abs(values[first] * values[second] - 1).min(initial=np.inf) > MISSED)
    return bool(np.abs(values - (-1 if kind == Special.PERIOD_DOUBLING else 1)).min(initial=np.inf) > MISSED)


def _crossed(family: "Family", before: "Orbit", there: "Orbit", after: "Orbit", weights: np.ndarray) -> bool:
    """Whether the equations lose rank at an orbit, unlike at its neighbours."""
    smallest = [family.regularity(o, family.lap(o, watched=False), weights) for o in (before, there, after)]
    return smallest[1] < SINGULAR * min(smallest[0], smallest[2])


def between(
    family: "Family", before: "Orbit", after: "Orbit", part: float, conditions: np.ndarray
) -> tuple["Orbit", "Lap"]:
    """The orbit of the branch beside a point of the line between two."""
    code, orbit, lap, _ = family.solve(before.between(after, part), conditions, ON_CHORD)
    if code != branch.CONVERGED:
        raise LostError(f"no orbit at part {part} of the way")
    return orbit, lap

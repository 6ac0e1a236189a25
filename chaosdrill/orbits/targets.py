"""What vanishes along a curve of special points: for each kind a smooth function of the orbits over two parameters."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.orbits.borders import Border, distance, left_out
from chaosdrill.orbits.find import least_period
from chaosdrill.orbits.multipliers import based
from chaosdrill.orbits.plane import Plane, plane_at
from chaosdrill.orbits.reading import eventless
from chaosdrill.orbits.special import LostError, doubling_test
from chaosdrill.orbits.touching import Touch, nearest_touch, slowest_event

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit

SAME_PATH = 1e-4
"""Distance in the norm of the weights within which two sequences of events follow one path at a border."""


class Target(Protocol):
    """A function that is zero along the curve.

    Attributes
    ----------
    kind : Special
    margin : float
        0, or the distance from the curve, in the norm of the weights, at which it is seen whether the system follows
        the orbits: where it does so only up to the curve itself, and only where the function is negative.
    """

    kind: Special
    margin: float

    def value(self, family: "Family", orbit: "Orbit", lap: "Lap", plane: Plane, instant: float) -> tuple[float, float]:
        """The function, and the instant on the orbit to which it belongs; ``plane`` and ``instant`` are of an orbit
        near by."""


@dataclass(frozen=True)
class Doubling:
    """A multiplier is -1."""

    kind = Special.PERIOD_DOUBLING
    margin = 0.0

    def value(self, family: "Family", orbit: "Orbit", lap: "Lap", plane: Plane, instant: float) -> tuple[float, float]:
        return float(doubling_test(family, orbit, lap.monodromy)), instant


@dataclass(frozen=True)
class Fold:
    """The surface of orbits folds over the parameters, whichever of them moves: nothing is special at a cusp."""

    kind = Special.FOLD
    margin = 0.0

    def value(self, family: "Family", orbit: "Orbit", lap: "Lap", plane: Plane, instant: float) -> tuple[float, float]:
        return plane_at(family, orbit, lap, plane.weights, plane).twist, instant


@dataclass(frozen=True)
class Touching:
    """A guard's greatest value within an arc is zero."""

    touch: Touch
    kind = Special.GRAZING
    margin = 1e-8

    def value(self, family: "Family", orbit: "Orbit", lap: "Lap", plane: Plane, instant: float) -> tuple[float, float]:
        return self.touch.greatest(family, orbit, instant)


@dataclass(frozen=True)
class Vanishing:
    """An event has no speed, where no path without it is an orbit: its reset moves the state however slow it is met."""

    event: int
    kind = Special.GRAZING
    # a guard met with the speed v is above zero by no more than v^2 later
    margin = 1e-6

    def value(self, family: "Family", orbit: "Orbit", lap: "Lap", plane: Plane, instant: float) -> tuple[float, float]:
        return -float(lap.speeds[self.event]), instant


def target_at(
    family: "Family", orbit: "Orbit", lap: "Lap", kind: Special, weights: np.ndarray
) -> tuple[Target, "Orbit", "Lap", float]:
    """What vanishes at a special point: (target, orbit to begin with, its lap, instant).

    At grazing the orbit told without the event that appears or vanishes is taken, since its multipliers are finite.

    Raises
    ------
    LostError
        No guard is touched.
    """
    if kind == Special.PERIOD_DOUBLING:
        return Doubling(), orbit, lap, 0.0
    if kind == Special.FOLD:
        return Fold(), orbit, lap, 0.0
    slowest = slowest_event(family, orbit, lap)
    found = nearest_touch(family, orbit)
    if found is not None and slowest is None:
        return Touching(found[0]), orbit, lap, found[1]
    for guess in _without_event(family, orbit, lap):
        code, other, _, _ = family.solve(based(family, guess))
        if code == branch.CONVERGED and distance(family, other, orbit, weights) < SAME_PATH:
            # a doubled orbit whose halves graze one after the other is one of half the period at their common border
            other, _ = least_period(family, other)
            touched = nearest_touch(family, other)
            if touched is not None and slowest_event(family, other, family.lap(other)) is None:
                return Touching(touched[0]), other, family.lap(other), touched[1]
    if found is not None:
        return Touching(found[0]), orbit, lap, found[1]
    if slowest is None:
        raise LostError("no guard is touched there, and no event comes without speed")
    return Vanishing(slowest), orbit, lap, 0.0


def _without_event(family: "Family", orbit: "Orbit", lap: "Lap") -> Iterator["Orbit"]:
    """The path told without events that may have no effect."""
    yield from left_out(Border(orbit, lap, None, None, 0.0))
    modes = set(orbit.arcs[:, at.ARC_MODE].tolist())
    if family.forced and len(modes) == 1:
        period = family.period_at(orbit)
        assert period is not None
        states, _ = family.strobes([orbit])
        name = family.plain.mode_names[modes.pop()]
        yield eventless(family, states[0, 0], name, orbit.periods, orbit.starts[0, family.states :], period)

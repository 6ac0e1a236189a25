"""From a border, at which a curve's events change, onto the curve with the others that begins there."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import BranchEnd
from chaosdrill.engine import branch
from chaosdrill.orbits.borders import Border, WeightsOf, distance, go_on, what_changed
from chaosdrill.orbits.correcting import Corrector, Spot
from chaosdrill.orbits.family import Family
from chaosdrill.orbits.special import ON_CHORD, LostError
from chaosdrill.orbits.targets import Touching, Vanishing
from chaosdrill.orbits.touching import slowest_event, touches
from chaosdrill.orbits.tracing import Traced

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.targets import Target

AHEAD = 1e-3
"""Step along the branch behind a border to an orbit whose new events are not as slow as can be."""

SHIFTS = (1e-4, -1e-4)
"""Changes of the second parameter, as parts of its range, at which the first point behind a border is looked for."""

JOINED = 5e-3
"""Distance in the norm of the weights, and in parts of the ranges, within which that point belongs to the border."""


def onward(corrector: Corrector, traced: Traced) -> tuple[Corrector, Spot, str] | None:
    """The curve that goes on behind a border: (its corrector, its first point with the way ahead, what changed).

    With the second parameter held, the branch behind the border is the one that `chaosdrill.orbits.borders.go_on`
    finds. A special point of the same kind is looked for next to it, a little away from the border, where the new
    events have some speed. Where the tangent map jumps, as for the multipliers of orbits that begin to graze, there is
    none near by, and the curve ends.
    """
    border = traced.border
    if border is None or traced.end == BranchEnd.DOUBLING or isinstance(corrector.target, Vanishing):
        return None
    family, last = corrector.family, traced.spots[-1]
    second, span = float(corrector.values(border.good)[1]), np.ptp(corrector.limits, axis=1)
    one = Family(family.plain.with_parameters(**{family.free[1]: second}), family.free[:1], family.numerics)
    good, bad = _flat(border.good), None if border.bad is None else _flat(border.bad)
    flat = Border(good, one.lap(good), bad, None if bad is None else one.lap(bad), border.error)
    found = go_on(one, flat, WeightsOf(one, span[:1]))
    if found is None:
        return None
    moved = one.moved(found.orbit, found.lap, AHEAD * found.ahead)
    weights = one.weights(moved, span[:1])
    code, orbit, _, _ = one.solve(moved, (found.ahead * weights**2)[np.newaxis], ON_CHORD)
    if code != branch.CONVERGED:
        return None
    for shift in SHIFTS:
        try:
            behind, spot = _beside(corrector, lifted(orbit, second), second + shift * float(span[1]))
        except LostError:
            continue
        weights = behind.weights(spot.orbit)
        change = behind.values(spot.orbit) - corrector.values(last.orbit)
        gap = max(float(np.linalg.norm(change / span)), distance(family, spot.orbit, last.orbit, weights))
        if gap < JOINED and behind.blocked(spot) is None and slowest_event(family, spot.orbit, spot.lap) is None:
            ahead = float(np.sign((change / span) @ (spot.tangent[-2:] / span)))
            _, text = what_changed(one, flat, found.orbit)
            return behind, replace(spot, tangent=ahead * spot.tangent, arclength=last.arclength + gap), text
    return None


def _beside(corrector: Corrector, orbit: "Orbit", second: float) -> tuple[Corrector, Spot]:
    """The point of the same kind at a value of the second parameter, next to an orbit with other events."""
    family = corrector.family
    values = corrector.values(orbit).copy()
    values[1] = second
    code, orbit, lap, _ = family.solve(orbit.with_values(values, family.states))
    if code != branch.CONVERGED:
        raise LostError("no orbit beside the border")
    target, instant = _same_target(family, orbit, corrector.target)
    behind = Corrector(family, target, corrector.limits)
    return behind, behind.first(orbit, lap, instant)


def lifted(orbit: "Orbit", value: float) -> "Orbit":
    """The same orbit with one more free parameter."""
    return replace(orbit, starts=np.column_stack([orbit.starts, np.full(len(orbit), value)]))


def _flat(orbit: "Orbit") -> "Orbit":
    """The same orbit without the last free parameter."""
    return replace(orbit, starts=np.ascontiguousarray(orbit.starts[:, :-1]))


def _same_target(family: Family, orbit: "Orbit", target: "Target") -> tuple["Target", float]:
    """The target of the same kind on an orbit next to a border, and its instant."""
    if not isinstance(target, Touching):
        return target, 0.0
    _, touch, instant = min(touches(family, orbit), key=lambda one: one[0], default=(0.0, None, 0.0))
    if touch is None:
        raise LostError("no guard has a greatest value within an arc")
    return Touching(touch), instant

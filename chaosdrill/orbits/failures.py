"""Why there is no orbit, in words."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.orbits.pace import unit_of

if TYPE_CHECKING:
    from chaosdrill.engine.run import Run
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.place import Place

SLIP = 1e-3
"""Part of the duration that a slip without motion takes at most."""

AT_REST = 1e-9
"""Part of its size by which a state moves at least along an orbit that is none of a point at rest."""

WATCHED = 64
"""Periods, or units of the motion's pace, over which a state that only grows is told from one that comes back."""

EVENLY = 0.4
"""Part of its whole way, to and fro, by which such a state goes on in either half of that."""


class NoOrbitError(Exception):
    """Why no orbit was found.

    Parameters
    ----------
    outcome : Outcome
    message : str
    residuals : ndarray
        Of Newton's method, as far as it got.
    """

    def __init__(self, outcome: Outcome, message: str, residuals: np.ndarray | None = None) -> None:
        super().__init__(message)
        self.outcome, self.message = outcome, message
        self.residuals = np.zeros(0) if residuals is None else residuals


def admissible(orbit: "Orbit", lap: "Lap") -> bool:
    """Whether the system follows the orbit as it is written down: its guards, their order, their outcomes."""
    events = orbit.arcs[:, at.ARC_END] >= 0
    return bool(
        (lap.crossed < 0).all()
        and (lap.came == orbit.arcs[:, at.ARC_OUTCOME]).all()
        and (orbit.durations > 0).all()
        and (lap.speeds[events] > 0).all()
    )


def inadmissible_words(family: "Family", orbit: "Orbit", lap: "Lap") -> str:
    """Why the system does not follow an orbit whose equations hold: the first reason."""
    system = family.plain
    for i, (mode, end, outcome) in enumerate(orbit.arcs.tolist()):
        name = system.mode_names[mode]
        if lap.crossed[i] >= 0:
            found = family.system.kernels.events[mode][lap.crossed[i]].outcomes[0]
            return f"in mode {name!r} the guard of {system.transitions[found].name!r} is crossed on the way"
        if not orbit.durations[i] > 0:
            return f"the stay in mode {name!r} would last {orbit.durations[i]:.3g}"
        if end >= 0 and lap.came[i] != outcome:
            return f"the event {system.transitions[outcome].name!r} comes out otherwise"
        if end >= 0 and not lap.speeds[i] > 0:
            return f"the guard of {system.transitions[outcome].name!r} would be met from its other side"
    return ""


def at_rest(family: "Family", orbit: "Orbit") -> bool:
    """Whether nothing moves along the orbit: no event happens, or none but a slip of no length."""
    if not orbit.eventless and orbit.durations.min() > SLIP * orbit.durations.sum():
        return False
    total = float(orbit.durations.sum())
    path = family.at([orbit], np.linspace(0, total, 33)[np.newaxis, :-1])[0][0]
    return bool(np.ptp(path, axis=0).max() <= AT_REST * max(1.0, np.abs(path).max()))


def understood(family: "Family", place: "Place", failure: NoOrbitError) -> NoOrbitError:
    """Why there is no orbit, from what the motion does later on: end, or rest, or let a state only grow."""
    system = place.system
    unit = unit_of(family, place)
    run = place.run(unit, family.numerics)
    points = [run.x.copy()]
    for _ in range(WATCHED):
        outcome = run.advance(1)[0]
        if outcome == failure.outcome:
            return failure
        if outcome != Outcome.OK:
            words = f"{failure.message}; and the motion from the start ends: {outcome.advice}"
            return NoOrbitError(outcome, words, failure.residuals)
        points.append(run.x.copy())
    if not family.forced and _rests(run):
        return NoOrbitError(Outcome.EQUILIBRIUM, "the motion from the start comes to rest", failure.residuals)
    growing = _growing(np.array(points))
    if not growing.any():
        return failure
    each = "a period" if family.forced else "a unit of time"
    net = (points[-1] - points[0]) / (WATCHED if family.forced else WATCHED * unit)
    told = ", ".join(f"{system.state_names[i]} by {net[i]:.3g}" for i in np.flatnonzero(growing))
    return NoOrbitError(
        Outcome.OPEN,
        f"the motion cannot close: {told} {each} on the average, and never back; leave a state that only grows out and "
        "carry it as a quadrature, or write a phase as a function of time",
        failure.residuals,
    )


def _rests(run: "Run") -> bool:
    """Whether nothing moves any more."""
    system = run.system
    rates = np.zeros(len(run.x) + len(system.quadratures))
    mode = system.mode_names.index(run.mode)
    system.kernels.functions[3](mode, run.elapsed, run.c, run.x, rates)
    return bool(np.abs(rates[: len(run.x)]).max() <= AT_REST * max(1.0, float(np.abs(run.x).max())))


def _growing(points: np.ndarray) -> np.ndarray:
    """Which states only grow or only fall, evenly, shape (n,)."""
    steps = np.diff(points, axis=0)
    way = np.abs(steps).sum(axis=0)
    halves = np.abs(steps.reshape(2, -1, points.shape[1]).sum(axis=1))
    size = np.maximum(np.abs(points).max(axis=0), 1.0)
    return (halves.min(axis=0) > EVENLY * way) & (way > 1e-3 * size)


def why_not(code: int, residuals: np.ndarray) -> str:
    """Why Newton's method failed, in words."""
    known = residuals[np.isfinite(residuals)]
    went = f"; its residuals went from {known[0]:.1e} to {known.min():.1e}" if len(known) else ""
    if code == branch.SINGULAR:
        return f"Newton's method found the equations singular{went}"
    if code == branch.SLOW:
        return f"Newton's method did not converge{went}"
    return f"Newton's method ran off to where the system cannot be followed ({Outcome(code).meaning}){went}"

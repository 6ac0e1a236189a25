"""Why there is no orbit, in words."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.engine.run import Run

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family, Lap
    from chaosdrill.orbits.orbit import Orbit

AT_REST = 1e-9
"""Part of its size by which a state moves at least along an orbit that is none of a point at rest."""

WATCHED = 64
"""Periods, or units of time, over which a state that only grows is told from one that comes back."""

ONE_WAY = 0.9
"""Part of its whole way by which such a state has gone on in the end, and in either half."""


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


def why_inadmissible(family: "Family", orbit: "Orbit", lap: "Lap") -> str:
    """The first reason, in words."""
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
    """Whether nothing moves along the orbit."""
    if not orbit.eventless:
        return False
    total = float(orbit.durations.sum())
    path = family.at([orbit], np.linspace(0, total, 33)[np.newaxis, :-1])[0][0]
    return bool(np.ptp(path, axis=0).max() <= AT_REST * max(1.0, np.abs(path).max()))


def drift(family: "Family", state: np.ndarray, mode: str) -> list[tuple[str, float]]:
    """States that only grow, or only fall, from a state on, and by how much in a period (or a unit of time)."""
    system = family.plain.with_initial(**dict(zip(family.plain.state_names, state.tolist(), strict=True)), mode=mode)
    run = Run(system, family.period or 1.0, family.numerics)
    points = [state]
    for _ in range(WATCHED):
        if run.advance(1)[0] != Outcome.OK:
            return []
        points.append(run.x.copy())
    steps = np.diff(points, axis=0)
    way = np.abs(steps).sum(axis=0)
    net = steps.sum(axis=0)
    halves = steps.reshape(2, -1, len(state)).sum(axis=1)
    growing = (np.abs(net) > ONE_WAY * way) & (np.abs(halves) > (1 - ONE_WAY) * 4 * way).all(axis=0) & (way > 1e-6)
    return [(name, float(net[i]) / WATCHED) for i, name in enumerate(system.state_names) if growing[i]]


def open_words(family: "Family", growing: list[tuple[str, float]]) -> str:
    """What keeps a motion from closing, in words."""
    each = "a period" if family.forced else "a unit of time"
    told = ", ".join(f"{name} by {amount:.3g}" for name, amount in growing)
    return (
        f"it cannot close: {told} {each} on the average, and never back; leave such a state out and carry it as a "
        "quadrature, or write a phase as a function of time"
    )


def why_not(code: int, residuals: np.ndarray) -> str:
    """Why Newton's method failed, in words."""
    if code in (branch.SLOW, branch.SINGULAR):
        why = "found the equations singular" if code == branch.SINGULAR else "did not converge"
        return f"Newton's method {why}; its residuals go from {residuals[0]:.1e} to {residuals.min():.1e}"
    return f"on the way to the orbit the run ended: {Outcome(code).advice}"

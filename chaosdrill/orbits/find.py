"""One orbit: from a guess of it to what is known of it, or to why there is none."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import branch
from chaosdrill.engine import lap as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.describe import describe, no_orbit
from chaosdrill.orbits.family import Family, Lap
from chaosdrill.orbits.multipliers import based
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.reading import guess_of_autonomous, guess_of_forced, settled
from chaosdrill.orbits.results import FoundOrbit

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

READINGS = 6
"""Times that the events of a guess are read anew, at most."""

AT_REST = 1e-9
"""Part of its size by which a state moves at least along an orbit that is none of a point at rest."""

SAME = 1e-7
"""Difference relative to the size of the states below which two points of an orbit are one."""


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


def find_orbit(system: "HybridSystem", period: int, start: str, transient: float, numerics: Numerics) -> FoundOrbit:
    """One orbit with all that is known of it, or why there is none.

    Parameters
    ----------
    system : HybridSystem
    period : int
        In forcing periods; 1 for systems without a period.
    start : {"attractor", "guess"}
        Where Newton's method starts: at the system's initial state, or where a run has come to from there.
    transient : float
        Forcing periods of that run, or its time.
    numerics : Numerics
    """
    try:
        family, orbit, lap, residuals, message = starting_orbit(
            system, (), period, start, int(np.ceil(transient)), numerics
        )
    except NoOrbitError as failure:
        return no_orbit(system, failure.outcome, failure.message, period, failure.residuals)
    return describe(family, orbit, lap, residuals, message)


def starting_orbit(
    system: "HybridSystem", free: tuple[str, ...], period: int, start: str, transient: int, numerics: Numerics
) -> tuple[Family, Orbit, Lap, np.ndarray, str]:
    """The orbit near the system's initial state, or near where that leads.

    Returns
    -------
    family, orbit, lap, residuals : Family, Orbit, Lap, ndarray
        The orbit with what one lap and Newton's method showed.
    message : str
        What there is to say of it.

    Raises
    ------
    NoOrbitError
    """
    family = Family(system, free, numerics)
    outcome, state, mode = settled(family, transient if start == "attractor" else 0)
    if outcome != Outcome.OK:
        raise NoOrbitError(outcome, f"the run that leads to the orbit ended: {outcome.advice}")
    orbit, lap, residuals = orbit_from_state(family, state, mode, period)
    least, message = least_period(family, orbit)
    if least is not orbit:
        _, least, lap, residuals = family.solve(least)
    return family, least, lap, residuals, message


def orbit_from_state(family: Family, state: np.ndarray, mode: str, period: int) -> tuple[Orbit, Lap, np.ndarray]:
    """The orbit near a state at phase 0, its arcs told from where least freedom is left.

    Raises
    ------
    NoOrbitError
    """
    values = np.array([family.plain.parameters[name] for name in family.free])
    failure = NoOrbitError(Outcome.NO_ORBIT, "")
    seen: list[Orbit] = []
    for _ in range(READINGS):
        if family.forced:
            outcome, guess = guess_of_forced(family, state, mode, period, values)
        else:
            outcome, guess = guess_of_autonomous(family, state, mode, LONGEST_RETURN, values)
        if outcome != Outcome.OK:
            raise NoOrbitError(outcome, f"the run from the start ended: {outcome.advice}")
        if guess is None:
            raise NoOrbitError(
                Outcome.EQUILIBRIUM,
                f"from the start the state does not move away and come back within {LONGEST_RETURN:g}",
            )
        if any(guess.same_events(old) for old in seen):
            raise failure
        seen.append(guess)
        code, orbit, lap, residuals = family.solve(based(family, guess))
        if code != branch.CONVERGED:
            raise NoOrbitError(Outcome.NO_ORBIT, _why_not(code, residuals), residuals)
        if at_rest(family, orbit):
            raise NoOrbitError(Outcome.EQUILIBRIUM, "what is found is a point at rest, not an orbit", residuals)
        if admissible(orbit, lap):
            return orbit, lap, residuals
        failure = NoOrbitError(Outcome.INADMISSIBLE, why_inadmissible(family, orbit, lap), residuals)
        states, modes = family.strobes([orbit])
        state, mode = states[0, 0], family.plain.mode_names[modes[0, 0]]
    raise failure


LONGEST_RETURN = 200.0
"""Time within which a system without a period is to return."""


def admissible(orbit: Orbit, lap: Lap) -> bool:
    """Whether the system follows the orbit as it is written down: its guards, their order, their outcomes."""
    events = orbit.arcs[:, at.ARC_END] >= 0
    return bool(
        (lap.crossed < 0).all()
        and (lap.came == orbit.arcs[:, at.ARC_OUTCOME]).all()
        and (orbit.durations > 0).all()
        and (lap.speeds[events] > 0).all()
    )


def why_inadmissible(family: Family, orbit: Orbit, lap: Lap) -> str:
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


def at_rest(family: Family, orbit: Orbit) -> bool:
    """Whether nothing moves along the orbit."""
    if not orbit.eventless:
        return False
    total = float(orbit.durations.sum())
    path = family.at([orbit], np.linspace(0, total, 33)[np.newaxis, :-1])[0][0]
    return bool(np.ptp(path, axis=0).max() <= AT_REST * max(1.0, np.abs(path).max()))


def least_period(family: Family, orbit: Orbit) -> tuple[Orbit, str]:
    """The same orbit gone through once, and a remark if it was asked for with a multiple of its period."""
    count, periods = len(orbit), orbit.periods
    size = np.maximum(np.abs(orbit.starts).max(axis=0), 1e-6)
    parts = periods if family.forced else count
    for times in range(parts, 1, -1):
        if count % times or (family.forced and periods % times):
            continue
        step = count // times
        turned = np.abs(np.roll(orbit.starts, step, axis=0) - orbit.starts) / size
        if np.array_equal(np.roll(orbit.arcs, step, axis=0), orbit.arcs) and turned.max() < SAME:
            least = replace(
                orbit,
                arcs=orbit.arcs[:step],
                periods=periods // times if family.forced else periods,
                starts=orbit.starts[:step],
                durations=orbit.durations[:step],
            )
            return least, f"its period is {least.periods}, not {periods}" if family.forced else ""
    return orbit, ""


def _why_not(code: int, residuals: np.ndarray) -> str:
    if code in (branch.SLOW, branch.SINGULAR):
        why = "found the equations singular" if code == branch.SINGULAR else "did not converge"
        return f"Newton's method {why}; its residuals go from {residuals[0]:.1e} to {residuals.min():.1e}"
    return f"on the way to the orbit the run ended: {Outcome(code).advice}"

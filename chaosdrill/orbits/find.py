"""One orbit: from a guess of it to what is known of it, or to why there is none."""

from dataclasses import replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import branch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.describe import describe, no_orbit
from chaosdrill.orbits.failures import (
    NoOrbitError,
    admissible,
    at_rest,
    inadmissible_words,
    understood,
    why_not,
)
from chaosdrill.orbits.family import Family, Lap
from chaosdrill.orbits.multipliers import based
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.place import Place, reached
from chaosdrill.orbits.reading import Reading, own_path, reading_from, returns, settled
from chaosdrill.orbits.results import FoundOrbit

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

READINGS = 6
"""Times that the events of a guess are read anew, at most."""

REACHES = (0.5, 0.1)
"""Longest corrections by one lap with which Newton's method is tried, one after the other."""

CONVERGING = 1e-2
"""Residual below which Newton's method is given more time."""

SAME = 1e-7
"""Difference relative to the size of the states below which two points of an orbit are one."""

MOST_TURNS = 64
"""Times that an orbit of a smooth flow may have been gone through, at most."""


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
        family, orbit, lap, residuals, message = starting_orbit(system, (), period, start, transient, numerics)
    except NoOrbitError as failure:
        return no_orbit(system, failure.outcome, failure.message, period, failure.residuals)
    return describe(family, orbit, lap, residuals, message)


def starting_orbit(
    system: "HybridSystem", free: tuple[str, ...], period: int, start: str, transient: float, numerics: Numerics
) -> tuple[Family, Orbit, Lap, np.ndarray, str]:
    """The orbit near the system's initial state, or near where that leads.

    On an attractor Newton's method starts where the motion comes back most nearly after the period, and there from
    several such places. An orbit of a shorter period is given only if none of the period asked for was found.

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
    outcome, run = settled(family, transient if start == "attractor" else 0)
    if outcome != Outcome.OK:
        raise NoOrbitError(outcome, f"the run that leads to the orbit ended: {outcome.advice}")
    place = reached(run, family.numerics) if start == "attractor" else Place(family.plain)
    readings = returns(family, run, period) if start == "attractor" else [reading_from(family, place, period)]
    failure, shorter = None, None
    for reading, reach in product(readings, REACHES):
        try:
            orbit, lap, residuals = orbit_read(family, reading, period, reach)
        except NoOrbitError as error:
            failure = failure or error
            continue
        least, message = least_period(family, orbit)
        if least is not orbit:
            _, least, lap, residuals = family.solve(least)
        if least.periods == period:
            return family, least, lap, residuals, message
        shorter = shorter or (family, least, lap, residuals, message)
    if shorter is not None:
        return shorter
    assert failure is not None
    raise understood(family, place, failure)


def orbit_read(
    family: Family, reading: Reading, period: int, reach: float = REACHES[0]
) -> tuple[Orbit, Lap, np.ndarray]:
    """The orbit near a path that is read, its arcs told from where least freedom is left.

    Where the system does not follow what Newton's method makes of it, its own path from there is read.

    Raises
    ------
    NoOrbitError
    """
    failure = NoOrbitError(Outcome.NO_ORBIT, "")
    seen: list[Orbit] = []
    for _ in range(READINGS):
        outcome, guess = reading()
        if outcome != Outcome.OK:
            raise NoOrbitError(outcome, f"the run from the start ended: {outcome.advice}")
        if guess is None:
            words = "does not come back soon"
            if family.forced:
                words = f"after {period} periods is in another mode than at its beginning"
            raise NoOrbitError(Outcome.NO_ORBIT, f"the motion from the start {words}")
        if any(guess.same_events(old) for old in seen):
            raise failure
        seen.append(guess)
        orbit, lap, residuals = solved(family, guess, reach)
        if admissible(orbit, lap):
            return orbit, lap, residuals
        failure = NoOrbitError(
            Outcome.INADMISSIBLE, f"the equations close, but {inadmissible_words(family, orbit, lap)}", residuals
        )
        reading = partial(own_path, family, orbit)
    raise failure


def solved(family: Family, guess: Orbit, reach: float = REACHES[0]) -> tuple[Orbit, Lap, np.ndarray]:
    """What Newton's method makes of a guess; the system need not follow it.

    Raises
    ------
    NoOrbitError
    """
    code, orbit, lap, residuals = family.solve(based(family, guess), reach=reach)
    if code == branch.SLOW and residuals[-1] <= CONVERGING:
        code, orbit, lap, more = family.solve(orbit, reach=reach)
        residuals = np.concatenate([residuals, more[1:]])
    if code != branch.CONVERGED:
        raise NoOrbitError(Outcome.NO_ORBIT, why_not(code, residuals), residuals)
    if at_rest(family, orbit):
        raise NoOrbitError(Outcome.EQUILIBRIUM, "what is found is a point at rest, not an orbit", residuals)
    return orbit, lap, residuals


def least_period(family: Family, orbit: Orbit) -> tuple[Orbit, str]:
    """The same orbit gone through once, and a remark if it was asked for with a multiple of its period."""
    count, periods = len(orbit), orbit.periods
    if not family.forced and orbit.eventless:
        return _one_turn(family, orbit), ""
    parts = periods if family.forced else count
    for times in range(parts, 1, -1):
        if count % times or (family.forced and periods % times):
            continue
        step = count // times
        if orbit.comes_again(step, SAME):
            least = replace(
                orbit,
                arcs=orbit.arcs[:step],
                periods=periods // times if family.forced else periods,
                starts=orbit.starts[:step],
                durations=orbit.durations[:step],
            )
            return least, f"its period is {least.periods}, not {periods}" if family.forced else ""
    return orbit, ""


def _one_turn(family: Family, orbit: Orbit) -> Orbit:
    """An orbit that is one arc of a smooth flow, gone through once."""
    d = family.states
    turns = np.arange(MOST_TURNS, 1, -1)
    ends = float(orbit.durations[0]) / turns
    states = family.at([orbit], ends[np.newaxis])[0][0]
    size = np.maximum(np.abs(orbit.starts[0, :d]), 1e-6)
    back = np.flatnonzero((np.abs(states - orbit.starts[0, :d]) / size).max(axis=1) < SAME)
    return replace(orbit, durations=ends[back[:1]]) if len(back) else orbit

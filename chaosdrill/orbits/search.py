"""All orbits up to a period, stable or not."""

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.describe import describe
from chaosdrill.orbits.failures import NoOrbitError, admissible
from chaosdrill.orbits.family import Family
from chaosdrill.orbits.find import least_period
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.recurrences import Recurrences, Return
from chaosdrill.orbits.results import FoundOrbit

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

PATIENCE = 300
"""Attempts in a row that find nothing new, after which a period is left."""

BEYOND = 1.0
"""As many attempts in a row as this times those that led to the last new orbit, if they are more."""

EQUAL = 1e-6
"""Difference relative to the extent of the motion below which two orbits are one."""

SAMPLES = 4096
"""Samples along an orbit without events on which the start of another one is looked for."""

CLOSER = 4
"""Times that the nearest place of a path is looked for in a shorter part of it."""

ACROSS = 1e-4
"""Distance from the path, relative to the extent of the motion, within which it passes a point."""

TAKEN = 0.3
"""Part of the distance of a return within which a known orbit lies that probably is the one it leads to."""


def search(
    system: "HybridSystem",
    max_period: int,
    starts: np.ndarray,
    modes: np.ndarray,
    numerics: Numerics,
    progress: Callable[[int, int, dict[str, int] | None], None] | None = None,
) -> list[FoundOrbit]:
    """All orbits up to a period that are found where motions nearly come back.

    Motions are recorded from the given states (by default the system's own) and from random ones in a box around them;
    Newton's method starts from their returns, the nearest first, until many in a row lead to nothing new (Auerbach et
    al. 1987, doi:10.1103/PhysRevLett.58.2387). Nothing proves that no orbit is missed.

    Parameters
    ----------
    system : HybridSystem
    max_period : int
        Longest period in forcing periods. Without forcing: how often the most frequent event of an orbit may happen in
        one round; without events too, how many maxima it may have of the state whose maxima come most regularly.
    starts, modes : ndarray, shapes (S, d) and (S,)
        States at phase 0, and their modes.
    numerics : Numerics
    progress : callable, optional
        Called with the periods done, their number, and the orbits so far.

    Returns
    -------
    list of FoundOrbit
        By period (without forcing by duration), the more stable ones first.
    """
    family = Family(system, (), numerics)
    if not len(starts):
        starts = np.array([[system.initial[x] for x in system.state_names]])
        modes = np.array([system.mode_names.index(system.initial["mode"])])
    recurrences = Recurrences(family, max_period, starts, modes)
    known = Known(family, recurrences.extent)
    for period in range(1, max_period + 1):
        _all_of(period, recurrences, known)
        if progress:
            progress(period, max_period, {Outcome.PERIODIC.meaning: len(known.found)})
    return sorted(known.found, key=lambda o: (o.period if family.forced else o.duration, abs(o.multipliers[0])))


def _all_of(period: int, recurrences: Recurrences, known: "Known") -> None:
    """Try the returns after a period, those that probably lead to a known orbit last."""
    put_off: list[tuple[float, Return]] = []

    def fresh() -> Iterator[Return]:
        for candidate in recurrences.nearest(period):
            apart = known.distance(candidate.place) / max(candidate.away, 1e-300)
            if apart > TAKEN:
                yield candidate
            else:
                put_off.append((apart, candidate))

    _try(fresh(), known)
    _try((candidate for _, candidate in sorted(put_off, key=lambda pair: -pair[0])), known)


def _try(candidates: Iterable[Return], known: "Known") -> None:
    """Look for the orbits near returns until many in a row lead to nothing new."""
    last = 0
    for attempt, candidate in enumerate(candidates, 1):
        if known.add(candidate):
            last = attempt
        if attempt - last > max(PATIENCE, BEYOND * last):
            return


class Known:
    """Orbits found so far, each told once.

    Parameters
    ----------
    family : Family
    extent : ndarray, shape (d,)
        Extent of the motion in every state.
    """

    def __init__(self, family: Family, extent: np.ndarray) -> None:
        self.family, self.extent = family, extent
        self.found: list[FoundOrbit] = []
        self._orbits: list[Orbit] = []
        self._refused: list[Orbit] = []
        self._points = np.zeros((0, len(extent)))
        self._paths: dict[int, np.ndarray] = {}

    def distance(self, place: np.ndarray) -> float:
        """Distance of the nearest point of a known orbit, relative to the extent."""
        return float((np.abs(self._points - place) / self.extent).max(axis=1).min(initial=np.inf))

    def add(self, candidate: Return) -> bool:
        """Look for the orbit near a return; whether it is a new one."""
        try:
            orbit, lap, residuals = candidate.attempt()
        except NoOrbitError:
            return False
        if not admissible(orbit, lap):
            return False
        least, _ = least_period(self.family, orbit)
        if any(self._same(least, old) for old in (*self._orbits, *self._refused)):
            return False
        if least is not orbit:
            code, least, lap, residuals = self.family.solve(least)
            if code:
                return False
        found = describe(self.family, least, lap, residuals)
        if found.outcome != Outcome.PERIODIC:
            self._refused.append(least)
            return False
        self._orbits.append(least)
        self.found.append(found)
        self._points = np.vstack([self._points, found.states if self.family.forced else least.starts])
        return True

    def _same(self, a: Orbit, b: Orbit) -> bool:
        """Whether two orbits are the same closed path: both take the same time, and one passes the other's start."""
        if len(a) != len(b) or a.periods != b.periods:
            return False
        if abs(a.durations.sum() - b.durations.sum()) > EQUAL * a.durations.sum():
            return False
        if a.eventless:
            return self._on_path(a, b)
        away = (np.abs(b.starts - a.starts[0]) / self.extent).max(axis=1)
        period = self.family.period
        if period:
            late = (b.phase + np.cumsum(b.durations) - b.durations - a.phase) / period
            away = np.maximum(away, np.abs(late - np.round(late)))
        return bool(((away <= EQUAL) & (b.arcs == a.arcs[0]).all(axis=1)).any())

    def _on_path(self, a: Orbit, b: Orbit) -> bool:
        """Whether an orbit without events passes the start of another one, as near as it is sampled."""
        start = a.starts[0] / self.extent
        if self.family.forced:
            strobes = self.family.strobes([b])[0][0] / self.extent
            return bool(np.abs(strobes - start).max(axis=1).min() <= EQUAL)
        if id(b) not in self._paths:
            instants = np.linspace(0, float(b.durations.sum()), SAMPLES, endpoint=False)
            self._paths[id(b)] = self.family.at([b], instants[np.newaxis])[0][0] / self.extent
        total = float(b.durations.sum())
        away = np.linalg.norm(self._paths[id(b)] - start, axis=1)
        time, width = int(away.argmin()) * total / SAMPLES, total / SAMPLES
        for _ in range(CLOSER):
            # the path may turn sharply between two samples
            instants = np.sort(np.linspace(time - width, time + width, 65) % total)
            near = self.family.at([b], instants[np.newaxis])[0][0] / self.extent
            away = np.linalg.norm(near - start, axis=1)
            time, width = float(instants[away.argmin()]), width / 32
        return bool(away.min() <= ACROSS)

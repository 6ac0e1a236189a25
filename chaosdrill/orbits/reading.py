"""Guesses of orbits, read off runs of the ordinary engine."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import lap as at
from chaosdrill.engine import layout
from chaosdrill.engine.run import Run
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.pace import unit_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.family import Family

MOST_EVENTS = 4096
"""Events of one orbit; more are chatter that is not completed."""


def settled(family: "Family", transient: float) -> tuple[Outcome, np.ndarray, str]:
    """State and mode at phase 0 to which the system's initial state leads, and how that went.

    The transient is in forcing periods, or a time where there are none.
    """
    parts = int(np.ceil(transient)) if family.forced else PARTS
    run = Run(family.plain, family.period or max(transient, 1e-300) / PARTS, family.numerics)
    outcome = run.advance(parts)[0] if transient else Outcome.OK
    return outcome, run.x.copy(), run.mode


def guess_of_forced(
    family: "Family", state: np.ndarray, mode: str, periods: int, values: np.ndarray, phase: float = 0.0
) -> tuple[Outcome, Orbit | None]:
    """The path from a state over so many forcing periods, as a guess of an orbit.

    Parameters
    ----------
    family : Family
    state : ndarray, shape (d,)
    mode : str
    periods : int
    values : ndarray, shape (q,)
        Free parameters.
    phase : float
        Time in the period at which the state is.

    Returns
    -------
    outcome : Outcome
        ``Outcome.OK``, or what ended the run before.
    orbit : Orbit or None
    """
    system = with_values(family, values).with_initial(
        **dict(zip(family.plain.state_names, state.tolist(), strict=True)), mode=mode
    )
    period = system.forcing_period()
    assert period is not None
    run = Run(system, period, family.numerics)
    run.carried_f[layout.TIME] = phase
    outcome, events = _events(run, periods + (phase > 0))
    if outcome != Outcome.OK:
        return outcome, None
    times = events[:, layout.EVENT_STROBES] * period + events[:, layout.EVENT_TIME]
    inside = times < phase + periods * period
    events, times = events[inside], times[inside]
    if not len(events):
        if phase > 0:
            rest = np.array([period - phase])
            arc = np.array([[family.system.mode_names.index(mode), at.SHARE, -1]], dtype=np.int64)
            ahead = Orbit(arc, 1, np.concatenate([state, values])[np.newaxis], phase, rest)
            state = family.at([ahead], rest[np.newaxis])[0][0, 0]
        return outcome, eventless(family, state, mode, periods, values, period)
    durations = np.diff(times, prepend=times[-1] - periods * period)
    orbit = orbit_of_events(family, events, durations, periods, values, float(times[-1] % period))
    return outcome, orbit if _connected(family, orbit) else None


def returns(family: "Family", state: np.ndarray, mode: str, periods: int) -> list[tuple[np.ndarray, str]]:
    """States on the motion from a state on that come back most nearly after so many periods, with their modes.

    Of systems without a period: states at some distance along it.
    """
    system = family.plain.with_initial(**dict(zip(family.plain.state_names, state.tolist(), strict=True)), mode=mode)
    run = Run(system, unit_of(family, system), family.numerics)
    states, modes, _ = strobed(run, (RECORD if family.forced else PLACES) + periods)
    names = [system.mode_names[m] for m in modes]
    if not family.forced or len(states) <= periods:
        return list(zip(states, names, strict=True))[:PLACES]
    spread = np.maximum(np.ptp(states, axis=0), 1e-9 * np.maximum(np.abs(states).max(axis=0), 1.0))
    last = len(states) - periods

    def away(steps: int) -> np.ndarray:
        return np.asarray((np.abs(states[steps : steps + last] - states[:last]) / spread).max(axis=1))

    whole, parts = away(periods), [q for q in range(1, periods) if periods % q == 0]
    # what is back sooner leads to an orbit of a shorter period
    sooner = np.min([away(q) for q in parts], axis=0) < SOONER * whole if parts else np.zeros(last, dtype=bool)
    return [(states[j], names[j]) for j in np.lexsort((whole, sooner))[:PLACES]]


def strobed(run: Run, length: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States and modes at the strobes of a run, its start first, and which events led to each from the one before.

    Returns
    -------
    states : ndarray, shape (m, d)
        Fewer than ``length`` + 1 if the run ended before.
    modes : ndarray of int, shape (m,)
    sequences : ndarray of int, shape (m,)
        A number that stands for a sequence of events; 0 for the first state.
    """
    d = len(run.x)
    samples = np.zeros((length + 3, d + len(run.system.quadratures) + 1))
    buffer = np.zeros((MOST_EVENTS, layout.EVENT_COLUMNS + 2 * d))
    start, mode = run.x.copy(), run.system.mode_names.index(run.mode)
    taken, rows, target, full = 0, [], length, True
    while full:
        _, full = run.advance(target, samples[taken:], buffer)
        target = 0
        new, events = run.filled()
        taken += new
        rows.append(buffer[:events, : layout.EVENT_COLUMNS].copy())
    table = np.concatenate(rows)
    changing = np.array([not t.marks_only() for t in run.system.transitions], dtype=bool)
    kinds = table[:, layout.EVENT_KIND].astype(np.int64)
    kept = changing[kinds] if len(kinds) else kinds == 0
    periods = table[kept, layout.EVENT_STROBES].astype(np.int64)
    ends = np.searchsorted(periods, np.arange(taken + 1))
    sequences = [hash(tuple(kinds[kept][a:b].tolist())) for a, b in pairwise(ends)]
    return (
        np.vstack([start, samples[:taken, :d]]),
        np.concatenate([[mode], samples[:taken, -1]]).astype(np.int64),
        np.array([0, *sequences], dtype=np.int64),
    )


def guess_of_return(family: "Family", state: np.ndarray, mode: str, values: np.ndarray) -> tuple[Outcome, Orbit | None]:
    """The path from a state until it is back, as a guess of an orbit of a system without a period."""
    system = with_values(family, values).with_initial(
        **dict(zip(family.plain.state_names, state.tolist(), strict=True)), mode=mode
    )
    unit, outcome, guess = unit_of(family, system), Outcome.OK, None
    units = SHORTEST_RETURN
    while guess is None and outcome == Outcome.OK and units <= LONGEST_RETURN:
        outcome, guess = guess_of_autonomous(family, state, mode, units * unit, values)
        units *= 8
    return outcome, guess


def guess_of_autonomous(
    family: "Family", state: np.ndarray, mode: str, duration: float, values: np.ndarray
) -> tuple[Outcome, Orbit | None]:
    """The path from a state until it is back as nearly as it comes within a duration, as a guess of an orbit."""
    system = with_values(family, values).with_initial(
        **dict(zip(family.plain.state_names, state.tolist(), strict=True)), mode=mode
    )
    unit = unit_of(family, system)
    run = Run(system, unit, family.numerics, samples=SAMPLES)
    whole = int(np.ceil(duration / unit))
    samples = np.zeros(((whole + 2) * SAMPLES, len(state) + len(system.quadratures) + 1))
    outcome, events = _events(run, whole, samples)
    if outcome != Outcome.OK:
        return outcome, None
    d = len(state)
    if len(events):
        last = _shortest_return(events[:, layout.EVENT_COLUMNS + d :], events[:, layout.EVENT_KIND])
        if last is None:
            return outcome, None
        times = events[:, layout.EVENT_STROBES] * unit + events[:, layout.EVENT_TIME]
        durations = np.diff(times)[:last]
        orbit = orbit_of_events(family, events[1 : last + 1], durations, 1, values, 0.0)
        return outcome, orbit if _connected(family, orbit) else None
    path = np.vstack([state, samples[: run.filled()[0], :d]])
    away = np.abs(path - state).max(axis=1)
    size = np.abs(path - path.mean(axis=0)).max()
    if size <= 1e-9 * max(1.0, np.abs(path).max()):
        return outcome, None
    left = np.flatnonzero(away > 0.2 * size)
    if not len(left):
        return outcome, None
    back = left[0] + _first_dip(away[left[0] :])
    arcs = np.array([[family.system.mode_names.index(mode), at.PLANE, -1]], dtype=np.int64)
    starts = np.concatenate([state, values])[np.newaxis]
    return outcome, Orbit(arcs, 1, starts, 0.0, np.array([back * unit / SAMPLES]))


RECORD = 256
"""Periods over which the nearest returns are looked for."""

SOONER = 3.0
"""Times the distance after a period within which a state is back after a part of it that counts."""

PLACES = 8
"""Places from which an orbit near an attractor is looked for."""

SHORTEST_RETURN, LONGEST_RETURN = 32, 2048
"""Units of the motion's pace within which a system without a period is to return: the first tried, and the last."""

PARTS = 64
"""Parts of a transient given as a time."""

SAMPLES = 64
"""Samples a unit, where a path without events is searched for its return."""

NEAR = 0.05
"""Part of the spread of the states within which a state counts as back."""


def _first_dip(away: np.ndarray) -> int:
    """Index of the first local minimum that is not much larger than the smallest value."""
    inner = np.flatnonzero((away[1:-1] <= away[:-2]) & (away[1:-1] <= away[2:])) + 1
    if not len(inner):
        return int(away.argmin())
    good = inner[away[inner] <= max(2 * away[inner].min(), NEAR * away.max())]
    return int(good[0])


def _shortest_return(states: np.ndarray, kinds: np.ndarray) -> int | None:
    """Number of events after which the first one comes again, as nearly as it does; None if its kind never does."""
    same = np.flatnonzero(kinds[1:] == kinds[0]) + 1
    if not len(same):
        return None
    spread = np.maximum(np.ptp(states, axis=0), 1e-12)
    away = (np.abs(states[same] - states[0]) / spread).max(axis=1)
    good = same[away <= max(2 * away.min(), NEAR)]
    return int(good[0])


def _events(run: Run, periods: int, samples: np.ndarray | None = None) -> tuple[Outcome, np.ndarray]:
    """Events that change something, over so many periods."""
    d = len(run.x)
    buffer = np.zeros((MOST_EVENTS, layout.EVENT_COLUMNS + 2 * d))
    outcome, full = run.advance(periods, samples, buffer)
    if full:
        return Outcome.EVENT_LIMIT, buffer[:0]
    rows = buffer[: run.filled()[1]]
    changing = np.array([not t.marks_only() for t in run.system.transitions], dtype=bool)
    return outcome, rows[changing[rows[:, layout.EVENT_KIND].astype(int)]] if len(rows) else rows


def orbit_of_events(
    family: "Family", events: np.ndarray, durations: np.ndarray, periods: int, values: np.ndarray, phase: float
) -> Orbit:
    d = family.states
    guards = family.system.kernels.events
    arcs = np.zeros((len(events), 3), dtype=np.int64)
    for arc, row in zip(arcs, events, strict=True):
        mode, kind = int(row[layout.EVENT_MODE]), int(row[layout.EVENT_KIND])
        arc[:] = mode, next(j for j, e in enumerate(guards[mode]) if kind in e.outcomes), kind
    after = np.roll(events[:, layout.EVENT_COLUMNS + d : layout.EVENT_COLUMNS + 2 * d], 1, axis=0)
    starts = np.column_stack([after, np.tile(values, (len(events), 1))])
    return Orbit(arcs, periods, starts, phase, durations)


def _connected(family: "Family", orbit: Orbit) -> bool:
    """Whether every event leads into the mode of the next arc; the last one may not, on a path that is no cycle."""
    targets = [family.plain.transitions[k].target for k in orbit.arcs[:, at.ARC_OUTCOME]]
    modes = [family.system.mode_names[m] for m in np.roll(orbit.arcs[:, at.ARC_MODE], -1)]
    return targets == modes


def eventless(family: "Family", state: np.ndarray, mode: str, periods: int, values: np.ndarray, period: float) -> Orbit:
    arcs = np.tile([family.system.mode_names.index(mode), at.SHARE, -1], (periods, 1)).astype(np.int64)
    whole = np.full(periods, period)
    one = Orbit(arcs[:1], 1, np.concatenate([state, values])[np.newaxis], 0.0, whole[:1])
    long = Orbit(one.arcs, 1, one.starts, 0.0, np.array([periods * period]))
    path = family.at([long], np.arange(periods)[np.newaxis] * period)[0][0]
    return Orbit(arcs, periods, np.column_stack([path, np.tile(values, (periods, 1))]), 0.0, whole)


def with_values(family: "Family", values: np.ndarray) -> "HybridSystem":
    """The plain system at values of the free parameters."""
    return family.plain.with_parameters(**dict(zip(family.free, values.tolist(), strict=True)))

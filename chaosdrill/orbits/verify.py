"""An orbit followed by the ordinary engine: whether it returns, and by the events that it is said to have."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.orbits.place import run_from, standpoint

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit

ROUND_OFF = 1e-15
"""What a step adds to the difference after a lap, beside the tolerance."""

SLACK = 1e3
"""Steps, and how unevenly they count, in the difference after a lap that round-off and the tolerance explain."""

MOST_NAMED = 12
"""Events that are all named where a run meets others; of longer orbits the first that differs."""

CLOSED = 1e-3
"""Largest difference after a lap of an orbit that counts as closed, whatever explains it."""

FAST = 1e4
"""Growth of small deviations over a lap above which it is verified in parts."""

MOST_PARTS = 256
"""Parts of a lap, at most."""


@dataclass(frozen=True)
class Lapped:
    """What runs of the engine around an orbit showed.

    Attributes
    ----------
    outcome : Outcome
        ``Outcome.OK``, or what ended the run.
    residual, recurrence : float
        Largest difference after one period and after two, relative to max(1, |x|).
    growth : float
        Largest factor by which a small deviation grows over a period.
    differs : str
        How the events differ from those of the orbit, in words; empty if they do not.
    """

    outcome: Outcome
    residual: float
    recurrence: float
    growth: float
    differs: str

    def explained(self, tolerance: float, laps: int = 1) -> float:
        """Difference after so many laps that round-off and the tolerance explain."""
        return min(SLACK * (ROUND_OFF + tolerance) * max(1.0, self.growth) ** laps, CLOSED)


def verify(family: "Family", orbit: "Orbit") -> Lapped:
    """Go around an orbit twice with the ordinary engine, which searches for events and knows nothing of arcs.

    Where small deviations grow too much over a period for that to say anything, the state is put back onto the orbit
    after parts of it, and the differences are those of the parts.
    """
    lapped = _lapped(family, orbit, 1)
    parts = 2
    while lapped.outcome == Outcome.OK and lapped.growth > FAST and parts <= MOST_PARTS:
        lapped = _lapped(family, orbit, parts)
        parts *= 2
    return lapped


def _lapped(family: "Family", orbit: "Orbit", parts: int) -> Lapped:
    """What two laps in so many parts each show."""
    arc, time, state = standpoint(family, orbit)
    d, total = family.states, float(orbit.durations.sum())
    run = run_from(family, orbit, arc, time, state, parts, tangents=np.eye(d), orthonormalise=False)
    forcing = family.period_at(orbit)
    instants = (time + np.arange(1, parts + 1) / parts * total) % total
    order = np.argsort(instants)
    ends = np.zeros((parts, d))
    ends[order] = family.at([orbit], instants[np.newaxis, order])[0][0]
    ends[-1] = state
    size = np.maximum(1.0, np.abs(ends).max(axis=1))
    units = orbit.periods if forcing and parts == 1 else 1
    buffer = np.zeros((8 * len(orbit) + 64, layout.EVENT_COLUMNS + 2 * d))
    differences, rows = np.zeros((2, parts)), []
    growth, differs = 0.0, ""
    for lap in range(2):
        for part in range(parts):
            outcome, full = run.advance(units, events=buffer)
            if outcome != Outcome.OK:
                return Lapped(outcome, np.inf, np.inf, np.inf, f"the run ends: {outcome.advice}")
            if full:
                return Lapped(outcome, np.inf, np.inf, np.inf, "many more events than the orbit has")
            rows.append(buffer[: run.filled()[1]].copy())
            differences[lap, part] = np.abs(run.x - ends[part]).max() / size[part]
            if lap == 0:
                growth = max(growth, float(np.linalg.norm(run.vectors, 2)))
            if parts > 1:
                run.put(ends[part], np.eye(d))
                if forcing:
                    run.begin_at(origin=(orbit.phase + time + (part + 1) / parts * total) % forcing)
        if lap == 0:
            differs = _compare(family, orbit, arc, np.concatenate(rows))
    return Lapped(Outcome.OK, float(differences[0].max()), float(differences[1].max()), growth, differs)


def _compare(family: "Family", orbit: "Orbit", arc: int, rows: np.ndarray) -> str:
    """How the events of a run that began on an arc differ from those of the orbit, in words."""
    transitions = family.plain.transitions
    met = [(int(row[layout.EVENT_MODE]), int(row[layout.EVENT_KIND])) for row in rows]
    met = [(mode, kind) for mode, kind in met if not transitions[kind].marks_only()]
    turned = np.roll(orbit.arcs, -arc, axis=0)
    expected = [(int(mode), int(kind)) for mode, end, kind in turned if end >= 0]
    if met == expected:
        return ""
    names = [[transitions[kind].name for _, kind in events] for events in (met, expected)]
    if max(map(len, names)) <= MOST_NAMED:
        went, said = (" ".join(events) or "no event" for events in names)
        return f"{went} instead of {said}"
    first = next((k for k, (a, b) in enumerate(zip(met, expected, strict=False)) if a != b), min(map(len, names)))
    went, said = (events[first] if first < len(events) else "nothing" for events in names)
    return f"event {first + 1} of {len(expected)} is {went} instead of {said}"

"""From where an orbit is looked for, by the settings of an analysis."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.judgement.recurrence import CLOSE
from chaosdrill.analysis.recording import record_returns
from chaosdrill.analysis.sections import find_section
from chaosdrill.analysis.tuning import SECTIONS
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.orbits.marks import Marks


@dataclass(frozen=True)
class OrbitStart:
    """From where an orbit is looked for, as `chaosdrill.orbits.find.find_orbit` takes it."""

    system: HybridSystem
    period: int
    start: str | float
    transient: float
    marks: "Marks | None" = None  # the section whose points the period counts, if one was named
    remark: str = ""  # what the motion from there does instead, if it cannot be back after the period

    def told(self, outcome: Outcome, message: str) -> str:
        """What a search from there says, with the remark where it found no orbit."""
        return "; ".join(filter(None, [self.remark, message])) if outcome != Outcome.PERIODIC else message


def orbit_start(system: HybridSystem, given: Any, numerics: Numerics) -> OrbitStart:
    """Where the search for an orbit begins by its settings.

    Where a section is named: in the middle of the first long way between events from a point of it on, so that it is
    beside all of them, and the round has the time that the ``period`` returns from there take. On an attractor it is
    the point after the transient to which ``period`` returns come back most closely; else the first point, or, if the
    way to it is long, its middle.
    """
    # a section alone needs no orbits, nor what they import
    from chaosdrill.orbits.marks import Marks
    from chaosdrill.orbits.problem import Problem

    if given.counts(system) != "section":
        lead_in = int(given.transient) if system.forced else given.transient
        return OrbitStart(system, given.period, given.start, lead_in)
    where, period = find_section(system, given, numerics), int(given.period)
    assert where.transitions is not None
    run = Run(where.system, where.unit, numerics)
    attracted = given.start == "attractor"
    lead_in = max(int(given.transient), 1) if attracted else 0
    found = record_returns(run, where.transitions, lead_in, where.longest)
    ahead = Run(where.system, where.unit, numerics)
    ahead.continue_from(run)
    passed = found
    if found.outcome == Outcome.OK:
        count = (SECTIONS.looked_at if attracted else 1) + period
        passed = record_returns(ahead, where.transitions, count, where.longest, every=True)
        found = passed.of(where.transitions)
    states, times = found.states_after(), found.times
    if len(times) <= period:
        # the search says what the motion does instead
        return OrbitStart(system, 1, "attractor", 0)
    problem = Problem(system, (), numerics)
    problem.set_unit(where.unit)
    modes = found.modes_after(where.system)
    nearest, back = _nearest(states, modes, problem.sizes, period)
    record_returns(run, where.transitions, nearest + 1, where.longest)
    first, last_time = times[nearest], times[nearest + period]
    instants = passed.times[(passed.times >= first) & (passed.times <= last_time)]
    # a way that is wide enough: the later it is, the farther the round leads beyond the return that was seen
    ways = np.diff(instants)
    wide = (instants[1:] + instants[:-1])[ways >= ways.max() / 2] / 2 - first
    places: list[tuple[Run | None, float]] = [(run, after) for after in wide.tolist()]
    if not attracted and first >= ways.max() / 4:
        # the start itself is on a way, and deviations from an orbit grow from there on
        places.insert(0, (None, float(first) / 2))
    for origin, after in places:
        beside = Run(where.system, after, numerics)
        if origin is not None:
            beside.continue_from(origin)
        beside.advance(1)
        state = dict(zip(system.state_names, beside.x.tolist(), strict=True))
        begun = system.with_initial(**state, mode=beside.mode)
        # what has passed a guard without an event, as a foot that scuffs, is no start
        if Run(begun, where.unit, numerics).advance(1)[0] != Outcome.INVALID_START:
            break
    remark = ""
    if not back:
        more = record_returns(ahead, where.transitions, SECTIONS.looked_at, where.longest)
        remark = _in_another_mode(np.concatenate([modes, more.modes_after(where.system)]), period)
    marks = Marks(where.system.limited({}), where.transitions)
    return OrbitStart(begun, 1, float(last_time - first), 0, marks, remark)


def _nearest(states: np.ndarray, modes: np.ndarray, sizes: np.ndarray, period: int) -> tuple[int, bool]:
    """The point to which ``period`` returns come back most closely, and whether any is in its mode again by then."""
    spread = np.maximum(np.ptp(states, axis=0), CLOSE * np.maximum(np.abs(states).max(axis=0), sizes))
    last = len(states) - period

    def away(steps: int) -> np.ndarray:
        missed = (np.abs(states[steps : steps + last] - states[:last]) / spread).max(axis=1)
        return np.where(modes[steps : steps + last] == modes[:last], missed, np.inf)

    after = away(period)
    # what is back sooner leads to an orbit of a shorter period
    sooner = np.array([away(q) for q in range(1, period) if period % q == 0]).min(axis=0, initial=np.inf)
    return int(np.lexsort((after, sooner < SECTIONS.sooner * after))[0]), bool(np.isfinite(after).any())


def _in_another_mode(modes: np.ndarray, period: int) -> str:
    """What a motion does whose points of the section have these modes, and never the same one after the period."""
    words = f"after {period} point{'s' * (period > 1)} of the section it is in another mode than at its beginning"
    again = (q for q in range(period + 1, len(modes) // 2) if (modes[q:] == modes[:-q]).all())
    after = next(again, 0)
    return f"{words}, and in the same after {after}: give period={after}" if after else words

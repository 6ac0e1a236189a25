"""Sections: where points of a motion are taken, and what lengths count.

A section is the strobe of a forcing, an event by the name or kind of its transition, or a surface: a comparison, met
where it becomes true. It travels as the text ``at`` through arguments, scenes and provenance, and as one record,
`Section`, through the analyses. The state on it is the one before the event.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from chaosdrill.analysis.recording import record_returns, time_of_motion
from chaosdrill.analysis.spans import Span
from chaosdrill.analysis.tuning import SECTIONS
from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Section:
    """Where points are taken."""

    system: HybridSystem  # the system; where a surface is the section, with a transition in every mode that marks it
    transitions: frozenset[int] | None  # the events before which the points are taken; None for the strobe
    own: int  # transitions that the system has without those
    counts: str  # {"strobe", "section", "time"}: what lengths count: strobes, points of the section, or time
    unit: float
    """Forcing period; without forcing the time in which the motion from the initial state crosses its own extent."""
    longest: float  # longest time between two points

    def at_parameters(self, system: HybridSystem, given: Any, numerics: Numerics) -> "Section":
        """The same section, looked for by the same settings, of the system at other parameters."""
        unit, longest = _times(system, self.counts, given, numerics)
        return replace(self, system=self.system.with_parameters(system.parameters), unit=unit, longest=longest)

    def grazed(self, times: np.ndarray) -> bool:
        """Whether points of a surface at these times follow each other at once: where the motion only touches it.

        Round-off then makes any number of points of one, which tell no period.
        """
        marked = self.transitions is not None and min(self.transitions, default=0) >= self.own
        return marked and bool((np.diff(times) <= SECTIONS.at_once * self.unit).any())


def find_section(system: HybridSystem, given: Any, numerics: Numerics, *, timed: bool = False) -> Section:
    """The section that the settings ``at``, ``max_return``, ``periods`` and ``duration`` of an analysis name.

    The ``unit`` is 1 where nothing asks for it: no point of a section is waited for, and it is not ``timed``.
    """
    counts = given.counts(system)
    marked, chosen = system, None
    if given.at not in (None, "strobe"):
        named = frozenset(i for i, t in enumerate(system.transitions) if given.at in (t.name, t.kind))
        marked, chosen = system, named
        if not named:
            from chaosdrill.model.surface import surface

            marked, chosen = surface(system, given.at)
    return Section(marked, chosen, len(system.transitions), counts, *_times(system, counts, given, numerics, timed))


def _times(
    system: HybridSystem, counts: str, given: Any, numerics: Numerics, timed: bool = False
) -> tuple[float, float]:
    """Unit of time of a section, and the longest time between two points."""
    period = system.forcing_period()
    unit = period or (given.max_return or 0.0) / SECTIONS.longest_return or 1.0
    if (counts == "section" or timed) and not (period or given.max_return):
        unit = time_of_motion(system, numerics)
    return unit, given.max_return or SECTIONS.longest_return * unit


def measured_span(section: Section, given: Any, numerics: Numerics, units: int) -> Span:
    """Time from the start that a number of section points takes; for a forced system in whole periods.

    A record begins and ends half a return after a point, so that it holds the requested number.
    """
    assert section.transitions is not None
    run = Run(section.system, section.unit, numerics)
    before, count = int(given.transient), int(given.periods)
    found = record_returns(run, section.transitions, before + count + 1, section.longest)
    if found.outcome != Outcome.OK or section.grazed(found.times):
        outcome = int(found.outcome) or int(Outcome.NO_RETURN)
        return Span(1.0, units, 0, False, outcome, message=run.stopped(found.outcome))
    after = (found.times[1:] + found.times[:-1]) / 2
    begin = float(after[before - 1]) if before else 0.0
    length = float(after[before + count - 1]) - begin
    if not section.system.forced:
        return Span(length / units, units, begin, False, measured=True)
    return Span(section.unit, math.ceil(length / section.unit), math.ceil(begin / section.unit), True)


def settled_at(section: Section, run: Run, points: int) -> Outcome:
    """Continue over a number of section points, which are discarded."""
    assert section.transitions is not None
    found = record_returns(run, section.transitions, points, section.longest)
    run.forget()
    return found.outcome

"""Where orbits meet a section: the states before its events, or on its surface."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine import shooting as at
from chaosdrill.orbits.guess import step_of
from chaosdrill.orbits.place import Place, started
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.functions import Wanted
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem


@dataclass(frozen=True)
class Marks:
    """A section: the events before which its points are taken."""

    system: "HybridSystem"  # with transitions that mark the section, if it is a surface, behind its own
    transitions: frozenset[int]


@dataclass(frozen=True)
class Columns:
    """Results on every orbit of a branch in addition to its state and multipliers."""

    marks: Marks | None = None  # the section, as for `chaosdrill.orbits.find.find_orbit`
    wanted: "Wanted | None" = None  # functions of the orbit, and what of them makes a point special


NO_COLUMNS = Columns()


def section_of(problem: "Problem", orbit: "Orbit", marks: Marks | None) -> np.ndarray:
    """Points of an orbit on a section in the order in which they come, shape (k, d).

    Without a section: its strobes, or where it starts.
    """
    if marks is None:
        return problem.strobes([orbit])[0][0]
    transitions = marks.system.transitions
    marking = [k for k in marks.transitions if transitions[k].marks_only()]
    found: list[np.ndarray] = []
    came = int(orbit.segments[-1, at.SEGMENT_OUTCOME])
    for one, before in problem.segment_by_segment(orbit):
        if marking:
            found += _marked(problem, one, came, marks.system, marking)
        came = int(one.segments[0, at.SEGMENT_OUTCOME])
        if came in marks.transitions:
            found.append(before)
    return np.array(found).reshape(-1, problem.states)


def _marked(
    problem: "Problem", one: "Orbit", came: int, system: "HybridSystem", marking: list[int]
) -> Iterator[np.ndarray]:
    """States in which a run along a single segment, which an event began if ``came`` is not -1, is marked."""
    d = problem.states
    values = dict(zip(problem.free, one.starts[0, d:].tolist(), strict=True))
    mode = system.mode_names[one.segments[0, at.SEGMENT_MODE]]
    place = Place(started(system.with_parameters(**values), one.starts[0, :d], mode), one.phase)
    run = place.run(float(one.durations[0]), problem.numerics)
    run.fix_step(step_of(problem, None))
    if came >= 0:
        run.just_took(came)
    rows = np.zeros((TUNING.most_events, layout.EVENT_COLUMNS + 2 * d))
    outcome, full, target = Outcome.OK, True, 1
    while full and outcome == Outcome.OK:
        outcome, full = run.advance(target, events=rows)
        target = 0
        for row in rows[: run.filled()[1]]:
            if row[layout.EVENT_KIND] in marking:
                yield row[layout.EVENT_COLUMNS : layout.EVENT_COLUMNS + d].copy()

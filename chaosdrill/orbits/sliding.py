"""Sliding bifurcations: which of the four happens where an orbit of a Filippov system changes its events.

An orbit crosses or slides along a surface between two fields. Where a stay on it begins or ends at the boundary of the
part of the surface on which motions slide, the sequence of modes changes in one of four ways (Kuznetsov, Rinaldi and
Gragnani 2003, doi:10.1142/S0218127403007874; di Bernardo, Kowalczyk and Nordmark 2002,
doi:10.1016/S0167-2789(02)00547-X).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.dataset.branches import Special
from chaosdrill.engine import shooting as at
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.points import Border, Candidate
    from chaosdrill.orbits.problem import Problem

Cycle = tuple[tuple[str, float], ...]

SLIDING = (
    Special.CROSSING_SLIDING,
    Special.GRAZING_SLIDING,
    Special.ADDING_SLIDING,
    Special.SWITCHING_SLIDING,
)
LANDING = (Special.CROSSING_SLIDING, Special.SWITCHING_SLIDING)
"""Kinds at which an orbit reaches the surface at the end of the part of it that slides."""
TOUCHING = (Special.GRAZING, Special.GRAZING_SLIDING, Special.ADDING_SLIDING)
"""Kinds at which an orbit touches a guard without an event."""


def sliding_modes(system: "HybridSystem") -> set[str]:
    """The modes in which a system slides along a surface between two fields."""
    begun = {t.target for t in system.transitions if t.kind == "slide"}
    return begun & {mode for t in system.transitions if t.kind == "leave" for mode in t.source}


def sliding_between(problem: "Problem", before: "Orbit", after: "Orbit") -> Special | None:
    """The sliding bifurcation between two orbits; None if it is not exactly one of the four."""
    system = problem.plain
    slides = sliding_modes(system)
    shorter, longer = sorted((_stays(system, orbit) for orbit in (before, after)), key=len)
    if not slides or len(longer) == len(shorter):
        return None
    reached = {kind: _reached(longer, shorter, kind, slides) for kind in SLIDING}
    kind = min(reached, key=lambda one: reached[one])
    return kind if np.isfinite(reached[kind]) else None


def sliding_beyond(problem: "Problem", border: "Border") -> Special | None:
    """The sliding bifurcation at a border behind which no orbit is known, from the first orbit beyond it."""
    system, orbit, shot = problem.plain, border.bad, border.bad_shot
    slides = sliding_modes(system)
    if not slides or orbit is None or shot is None:
        return None
    brief = _brief_before_sliding(problem, orbit)
    for i, (mode, _, outcome) in enumerate(orbit.segments.tolist()):
        changed = shot.crossed[i] >= 0 or (outcome >= 0 and shot.came[i] != outcome)
        if changed and (i in brief or (i + 1) % len(orbit) in brief):
            return Special.SWITCHING_SLIDING
        first, last = TUNING.end_of_stay * orbit.durations[i], (1 - TUNING.end_of_stay) * orbit.durations[i]
        if shot.crossed[i] >= 0 and first < shot.met[i] < last:
            return Special.ADDING_SLIDING if system.mode_names[mode] in slides else Special.GRAZING_SLIDING
        if outcome >= 0 and shot.came[i] >= 0 and shot.came[i] != outcome:
            expected, came = (system.transitions[k].target in slides for k in (outcome, int(shot.came[i])))
            ends = orbit.durations[(i + 1) % len(orbit)] <= TUNING.tangential * orbit.durations.sum()
            if came and not expected:
                return Special.CROSSING_SLIDING
            if expected and not came and not ends:
                return Special.SWITCHING_SLIDING
    return None


@dataclass(frozen=True)
class Landing:
    """A motion reaches the surface where the field beyond it is tangent to it: at the end of the part that slides.

    At crossing-sliding that field turns away from the surface, and the orbit is followed that crosses. At
    switching-sliding it turns towards the surface, and the orbit is followed that slides at once. In between the
    tangency is of third order (di Bernardo et al. 2008, doi:10.1007/978-1-84628-708-4, chapter 9).
    """

    segment: int  # at whose end the surface is reached
    sliding: int  # the mode
    leave: int  # guard of that mode at which the part that slides ends
    way: int  # sign of that guard where the motion crosses
    beyond: int  # mode of the field beyond
    kind: Special
    margin = 1e-8

    def value(self, candidate: "Candidate") -> tuple[float, float]:
        """Speed at which the field beyond leaves the surface; negative where the orbit is followed."""
        speed = self.at(candidate.problem, candidate.orbit)[0]
        return (-speed if self.kind == Special.CROSSING_SLIDING else speed), candidate.tracked

    def holds(self, problem: "Problem", orbit: "Orbit") -> bool:
        """Whether the field beyond turns as it does at points of this kind."""
        return (self.at(problem, orbit)[1] > 0) == (self.kind == Special.CROSSING_SLIDING)

    def at(self, problem: "Problem", orbit: "Orbit") -> tuple[float, float]:
        """Speed at which the field beyond leaves the surface, and its rate along that field."""
        system, after = problem.system, (self.segment + 1) % len(orbit)
        kernels, n = kernels_of(system), len(system.state_names)
        constants = kernels.constants(system.parameters)
        gradient, rates = np.zeros(n + 1), np.zeros(n + len(system.quadratures))
        time = orbit.phase + float(orbit.durations[: self.segment + 1].sum())
        state = np.ascontiguousarray(orbit.starts[after])
        kernels.functions.field(self.beyond, time, constants, state, rates)
        speed = kernels.functions.guard(self.sliding, self.leave, time, constants, state, gradient)
        return self.way * float(speed), self.way * float(gradient[:n] @ rates[:n] + gradient[n])


def landings(problem: "Problem", orbit: "Orbit", kind: Special) -> list[tuple[float, Landing]]:
    """Events at which an orbit may reach the end of the part that slides, nearest first: (how near, which).

    How near is a time, as a part of the orbit's duration.
    """
    system, events = problem.plain, kernels_of(problem.system).layout.events
    names, taken = system.mode_names, "cross" if kind == Special.CROSSING_SLIDING else "slide"
    found = []
    for i, (mode, end, outcome) in enumerate(orbit.segments.tolist()):
        if end < 0 or system.transitions[outcome].kind != taken:
            continue
        outcomes = [system.transitions[k] for k in events[mode][end].outcomes]
        ways = {one.kind: names.index(one.target) for one in outcomes}
        if not {"cross", "slide"} <= set(ways):
            continue
        for j, event in enumerate(events[ways["slide"]]):
            if any(names.index(system.transitions[k].target) == ways["cross"] for k in event.outcomes):
                one = Landing(i, ways["slide"], j, event.direction, ways["cross"], kind)
                speed, rate = one.at(problem, orbit)
                near = abs(speed) / max(abs(rate) * float(orbit.durations.sum()), 1e-300)
                found.append((near, one))
    return sorted(found, key=lambda one: one[0])


def uncrossed(problem: "Problem", orbit: "Orbit") -> Iterator["Orbit"]:
    """A guess of the orbit on the other side of a crossing-sliding point: it crosses where it slid for no time."""
    if orbit.eventless:
        return
    system, events = problem.plain, kernels_of(problem.system).layout.events
    slides, short = sliding_modes(system), TUNING.tangential * float(orbit.durations.sum())
    segments, count = orbit.segments.copy(), len(orbit)
    brief = [i for i in range(count) if system.mode_names[segments[i, 0]] in slides and orbit.durations[i] <= short]
    dropped = []
    for i in brief:
        mode, end, _ = segments[i - 1].tolist()
        target = system.mode_names[segments[(i + 1) % count, at.SEGMENT_MODE]]
        crossing = [
            k
            for k in events[mode][end].outcomes
            if system.transitions[k].kind == "cross" and system.transitions[k].target == target
        ]
        if crossing:
            segments[i - 1, at.SEGMENT_OUTCOME] = crossing[0]
            dropped.append(i)
    yield from _without(orbit, segments, dropped)


def _without(orbit: "Orbit", segments: np.ndarray, dropped: list[int]) -> Iterator["Orbit"]:
    """The orbit with other segments and without some of them."""
    kept = [i for i in range(len(orbit)) if i not in dropped]
    if dropped and kept:
        first = kept[0]
        turned = replace(orbit, segments=segments).rotated(first, None)
        kept = [i - first for i in kept]
        yield replace(
            turned, segments=turned.segments[kept], starts=turned.starts[kept], durations=turned.durations[kept]
        )


def switched(problem: "Problem", orbit: "Orbit") -> Iterator["Orbit"]:
    """A guess of the orbit beyond a switching-sliding point: it crosses the surface first, and slides when it is back.

    All stays that begin at the end of the part that slides are begun so together, as those of a symmetric orbit are.
    They last for a while: a stay of no time satisfies the equations, and Newton's method goes back to it.
    """
    system = problem.plain
    slides, events = sliding_modes(system), kernels_of(problem.system).layout.events
    if not slides or orbit.eventless:
        return
    names, count, stay = system.mode_names, len(orbit), TUNING.ahead * float(orbit.durations.sum())
    rows, starts, durations = [], [], []
    for i, (mode, end, outcome) in enumerate(orbit.segments.tolist()):
        rows.append([mode, end, outcome])
        starts.append(orbit.starts[i])
        durations.append(float(orbit.durations[i]))
        if end < 0 or names[mode] in slides or system.transitions[outcome].target not in slides:
            continue
        for crossing in (k for k in events[mode][end].outcomes if system.transitions[k].kind == "cross"):
            other = names.index(system.transitions[crossing].target)
            ways = [(j, k) for j, event in enumerate(events[other]) for k in event.outcomes]
            back = [way for way in ways if system.transitions[way[1]].kind == "slide"]
            if back and _leaves(problem, orbit, (i + 1) % count, other):
                rows[-1][at.SEGMENT_OUTCOME] = crossing
                rows.append([other, *back[0]])
                starts.append(orbit.starts[(i + 1) % count])
                durations.append(stay)
    if len(rows) > count:
        yield replace(orbit, segments=np.array(rows), starts=np.array(starts), durations=np.array(durations))


def _brief_before_sliding(problem: "Problem", orbit: "Orbit") -> list[int]:
    """The stays of no time behind the surface after which the motion slides: they begin at switching-sliding."""
    system = problem.plain
    slides, short = sliding_modes(system), TUNING.tangential * float(orbit.durations.sum())
    sliding = [system.mode_names[m] in slides for m in orbit.segments[:, at.SEGMENT_MODE].tolist()]
    return [
        i
        for i, lasting in enumerate(orbit.durations.tolist())
        if lasting <= short and (sliding[i - 1], sliding[i], sliding[(i + 1) % len(orbit)]) == (False, False, True)
    ]


def unswitched(problem: "Problem", orbit: "Orbit") -> Iterator["Orbit"]:
    """A guess of the orbit on the other side of a switching-sliding point: it slides at once."""
    if orbit.eventless:
        return
    brief = _brief_before_sliding(problem, orbit)
    segments, events = orbit.segments.copy(), kernels_of(problem.system).layout.events
    for i in brief:
        mode, end, _ = segments[i - 1].tolist()
        sliding = [k for k in events[mode][end].outcomes if problem.plain.transitions[k].kind == "slide"]
        if not sliding:
            return
        segments[i - 1, at.SEGMENT_OUTCOME] = sliding[0]
    yield from _without(orbit, segments, brief)


def _leaves(problem: "Problem", orbit: "Orbit", segment: int, other: int) -> bool:
    """Whether a stay on the surface begins at the end of the part that slides, towards another mode."""
    system, kernels = problem.plain, kernels_of(problem.system)
    mode, n = int(orbit.segments[segment, at.SEGMENT_MODE]), len(problem.system.state_names)
    constants = kernels.constants(problem.system.parameters)
    gradient, rates = np.zeros(n + 1), np.zeros(n + len(problem.system.quadratures))
    time = orbit.phase + float(orbit.durations[:segment].sum())
    state = np.ascontiguousarray(orbit.starts[segment])
    kernels.functions.field(mode, time, constants, state, rates)
    for j, event in enumerate(kernels.layout.events[mode]):
        if any(system.transitions[k].target == system.mode_names[other] for k in event.outcomes):
            value = float(kernels.functions.guard(mode, j, time, constants, state, gradient))
            pace = abs(float(gradient[:n] @ rates[:n] + gradient[n]))
            return abs(value) <= TUNING.tangential * pace * float(orbit.durations.sum())
    return False


def _stays(system: "HybridSystem", orbit: "Orbit") -> Cycle:
    """The modes in order, and how long each lasts, written from the least rotation of their names."""
    if orbit.eventless:
        return ((system.mode_names[orbit.segments[0, at.SEGMENT_MODE]], float(orbit.durations.sum())),)
    modes = [system.mode_names[m] for m in orbit.segments[:, at.SEGMENT_MODE].tolist()]
    return _least(tuple(zip(modes, orbit.durations.tolist(), strict=True)))


def _least(cycle: Cycle) -> Cycle:
    return min((cycle[k:] + cycle[:k] for k in range(len(cycle))), key=_names)


def _names(cycle: Cycle) -> tuple[str, ...]:
    return tuple(mode for mode, _ in cycle)


def _reached(longer: Cycle, shorter: Cycle, kind: Special, slides: set[str]) -> float:
    """The longest of the stays without which, all of one kind, the one cycle of modes is the other; infinite if none.

    A stay between two others may be taken for one of two kinds: what vanishes is the brief one.
    """
    cycles, count = {_names(longer): (0.0, longer)}, len(longer)
    while cycles and count > len(shorter):
        less: dict[tuple[str, ...], tuple[float, Cycle]] = {}
        for most, cycle in cycles.values():
            for lasting, left in _left_out(cycle, kind, slides):
                most_now, name = max(most, lasting), _names(left)
                if name not in less or most_now < less[name][0]:
                    less[name] = most_now, left
        cycles = less
        count = len(next(iter(cycles), ()))
    return cycles.get(_names(shorter), (np.inf, ()))[0]


def _left_out(cycle: Cycle, kind: Special, slides: set[str]) -> Iterator[tuple[float, Cycle]]:
    """The cycles without one stay that begins or ends at a sliding bifurcation, and how long it lasts."""
    for k in range(len(cycle)):
        turned = cycle[k:] + cycle[:k]
        (before, lasting), (stay, brief), (after, last) = (turned[j % len(cycle)] for j in range(3))
        if (before in slides, stay in slides, after in slides) != _PATTERNS[kind]:
            continue
        if kind in (Special.CROSSING_SLIDING, Special.SWITCHING_SLIDING):
            if before != after:
                yield brief, _least((*turned[:1], *turned[2:]))
        elif before == after:
            yield brief, _least(((before, lasting + brief + last), *turned[3:]))


_PATTERNS = {
    Special.CROSSING_SLIDING: (False, True, False),
    Special.GRAZING_SLIDING: (False, True, False),
    Special.ADDING_SLIDING: (True, False, True),
    Special.SWITCHING_SLIDING: (False, False, True),
}
"""Whether the mode before a stay, that of the stay and the one after it slide."""

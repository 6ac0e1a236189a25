"""Sliding bifurcations: which of the four happens where an orbit of a Filippov system changes its events.

An orbit crosses or slides along a surface between two fields. Where a stay on it begins or ends at the boundary of the
part of the surface on which motions slide, the sequence of modes changes in one of four ways (Kuznetsov, Rinaldi and
Gragnani 2003, doi:10.1142/S0218127403007874; di Bernardo, Kowalczyk and Nordmark 2002,
doi:10.1016/S0167-2789(02)00547-X).
"""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset.branches import Special
from chaosdrill.engine import shooting as at
from chaosdrill.orbits.settings import SETTINGS

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.points import Border
    from chaosdrill.orbits.problem import Problem

SLIDING = (
    Special.CROSSING_SLIDING,
    Special.GRAZING_SLIDING,
    Special.ADDING_SLIDING,
    Special.SWITCHING_SLIDING,
)
TOUCHING = (Special.GRAZING, Special.GRAZING_SLIDING, Special.ADDING_SLIDING)
"""Kinds at which an orbit touches a guard without an event."""


def sliding_modes(system: "HybridSystem") -> set[str]:
    """The modes in which a system slides along a surface between two fields."""
    begun = {t.target for t in system.transitions if t.kind == "slide"}
    return begun & {mode for t in system.transitions if t.kind == "leave" for mode in t.source}


def sliding_between(problem: "Problem", before: "Orbit", after: "Orbit") -> Special | None:
    """The sliding bifurcation between two orbits; None if it is none of the four, or several different ones."""
    system = problem.plain
    slides = sliding_modes(system)
    if not slides:
        return None
    longer, shorter = sorted(([system.mode_names[m] for m in _modes(orbit)] for orbit in (before, after)), key=len)[::-1]
    if len(longer) == len(shorter):
        return None
    found = {kind for kind in SLIDING if _reached(tuple(longer), tuple(shorter), kind, slides)}
    return found.pop() if len(found) == 1 else None


def sliding_beyond(problem: "Problem", border: "Border") -> Special | None:
    """The sliding bifurcation at a border behind which no orbit is known, from the first orbit beyond it."""
    system, orbit, shot = problem.plain, border.bad, border.bad_shot
    slides = sliding_modes(system)
    if not slides or orbit is None or shot is None:
        return None
    for i, (mode, _, outcome) in enumerate(orbit.segments.tolist()):
        if shot.crossed[i] >= 0 and 1e-6 < shot.met[i] / orbit.durations[i] < 1 - 1e-6:
            return Special.ADDING_SLIDING if system.mode_names[mode] in slides else Special.GRAZING_SLIDING
        if outcome >= 0 and shot.came[i] >= 0 and shot.came[i] != outcome:
            expected, came = (system.transitions[k].target in slides for k in (outcome, int(shot.came[i])))
            brief = orbit.durations[(i + 1) % len(orbit)] <= SETTINGS.tangential * orbit.durations.sum()
            if came and not expected:
                return Special.CROSSING_SLIDING
            if expected and not came:
                return Special.CROSSING_SLIDING if brief else Special.SWITCHING_SLIDING
    return None


def _modes(orbit: "Orbit") -> list[int]:
    """The modes in order; one that goes on behind no event counts once."""
    events = orbit.segments[:, at.SEGMENT_END] >= 0
    modes = orbit.segments[:, at.SEGMENT_MODE]
    return modes[events].tolist() if events.any() else modes[:1].tolist()


def _reached(longer: tuple[str, ...], shorter: tuple[str, ...], kind: Special, slides: set[str]) -> bool:
    """Whether leaving out stays of one kind makes the one cycle of modes the other."""
    cycles = {longer}
    while cycles and len(next(iter(cycles))) > len(shorter):
        cycles = {less for cycle in cycles for less in _left_out(cycle, kind, slides)}
    return min(shorter[k:] + shorter[:k] for k in range(len(shorter))) in cycles


def _left_out(cycle: tuple[str, ...], kind: Special, slides: set[str]) -> "list[tuple[str, ...]]":
    """The cycles without one stay that begins or ends at a sliding bifurcation, written from their least rotation."""
    found, count = set(), len(cycle)
    for k in range(count):
        turned = cycle[k:] + cycle[:k]
        before, stay, after = turned[0], turned[1 % count], turned[2 % count]
        here = (before in slides, stay in slides, after in slides)
        less: tuple[str, ...] | None = None
        if kind == Special.CROSSING_SLIDING and here == (False, True, False) and before != after:
            less = turned[:1] + turned[2:]
        elif kind == Special.GRAZING_SLIDING and here == (False, True, False) and before == after:
            less = turned[:1] + turned[3:]
        elif kind == Special.ADDING_SLIDING and here == (True, False, True) and before == after:
            less = turned[:1] + turned[3:]
        elif kind == Special.SWITCHING_SLIDING and here == (False, False, True):
            less = turned[:1] + turned[2:]
        if less:
            found.add(min(less[j:] + less[:j] for j in range(len(less))))
    return sorted(found)

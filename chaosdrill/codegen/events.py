"""Events of each mode of a system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.codegen.layout import Watched
from chaosdrill.codegen.steep import steep_operations
from chaosdrill.model.crossings import INCREASING, Crossing, crossings
from chaosdrill.model.derive import guard_gradient
from chaosdrill.model.special import SPECIAL

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


@dataclass(frozen=True)
class Event:
    """A surface that one mode watches, as `Watched`, and the expression of it."""

    guard: Any
    """What is zero on it, whatever the way in which guards are written"""
    direction: int
    outcomes: tuple[int, ...]
    affine: bool
    steep: bool
    timed: bool
    key: int
    surface: int

    def watched(self) -> Watched:
        """All of it but its guard."""
        return Watched(*(getattr(self, name) for name in Watched._fields))


def mode_events(system: "HybridSystem", mode: str) -> tuple[Event, ...]:
    """The events that a mode watches, larger priority first, then in order of declaration."""
    groups: dict[Crossing, list[int]] = {}
    for index, crossing in enumerate(crossings(system.transitions)):
        if mode in system.transitions[index].source:
            groups.setdefault(crossing, []).append(index)
    moving = {*system.states, system.time}
    keys = guard_keys(system)
    surfaces = list(dict.fromkeys(surface for surface, _ in keys))
    events = [
        Event(
            guard,
            direction,
            tuple(found),
            affine=not any(g.free_symbols & moving for g in guard_gradient(system, guard)),
            steep=bool(steep_operations([guard], moving)),
            timed=not guard.free_symbols & set(system.states),
            key=keys.index(Crossing(guard, direction)),
            surface=surfaces.index(guard),
        )
        for (guard, direction), found in groups.items()
    ]
    return tuple(sorted(events, key=lambda e: -max(system.transitions[i].priority for i in e.outcomes)))


def guard_keys(system: "HybridSystem") -> list[Crossing]:
    """The surfaces of a system's guards with the ways in which they are crossed, each once."""
    return list(dict.fromkeys(crossings(system.transitions)))


def returns(system: "HybridSystem", events: Sequence[Sequence[Event]]) -> list[list[int]]:
    """Where what a transition throws off its surface meets that again: guards of its target mode, -1 for none.

    Two for each transition: the guard that is met from above the surface, and the one that is met from below.
    """
    modes, found = list(system.modes), []
    for transition, crossing in zip(system.transitions, crossings(system.transitions), strict=True):
        there = [(j, e) for j, e in enumerate(events[modes.index(transition.target)]) if e.guard == crossing.surface]
        found.append([next((j for j, e in there if e.direction in (0, way)), -1) for way in (-1, 1)])
    return found


def in_series(system: "HybridSystem") -> set[int]:
    """Transitions that may be one of a series of rebounds, all on one surface, that another one completes."""
    surfaces = [surface for surface, _ in crossings(system.transitions)]
    usual = {k: t for k, t in enumerate(system.transitions) if t.completes is None and not t.marks_only()}
    completed = {t.completes for t in system.transitions}
    found = {k for k, t in usual.items() if t.name in completed}
    waiting = list(found)
    while waiting:
        last = waiting.pop()
        target = system.transitions[last].target
        following = {k for k, t in usual.items() if target in t.source and surfaces[k] == surfaces[last]} - found
        found |= following
        waiting += following
    return found


def cancels(image: Any) -> bool:
    """Whether the image of a reset may be small beside its operands, and so as inexact as they are.

    A product, such as ``-e*v``, is as exact as its factors.
    """
    exact = (*INCREASING, sympy.exp, sympy.cosh)
    return any(
        p.is_Add or (p.is_Function and not isinstance(p, exact) and type(p).__name__ not in SPECIAL)
        for p in sympy.preorder_traversal(image)
    )

"""Events of each mode of a system."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.model.crossings import INCREASING, Crossing, crossings
from chaosdrill.model.derive import guard_gradient
from chaosdrill.model.special import SPECIAL

if TYPE_CHECKING:
    from chaosdrill.model.reading import Transition
    from chaosdrill.model.system import HybridSystem


@dataclass(frozen=True)
class Event:
    """A surface that one mode watches: its outcomes are transitions in the order in which they are tried."""

    guard: Any
    """What is zero on it, whatever the way in which guards are written"""
    direction: int
    outcomes: tuple[int, ...]
    affine: bool
    """Whether it is linear in the states and free of time."""
    entire: bool
    """Whether its series reaches as far as that of the states: sums, products, sines, cosines, and what drives them."""
    timed: bool
    """Whether it depends on time alone."""
    key: int
    """Number of the guard with its direction, the same in all modes that watch it."""
    surface: int
    """Number of the surface on which it is zero, the same for both directions."""


def mode_events(system: "HybridSystem", mode: str) -> tuple[Event, ...]:
    """The events that a mode watches, larger priority first, then in order of declaration."""
    groups: dict[Crossing, list[int]] = {}
    for index, crossing in enumerate(crossings(system.transitions)):
        if mode in system.transitions[index].source:
            groups.setdefault(crossing, []).append(index)
    moving = {*system.states, system.time}
    in_rates = {part for rate in system.modes[mode].values() for part in sympy.preorder_traversal(rate)}
    keys = guard_keys(system)
    surfaces = list(dict.fromkeys(surface for surface, _ in keys))
    events = [
        Event(
            guard,
            direction,
            tuple(found),
            affine=not any(g.free_symbols & moving for g in guard_gradient(system, guard)),
            entire=_is_entire(guard, moving, in_rates),
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


def cancels(transition: "Transition") -> bool:
    """Whether a reset may give what is small beside its operands, and so as inexact as they are.

    A product, such as ``-e*v``, is as exact as its factors.
    """
    exact = (*INCREASING, sympy.exp, sympy.cosh)
    parts = [part for image in transition.reset.values() for part in sympy.preorder_traversal(image)]
    return any(
        p.is_Add or (p.is_Function and not isinstance(p, exact) and type(p).__name__ not in SPECIAL) for p in parts
    )


def _is_entire(expression: Any, moving: set[Any], in_rates: set[Any]) -> bool:
    if not expression.free_symbols & moving or expression.is_Symbol or expression in in_rates:
        return True
    power = expression.is_Pow and expression.exp.is_Integer and expression.exp > 0
    if not (power or expression.is_Add or expression.is_Mul or expression.func in (sympy.sin, sympy.cos)):
        return False
    return all(_is_entire(part, moving, in_rates) for part in expression.args)

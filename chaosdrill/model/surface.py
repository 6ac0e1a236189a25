"""A surface in state space, marked by transitions that change nothing, or by those of a map that lead beyond it."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import sympy

from chaosdrill.model.crossings import crossings
from chaosdrill.model.derive import image_of
from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.held import Trial, kept_apart
from chaosdrill.model.period import repeats
from chaosdrill.model.places import parameter
from chaosdrill.model.rules import folded, refused
from chaosdrill.model.special import FLOW
from chaosdrill.model.system import HybridSystem
from chaosdrill.model.text import read_text
from chaosdrill.model.transition import REFLECTION, Transition


def surface(system: HybridSystem, at: str) -> tuple[HybridSystem, frozenset[int]]:
    """The system with transitions that mark where a comparison becomes true, and their indices.

    Those of a map are its iterates for which it is true, and its starts are those for which it is not. Raises
    `ExpressionError` if that is no comparison of what moves, if an event of the system has that surface, or if a
    reflection, which is no motion, would cross it.
    """
    if system.discrete:
        return _iterates(system, at)
    known = system.shared.get(("surface", at))
    if known is None:
        moving = {*system.states, *(() if system.time is None else (system.time,))}
        found = _comparison(system, at, moving)
        value = found.gts - found.lts
        if told := refused(value, moving, FLOW) or folded(value, moving, system.parameters):
            raise ExpressionError(told)
        first = 1 + max((t.priority for t in system.transitions), default=0)
        marks = [
            Transition(f"{at} in {mode}", mode, mode, guard=value, direction=+1, priority=first)
            for mode in system.modes
        ]
        mark, *others = crossings((marks[0], *system.transitions))
        for t, other in zip(system.transitions, others, strict=True):
            reflects = t.kind == REFLECTION
            if other.surface == mark.surface and (reflects or other.direction in (0, mark.direction)):
                raise ExpressionError(f"this surface is the guard of {t.name!r}; name that, as in at={t.name!r}")
            if reflects and not _kept(system, t, value):
                raise ExpressionError(
                    f"the reflection {t.name!r} throws states across it, which is not a crossing; compare what the "
                    "symmetry keeps, as in x**2 > 1 where x becomes -x, name an event, or take the whole system"
                )
        if not repeats(system, value, system.parameters):
            words = "the surface does not repeat after the forcing period; compare states, or what repeats"
            raise ExpressionError(words)
        known = system.shared["surface", at] = system.remade(transitions=(*system.transitions, *marks))
    marked = known.changed(parameters=system.parameters, initial=system.initial, names_mode=system.names_mode)
    count = len(system.transitions)
    return marked, frozenset(range(count, len(marked.transitions)))


def _iterates(system: HybridSystem, at: str) -> tuple[HybridSystem, frozenset[int]]:
    known = system.shared.get(("surface", at))
    if known is None:
        whole = system.built
        found = _comparison(whole, at, set(whole.states))
        outcomes = []
        for t in whole.transitions:
            holds = [*t.conditions.values(), found.xreplace(image_of(whole, t))]
            outcomes += [replace(t, name=f"{t.name} to {at}", condition=sympy.And(*holds)), t]
        known = system.shared["surface", at] = whole.changed(
            transitions=tuple(outcomes), regions=dict.fromkeys(whole.modes, sympy.Not(found))
        )
    marked = known.changed(parameters=system.parameters, initial=system.initial)
    return marked, frozenset(range(0, len(marked.transitions), 2))


def _comparison(system: HybridSystem, at: str, moving: Iterable[Any]) -> Any:
    """The comparison of a text."""
    names = {symbol.name: symbol for symbol in moving} | {name: parameter(name) for name in system.parameters}
    found = read_text(at, names, condition=True)
    if not hasattr(found, "gts") or not found.free_symbols & set(system.states):
        raise ExpressionError("a section is one comparison of states by < or >, such as x > 0")
    return found


def _kept(system: HybridSystem, transition: Transition, value: Any) -> bool:
    """Whether a reflection leaves the value of an expression as it is."""
    after = value.xreplace(image_of(system, transition))
    # a clock, which alone becomes a constant, is turned back from its opposite
    turned = (x + end for x, end in transition.reset.items() if not end.free_symbols & set(system.states))
    return Trial(system).zero(kept_apart([after, -value]), (transition.guard, *turned))

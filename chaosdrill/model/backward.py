"""A system with time running backwards, where every event can be undone."""

from collections.abc import Mapping
from typing import Any

import sympy
from sympy.solvers.solveset import NonlinearError

from chaosdrill.model.system import HybridSystem
from chaosdrill.model.transition import Transition


def backward(system: HybridSystem) -> HybridSystem | None:
    """The system whose motions are those of another one, run backwards from one strobe to the one before.

    Rates have the other sign, time too, and every transition leads from its target to its source, where the motion
    meets the image of its guard. None where an event cannot be undone: for maps, regions, noise, Python functions,
    events with several outcomes or without rank, and resets that are not linear in the states that they change.
    """
    if system.discrete or system.regions or system.noise or system.sources:
        return None
    moved = {} if system.time is None else {system.time: -system.time}
    transitions = []
    for t in system.transitions:
        if t.marks_only():
            continue
        before = _before(system, t)
        if before is None or t.conditions or t.completes is not None or len(t.source) != 1:
            return None
        guard = t.guard.xreplace(before).xreplace(moved)
        reset = {state: value.xreplace(moved) for state, value in before.items()}
        transitions.append(Transition(t.name, t.target, t.source[0], guard, 0, reset, priority=t.priority, kind=t.kind))
    guards = [(t.source, t.guard) for t in transitions]
    if any(guards.count(one) > 1 for one in guards):
        return None
    return HybridSystem(
        name=f"{system.name}, backwards",
        states=system.states,
        time=system.time,
        parameters=system.parameters,
        modes={
            mode: {state: -rate.xreplace(moved) for state, rate in rates.items()}
            for mode, rates in system.modes.items()
        },
        transitions=transitions,
        period=system.period,
        bounds=system.bounds,
        initial={"mode": system.initial["mode"]},
    )


def _before(system: HybridSystem, t: Transition) -> Mapping[Any, Any] | None:
    """The states that a reset changes, before it, by those after it; None where it has no inverse."""
    from chaosdrill.model.places import parameter

    changed = [state for state in system.states if state in t.reset]
    if not changed:
        return {}
    try:
        matrix, rest = sympy.linear_eq_to_matrix([t.reset[state] for state in changed], changed)
    except NonlinearError:
        return None
    values = {parameter(name): value for name, value in system.parameters.items()}
    free = matrix.free_symbols - set(values)
    if free or not abs(complex(matrix.xreplace(values).det())) > 0:
        return None
    inverse = matrix.inv()
    found = inverse * (sympy.Matrix(changed) + rest)
    return dict(zip(changed, found, strict=True))

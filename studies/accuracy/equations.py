"""The drill written out for another solver: rates with tangents, guards, and what an event does to all of it.

The expressions come from the package (``chaosdrill.model.derive``), so that every solver does the same work: the
same right-hand side, the same events, the same saltation matrices. States that a mode holds at zero are left out
there.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import sympy

import chaosdrill as cd
from chaosdrill.codegen import special
from chaosdrill.model.derive import guard_gradient, jacobian, reset_map, saltation

SPECIAL = {name: getattr(special, name) for name in ("hunt_crossley_exit", "hunt_crossley_peak")}


@dataclass(frozen=True)
class Event:
    """One guard of a mode.

    Attributes
    ----------
    guard, direction
        Expression, and +1 or -1.
    outcomes : tuple of (target mode, condition or None, images)
        Images are the vector of the target mode after the event by the vector of this mode before it.
    """

    guard: Any
    direction: int
    outcomes: tuple[tuple[str, Any, list[Any]], ...]


@dataclass(frozen=True)
class Mode:
    """One mode: its vector (states that move, then as many tangents), the rates of that, and its events."""

    symbols: list[Any]
    rates: list[Any]
    events: tuple[Event, ...]


MODES = ("stick", "slip")
"""Modes that occur where no contact is held; the others are left out, which saves the other solvers some work."""


def write_out(system: "cd.HybridSystem", tangents: int) -> dict[str, Mode]:
    """Return ``MODES`` of the drill at its present parameters, with this number of tangents beside the state."""
    numbers = {sympy.Symbol(name, real=True): value for name, value in system.parameters.items()}
    vectors = [[sympy.Symbol(f"{s.name}_{v}", real=True) for s in system.states] for v in range(tangents)]
    moving = {name: [s for s in system.states if system.modes[name][s] != 0] for name in MODES}

    def held(mode: str) -> dict[Any, int]:
        still = [i for i, s in enumerate(system.states) if s not in moving[mode]]
        return {symbol: 0 for i in still for symbol in (system.states[i], *(d[i] for d in vectors))}

    def vector(mode: str, full: list[list[Any]], source: str) -> list[Any]:
        kept = [i for i, s in enumerate(system.states) if s in moving[mode]]
        return [sympy.sympify(part[i]).subs(numbers).subs(held(source)) for part in full for i in kept]

    modes = {}
    for name in MODES:
        field = system.modes[name]
        slope = jacobian(system, name)
        rates = [[field[s] for s in system.states], *(list(slope * sympy.Matrix(d)) for d in vectors)]
        grouped: dict[Any, list[Any]] = {}
        for transition in system.transitions:
            if name in transition.source and transition.target in MODES:
                grouped.setdefault((transition.guard, transition.direction), []).append(transition)
        events = []
        for (guard, direction), transitions in grouped.items():
            outcomes = []
            for transition in transitions:
                torn = saltation(system, transition, name)
                image = [reset_map(system, transition), *(list(torn * sympy.Matrix(d)) for d in vectors)]
                condition = transition.conditions.get(name)
                if condition is not None:
                    condition = condition.subs(numbers).subs(held(name))
                outcomes.append((transition.target, condition, vector(transition.target, image, name)))
            events.append(Event(guard.subs(numbers).subs(held(name)), direction, tuple(outcomes)))
        symbols = [symbol for part in (system.states, *vectors) for symbol in part if symbol not in held(name)]
        modes[name] = Mode(symbols, vector(name, rates, name), tuple(events))
    return modes


def onto_guard(system: "cd.HybridSystem", event: Event, mode: Mode) -> list[Any]:
    """Return the mode's vector with its states moved onto a guard along the gradient."""
    symbols = [s for s in mode.symbols if s in system.states]
    gradient = dict(zip(system.states, guard_gradient(system, event.guard), strict=False))
    square = sum(gradient[s] ** 2 for s in symbols)
    return [s - event.guard * gradient[s] / square if s in symbols else s for s in mode.symbols]


def event_function(
    system: "cd.HybridSystem", event: Event, mode: Mode, jit: Callable[[Any], Any]
) -> Callable[..., int]:
    """Return ``f(t, before, after_0, ...)`` that writes into the array of the outcome and returns its number."""
    names = [s.name for s in mode.symbols]
    known: dict[str, Any] = {}
    time = system.time
    onto = dict(zip(mode.symbols, onto_guard(system, event, mode), strict=True))
    lines = [f"def take(t, before, {', '.join(f'after{k}' for k in range(len(event.outcomes)))}):"]
    lines.append(f"    {', '.join(names)} = {', '.join(f'before[{i}]' for i in range(len(names)))}")
    for k, (_, condition, image) in enumerate(event.outcomes):
        moved = [entry.xreplace(onto) if entry.is_Symbol else entry for entry in image]
        known[f"image{k}"] = jit(sympy.lambdify([time, *mode.symbols], moved, modules=[SPECIAL, "math"], cse=True))
        if condition is not None:
            known[f"holds{k}"] = jit(sympy.lambdify([time, *mode.symbols], condition, modules=[SPECIAL, "math"]))
        lines.append(f"    if holds{k}(t, {', '.join(names)}):" if condition is not None else "    if True:")
        lines.append(f"        values = image{k}(t, {', '.join(names)})")
        lines += [f"        after{k}[{i}] = values[{i}]" for i in range(len(image))]
        lines.append(f"        return {k}")
    lines.append("    return -1")
    exec("\n".join(lines), known)
    return jit(known["take"])


def as_it_is(function: Any) -> Any:
    """Leave a function to Python."""
    return function


def orthonormalise(vector: Any, states: int, tangents: int, logs: Any) -> None:
    """Orthonormalise the tangents behind the ``states`` of a vector and add the logarithms of their growth."""
    for v in range(tangents):
        at = states * (v + 1)
        for w in range(v):
            before = states * (w + 1)
            overlap = 0.0
            for i in range(states):
                overlap += vector[at + i] * vector[before + i]
            for i in range(states):
                vector[at + i] -= overlap * vector[before + i]
        square = 0.0
        for i in range(states):
            square += vector[at + i] ** 2
        length = square**0.5
        for i in range(states):
            vector[at + i] /= length
        logs[v] += math.log(length)

"""A system that carries passengers: integrals along its motion, and a tangent with its saltation, as further states."""

from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any

from chaosdrill.model.system import HybridSystem
from chaosdrill.model.transition import Transition

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True)
class Lifted:
    """The system with its passengers, which feed back into nothing, and how its transitions are counted."""

    system: HybridSystem  # states: the n own ones, the r quadratures, then the n of the tangent, if there is one
    taken: dict[tuple[int, int], int]
    """Its transition by a mode, and by that of the own system which is taken there."""


def lifted(system: HybridSystem, *, tangent: bool) -> Lifted:
    """The system whose states are (x, Q, a): Q' = w(x), the integrands of its quadratures, and a' = A(x) a, a := S a.

    First derivatives of the lifted motion are second ones of the own one: the linearised equations of an orbit of the
    lifted system hold those of the saltation matrix S by state, time and parameters. ``tangent``: whether a is carried.
    """
    taken = {way: place for place, way in enumerate(_ways(system))}
    return Lifted(system.relative(("lifted", str(tangent)), partial(_lifted, system, tangent)), taken)


def _ways(system: HybridSystem) -> list[tuple[int, int]]:
    """Mode and transition of every transition of the lifted system, in their order."""
    modes = system.mode_names
    return [(modes.index(source), number) for number, one in enumerate(system.transitions) for source in one.source]


def _lifted(system: HybridSystem, tangent: bool) -> HybridSystem:
    import sympy

    from chaosdrill.model.derive import jacobian_entries
    from chaosdrill.model.held import held_surfaces
    from chaosdrill.model.places import places_of

    taken = {*system.state_names, *system.parameters, str(system.time)}
    names = (name for number in count() if (name := f"carried_{number}") not in taken)
    integrals = {sympy.Symbol(next(names), real=True): rates for rates in system.quadratures.values()}
    changes = [sympy.Symbol(next(names), real=True) for _ in system.states if tangent]
    modes: dict[str, dict[Any, Any]] = {}
    for mode, field in system.modes.items():
        modes[mode] = {**field, **{q: rates[mode] for q, rates in integrals.items()}}
        entries = jacobian_entries(system, mode) if tangent else {}
        modes[mode] |= dict.fromkeys(changes, sympy.Integer(0))
        for (i, j), slope in entries.items():
            modes[mode][changes[i]] += slope * changes[j]
    transitions = [
        _carrying(system, system.transitions[number], system.mode_names[mode], changes)
        for mode, number in _ways(system)
    ]
    wide = HybridSystem(
        name=f"{system.name} (lifted)",
        states=(*system.states, *integrals, *changes),
        time=system.time,
        parameters=system.parameters,
        modes=modes,
        transitions=transitions,
        period=system.period,
        initial=system.initial,
        bounds={**system.bounds, **{one.name: None for one in (*integrals, *changes)}},
    )
    own = {place: symbol for symbol, place in places_of(system).items()}
    # what it holds is what the own one holds: passengers are led, whatever their values
    wide.shared["held"] = {
        mode: tuple(surface.xreplace(own) for surface in surfaces)
        for mode, surfaces in held_surfaces(system.placed).items()
    }
    return wide


def _carrying(system: HybridSystem, one: Transition, source: str, changes: "Sequence[Any]") -> Transition:
    """A transition from one mode that takes the tangent across."""
    import sympy

    from chaosdrill.model.derive import saltation

    reset = dict(one.reset)
    if changes and not one.marks_only():
        matrix = saltation(system, one, source)
        across = matrix * sympy.Matrix(changes)
        reset |= {a: e for a, e in zip(changes, across, strict=True) if e != a}

    def named(name: str) -> str:
        return f"{name} from {source}"

    return Transition(
        name=named(one.name),
        source=source,
        target=one.target,
        guard=one.guard,
        direction=one.direction,
        reset=reset,
        condition=one.conditions.get(source),
        priority=one.priority,
        completes=None if one.completes is None else named(one.completes),
        kind=one.kind,
    )

"""A system whose symbols are named by their places: all that derives and computes sees these names alone.

State 3 is ``x_3``, parameter 0 is ``p_0``, time is ``t``. What a user calls them comes back in labels and messages
only. So no result depends on it: not by a name that a function or a temporary has too, and not by the order in which
sums are added up, which sympy takes from names.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import sympy

from chaosdrill.model.crossings import crossings
from chaosdrill.model.values import Shared, System, deriving

S = TypeVar("S", bound=System)

TIME = sympy.Symbol("t", real=True)


def places_of(system: System) -> dict[Any, Any]:
    """The symbol of the place of every symbol of a system."""
    places = {x: sympy.Symbol(f"x_{i}", real=True) for i, x in enumerate(system.states)}
    places |= {parameter(name): sympy.Symbol(f"p_{i}", real=True) for i, name in enumerate(system.parameters)}
    return places if system.time is None else {**places, system.time: TIME}


def placed(system: S) -> S:
    """A system in places; what is derived of it is kept with it."""
    with deriving:
        form = system.shared.get("placed")
        if form is None:
            form = system.shared["placed"] = _in_places(system)
    starts = dict(zip(form.state_names, system.initial_values, strict=True))
    found: S = form.changed(
        parameters=dict(zip(form.parameters, system.parameters.values(), strict=True)),
        initial={"mode": system.initial["mode"], **starts},
    )
    return found


def _in_places(system: S) -> S:
    """The same system with states, parameters and time called by their places; modes and transitions keep names.

    Its guards are the surfaces on which those of the system vanish, however they are written.
    """
    places = places_of(system)

    def put(expression: Any) -> Any:
        return sympy.sympify(expression).xreplace(places)

    names = {symbol.name: place.name for symbol, place in places.items() if symbol != system.time}
    other, shared = rewritten(system, put, places), Shared()
    if (held := system.told_held) is not None:
        shared["held"] = {mode: tuple(map(put, surfaces)) for mode, surfaces in held.items()}
    return other.changed(
        states=tuple(places[x] for x in system.states),
        time=None if system.time is None else TIME,
        parameters={names[name]: value for name, value in system.parameters.items()},
        exponent_parameters=tuple(names[name] for name in system.exponent_parameters),
        initial={names.get(name, name): value for name, value in system.initial.items()},
        bounds={names[name]: bound for name, bound in system.bounds.items()},
        labels={},
        transitions=tuple(
            replace(t, guard=crossing.surface, direction=crossing.direction)
            for t, crossing in zip(other.transitions, crossings(other.transitions), strict=True)
        ),
        period=None if system.period is None else put(system.period),
        shared=shared,
    )


def rewritten(system: S, put: Callable[[Any], Any], states: Mapping[Any, Any] | None = None) -> S:
    """A copy with other expressions, and other symbols of its ``states`` before their rates and resets.

    The period stays as it is.
    """

    def fields(rates: Mapping[Any, Any]) -> dict[Any, Any]:
        if states is None:
            return {x: put(rate) for x, rate in rates.items()}
        return {place: put(rates[x]) for x, place in states.items() if x in rates}

    def by_mode(given: Mapping[str, Any]) -> dict[str, Any]:
        return {mode: put(expression) for mode, expression in given.items()}

    return system.changed(
        shared=system.shared,
        regions=by_mode(system.regions),
        modes={mode: fields(rates) for mode, rates in system.modes.items()},
        quadratures={name: by_mode(rates) for name, rates in system.quadratures.items()},
        transitions=tuple(
            replace(
                t,
                guard=put(t.guard),
                reset=fields(t.reset),
                condition=None if t.condition is None else by_mode(t.conditions),
            )
            for t in system.transitions
        ),
    )


def arguments(placed: System) -> list[Any]:
    """Time, states and parameters of a system in places, as the arguments of functions made of its expressions."""
    return [TIME, *placed.states, *map(parameter, placed.parameters)]


def parameter(name: str) -> Any:
    """The symbol of a parameter."""
    return sympy.Symbol(name, real=True)

"""A hybrid system as plain data: texts, numbers, lists and tables, written from it and read back without running code.

A definition holds the equations; the values of parameters and the initial state are stored beside it, as in scenes.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.reading import Reader
from chaosdrill.model.tables import DEFAULT_BOUNDS
from chaosdrill.model.text import write_text
from chaosdrill.model.transition import Transition
from chaosdrill.model.values import Definition

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


def write_definition(system: "HybridSystem") -> dict[str, Any]:
    """The equations of a system as plain data, from which `build_defined` makes the same system, to the last bit.

    They are texts, numbers, lists and dicts: ``name``, ``states``, ``time``, ``period``, ``modes`` (mode -> state ->
    rate), ``transitions`` and, where there are any, ``regions``, ``quadratures``, ``bounds``, ``labels`` and
    ``description``; of a map ``name``, ``states``, ``images`` and the last three.

    Raises `ModelError` if text cannot hold the system, with the reason: a function that the grammar does not know, a
    number of more digits than a double has, an expression that sympy did not evaluate.
    """
    if "definition" not in system.shared:
        try:
            system.shared["definition"] = _written(system.built)
        except ModelError as fault:
            system.shared["definition"] = str(fault)
    found = system.shared["definition"]
    if isinstance(found, str):
        raise ModelError(found)
    return dict(found)


def build_defined(
    definition: Mapping[str, Any], parameters: Mapping[str, Any], initial: Mapping[str, Any] | None = None
) -> "HybridSystem":
    """The system of a definition, as `write_definition` gives it, with all its parameters in order.

    Raises `ModelError` with all faults, one a line, each with its place, and `SettingsError` if a parameter or an
    initial value is no finite number.
    """
    from chaosdrill.model.maps import Map
    from chaosdrill.model.system import HybridSystem

    reader = reader_of(definition, parameters)
    found = reader.read(definition)
    if found is None:
        raise ModelError(reader.told("definition"))
    return (Map if is_map(definition) else HybridSystem).of(found, parameters, initial)


def is_map(definition: Mapping[str, Any]) -> bool:
    """Whether a definition is that of a map."""
    return isinstance(definition, Mapping) and "images" in definition


def reader_of(definition: Mapping[str, Any], parameters: Any) -> Reader:
    """The reader of a definition, with values of its parameters."""
    from chaosdrill.model.images import MapReader

    return MapReader(parameters) if is_map(definition) else Reader(parameters)


def _written(system: "HybridSystem") -> dict[str, Any]:
    if functions := system.sources:
        told = (
            f"{place} is the Python function {one.name!r:.60}, content {one.digest}" for place, one in functions.items()
        )
        raise ModelError(f"{system.name}: no text can hold Python functions: {'; '.join(told)}")
    try:
        definition = _plain(system)
        reader = reader_of(definition, system.parameters)
        found = reader.read(definition)
        if found is None:
            raise ModelError(reader.told(f"{system.name}: definition").splitlines()[0])
        for name in (one.name for one in fields(found)):
            for where, before, after in _differing(name, getattr(system, name), getattr(found, name)):
                raise ModelError(f"{system.name}: {where}: {before} as text would be read as {after}")
    except RecursionError:
        raise ModelError(f"{system.name}: an expression is nested too deeply to be written as text") from None
    return definition


def _plain(system: "HybridSystem") -> dict[str, Any]:
    bounds = {
        name: [float(end) if abs(end) != float("inf") else str(end) for end in pair]
        for name, pair in system.bounds.items()
        if pair != DEFAULT_BOUNDS
    }
    found = {
        "name": system.name,
        "description": system.description,
        "states": list(system.state_names),
        "time": None if system.time is None else system.time.name,
        "period": None if system.period is None else write_text(system.period),
        "modes": {mode: _table(field) for mode, field in system.modes.items()},
        "transitions": [_transition(t) for t in system.transitions],
        "regions": _table(system.regions),
        "quadratures": {name: one_or_by_mode(_table(rates)) for name, rates in system.quadratures.items()},
        "bounds": bounds,
        "labels": dict(system.labels),
        "noise": {name: {**one, "at": list(one["at"])} for name, one in system.noise.items()},
    }
    if system.discrete:
        from chaosdrill.model.images import KEYS

        found = {name: found.get(name) for name in KEYS} | {"images": _table(vars(system)["images"])}
    return {name: value for name, value in found.items() if value is not None and value not in ("", {}, [])}


def _transition(transition: Transition) -> dict[str, Any]:
    found = {
        "name": transition.name,
        "source": transition.source[0] if len(transition.source) == 1 else list(transition.source),
        "target": transition.target,
        "guard": write_text(transition.guard),
        "direction": transition.direction,
        "reset": _table(transition.reset),
        "condition": one_or_by_mode(_table(transition.conditions)),
        "priority": transition.priority,
        "completes": transition.completes,
        "kind": None if transition.kind == transition.name else transition.kind,
    }
    return {
        name: value for name, value in found.items() if value not in (None, {}) and (name, value) != ("priority", 0)
    }


def _table(expressions: Mapping[Any, Any]) -> dict[str, str]:
    return {str(getattr(key, "name", key)): write_text(value) for key, value in expressions.items()}


def one_or_by_mode(texts: Mapping[str, str]) -> Any:
    """One text if all modes share it, else one for each mode; None without any."""
    different = set(texts.values())
    return dict(texts) if len(different) > 1 else next(iter(different), None)


def operations(system: Definition, mode: str) -> int:
    """Products, powers and functions of what moves, in rates, quadratures and guards of a mode; equal ones count once.

    Sums and constant factors cost next to nothing. A function counts twice, since its series needs that of its slope.
    """
    moving = {*system.states, system.time}
    watched = [t.guard for t in system.transitions if mode in t.source]
    whole = [*system.modes[mode].values(), *(rates[mode] for rates in system.quadratures.values()), *watched]
    parts = {part for one in whole for part in sympy.preorder_traversal(one) if part.free_symbols & moving}
    factors = (sum(1 for factor in part.args if factor.free_symbols & moving) for part in parts if part.is_Mul)
    return sum(count - 1 for count in factors) + sum(part.is_Pow + 2 * part.is_Function for part in parts)


def _differing(where: str, one: Any, other: Any) -> Iterator[tuple[str, Any, Any]]:
    """Differences between two systems, with their places; the order of tables and every digit count."""
    if isinstance(one, Transition) and isinstance(other, Transition):
        one, other = one.content(), other.content()
    if isinstance(one, dict) and isinstance(other, dict) and list(one) == list(other):
        for key, value in one.items():
            yield from _differing(f"{where}.{key}", value, other[key])
    elif isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        for first, second in zip(one, other, strict=True):
            yield from _differing(where, first, second)
    elif not _same(one, other):
        yield where, one, other


def _same(one: Any, other: Any) -> bool:
    """Whether two things are the same, expressions node by node: type, order, and every digit of a number."""
    if not isinstance(one, sympy.Basic) or not isinstance(other, sympy.Basic):
        return bool(one == other)
    nodes = zip(sympy.preorder_traversal(one), sympy.preorder_traversal(other), strict=False)
    return one == other and all(type(a) is type(b) and (not a.is_Float or a._prec == b._prec) for a, b in nodes)

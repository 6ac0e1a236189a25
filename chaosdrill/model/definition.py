"""A hybrid system as plain data: texts, numbers, lists and tables, written from it and read back without running code.

What a definition holds are the equations; values of parameters and the initial state stand beside it, as in scenes.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.errors import ChaosdrillError, ModelError
from chaosdrill.model.definition_reading import Fault, Reading, read_definition
from chaosdrill.model.text import write_text

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem
    from chaosdrill.model.transition import Transition


def write_definition(system: "HybridSystem") -> dict[str, Any]:
    """The equations of a system as plain data, from which `build_defined` makes the same system, to the last bit.

    Parameters
    ----------
    system : HybridSystem

    Returns
    -------
    dict
        Texts, numbers, lists and dicts: ``name``, ``states``, ``time``, ``period``, ``modes`` (mode -> state -> rate),
        ``transitions`` and, where there are any, ``quadratures``, ``bounds``, ``labels`` and ``description``.

    Raises
    ------
    ModelError
        If text cannot hold the system, with the reason: a function of one's own, a number of more digits than a double
        has, an expression that sympy did not evaluate.
    """
    if "definition" not in system.shared:
        try:
            system.shared["definition"] = _written(system)
        except ModelError as fault:
            system.shared["definition"] = str(fault)
    found = system.shared["definition"]
    if isinstance(found, str):
        raise ModelError(found)
    return dict(found)


def build_defined(
    definition: Mapping[str, Any], parameters: Mapping[str, Any], initial: Mapping[str, Any] | None = None
) -> "HybridSystem":
    """The system of a definition.

    Parameters
    ----------
    definition : mapping
        As `write_definition` gives it.
    parameters : mapping of str to float
        All parameters, in order.
    initial : mapping, optional
        ``mode`` and values of states; default: the first mode, and 0.

    Returns
    -------
    HybridSystem

    Raises
    ------
    ModelError
        With all faults, one a line, each with its place.
    """
    reading, faults = read_definition(definition, parameters)
    if not faults:
        try:
            return make_system(reading, parameters, initial or {})
        except ChaosdrillError as fault:
            faults = [Fault(getattr(fault, "place", ()), str(fault))]
    raise ModelError("\n".join(fault.text() for fault in faults))


def make_system(reading: Reading, parameters: Mapping[str, Any], initial: Mapping[str, Any]) -> "HybridSystem":
    """The system of a definition that was read without faults; ModelError or SettingsError if it cannot be compiled."""
    from chaosdrill.model.system import HybridSystem

    return HybridSystem(**reading.fields, parameters=parameters, initial=initial)


def _written(system: "HybridSystem") -> dict[str, Any]:
    try:
        definition = _plain(system)
        reading, faults = read_definition(definition, system.parameters)
        if faults:
            raise ModelError(f"{system.name}: {faults[0].text()}")
        for where, before, after in _pairs(system, reading.fields):
            if not _same(before, after):
                raise ModelError(f"{system.name}: {where}: {before} as text would be read as {after}")
    except RecursionError:
        raise ModelError(f"{system.name}: an expression is nested too deeply to be written as text") from None
    return definition


def _plain(system: "HybridSystem") -> dict[str, Any]:
    from chaosdrill.model.system import DEFAULT_BOUND

    bounds = {
        name: [float(end) if abs(end) != float("inf") else str(end) for end in pair]
        for name, pair in system.bounds.items()
        if pair != (-DEFAULT_BOUND, DEFAULT_BOUND)
    }
    found = {
        "name": system.name,
        "description": system.description,
        "states": list(system.state_names),
        "time": None if system.time is None else system.time.name,
        "period": None if system.period is None else write_text(system.period),
        "modes": {mode: _table(field) for mode, field in system.modes.items()},
        "transitions": [_transition(t) for t in system.transitions],
        "quadratures": _table(system.quadratures),
        "bounds": bounds,
        "labels": {str(name): str(label) for name, label in system.labels.items()},
    }
    return {name: value for name, value in found.items() if value is not None and value not in ("", {}, [])}


def _transition(transition: "Transition") -> dict[str, Any]:
    one = len(transition.source) == 1
    found = {
        "name": transition.name,
        "source": transition.source[0] if one else list(transition.source),
        "target": transition.target,
        "guard": write_text(transition.guard),
        "direction": int(transition.direction),
        "reset": _table(transition.reset),
        "condition": None if transition.condition is None else write_text(transition.condition),
        "priority": int(transition.priority),
        "completes": transition.completes,
        "kind": None if transition.kind == transition.name else transition.kind,
    }
    return {
        name: value
        for name, value in found.items()
        if value is not None and value != {} and (name, value) != ("priority", 0)
    }


def _table(expressions: Mapping[Any, Any]) -> dict[str, str]:
    return {str(getattr(key, "name", key)): write_text(value) for key, value in expressions.items()}


def _pairs(system: "HybridSystem", fields: Mapping[str, Any]) -> "list[tuple[str, Any, Any]]":
    """Every expression and every other field of a system beside what was read, with the name of its place."""
    pairs = [
        ("states", list(system.states), list(fields["states"])),
        ("time", system.time, fields["time"]),
        ("description", system.description, fields["description"]),
        ("labels", {str(n): str(label) for n, label in system.labels.items()}, fields["labels"]),
        ("modes", list(system.modes), list(fields["modes"])),
        ("quadratures", list(system.quadratures), list(fields["quadratures"])),
        ("period", system.period, fields["period"]),
        ("transitions", len(system.transitions), len(fields["transitions"])),
    ]
    for mode, field in system.modes.items():
        read = fields["modes"][mode]
        pairs.append((f"mode {mode!r}", list(field), list(read)))
        pairs += [(f"mode {mode!r}, d{state}/dt", rate, read[state]) for state, rate in field.items()]
    pairs += [(f"quadrature {name!r}", rate, fields["quadratures"][name]) for name, rate in system.quadratures.items()]
    for one, other in zip(system.transitions, fields["transitions"], strict=True):
        where = f"transition {one.name!r}"
        rest = ("name", "source", "target", "direction", "priority", "completes", "kind")
        pairs += [(f"{where}, {key}", getattr(one, key), getattr(other, key)) for key in (*rest, "guard", "condition")]
        pairs.append((f"{where}, reset", list(one.reset), list(other.reset)))
        pairs += [(f"{where}, reset of {state}", value, other.reset[state]) for state, value in one.reset.items()]
    return pairs


def _same(one: Any, other: Any) -> bool:
    """Whether two things are the same, expressions node by node: type, order, and every digit of a number."""
    if not isinstance(one, sympy.Basic) or not isinstance(other, sympy.Basic):
        return bool(one == other)
    nodes = zip(sympy.preorder_traversal(one), sympy.preorder_traversal(other), strict=False)
    return one == other and all(type(a) is type(b) and (not a.is_Float or a._prec == b._prec) for a, b in nodes)

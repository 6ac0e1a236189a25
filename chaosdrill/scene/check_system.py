"""Whether the names and numbers of the table ``system`` exist and can be."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from sys import float_info
from typing import Any

from chaosdrill.errors import ModelError
from chaosdrill.names import remedy
from chaosdrill.scene.check_definition import check_definition
from chaosdrill.scene.document import SystemTable
from chaosdrill.scene.limits import LIMITS
from chaosdrill.scene.problems import Problem
from chaosdrill.scene.si import ReadSI, read_si
from chaosdrill.scene.strict import validate

MOST = float_info.max


@dataclass
class CheckedSystem:
    """What is known of the system without building it.

    ``known`` and ``states`` are None as long as the model cannot be told; ``parameters`` are those that the scene sets.
    Either ``model`` names a system of the shelf, or ``definition`` holds one.
    """

    model: str = ""
    definition: dict[str, Any] | None = None
    effects: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    initial: dict[str, Any] = field(default_factory=dict)
    si: ReadSI = field(default_factory=ReadSI)
    known: dict[str, float] | None = None
    states: tuple[str, ...] | None = None
    problems: list[Problem] = field(default_factory=list)


def check_system(raw: Mapping[str, Any]) -> CheckedSystem:
    """Check the table ``system`` as the file holds it."""
    table, problems = validate(SystemTable, raw, ("system",))
    checked = CheckedSystem(problems=problems)
    if ("model" in raw) == ("definition" in raw):
        both = "model and definition are both given; leave one of them out"
        neither = "missing; name a system of the shelf, or write one as [system.definition]"
        fault = Problem(("system", "definition"), both) if "model" in raw else Problem(("system", "model"), neither)
        problems.append(fault)
    elif isinstance(raw.get("model"), str):
        checked.model = raw["model"]
        _look_up(checked, table_in(raw, "effects"))
    elif isinstance(raw.get("definition"), Mapping):
        checked.definition = dict(raw["definition"])
        checked.known = dict(table_in(raw, "parameters"))
        checked.states, faults = check_definition(checked.definition, checked.known, table_in(raw, "effects"))
        problems += faults
    if checked.known is not None:
        for name in table_in(raw, "parameters"):
            if name not in checked.known:
                place = ("system", "parameters", name)
                problems.append(Problem(place, f"unknown parameter; {remedy(name, checked.known)}"))
    if checked.states is not None:
        problems += check_state(table_in(raw, "initial"), checked.states, ("system", "initial"))
    given = dict(table_in(raw, "parameters"))
    if table_in(raw, "si") and checked.known is not None:
        if checked.model in LIMITS:
            checked.si, faults = read_si(raw["si"], given, checked.known)
            beyond = check_limits(checked.model, checked.si.parameters, ("system", "si"))
            # a parameter made of several quantities has no line of its own
            problems += faults + [replace(fault, path=("system", "si")) for fault in beyond]
            checked.parameters = checked.si.parameters
        else:
            problems.append(Problem(("system", "si"), f"only {' and '.join(LIMITS)} can be given in SI units"))
    problems += check_limits(checked.model, given, ("system", "parameters"))
    if table is not None:
        checked.parameters = {**checked.parameters, **table.parameters}
        checked.initial = table.initial
    return checked


def check_state(given: Mapping[str, Any], states: tuple[str, ...], at: tuple[str | int, ...]) -> list[Problem]:
    """Check the names and types of a table of initial values."""
    problems = []
    for name, value in given.items():
        if name == "mode":
            if not isinstance(value, str):
                problems.append(Problem((*at, name), f"expected the name of a mode, received {value!r:.60}"))
        elif name not in states:
            problems.append(Problem((*at, name), f"unknown state; {remedy(name, ('mode', *states))}"))
        elif isinstance(value, str):
            problems.append(Problem((*at, name), f"expected a number, received {value!r:.60}"))
    return problems


def check_limits(model: str, values: Mapping[str, Any], at: tuple[str | int, ...]) -> list[Problem]:
    """Check numbers against the limits of the model's parameters."""
    problems = []
    for name, limit in LIMITS.get(model, {}).items():
        value = values.get(name)
        # what is no finite number is a fault of another kind
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= MOST:
            continue
        if fault := limit.refuses(value):
            problems.append(Problem((*at, name), fault))
    return problems


def _look_up(checked: CheckedSystem, effects: Mapping[str, Any]) -> None:
    """Find the model's parameters and states; with a wrong effect, all that it could have."""
    from chaosdrill import systems

    entry = systems.REGISTRY.get(checked.model)
    if entry is None:
        fault = f"unknown model {checked.model!r:.60}; {remedy(checked.model, systems.REGISTRY)}"
        checked.problems.append(Problem(("system", "model"), fault))
        return
    faults: list[Problem] = []
    texts = {effect: option for effect, option in effects.items() if isinstance(option, str)}
    for effect, option in texts.items():
        place = ("system", "effects", effect)
        if not entry.effects:
            faults.append(Problem(place, f"{checked.model} is not assembled from effects; leave them out"))
        elif effect not in systems.EFFECTS:
            faults.append(Problem(place, f"unknown effect; {remedy(effect, systems.EFFECTS)}"))
        elif option not in systems.EFFECTS[effect]:
            fault = f"unknown option {option!r:.60}; {remedy(option, systems.EFFECTS[effect])}"
            faults.append(Problem(place, fault))
        else:
            checked.effects[effect] = option
    chosen = checked.effects if entry.effects else None
    certain = not faults and len(texts) == len(effects)
    try:
        checked.known = systems.parameters(checked.model, chosen)
        checked.states = systems.states(checked.model, chosen)
    except ModelError as fault:
        if certain:
            faults.append(Problem(("system", "effects"), str(fault)))
        certain = False
    if entry.effects and not certain:
        checked.known, checked.states = _widest(checked.model)
    checked.problems += faults


def _widest(model: str) -> tuple[dict[str, float], tuple[str, ...]]:
    """Every parameter and state that some choice of effects has."""
    from chaosdrill import systems

    known: dict[str, float] = {}
    states: dict[str, None] = {}
    for options in product(*systems.EFFECTS.values()):
        chosen = dict(zip(systems.EFFECTS, options, strict=True))
        try:
            known |= systems.parameters(model, chosen)
            states |= dict.fromkeys(systems.states(model, chosen))
        except ModelError:
            continue
    return known, tuple(states)


def table_in(raw: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """A table of the file, or nothing where there is none or something else."""
    found = raw.get(name)
    return found if isinstance(found, Mapping) else {}

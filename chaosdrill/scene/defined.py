"""Systems defined in scenes: checks and derivations of an earlier process are not repeated."""

import json
from collections.abc import Mapping
from functools import partial
from hashlib import sha256
from typing import Any, NamedTuple

from chaosdrill import systems
from chaosdrill.model import HybridSystem
from chaosdrill.model.tables import finite
from chaosdrill.scene.check_made import driven_system, filippov_system, halved_system


def checked_before(definition: Mapping[str, Any], parameters: Mapping[str, Any]) -> HybridSystem | None:
    """The system of a definition that was run before, and so has no faults; any initial state is allowed.

    ``definition``: the table of the scene. ``parameters``: all parameters, in order.
    """
    key = _key(definition, parameters)
    return None if key is None else _kind(definition).known(key, partial(_build, definition, parameters), {})


def sliding_before(table: Mapping[str, Any], *given: Mapping[str, Any]) -> HybridSystem | None:
    """The system of two fields and a surface that were run before, and so have no faults, with its definition.

    ``given``: parameters, and the initial state.
    """
    key = _made_key("filippov", table, *given)
    make = partial(filippov_system, table, *given)
    found = None if key is None else HybridSystem.known(key, make, {})
    return found if found is not None and isinstance(found.shared.get("definition"), dict) else None


def sliding(table: Mapping[str, Any], *given: Mapping[str, Any]) -> tuple[HybridSystem, dict[str, Any]]:
    """The system of two fields and a surface, and its definition; both are kept.

    Raises `ChaosdrillError` if they make none.
    """
    found = sliding_before(table, *given)
    if found is None:
        from chaosdrill.codegen.record import remember
        from chaosdrill.model.definition import write_definition

        found = filippov_system(table, *given)
        write_definition(found)
        if (key := _made_key("filippov", table, *given)) is not None:
            remember(found.enlisted(key))
    return found, dict(found.shared["definition"])


class Recipe(NamedTuple):
    """What makes a system with drives, or one over half of its motion."""

    model: str
    definition: Mapping[str, Any] | None
    effects: Mapping[str, str]
    parameters: Mapping[str, Any]
    initial: Mapping[str, Any]
    drives: Mapping[str, Any]
    symmetry: Mapping[str, str]

    @property
    def key(self) -> tuple[str, ...] | None:
        """Under which it is kept; None for what no table of a scene holds."""
        tables = [self.model, self.definition, self.effects, self.drives, self.symmetry]
        return _made_key("made", tables, self.parameters, self.initial)

    def before(self) -> HybridSystem | None:
        """The system, if it was run before, and so has no faults."""
        key = self.key
        if key is None or (self.definition is None and self.model not in systems.REGISTRY):
            return None
        kind = HybridSystem if self.definition is None else _kind(self.definition)
        found = kind.known(key, partial(_make, self), {})
        if found is None or self.definition is not None:
            return found
        return found.limited(systems.limits(self.model, self._effects()))

    def undriven(self, *, kept: bool = False) -> HybridSystem:
        """The system without its drives and its symmetry, in its own first mode.

        With ``kept`` the derived parts of a definition are kept, but not for a system with drives, which may have
        parameters that only these use.
        """
        start = {name: value for name, value in self.initial.items() if name != "mode"}
        if self.definition is not None:
            key = _key(self.definition, self.parameters) if kept else None
            make = partial(_build, self.definition, self.parameters)
            return (make() if key is None else _kind(self.definition).listed(key, make, {})).begun(start)
        return systems.build(self.model, parameters=self.parameters, effects=self._effects(), initial=start)

    def _effects(self) -> Mapping[str, str] | None:
        return self.effects if systems.REGISTRY[self.model].effects else None


def _make(one: Recipe) -> HybridSystem:
    system = one.undriven()
    if "mode" in one.initial:
        system = system.with_initial(mode=one.initial["mode"])
    found: HybridSystem = halved_system(driven_system(system, one.drives), one.symmetry)
    return found


def _build(definition: Mapping[str, Any], parameters: Mapping[str, Any]) -> HybridSystem:
    from chaosdrill.model.definition import build_defined

    return build_defined(definition, parameters)


def _kind(definition: Mapping[str, Any]) -> type[HybridSystem]:
    from chaosdrill.model import Map

    return Map if "images" in definition else HybridSystem


def _key(definition: Mapping[str, Any], parameters: Mapping[str, Any]) -> tuple[str, ...] | None:
    """Everything that determines the system; None for systems that no scene can hold."""
    return _made_key("scene", definition, parameters, {})


def _made_key(
    kind: str, tables: Any, parameters: Mapping[str, Any], initial: Mapping[str, Any]
) -> tuple[str, ...] | None:
    numbers = {name: finite(value) for name, value in parameters.items()}
    start = {name: value if isinstance(value, str) else finite(value) for name, value in initial.items()}
    if None in numbers.values() or None in start.values():
        return None
    try:
        text = json.dumps([tables, list(numbers.items()), *([start] if start else [])])
    except (TypeError, ValueError, RecursionError):
        return None
    return kind, sha256(text.encode()).hexdigest()

"""Systems that scenes define: what an earlier process has checked and derived of one is not done again."""

import json
from collections.abc import Mapping
from functools import partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from chaosdrill.model.tables import finite

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def checked_before(definition: Mapping[str, Any], parameters: Mapping[str, Any]) -> "HybridSystem | None":
    """The system of a definition that was run before, and so has no faults; it starts anywhere.

    Parameters
    ----------
    definition : mapping
        The table of the scene.
    parameters : mapping of str to value
        All parameters, in order.
    """
    from chaosdrill.model import HybridSystem

    key = _key(definition, parameters)
    return None if key is None else HybridSystem.known(key, partial(_build, definition, parameters), {})


def build(
    definition: Mapping[str, Any], parameters: Mapping[str, float], initial: Mapping[str, Any], *, kept: bool
) -> "HybridSystem":
    """The system of a definition that has been checked; as `chaosdrill.model.definition.build_defined`.

    With ``kept`` what is derived of it is kept. One with drives may have parameters that only these use, and is not.
    """
    from chaosdrill.model import HybridSystem

    key = _key(definition, parameters) if kept else None
    make = partial(_build, definition, parameters)
    return (make() if key is None else HybridSystem.listed(key, make, {})).begun(initial)


def _build(definition: Mapping[str, Any], parameters: Mapping[str, Any]) -> "HybridSystem":
    from chaosdrill.model.definition import build_defined

    return build_defined(definition, parameters)


def _key(definition: Mapping[str, Any], parameters: Mapping[str, Any]) -> tuple[str, ...] | None:
    """All that makes the system; None for a map, and for what no table of a scene holds."""
    numbers = {name: finite(value) for name, value in parameters.items()}
    if "images" in definition or None in numbers.values():
        return None
    try:
        text = json.dumps([definition, list(numbers.items())])
    except (TypeError, ValueError, RecursionError):
        return None
    return "scene", sha256(text.encode()).hexdigest()

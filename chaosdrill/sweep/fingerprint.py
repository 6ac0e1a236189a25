"""Differences between two descriptions of a task."""

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.dataset.provenance import library_versions, to_json
from chaosdrill.sweep.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


def origin() -> dict[str, Any]:
    """Versions of all numerical libraries, and a key of the package's own numerical code."""
    from chaosdrill.codegen.cache import code_key

    return {"versions": library_versions(), "package source": code_key()}


def of_system(system: "HybridSystem") -> dict[str, Any]:
    """Equations, parameters and initial state of a system."""
    if "texts" not in system.shared:
        system.shared["texts"] = _texts(system)
    return {
        "name": system.name,
        "parameters": system.parameters,
        "initial": system.start,
        "bounds": system.bounds,
        **system.shared["texts"],
    }


def _texts(system: "HybridSystem") -> dict[str, Any]:
    """The equations, with all digits of their numbers."""
    from chaosdrill.model.text import Digits

    text = Digits().doprint
    return {
        "regions": {mode: text(region) for mode, region in system.regions.items()},
        "modes": {mode: {str(s): text(rate) for s, rate in field.items()} for mode, field in system.modes.items()},
        "transitions": [text(transition.content()) for transition in system.transitions],
        "period": text(system.period),
        "quadratures": {
            name: {mode: text(e) for mode, e in rates.items()} for name, rates in system.quadratures.items()
        },
    }


def plain(fingerprint: Mapping[str, Any]) -> dict[str, Any]:
    """The description as JSON gives it back, so that it can be compared with one from a file."""
    read: dict[str, Any] = json.loads(to_json(fingerprint))
    return read


def changes(before: Any, now: Any) -> list[str]:
    """What differs, a line each: ``parameters.eta: 0.448 before, 0.45 now``."""
    found = list(_changes(before, now, ""))
    more = len(found) - TUNING.differences_shown
    return [*found[: TUNING.differences_shown], f"and {more} more"] if more > 0 else found


def _changes(before: Any, now: Any, path: str) -> Iterator[str]:
    if isinstance(before, dict) and isinstance(now, dict):
        for key in [*before, *(key for key in now if key not in before)]:
            place = f"{path}.{key}" if path else str(key)
            if key in now and key in before:
                yield from _changes(before[key], now[key], place)
            else:
                was, here = (_short(side[key]) if key in side else "absent" for side in (before, now))
                yield f"{place}: {was} before, {here} now"
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for index, (one, other) in enumerate(zip(before, now, strict=True)):
            yield from _changes(one, other, f"{path}[{index}]")
    elif isinstance(before, list) and isinstance(now, list):
        yield f"{path}: {len(before)} entries before, {len(now)} now"
    # as text NaN equals itself
    elif json.dumps(before) != json.dumps(now):
        yield f"{path}: {_short(before)} before, {_short(now)} now"


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= TUNING.letters_shown else f"{text[: TUNING.letters_shown - 3]}..."

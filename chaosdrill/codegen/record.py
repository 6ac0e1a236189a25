"""What was derived of a system, kept on the disk as plain data, so that another process needs no sympy.

A record holds the outline of a system of the library or of a scene, what is known of its structure, and where its
compiled code is; it is JSON, of which nothing is run. It lies beside compiled code, whole, where nobody else can write,
under a key of all code that derives and of what makes the system. One that is damaged, or another system's, is as good
as none.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from chaosdrill.codegen.cache import RECORD, cache_folder, keep, read
from chaosdrill.codegen.layout import Layout
from chaosdrill.codegen.tuning import TUNING
from chaosdrill.dataset.provenance import library_versions
from chaosdrill.model.outline import WholeSystem, attributes
from chaosdrill.model.system import RELATED
from chaosdrill.package import modules, source

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem, Shared

_FOLDERS = ("model", "codegen", "systems", "systems.drill")
_FILES = (
    *("engine.setup", "engine.structure", "engine.period", "analysis.judgement.classification", "sweep.fingerprint"),
    *("equilibrium.expressions", "equilibrium.fields"),
    *("declared", "scene.checks", "scene.defined", "scene.check_made"),
    *("orbits.residual", "orbits.expressions", "orbits.functions", "orbits.verification", "orbits.neutral"),
    "analysis.measures.orders",
)
"""What derives, and what checks the definition of a scene, beside `_FOLDERS`."""


def _pairs(plain: Any) -> frozenset[tuple[int, int]]:
    return frozenset((int(one), int(other)) for one, other in plain)


_GROWING = ("formulas", "fields of equilibria")
"""Facts to which more is added as it is asked for."""

_FACTS: Mapping[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    **dict.fromkeys(("autonomous", "contracts", "repeats"), (bool, bool)),
    **dict.fromkeys(("symmetries", "lines", "turns", "conserved", "branching", "pins", "frozen"), (list, list)),
    **dict.fromkeys(("period by math", "period by numpy"), (list, list)),
    "always_passed": (sorted, _pairs),
    "definition": (lambda found: found, lambda found: found),
    **dict.fromkeys(("regions", "texts"), (dict, dict)),
    "sources": (dict, dict),
    **dict.fromkeys(_GROWING, (dict, dict)),
}
"""What is kept of `Shared`, by its name there: how it is written, and how it is read."""


class KeptCode(NamedTuple):
    """Functions that were compiled together, and where their machine code is kept."""

    names: tuple[str, ...]
    imports: tuple[str, ...]
    """Special functions that it calls."""
    key: str


class Held(NamedTuple):
    """Functions that were compiled, and where their code is."""

    layout: Layout
    single: tuple[KeptCode, ...]
    lanes: KeptCode | None
    processor: tuple[str, str]
    """For which the code is."""


@cache
def _deriving() -> str:
    """Digest of all that derives."""
    digest = hashlib.sha256(repr((library_versions(), version("llvmlite"))).encode())
    names = [f"{folder}.{name}" for folder in _FOLDERS for name in modules(folder.replace(".", "/"))]
    for name in (*names, *_FILES):
        digest.update(source(f"chaosdrill.{name}"))
    return digest.hexdigest()


def place(key: tuple[str, ...]) -> Path:
    """The file of the record of a system."""
    digest = hashlib.sha256(json.dumps([_deriving(), key]).encode()).hexdigest()
    return cache_folder() / "kernels" / f"{digest[:32]}{RECORD}"


def recall(shared: "Shared") -> bool:
    """Put in what the record of a system holds; whether there is one."""
    assert shared.key is not None
    content = read(place(shared.key))
    try:
        found = json.loads(content or b"null")
        if found is None or found["key"] != list(shared.key):
            return False
        facts = {name: _FACTS[name][1](value) for name, value in found["facts"].items()}
        kernels = {
            tuple((str(name), int(value)) for name, value in key): Held(
                Layout.of(layout), tuple(map(_code, single)), None if lanes is None else _code(lanes), tuple(processor)
            )
            for key, (layout, single, lanes, processor) in found["kernels"]
        }
        attributes(found["outline"], WholeSystem(_nothing))
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return False
    shared.outline, shared.held = found["outline"], kernels
    shared.recalled = frozenset(_names(facts, kernels))
    for name, value in facts.items():
        shared.setdefault(name, value)
    return True


def remember(system: "HybridSystem") -> None:
    """Keep what is known of a system of the library, or of a scene, if that is more than its record holds.

    So it is with the systems that were derived from it, and with one that is needed first.
    """
    shared = system.shared
    for other in list(shared.get(RELATED, {}).values()):
        if other.shared is not shared:
            remember(other)
    if shared.origin is not None:
        _remember(shared.origin.shared)
    _remember(shared)


def _remember(shared: "Shared") -> None:
    if shared.key is None or shared.outline is None:
        return
    facts = {
        name: value
        for name, value in list(shared.items())
        if name in _FACTS and not callable(value) and (name != "sources" or not value)
    }
    compiled = {key: getattr(one, "holds", None) for key, one in list(shared.items())}
    kernels = {**shared.held, **{key: held for key, held in compiled.items() if isinstance(held, Held)}}
    if _names(facts, kernels) <= shared.recalled:
        return
    content = {
        "key": shared.key,
        "outline": shared.outline,
        "facts": {name: _FACTS[name][0](value) for name, value in facts.items()},
        "kernels": [[key, held] for key, held in kernels.items()],
    }
    text = json.dumps(content).encode()
    if len(text) <= TUNING.record_bytes:
        keep(place(shared.key), text)
        shared.recalled = _names(facts, kernels)


def _nothing() -> Any:
    raise NotImplementedError


def _names(facts: Mapping[str, Any], kernels: Mapping[Any, Held]) -> frozenset[Any]:
    """What a record holds, by name."""
    more = ((name, part) for name in _GROWING for part in facts.get(name, ()))
    return frozenset({*facts, *more, *((key, held.lanes is not None, held.processor) for key, held in kernels.items())})


def _code(plain: Any) -> KeptCode:
    names, imports, key = plain
    if not isinstance(key, str) or not key.isalnum():
        raise ValueError(key)
    return KeptCode(tuple(names), tuple(imports), key)

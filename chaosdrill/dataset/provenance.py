"""Provenance of a dataset, as attributes that NetCDF can store."""

import json
import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from numbers import Integral, Real
from typing import Any

from chaosdrill.dataset.references import package, references
from chaosdrill.errors import ModelError
from chaosdrill.version import __version__

CONVENTIONS = "CF-1.11, ACDD-1.3"

FORMAT = 4
"""Version of the layout of archives.

1: without this number, and without the attributes of ACDD and the digests. 2: without the definitions of systems.
"""

DERIVED = "derived"
"""Attribute of a dataset that a function of this package made of another: what was done."""

LIBRARIES = ("numpy", "numba", "sympy", "xarray", "netCDF4")


def provenance(
    title: str,
    *,
    action: str,
    kind: str | None = None,
    variables: Iterable[str] = (),
    system: Any = None,
    settings: Mapping[str, Any] | None = None,
    scene: Any = None,
) -> dict[str, str | float | int]:
    """Attributes that describe the origin of a dataset or an archive: text and numbers only, the rest as JSON text.

    NetCDF holds neither None nor bool nor dict. The names are those of CF-1.11 and ACDD-1.3 where these have one.

    ``title``: what the data are, in a few words. ``action``: what was done, for the history line; the time (UTC) and
    the version are put in front of it. ``variables``: names of the variables, since some methods are used only where
    their results are there. ``system``: that which was run; its name, definition, parameters and initial state are
    recorded, and the reason where no text can hold its definition. ``settings``: arguments of the analysis, of which
    ``method``, ``tolerance`` and the number that seeds random states become attributes of their own. ``scene``: for the
    root of an archive: its text, name and SHA-256, and its scales if it is in SI.
    """
    stamp = now()
    attributes: dict[str, str | float | int] = {
        "Conventions": CONVENTIONS,
        "format_version": FORMAT,
        "title": title,
        "summary": f"Simulation of a hybrid dynamical system: {title}.",
        "keywords": ", ".join(("hybrid dynamical system", "chaos", "simulation", *((kind,) if kind else ()))),
        "history": f"{stamp} {signature()}: {action}",
        "date_created": stamp,
        "processing_level": "computed from a model; no observations",
        "versions": to_json(library_versions()),
        "platform": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
    }
    if kind is not None:
        attributes["kind"] = kind
    if system is not None:
        attributes["system"] = system.name
        attributes |= _definition(system)
        attributes["parameters"] = to_json(system.parameters)
        attributes["initial"] = to_json({str(name): value for name, value in system.start.items()})
    if settings is not None:
        attributes |= _of_settings(settings)
    if scene is not None:
        attributes |= {"scene": scene.text, "scene_name": scene.name, "scene_sha256": scene.sha256}
        attributes |= {f"si_{name}": value for name, value in scene.scales.items()}
    attributes["source"] = _source(attributes)
    attributes["references"] = "\n".join(entry.text() for entry in (package(), *references(attributes, variables)))
    return attributes


def drawn(noise: Mapping[str, Any]) -> dict[str, str]:
    """How parameters are drawn anew, in words, from the table ``noise`` of a system or of its definition."""
    found = {}
    for name, one in noise.items():
        when = f"drawn anew at {' and '.join(one['at'])}" if one["at"] else "without spread, so that it is not drawn"
        found[str(name)] = f"{one['distribution']}, {when}"
    return found


def now() -> str:
    """The time in UTC, as ISO 8601."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def signature() -> str:
    """Name and version of the package."""
    return f"chaosdrill {__version__}"


def _definition(system: Any) -> dict[str, str]:
    from chaosdrill.model.system import SYSTEM

    if not SYSTEM.holds(system):
        return {}
    if "definition" not in system.shared:
        from chaosdrill.model.definition import write_definition

        with suppress(ModelError):
            write_definition(system)
    found = system.shared["definition"]
    if not isinstance(found, str):
        return {"definition": to_json(found)}
    derived = {}
    if system.sources:
        from chaosdrill.model.python import DERIVATIVES

        derived = {"derivatives": DERIVATIVES}
    return {"definition_missing": found, **derived}


def _of_settings(settings: Mapping[str, Any]) -> dict[str, str | float | int]:
    found: dict[str, str | float | int] = {}
    if settings.get("method") is not None:
        found["method"] = str(settings["method"])
    if settings.get("tolerance") is not None:
        found["tolerance"] = float(settings["tolerance"])
    random = settings.get("random")
    if isinstance(random, Mapping) and "seed" in random:
        found["random_seed"] = int(random["seed"])
    return found | {"settings": to_json(settings)}


def _source(attributes: Mapping[str, Any]) -> str:
    """The model and its version, as CF requires."""
    parts = [signature()]
    for name in ("system", "method", "tolerance"):
        if name in attributes:
            parts.append(f"{name} {attributes[name]}")
    return ", ".join(parts)


@cache
def library_versions() -> dict[str, str]:
    """Versions of the package and of the libraries that its numbers depend on."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"chaosdrill": __version__}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def to_json(value: Any) -> str:
    """JSON text of nested mappings, arrays and numbers; floats keep every bit."""
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    """Convert values that ``json`` does not handle: NumPy scalars and arrays, other numbers, and named objects."""
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value)
    return value.tolist() if hasattr(value, "tolist") else str(value)

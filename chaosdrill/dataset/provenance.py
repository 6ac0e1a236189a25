"""Where a dataset came from, as attributes that NetCDF can hold."""

import json
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from typing import Any

CONVENTIONS = "CF-1.11"
LIBRARIES = ("numpy", "numba", "sympy", "xarray", "netCDF4")


def provenance(
    title: str, *, action: str, system: Any = None, settings: Mapping[str, Any] | None = None
) -> dict[str, str | float]:
    """All attributes that say where a dataset or an archive came from.

    Parameters
    ----------
    title : str
        What the data are, in a few words.
    action : str
        What was done, for the history line; the time (UTC) and the version are put in front of it.
    system : HybridSystem, optional
        The system that was run; its name, parameters and initial state are recorded.
    settings : mapping, optional
        Arguments of the analysis. ``method`` and ``tolerance`` become attributes of their own.

    Returns
    -------
    dict
        Text and numbers only: NetCDF holds neither None nor bool nor dict, so the rest is JSON text.
    """
    import chaosdrill

    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    attributes: dict[str, str | float] = {
        "Conventions": CONVENTIONS,
        "title": title,
        "history": f"{now} chaosdrill {chaosdrill.__version__}: {action}",
        "versions": to_json(library_versions()),
        "platform": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
    }
    if system is not None:
        attributes["system"] = system.name
        attributes["parameters"] = to_json(system.parameters)
        attributes["initial"] = to_json({str(name): value for name, value in system.initial.items()})
    if settings is not None:
        if settings.get("method") is not None:
            attributes["method"] = str(settings["method"])
        if settings.get("tolerance") is not None:
            attributes["tolerance"] = float(settings["tolerance"])
        attributes["settings"] = to_json(settings)
    return attributes


@cache
def library_versions() -> dict[str, str]:
    """Versions of the package and of the libraries that its numbers depend on."""
    from importlib.metadata import PackageNotFoundError, version

    import chaosdrill

    found = {"chaosdrill": chaosdrill.__version__}
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
    """What ``json`` does not know: NumPy scalars and arrays, and things that have only a name."""
    return value.tolist() if hasattr(value, "tolist") else str(value)

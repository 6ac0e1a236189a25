"""An analysis is run again from what its dataset holds: the definition of its system, numbers, and arguments."""

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.registry import analyses, function
from chaosdrill.dataset.provenance import DERIVED
from chaosdrill.errors import ArchiveError

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.model import HybridSystem

_NEEDED = ("definition", "parameters", "initial", "settings")


def hindrance(ds: "xr.Dataset") -> str | None:
    """Why a dataset cannot be computed again from what it holds; None if nothing speaks against it."""
    kind = ds.attrs.get("kind")
    if not isinstance(kind, str) or kind not in analyses():
        return "it is not the result of an analysis"
    if DERIVED in ds.attrs:
        return f"it was derived from the result of an analysis: {ds.attrs[DERIVED]!s:.200}"
    if any(str(name).endswith("_si") for name in ds.variables):
        return "it contains SI units, which only the archive of its scene can reproduce"
    if "definition" not in ds.attrs and "definition_missing" in ds.attrs:
        return f"its system cannot be written as text: {ds.attrs['definition_missing']!s:.500}"
    missing = [name for name in _NEEDED if name not in ds.attrs]
    if missing:
        return f"it has no attribute {missing[0]!r}, as in archives written by {_who(ds)}"
    return None


def system_of(ds: "xr.Dataset") -> "HybridSystem":
    """The system that a dataset was made with, from its definition.

    Raises
    ------
    ChaosdrillError
        If the definition, the parameters or the initial state cannot be read.
    """
    from chaosdrill.model.definition import build_defined

    definition, parameters, initial = (_table(ds, name) for name in _NEEDED[:3])
    return build_defined(definition, parameters, initial)


def rerun(ds: "xr.Dataset", *, workers: int = 1, progress: Callable[..., None] | None = None) -> "xr.Dataset":
    """What the analysis of a dataset gives now.

    Parameters
    ----------
    ds : xarray.Dataset
        One without `hindrance`.
    workers : int
        Points computed at a time, where the analysis has several.
    progress : callable, optional
        As for the analyses.

    Raises
    ------
    ChaosdrillError
        If the system cannot be read, or the analysis cannot be run with its arguments.
    """
    entry = analyses()[ds.attrs["kind"]]
    keywords = _table(ds, "settings")
    if unknown := [name for name in keywords if name not in entry.told()]:
        raise ArchiveError(f"settings: {entry.function} of this version has no argument {unknown[0]!r:.60}")
    if entry.settings.parallel:
        keywords["workers"] = workers
    result: xr.Dataset = function(entry.function)(system_of(ds), **keywords, progress=progress)
    return result


def _who(ds: "xr.Dataset") -> str:
    number = ds.attrs.get("format_version", 1)
    return f"versions of format {number!s:.20}" if number in (1, 2) else "other programs"


def _table(ds: "xr.Dataset", name: str) -> dict[str, Any]:
    try:
        found = json.loads(ds.attrs[name])
    except (TypeError, ValueError, RecursionError) as fault:
        raise ArchiveError(f"{name}: not JSON: {fault!s:.200}") from None
    if not isinstance(found, Mapping):
        raise ArchiveError(f"{name}: expected a table, received {found!r:.60}")
    return dict(found)

"""Contents and origin of an archive, and its references."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.archive.digest import DIGESTS, altered, unsealed
from chaosdrill.archive.read import groups_of, open_archive, read_archive
from chaosdrill.dataset.branches import count_special_points
from chaosdrill.dataset.outcomes import count_outcomes
from chaosdrill.dataset.provenance import drawn
from chaosdrill.dataset.references import Reference, mapping, package, references
from chaosdrill.errors import ArchiveError
from chaosdrill.typed import PATH, expecting
from chaosdrill.workflow.run_scene import hindrance

_ORIGIN = (
    *("title", "history", "platform", "wall_time_s", "scene_name", "scene_sha256"),
    *("si_time_s", "si_length_m", "si_force_N"),
)


@expecting(ArchiveError, path=PATH)
def info(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Describe an archive.

    Parameters
    ----------
    path : path-like
        The archive.

    Returns
    -------
    dict
        Plain values, ready for JSON: ``path``, ``bytes``, the origin from the root's attributes, ``quantities``
        (numbers of the root, as those of a scene in SI units: value, units, long name), and ``groups``: name ->
        ``kind``, ``system``, ``method``, ``tolerance``, ``dimensions``, ``variables`` (name -> dimensions, dtype,
        units, long name), ``noise`` (parameter -> how it is drawn, if any is), ``repeatable`` (from what `verify` would
        repeat it, or why it cannot), ``outcomes`` and ``special_points`` (name -> count), and ``altered``, the
        variables that were altered after writing (":" for attributes of the group), if any, and ``without_digests``,
        where that is unknown. The root likewise, with ":scene" for a scene whose SHA-256 differs from the stored one.
        ``unsealed`` says in a sentence which groups hold no digests, and is empty if none. An archive that was saved
        from Python has the ``versions`` of its groups.

    Raises
    ------
    ArchiveError
        If the archive cannot be opened.
    """
    tree = read_archive(path)
    described: dict[str, Any] = {"path": str(path), "bytes": Path(path).stat().st_size}
    described |= {name: _plain(tree.attrs[name]) for name in _ORIGIN if name in tree.attrs}
    described["versions"] = stored_versions(tree.attrs) or _versions_of_groups(tree)
    if "kind" not in tree.attrs and (changed := altered(tree.to_dataset(inherit=False))):
        described["altered"] = changed
    described["unsealed"] = unsealed(tree)
    described["quantities"] = {
        str(name): {"value": _plain(variable.values), **_about(variable.attrs)}
        for name, variable in tree.to_dataset().data_vars.items()
        if variable.ndim == 0 and "kind" not in tree.attrs
    }
    described["groups"] = {
        path: _group(group, "scene" in tree.attrs) for path, group in groups_of(tree).items() if "kind" in group.attrs
    }
    return described


def stored_versions(attributes: Mapping[Any, Any]) -> dict[str, str]:
    """Versions of the package and its libraries, from the attributes that they wrote; empty if they cannot be read."""
    return {name: str(version) for name, version in mapping(attributes.get("versions")).items()}


def _versions_of_groups(tree: DataTree) -> dict[str, str]:
    """Versions named by the groups; several of a library if their origins differ."""
    found: dict[str, dict[str, None]] = {}
    for node in tree.subtree:
        for name, version in stored_versions(node.attrs).items():
            found.setdefault(name, {})[version] = None
    return {name: " and ".join(versions) for name, versions in found.items()}


def _group(group: Dataset, scene: bool) -> dict[str, Any]:
    kept = ("kind", "system", "method", "tolerance", "wall_time_s")
    described = {name: _plain(group.attrs[name]) for name in kept if name in group.attrs}
    described["dimensions"] = {str(name): size for name, size in group.sizes.items()}
    described["variables"] = {
        str(name): {
            "dimensions": [str(dim) for dim in variable.dims],
            "dtype": "text" if variable.dtype.kind in "OUT" else str(variable.dtype),
            **_about(variable.attrs),
        }
        for name, variable in group.variables.items()
    }
    why_not = None if scene else hindrance(group)
    origin = "from the scene" if scene else "from the definition of its system"
    described["repeatable"] = origin if why_not is None else f"no: {why_not}"
    if changed := altered(group):
        described["altered"] = changed
    if DIGESTS not in group.attrs:
        described["without_digests"] = True
    if noise := _noise(group):
        described["noise"] = noise
    if "outcome" in group:
        described["outcomes"] = count_outcomes(group["outcome"].values)
    if "special_kind" in group:
        described["special_points"] = count_special_points(group["special_kind"])
    return described


def _about(attributes: Mapping[Any, Any]) -> dict[str, str]:
    return {name: str(attributes.get(name, "")) for name in ("units", "long_name")}


def _noise(group: Dataset) -> dict[str, str]:
    """How the parameters of a system are drawn, by the definition that a group holds."""
    try:
        return drawn(json.loads(group.attrs["definition"]).get("noise", {}))
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError):
        return {}


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


@expecting(ArchiveError, path=PATH)
def cite(path: str | os.PathLike[str]) -> list[Reference]:
    """References for an archive: this package, and its analyses, methods and systems.

    Parameters
    ----------
    path : path-like
        The archive.

    Returns
    -------
    list of Reference
        Each once, the package first. ``text()`` is a line to read, ``bibtex()`` an entry for BibTeX.

    Raises
    ------
    ArchiveError
        If the archive cannot be opened.
    """
    return references_in(open_archive(path))


def references_in(tree: DataTree) -> list[Reference]:
    """The references of an archive that is open."""
    found = [package()]
    for group in groups_of(tree).values():
        if "kind" in group.attrs:
            found += references(group.attrs, [str(name) for name in group.variables])
    return list(dict.fromkeys(found))

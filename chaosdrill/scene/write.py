"""Write a system defined in Python as a scene for the command line."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from chaosdrill.archive import check_writable, writing
from chaosdrill.errors import ArchiveError, SceneError
from chaosdrill.model.system import SYSTEM, HybridSystem
from chaosdrill.scene.changes import bare_or_quoted, toml_value
from chaosdrill.scene.load import parse_scene
from chaosdrill.typed import PATH, TABLE, TABLES, TEXT, expecting

_HEADERS = {"system": 4, "analysis": 2, "numerics": 1}
"""Depth to which tables have their own header; deeper tables stand on one line."""


@expecting(SceneError, path=PATH, system=SYSTEM, analyses=TABLES, numerics=TABLE, title=TEXT)
def save_scene(
    path: str | os.PathLike[str],
    system: HybridSystem,
    analyses: Mapping[str, Mapping[str, Any]],
    *,
    title: str | None = None,
    numerics: Mapping[str, Any] | None = None,
) -> Path:
    """Write a scene that defines a system, for ``chaosdrill run`` and all other commands.

    Parameters
    ----------
    path : path-like
        Target file; an earlier one is replaced.
    system : HybridSystem
        Its equations, parameters and initial state are written as text and numbers, to the last bit.
    analyses : mapping of str to mapping
        The analyses, by group of the archive, with the keys of a scene: ``{"spectrum": {"kind": "lyapunov-spectrum",
        "periods": 5000, "transient": 200}}``.
    title : str, optional
        Default: the name of the system.
    numerics : mapping, optional
        ``method``, ``tolerance`` and ``steps``.

    Returns
    -------
    pathlib.Path
        The target.

    Raises
    ------
    ModelError
        If the system cannot be written as text, with the reason.
    SceneError
        If the scene would have faults, or the file cannot be written.
    SettingsError
        If a value cannot be written in TOML.
    """
    from chaosdrill.model.definition import write_definition

    document = {
        "title": system.name if title is None else title,
        "system": {
            "map" if system.discrete else "definition": write_definition(system),
            "parameters": dict(system.parameters),
            "initial": system.start,
        },
        "numerics": dict(numerics or {}),
        "analysis": {name: dict(keys) for name, keys in analyses.items()},
    }
    target = Path(path)
    text = "\n".join(_lines({name: value for name, value in document.items() if value != {}}, ())).strip() + "\n"
    parse_scene(text, target.name)
    try:
        check_writable(target, ".toml")
        with writing(target, "scene") as draft:
            draft.write_text(text, encoding="utf-8")
    except ArchiveError as fault:
        raise SceneError(str(fault)) from fault
    return target


def _lines(table: Mapping[str, Any], path: tuple[str, ...], *, flat: bool = False) -> Iterator[str]:
    """Values of a table, then the tables in it, each below its header; all on one line each if ``flat``."""
    later = {}
    for name, value in table.items():
        if not flat and _has_header(value, (*path, name)):
            later[name] = value
        else:
            yield f"{bare_or_quoted(name)} = {toml_value(value, '.'.join((*path, name)))}"
    for name, value in later.items():
        inner = (*path, name)
        header = ".".join(map(bare_or_quoted, inner))
        if isinstance(value, list):
            for entry in value:
                yield f"\n[[{header}]]"
                yield from _lines(entry, inner, flat=True)
        else:
            if any(not _has_header(entry, (*inner, key)) for key, entry in value.items()):
                yield f"\n[{header}]"
            yield from _lines(value, inner)


def _has_header(value: Any, path: tuple[str, ...]) -> bool:
    if not value or len(path) > _HEADERS.get(path[0], 0):
        return False
    tables = isinstance(value, list) and all(isinstance(entry, dict) for entry in value)
    return isinstance(value, dict) or (tables and path[0] == "system")

"""How tables of a scene are validated: nothing converted, nothing unknown, and every fault told in plain words."""

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from chaosdrill.names import remedy
from chaosdrill.scene.lines import Path
from chaosdrill.scene.problems import Problem


class Strict(BaseModel):
    """A table of a scene."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


Table = TypeVar("Table", bound=Strict)

_WORDS = {
    "float_type": "expected a number",
    "int_type": "expected a whole number",
    "string_type": "expected text in quotes",
    "dict_type": "expected a table",
    "model_type": "expected a table",
    "list_type": "expected a list",
    "finite_number": "must be finite",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "too_short": "must have at least {min_length} entries",
    "too_long": "must have at most {max_length} entries",
}


def validate(table: type[Table], raw: Any, at: Path) -> tuple[Table | None, list[Problem]]:
    """Validate one table of a scene.

    Parameters
    ----------
    table : type
        What it must be.
    raw : object
        What the file holds.
    at : path
        Where it stands.

    Returns
    -------
    value : Table or None
        None if there are problems.
    problems : list of Problem
        All of them.
    """
    try:
        return table.model_validate(raw), []
    except ValidationError as fault:
        found: dict[Path, Problem] = {}
        for error in fault.errors(include_url=False):
            path = _place(error["loc"], raw, keep_last=error["type"] in ("missing", "extra_forbidden"))
            # of a value that may be one of several types only the first complaint is of use
            found.setdefault(path, Problem((*at, *path), _message(error, table)))
        return None, list(found.values())


def _place(location: tuple[int | str, ...], raw: Any, *, keep_last: bool) -> Path:
    """The path in the file; pydantic's has the names of alternatives between the keys."""
    path: Path = ()
    for position, part in enumerate(location):
        if isinstance(raw, Mapping) and part in raw:
            raw = raw[str(part)]
        elif isinstance(raw, list) and isinstance(part, int):
            raw = raw[part]
        elif not (keep_last and position == len(location) - 1):
            continue
        path = (*path, part)
    return path


def _message(error: Any, table: type[Strict]) -> str:
    kind, received = error["type"], error["input"]
    if kind == "missing":
        return "missing"
    if kind == "extra_forbidden":
        known = remedy(str(error["loc"][-1]), table.model_fields) if len(error["loc"]) == 1 else "leave it out"
        return f"unknown key; {known}"
    context = error.get("ctx", {})
    words = _WORDS[kind].format(**context) if kind in _WORDS else error["msg"]
    if kind == "too_short" and context["min_length"] == 1:
        words = "must not be empty"
    return words if isinstance(received, Mapping) else f"{words}, received {received!r:.60}"

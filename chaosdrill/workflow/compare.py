"""Two archives, variable by variable: bit by bit, or by what can be compared."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from chaosdrill.archive.digest import DIGESTS
from chaosdrill.dataset.references import mapping
from chaosdrill.dataset.schema import SCHEMA

if TYPE_CHECKING:
    import xarray as xr

PASSING = frozenset({"history", "date_created", "wall_time_s", "versions", "platform", "recommendation", DIGESTS})
"""Attributes that a second run on another day or machine may change."""

DESCRIPTIVE = frozenset(
    {"Conventions", "format_version", "summary", "keywords", "processing_level", "source", "references"}
    | {"coverage_content_type", "long_name", "comment", "flag_values", "flag_meanings", "random_seed"}
    | {"definition", "definition_missing"}
)
"""Attributes in words of the version that wrote them."""

CLOCKED = "not compared: measured time"


@dataclass(frozen=True)
class Difference:
    """What differs in one variable or attribute.

    Parameters
    ----------
    group : str
        Path of the group.
    variable : str
        Variable, or ``:attribute`` of the group, or ``variable:attribute``.
    what : str
        In words.
    differing : int
        Number of values that differ.
    total : int
        Number of values compared.
    max_abs : float
        Largest absolute difference; infinite between a number and NaN; NaN where there is nothing to subtract.
    """

    group: str
    variable: str
    what: str
    differing: int = 1
    total: int = 1
    max_abs: float = float("nan")


@dataclass(frozen=True)
class Check:
    """How one variable was compared.

    Parameters
    ----------
    group : str
        Path of the group.
    variable : str
        Its name.
    how : str
        In words: "bit for bit", "within 1e-08", "within 8 standard errors", ...
    agrees : bool
        Whether it is so.
    """

    group: str
    variable: str
    how: str
    agrees: bool


def compare(first: "xr.DataTree", second: "xr.DataTree") -> list[Difference]:
    """All differences between two archives, wall time, history, versions and platform apart, and what a clock measured.

    Numbers are equal if they are so bit for bit.

    Parameters
    ----------
    first, second : xarray.DataTree
        The archive as it is, and as it should be.

    Returns
    -------
    list of Difference
        Empty if they are equal.
    """
    return examine(first, second)[0]


def examine(
    first: "xr.DataTree", second: "xr.DataTree", *, exact: bool = True, older: bool = False
) -> tuple[list[Difference], list[Check]]:
    """The differences between two archives, and how each variable was compared.

    Parameters
    ----------
    first, second : xarray.DataTree
        The archive as it is, and as it should be.
    exact : bool, default True
        Bit for bit; else by what can be compared between machines and versions (`agreement`).
    older : bool, default False
        The first archive is of another version, whose descriptions in words may differ.
    """
    groups = {node.path: node.to_dataset(inherit=False) for node in first.subtree}
    others = {node.path: node.to_dataset(inherit=False) for node in second.subtree}
    found = [Difference(path, "", "group is missing") for path in others if path not in groups]
    checks: list[Check] = []
    passing = PASSING | DESCRIPTIVE if older else PASSING
    for path, group in groups.items():
        if path in others:
            found += _group(path, group, others[path], exact, passing, checks)
        else:
            found.append(Difference(path, "", "unexpected group"))
    return found, checks


def _group(
    path: str,
    first: "xr.Dataset",
    second: "xr.Dataset",
    exact: bool,
    passing: frozenset[str],
    checks: list[Check],
) -> list[Difference]:
    found = _attributes(path, "", first.attrs, second.attrs, passing)
    clocked = {v.name for v in SCHEMA.get(str(second.attrs.get("kind")), {}).values() if v.clocked}
    found += [Difference(path, str(name), "is missing") for name in second.variables if name not in first.variables]
    if not exact:
        first, second = _shared_events(first, second)
    for name in (str(name) for name in first.variables):
        if name not in second.variables:
            found.append(Difference(path, name, "does not belong here"))
            continue
        one, other = first.variables[name], second.variables[name]
        found += _attributes(path, name, one.attrs, other.attrs, passing)
        if one.dims != other.dims or one.shape != other.shape:
            what = f"is {dict(one.sizes)}; expected {dict(other.sizes)}"
            differences, how = [Difference(path, name, what, one.size, one.size)], "shape"
        elif name in clocked:
            differences, how = [], CLOCKED
        elif exact:
            differences, how = _values(path, name, one.values, other.values), "bit for bit"
        else:
            differences, how = _agreeing(path, name, first, second)
        checks.append(Check(path, name, how, not differences))
        found += differences
    return found


def _shared_events(first: "xr.Dataset", second: "xr.Dataset") -> "tuple[xr.Dataset, xr.Dataset]":
    """Both up to the shorter of two lists of events: of runs that have parted one may have some more."""
    if second.attrs.get("kind") != "trajectory":
        return first, second
    count = min(first.sizes.get("event", 0), second.sizes.get("event", 0))
    return tuple(ds.isel(event=slice(count), missing_dims="ignore") for ds in (first, second))  # type: ignore[return-value]


def _attributes(
    path: str, name: str, first: dict[str, Any], second: dict[str, Any], passing: frozenset[str]
) -> list[Difference]:
    import numpy as np

    def same(one: Any, other: Any) -> bool:
        # NetCDF gives back a list of one entry as that entry, and a table in JSON is the same in any order
        tables = mapping(one), mapping(other)
        return np.array_equal(np.atleast_1d(one), np.atleast_1d(other)) or (tables[0] == tables[1] != {})

    return [
        Difference(path, f"{name}:{key}", "attribute differs")
        for key in sorted({*first, *second} - passing)
        if key not in first or key not in second or not same(first[key], second[key])
    ]


def _agreeing(path: str, name: str, first: "xr.Dataset", second: "xr.Dataset") -> tuple[list[Difference], str]:
    import numpy as np

    from chaosdrill.workflow.agreement import agreement

    one, other = first[name].values, second[name].values
    if (one.dtype.kind in "OUT") != (other.dtype.kind in "OUT"):
        return [Difference(path, name, f"holds {one.dtype}; expected {other.dtype}", one.size, one.size)], "type"
    how, wrong = agreement(name, first, second)
    count = int(np.count_nonzero(wrong))
    if not count:
        return [], how
    if one.dtype.kind in "OUT":
        return [Difference(path, name, "text differs", count, wrong.size)], how
    return [Difference(path, name, f"differs: not {how}", count, wrong.size, _largest(one, other, wrong))], how


def _values(path: str, name: str, one: Any, other: Any) -> list[Difference]:
    import numpy as np

    if one.dtype.kind in "OUT" or other.dtype.kind in "OUT":
        differs = np.asarray(one, dtype=str) != np.asarray(other, dtype=str)
        count = int(np.count_nonzero(differs))
        return [Difference(path, name, "text differs", count, differs.size)] if count else []
    if one.dtype != other.dtype:
        return [Difference(path, name, f"holds {one.dtype}; expected {other.dtype}", one.size, one.size)]
    bits = f"u{one.dtype.itemsize}"
    differs = np.ascontiguousarray(one).view(bits) != np.ascontiguousarray(other).view(bits)
    differs = differs.reshape(one.shape)
    count = int(np.count_nonzero(differs))
    if not count:
        return []
    return [Difference(path, name, "values differ", count, differs.size, _largest(one, other, differs))]


def _largest(one: Any, other: Any, differs: Any) -> float:
    import numpy as np

    with np.errstate(invalid="ignore"):
        apart = np.abs(one.astype(float) - other.astype(float))[differs]
    # one side is NaN: no number says how far apart they are
    return float(np.where(np.isnan(apart), np.inf, apart).max())

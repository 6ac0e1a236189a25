"""Two archives, variable by variable and bit by bit."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from chaosdrill.dataset.schema import SCHEMA

if TYPE_CHECKING:
    import xarray as xr

# what a second run on another day or machine may change
PASSING = frozenset({"history", "wall_time_s", "versions", "platform", "recommendation"})


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
    groups = {node.path: node.to_dataset(inherit=False) for node in first.subtree}
    others = {node.path: node.to_dataset(inherit=False) for node in second.subtree}
    found = [Difference(path, "", "group is missing") for path in others if path not in groups]
    for path, group in groups.items():
        if path in others:
            found += _group(path, group, others[path])
        else:
            found.append(Difference(path, "", "group does not belong here"))
    return found


def _group(path: str, first: "xr.Dataset", second: "xr.Dataset") -> list[Difference]:
    found = _attributes(path, "", first.attrs, second.attrs)
    names = [str(name) for name in first.variables]
    clocked = {v.name for v in SCHEMA.get(str(second.attrs.get("kind")), {}).values() if v.clocked}
    found += [Difference(path, str(name), "is missing") for name in second.variables if name not in first.variables]
    for name in names:
        if name not in second.variables:
            found.append(Difference(path, name, "does not belong here"))
            continue
        one, other = first.variables[name], second.variables[name]
        found += _attributes(path, name, one.attrs, other.attrs)
        if one.dims != other.dims or one.shape != other.shape:
            what = f"is {dict(one.sizes)}; expected {dict(other.sizes)}"
            found.append(Difference(path, name, what, one.size, one.size))
        elif name not in clocked:
            found += _values(path, name, one.values, other.values)
    return found


def _attributes(path: str, name: str, first: dict[str, Any], second: dict[str, Any]) -> list[Difference]:
    import numpy as np

    def same(one: Any, other: Any) -> bool:
        # NetCDF gives back a list of one entry as that entry
        return np.array_equal(np.atleast_1d(one), np.atleast_1d(other))

    return [
        Difference(path, f"{name}:{key}", "attribute differs")
        for key in sorted({*first, *second} - PASSING)
        if key not in first or key not in second or not same(first[key], second[key])
    ]


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
    count = int(np.count_nonzero(differs))
    if not count:
        return []
    with np.errstate(invalid="ignore"):
        apart = np.abs(one.astype(float) - other.astype(float)).reshape(differs.shape)[differs]
    # one side is NaN: no number says how far apart they are
    apart = np.where(np.isnan(apart), np.inf, apart)
    return [Difference(path, name, "values differ", count, differs.size, float(apart.max()))]

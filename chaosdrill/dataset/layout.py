"""Check of the layout that a file declares, before any of its contents is read."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ArchiveError
from chaosdrill.files import netcdf, netcdf_name

if TYPE_CHECKING:
    import netCDF4

DEEPEST = 16
"""Levels of groups."""

MOST_GROUPS = 10_000

MOST_VARIABLES = 1_000
"""In one group."""

FREE_BYTES = 2**26
"""What a file may declare however small it is."""

COMPRESSION = 1100
"""Bytes that deflate can make of one, at most: 1032; chunks that were never written take even less."""


def check_layout(file: Path) -> None:
    """Reject unreasonably many or deeply nested groups, and variables far larger than the file.

    Raises
    ------
    ArchiveError
        With the group or variable, the declared value, and the limit.
    """
    import netCDF4

    allowed = FREE_BYTES + COMPRESSION * file.stat().st_size
    total = count = 0
    with netcdf, netcdf_name(file) as known, netCDF4.Dataset(known) as root:
        waiting: list[tuple[netCDF4.Dataset, str, int]] = [(root, "/", 0)]
        while waiting:
            group, path, depth = waiting.pop()
            count += 1
            if depth > DEEPEST or count > MOST_GROUPS or len(group.variables) > MOST_VARIABLES:
                raise ArchiveError(
                    f"{file}: {path}: {count} groups, {depth} deep, {len(group.variables)} variables in this one; an "
                    f"archive has at most {MOST_GROUPS} groups, {DEEPEST} deep, of {MOST_VARIABLES} variables"
                )
            for name, variable in group.variables.items():
                total += _bytes(variable)
                if total > allowed:
                    raise ArchiveError(
                        f"{file}: {path}: {name} is declared with the shape {variable.shape}, more than a file of "
                        f"{file.stat().st_size} bytes can hold; it is damaged, or no archive"
                    )
            waiting += [(child, f"{path.rstrip('/')}/{name}", depth + 1) for name, child in group.groups.items()]


def read_through(file: Path) -> None:
    """Read all attributes and values once, block by block."""
    import netCDF4

    with netcdf, netcdf_name(file) as known, netCDF4.Dataset(known) as root:
        waiting = [root]
        while waiting:
            group = waiting.pop()
            parts: tuple[Any, ...] = (group, *group.variables.values())
            for part in parts:
                for name in part.ncattrs():
                    part.getncattr(name)
            for variable in group.variables.values():
                length = variable.shape[0] if variable.shape else 1
                rows = max(1, FREE_BYTES * length // max(1, _bytes(variable)))
                for start in range(0, length, rows):
                    variable.__getitem__(slice(start, start + rows) if variable.shape else ...)
            waiting += group.groups.values()


def _bytes(variable: "netCDF4.Variable") -> int:
    # texts have a length each, and a pointer at least
    size = getattr(variable.dtype, "itemsize", 8)
    for length in variable.shape:
        size *= int(length)
    return size

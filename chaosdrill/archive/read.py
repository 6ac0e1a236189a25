"""Open an archive, or say why not."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from chaosdrill.errors import ArchiveError

if TYPE_CHECKING:
    import xarray as xr

_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def open_archive(path: str | os.PathLike[str]) -> "xr.DataTree":
    """Open an archive and read it whole into memory; the file is closed again.

    Parameters
    ----------
    path : path-like
        A file that `save` or ``chaosdrill run`` has written.

    Returns
    -------
    xarray.DataTree
        One group an analysis.

    Raises
    ------
    ArchiveError
        If there is no such file, or if it is not NetCDF-4, damaged, or not of this package.
    """
    file = Path(path)
    _check_signature(file)
    import xarray as xr

    try:
        with xr.open_datatree(file, engine="netcdf4") as lazy:
            # DataTree.load of xarray 2026.9 leaves a variable on disk that has the name of a group
            nodes = {node.path: node.to_dataset(inherit=False).load() for node in lazy.subtree}
            tree = xr.DataTree.from_dict(nodes)
    # a damaged file makes the readers fail in ways of their own
    except (OSError, RuntimeError, ValueError, KeyError, AttributeError, TypeError) as fault:
        raise ArchiveError(f"{file}: truncated or damaged: {fault}") from fault
    if not any("kind" in node.attrs for node in tree.subtree):
        raise ArchiveError(f"{file}: NetCDF, but not an archive of chaosdrill: no group has the attribute 'kind'")
    return tree


def _check_signature(file: Path) -> None:
    try:
        with file.open("rb") as stream:
            start = stream.read(len(_SIGNATURE))
    except (OSError, ValueError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else fault
        raise ArchiveError(f"{file}: cannot read the archive: {reason}") from fault
    if not start:
        raise ArchiveError(f"{file}: is empty; the run that wrote it did not finish")
    if start != _SIGNATURE:
        raise ArchiveError(f"{file}: not a NetCDF-4 file")

"""Write an archive whole, or leave what was there."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.archive.digest import with_digests
from chaosdrill.archive.labels import labels_to_file
from chaosdrill.archive.seal import seal
from chaosdrill.errors import ArchiveError
from chaosdrill.files import draft_of, replacing, small_netcdf_cache

if TYPE_CHECKING:
    import xarray as xr

COMPRESSION = {"zlib": True, "complevel": 4, "shuffle": True}


def save(tree: "xr.DataTree | xr.Dataset", path: str | os.PathLike[str]) -> Path:
    """Write an archive.

    The file is written beside its target, flushed to the disk and only then moved into place, so that a full disk or an
    interrupt leaves the earlier file whole and nothing else. Every group gets the digests of its variables, by which
    `verify` and `info` see what was altered since.

    Parameters
    ----------
    tree : xarray.DataTree or xarray.Dataset
        What an analysis or a scene returned.
    path : path-like
        Target file; an earlier one is replaced.

    Returns
    -------
    pathlib.Path
        The target.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    import xarray as xr

    target = Path(path)
    check_writable(target)
    if isinstance(tree, xr.Dataset):
        tree = xr.DataTree(tree)
    nodes = {node.path: with_digests(node.to_dataset(inherit=False)) for node in tree.subtree}
    tree = xr.DataTree.from_dict({path: labels_to_file(ds) for path, ds in nodes.items()})
    try:
        with replacing(target) as draft, small_netcdf_cache():
            tree.to_netcdf(draft, engine="netcdf4", format="NETCDF4", encoding=_encoding(tree))
            seal(draft)
    except (OSError, RuntimeError) as fault:
        reason = f"cannot write the archive: {_reason(fault)}; an earlier file is as it was"
        raise ArchiveError(f"{target}: {reason}") from fault
    return target


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse a target that cannot be written, before any work is done for it.

    Raises
    ------
    ArchiveError
        With the reason.
    """
    target = Path(path)
    if target.is_dir():
        raise ArchiveError(f"{target}: is a folder; name a file, as in {target / 'result.nc'}")
    if not target.parent.is_dir():
        raise ArchiveError(f"{target}: the folder {target.parent} does not exist; make it first")
    trial = draft_of(target)
    try:
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as fault:
        raise ArchiveError(f"{target}: cannot write into {target.parent}: {_reason(fault)}") from fault


def _encoding(tree: "xr.DataTree") -> dict[str, dict[str, dict[str, Any]]]:
    encoding: dict[str, dict[str, dict[str, Any]]] = {}
    for node in tree.subtree:
        dataset = node.to_dataset(inherit=False)
        encoding[node.path] = {}
        for name, variable in dataset.variables.items():
            chosen: dict[str, Any] = {}
            if variable.dtype.kind in "iufb" and variable.ndim and variable.size:
                chosen |= COMPRESSION
            if name in dataset.coords:
                # CF: a coordinate has no missing values
                chosen["_FillValue"] = None
            if chosen:
                encoding[node.path][str(name)] = chosen
    return encoding


def _reason(fault: Exception) -> str:
    if isinstance(fault, OSError) and fault.strerror:
        return fault.strerror
    return f"{fault} (is the disk full?)"

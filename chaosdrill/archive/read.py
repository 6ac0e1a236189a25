"""Open an archive, or report why it cannot be opened."""

import os
import warnings
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.archive.digest import altered, unsealed
from chaosdrill.archive.trial import TruncatedError, borrowed
from chaosdrill.dataset.provenance import FORMAT
from chaosdrill.errors import ArchiveError
from chaosdrill.files import HDF5, format_of_bytes, open_target, reason_of
from chaosdrill.typed import PATH, expecting

REMEDY = "copy or download it once more, or compute it again"
"""For a file whose bytes are not those that were written."""

_WAYS = {
    "text": "run a scene by 'chaosdrill run SCENE.toml -o OUT.nc', and name OUT.nc",
    "NetCDF-3": "chaosdrill writes NetCDF-4; 'nccopy -k nc4 FILE NEW' turns a converted archive back",
}
"""What to do with a file of another kind, by its format."""


@expecting(ArchiveError, path=PATH)
def open_archive(path: str | os.PathLike[str]) -> "DataTree":
    """Read a whole archive into memory, and close the file.

    Parameters
    ----------
    path : path-like
        A file written by `save` or ``chaosdrill run``.

    Returns
    -------
    xarray.DataTree
        One group per analysis.

    Raises
    ------
    ArchiveError
        If there is no such file, or if it is not NetCDF-4, damaged, of a later format, or not of this package.

    Warns
    -----
    UserWarning
        If values or attributes were altered after the archive was written, or have no digests that would tell.
    """
    tree = read_archive(path)
    changed = altered_parts(tree)
    found = [f"altered since the archive was written: {', '.join(changed)}"] if changed else []
    if found := [*found, *filter(None, [unsealed(tree)])]:
        warnings.warn(f"{os.fspath(path)!s}: {'; '.join(found)}", stacklevel=3)
    return tree


@expecting(ArchiveError, path=PATH)
def read_archive(path: str | os.PathLike[str]) -> "DataTree":
    """The same without a warning of alterations, for those that tell of them themselves."""
    file = Path(path)
    _check_signature(file)
    with borrowed() as reader:
        # what takes half a second to import does so while the process starts
        reader.begin(file)
        try:
            import xarray as xr

            import_module("chaosdrill.dataset.words")
        except (ImportError, OSError) as fault:
            raise ArchiveError(
                f"{file}: cannot be read now, since a library cannot be loaded ({fault}); are too many files open, or "
                "is there too little memory?"
            ) from fault
        # warnings of readers about a damaged file do not help its user
        with warnings.catch_warnings(action="ignore"):
            try:
                groups = reader.read(file, decoded=True)
            except TruncatedError as fault:
                raise ArchiveError(f"{fault}; {REMEDY}") from fault
            try:
                tree = xr.DataTree.from_dict({place: _lists(ds) for place, ds in groups.items()})
            except MemoryError as fault:
                raise ArchiveError(f"{file}: not enough memory to read it: {fault}") from fault
            # groups that contradict each other
            except Exception as fault:
                raise ArchiveError(f"{file}: truncated or damaged: {fault!s:.500}; {REMEDY}") from fault
    if not any("kind" in node.attrs for node in tree.subtree):
        raise ArchiveError(f"{file}: NetCDF, but not an archive of chaosdrill: no group has the attribute 'kind'")
    if (number := format_of(tree.attrs)) > FORMAT:
        raise ArchiveError(
            f"{file}: format {number}, written by a later version of chaosdrill "
            f"({tree.attrs.get('versions', 'unknown')}); this one reads formats up to {FORMAT}: install that one, or "
            "read the file with plain xarray"
        )
    return tree


def groups_of(tree: DataTree) -> dict[str, Dataset]:
    """The groups of an archive by their paths, each with what is its own."""
    return {node.path: node.to_dataset(inherit=False) for node in tree.subtree}


def altered_parts(tree: DataTree) -> list[str]:
    """Attributes of the archive, and variables and attributes of its groups, altered after they were written."""
    groups = groups_of(tree).items()
    return [f"{path.strip('/')} {name}".strip() for path, group in groups for name in altered(group) or ()]


def format_of(attributes: Mapping[Any, Any]) -> int:
    """Number of the format, from the attributes of an archive; those written before formats had numbers are 1."""
    try:
        return int(attributes.get("format_version", 1))
    except (TypeError, ValueError, OverflowError):
        return 1


def _lists(ds: Dataset) -> Dataset:
    """The same with codes in a list, of which NetCDF gives back a single one as a number, and plain numbers beside."""
    import numpy as np

    for attributes in (ds.attrs, *(variable.attrs for variable in ds.variables.values())):
        for name, value in attributes.items():
            if name == "flag_values":
                attributes[name] = np.atleast_1d(value)
            elif isinstance(value, np.number):
                attributes[name] = value.item()
    return ds


def _check_signature(file: Path) -> None:
    try:
        with open_target(file) as stream:
            start = stream.read(512)
    except (OSError, ValueError) as fault:
        raise ArchiveError(f"{file}: cannot read the archive: {reason_of(fault)}") from fault
    if not start:
        raise ArchiveError(f"{file}: is empty; the run that wrote it did not finish: {REMEDY}")
    if not start.startswith(HDF5):
        found = format_of_bytes(start)
        way = _WAYS.get(found, "name an archive, which 'chaosdrill run' or chaosdrill.save has written")
        what = f", but {found}; {way}" if found else f"; {way}. If this was one, {REMEDY}"
        raise ArchiveError(f"{file}: not a NetCDF-4 file{what}")

"""Whether a fault is the program's or that of an archive which is not as it was written."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from chaosdrill.archive.digest import altered
from chaosdrill.errors import ArchiveError, ChaosdrillError

if TYPE_CHECKING:
    import xarray as xr


@contextmanager
def blaming(path: str | os.PathLike[str], datasets: "Iterable[xr.Dataset]", what: str) -> Iterator[None]:
    """Turn any fault of the block into an error of the archive, if one of its groups is not as it was written.

    Parameters
    ----------
    path : path-like
        The archive.
    datasets : iterable of xarray.Dataset
        The groups that the block uses.
    what : str
        What the block does, such as "drawn".

    Raises
    ------
    ArchiveError
        With the fault, and the variables that were altered. A fault with groups as they were written is a mistake of
        the program, and is let through.
    """
    try:
        yield
    except (ChaosdrillError, MemoryError):
        raise
    except Exception as fault:
        changed = [altered(ds) for ds in datasets]
        if all(names == [] for names in changed):
            raise
        names = ", ".join(name for found in changed for name in found or ())
        told = f"altered after it was written: {names}" if names else "not written by this version of chaosdrill"
        raise ArchiveError(f"{path}: cannot be {what} ({fault}); it is {told}") from fault

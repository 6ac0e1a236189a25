"""What is to be cited for an archive."""

import os
from typing import TYPE_CHECKING

from chaosdrill.archive.read import open_archive
from chaosdrill.dataset.references import Reference, package, references
from chaosdrill.errors import ArchiveError
from chaosdrill.typed import PATH, expecting

if TYPE_CHECKING:
    import xarray as xr


@expecting(ArchiveError, path=PATH)
def cite(path: str | os.PathLike[str]) -> list[Reference]:
    """The references of what an archive was made with: this package, analyses, methods and systems.

    Parameters
    ----------
    path : path-like
        The archive.

    Returns
    -------
    list of Reference
        Each once, the package first. ``text()`` of one is a line for people, ``bibtex()`` its entry.

    Raises
    ------
    ArchiveError
        If the archive cannot be opened.
    """
    return references_in(open_archive(path))


def references_in(tree: "xr.DataTree") -> list[Reference]:
    """The references of an archive that is open."""
    found = [package()]
    for node in tree.subtree:
        group = node.to_dataset(inherit=False)
        if "kind" in group.attrs:
            found += references(group.attrs, [str(name) for name in group.variables])
    return list(dict.fromkeys(found))

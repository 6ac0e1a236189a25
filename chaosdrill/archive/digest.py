"""Digests of the contents of an archive, and of the whole file.

The digest of a variable in the attributes reveals an altered value without computing it again. The last line of a file
is the SHA-256 of everything before it, which reveals a truncation or a flipped bit without reading more. Both show that
nothing was damaged, but never that a file is harmless: a harmful file can have correct digests. HDF5 ignores what
follows its own end of file, and removes it when a file is opened for writing and closed again.
"""

import json
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any, BinaryIO

from chaosdrill.annotations import Dataset, DataTree, Variable
from chaosdrill.archive.inside import FREE_BYTES, USUAL_COMPRESSION
from chaosdrill.archive.tuning import TUNING
from chaosdrill.dataset.references import mapping
from chaosdrill.errors import ArchiveError, ChaosdrillError

DIGESTS = "digests"
"""Attribute of a group: JSON of the digest of each of its variables, and of its attributes under the empty name."""

_UNSEALED = (DIGESTS, "history")

_MARK = b"\nchaosdrill sha256 "
LENGTH = len(_MARK) + 64 + 1


def with_digests(ds: Dataset) -> Dataset:
    """The dataset with its digests as an attribute, in place of earlier ones."""
    attributes = {name: value for name, value in ds.attrs.items() if name != DIGESTS}
    return ds.assign_attrs({**attributes, DIGESTS: json.dumps(digests(ds))})


def digests(ds: Dataset) -> dict[str, str]:
    """Digest of each variable (values, type, dimensions and attributes), and of the dataset's own attributes."""
    found = {
        str(name): _of_variable(variable)
        for name, variable in sorted(ds.variables.items(), key=lambda named: str(named[0]))
    }
    found[""] = sha256(_text(ds.attrs)).hexdigest()[:32]
    return found


def altered(ds: Dataset) -> list[str] | None:
    """Names of the variables that are not as they were written.

    ":" stands for attributes of the group, ":scene" for a scene, and ":digests" for digests that are damaged.

    Returns: None if the dataset holds no digests, as in archives of format 1 and those written by other programs.
    """
    text, known = ds.attrs.get("scene"), ds.attrs.get("scene_sha256")
    other = isinstance(text, str) and known is not None and sha256(text.encode(errors="replace")).hexdigest() != known
    # archives of format 1 have that digest too
    scene = [":scene"] if other else []
    if DIGESTS not in ds.attrs:
        return scene or None
    stored, now = mapping(ds.attrs[DIGESTS]), digests(ds)
    if not stored:
        return [f":{DIGESTS}", *scene]
    names = sorted({*stored, *now})
    return [name or ":" for name in names if stored.get(name) != now.get(name)] + scene


def unsealed(tree: DataTree) -> str:
    """Warning about an archive with groups without digests; empty if all have them."""
    bare = [node.path for node in tree.subtree if "kind" in node.attrs and DIGESTS not in node.attrs]
    if not bare:
        return ""
    lack = f"{', '.join(bare)} {'has' if len(bare) == 1 else 'have'} no digests"
    return (
        f"not sealed: {lack}, so alterations cannot be detected; compute it again, or seal what is there by "
        "chaosdrill.save"
    )


@contextmanager
def error_context(path: str | os.PathLike[str], datasets: Iterable[Dataset], what: str) -> Iterator[None]:
    """Turn any exception in the block into an error of the archive, if one of its groups was altered.

    The block uses the groups ``datasets`` of the archive ``path``; ``what`` it does with them is such as "drawn".

    Raises `ArchiveError`, with the exception and the altered variables. An exception with unaltered groups is a bug of
    the program, and passes through.
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


def _of_variable(variable: Variable) -> str:
    import numpy as np

    values = np.asarray(variable.values)
    total = sha256()
    if values.dtype.kind in "OUT":
        # a missing text is written as an empty one
        texts = [text if isinstance(text, str) else "" for text in values.ravel().tolist()]
        total.update(json.dumps(texts).encode())
        kind = "text"
    else:
        # of dates the file keeps no resolution
        kind = "<M8[ns]" if values.dtype.kind == "M" else values.dtype.newbyteorder("<").str
        flat = values.reshape(-1)
        for start in range(0, flat.size, TUNING.digest_entries):
            block = flat[start : start + TUNING.digest_entries].astype(kind)
            if block.dtype.kind == "f":
                # a NaN has many bit patterns, and readers may exchange one for another
                block[np.isnan(block)] = np.nan
            total.update(block.view("<i8").data if block.dtype.kind == "M" else block.data)
    total.update(json.dumps([kind, [str(dim) for dim in variable.dims], list(variable.shape)]).encode())
    total.update(_text(variable.attrs))
    return total.hexdigest()[:32]


def _text(attributes: dict[Any, Any]) -> bytes:
    """Attributes as read back from a file: a list of one entry becomes that entry. Tools append to the history."""
    import numpy as np

    plain = {}
    for name, value in attributes.items():
        if name in _UNSEALED:
            continue
        value = np.asarray(value).tolist()
        plain[str(name)] = value[0] if isinstance(value, list) and len(value) == 1 else value
    return json.dumps(plain, sort_keys=True, default=str).encode()


def append_checksum(file: Path) -> None:
    """Append the line to a file."""
    with file.open("r+b") as stream:
        size = stream.seek(0, os.SEEK_END)
        stream.write(_line(stream, size))


def has_checksum(stream: BinaryIO) -> bool:
    """Whether an open file ends with the right line; a file of holes, which would take long to read, does not."""
    status = os.fstat(stream.fileno())
    held = FREE_BYTES + USUAL_COMPRESSION * 512 * status.st_blocks
    size = status.st_size - LENGTH
    return 0 < size <= held and _line(stream, size) == stream.read(LENGTH)


def _line(stream: BinaryIO, size: int) -> bytes:
    """The line that belongs after the first ``size`` bytes of a file, where the stream is left."""
    total = sha256()
    stream.seek(0)
    while size > 0 and (block := stream.read(min(TUNING.digest_bytes, size))):
        total.update(block)
        size -= len(block)
    return _MARK + total.hexdigest().encode() + b"\n"

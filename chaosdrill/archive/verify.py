"""Whether an archive is what its own scene gives."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.archive.compare import Difference, compare
from chaosdrill.archive.describe import stored_versions
from chaosdrill.archive.read import open_archive
from chaosdrill.errors import ArchiveError, ChaosdrillError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Verification:
    """Result of `verify`.

    Parameters
    ----------
    path : pathlib.Path
        The archive.
    differences : tuple of Difference
        Empty if the archive is what its scene gives.
    notes : tuple of str
        What may explain differences: other versions, another platform.
    """

    path: Path
    differences: tuple[Difference, ...]
    notes: tuple[str, ...]

    @property
    def equal(self) -> bool:
        """Whether the archive is, bit for bit, what its scene gives."""
        return not self.differences

    def table(self) -> str:
        """The differences as a table: group, variable, how many values differ, by how much at most."""
        rows = [("group", "variable", "differing", "max |difference|", "")]
        for item in self.differences:
            largest = "" if item.max_abs != item.max_abs else f"{item.max_abs:.3g}"
            rows.append((item.group, item.variable, f"{item.differing} of {item.total}", largest, item.what))
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
        )


def verify(
    path: str | os.PathLike[str], *, workers: int = 1, report: Callable[[str], Any] | None = None
) -> Verification:
    """Run the scene that an archive holds once more and compare, variable by variable.

    Parameters
    ----------
    path : path-like
        The archive.
    workers : int
        Points computed at a time.
    report : callable, optional
        As for `Scene.run`.

    Returns
    -------
    Verification

    Raises
    ------
    ArchiveError
        If the archive cannot be opened, or holds no scene that can be run.
    """
    from chaosdrill.scene import parse_scene

    tree = open_archive(path)
    text = tree.attrs.get("scene")
    if not isinstance(text, str):
        raise ArchiveError(f"{path}: holds no scene; only archives of 'chaosdrill run' can be verified")
    try:
        scene = parse_scene(text, str(tree.attrs.get("scene_name", "scene.toml")))
        again = scene.run(workers=workers, report=report)
    except ChaosdrillError as fault:
        raise ArchiveError(f"{path}: the scene it holds cannot be run:\n{fault}") from fault
    return Verification(Path(path), tuple(compare(tree, again)), tuple(_notes(tree, again)))


def _notes(first: "xr.DataTree", second: "xr.DataTree") -> list[str]:
    """Versions and platforms in which the two runs differ."""
    notes = []
    before = stored_versions(first)
    for name, version in stored_versions(second).items():
        if before.get(name) != version:
            notes.append(f"made with {name} {before.get(name, 'unknown')}, now {version}")
    if first.attrs.get("platform") != second.attrs["platform"]:
        notes.append(f"made on {first.attrs.get('platform', 'unknown')}, now on {second.attrs['platform']}")
    return notes

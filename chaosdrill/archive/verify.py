"""Whether an archive is what its own scene gives."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.archive.compare import CLOCKED, Check, Difference, examine
from chaosdrill.archive.describe import stored_versions
from chaosdrill.archive.digest import altered
from chaosdrill.archive.read import format_of, open_archive
from chaosdrill.dataset.provenance import FORMAT
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
    checks : tuple of Check
        How each variable was compared.
    exact : bool
        Whether numbers were compared bit for bit; else by what can be compared between machines and versions.
    """

    path: Path
    differences: tuple[Difference, ...]
    notes: tuple[str, ...]
    checks: tuple[Check, ...] = ()
    exact: bool = True

    @property
    def equal(self) -> bool:
        """Whether the archive is what its scene gives, as far as each variable can be compared."""
        return not self.differences

    def table(self) -> str:
        """The differences as a table.

        Returns
        -------
        str
            A line each: group, variable, how many values differ, by how much at most.
        """
        rows = [("group", "variable", "differing", "max |difference|", "")]
        for item in self.differences:
            largest = "" if item.max_abs != item.max_abs else f"{item.max_abs:.3g}"
            rows.append((item.group, item.variable, f"{item.differing} of {item.total}", largest, item.what))
        return _columns(rows)

    def how(self) -> str:
        """What was compared how, as a table.

        Returns
        -------
        str
            A line for each way in each group: group, how, names of the variables.
        """
        rows = [("group", "compared", "variables")]
        found: dict[tuple[str, str], list[str]] = {}
        for check in self.checks:
            found.setdefault((check.group, check.how), []).append(check.variable)
        rows += [(group, how, ", ".join(names)) for (group, how), names in found.items()]
        return _columns(rows)


def verify(
    path: str | os.PathLike[str], *, workers: int = 1, report: Callable[[str], Any] | None = None
) -> Verification:
    """Run the scene that an archive holds once more and compare, variable by variable.

    With the versions and the platform of the archive numbers are compared bit for bit. With others, cycles, multipliers
    and whatever attracts are to agree within the error of the method, and in chaos averages within their errors;
    ``checks`` says which it was for each variable. What is not as it was written, by the digests that the archive
    holds, is a difference in either case.

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
        ``equal`` says whether the archive is what its scene gives, ``differences`` where not.

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
    notes = _notes(tree, again)
    older = format_of(tree) < FORMAT or stored_versions(tree).get("chaosdrill") != stored_versions(again)["chaosdrill"]
    differences, checks = examine(tree, again, exact=not notes, older=older)
    differences, checks = _with_digests(tree, differences, checks)
    return Verification(Path(path), tuple(differences), tuple(notes), tuple(checks), not notes)


def _with_digests(
    tree: "xr.DataTree", differences: list[Difference], checks: list[Check]
) -> tuple[list[Difference], list[Check]]:
    """The differences and checks with what the archive's own digests tell of variables not found different yet."""
    named = {(item.group, item.variable.split(":")[0]) for item in differences}
    found = list(differences)
    clocked = set()
    for node in tree.subtree:
        group = node.to_dataset(inherit=False)
        changed = altered(group)
        if changed is None:
            continue
        clocked |= {(node.path, str(name)) for name in group.variables}
        for name in changed:
            if (node.path, name.strip(":")) not in named:
                found.append(Difference(node.path, name, "is not as it was written, by its digest"))
    checks = [
        replace(check, how="by the digest of its values alone: a clock measured it", agrees=True)
        if check.how == CLOCKED and (check.group, check.variable) in clocked
        else check
        for check in checks
    ]
    wrong = {(item.group, item.variable) for item in found}
    return found, [replace(c, agrees=False) if (c.group, c.variable) in wrong else c for c in checks]


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


def _columns(rows: Sequence[tuple[str, ...]]) -> str:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )

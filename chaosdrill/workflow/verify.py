"""Verify that an archive is reproduced by its own scene, or by the definitions in it."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.archive.digest import altered, error_context, unsealed
from chaosdrill.archive.read import format_of, groups_of, read_archive
from chaosdrill.dataset.provenance import FORMAT, library_versions
from chaosdrill.errors import ArchiveError, ChaosdrillError, SettingsError
from chaosdrill.typed import COUNT, FUNCTION, PATH, expecting
from chaosdrill.workflow.compare import CLOCKED, Check, Difference, examine
from chaosdrill.workflow.describe import stored_versions
from chaosdrill.workflow.run_scene import compute, hindrance, rerun


@dataclass(frozen=True)
class Verification:
    """Result of `verify`.

    Parameters
    ----------
    path : pathlib.Path
        The archive.
    differences : tuple of Difference
        Empty if the archive is reproduced.
    notes : tuple of str
        Possible reasons for differences: other versions, and another platform.
    checks : tuple of Check
        How each variable was compared.
    exact : bool
        Whether numbers were compared bit for bit; otherwise by the criteria for other machines and versions.
    unsealed : str
        A warning about groups without digests, whose alterations cannot be detected; empty if all have digests.
    """

    path: Path
    differences: tuple[Difference, ...]
    notes: tuple[str, ...]
    checks: tuple[Check, ...] = ()
    exact: bool = True
    unsealed: str = ""

    @property
    def equal(self) -> bool:
        """Whether the archive is reproduced, as far as each variable can be compared."""
        return not self.differences

    def table(self) -> str:
        """The differences as a table.

        Returns
        -------
        str
            One line per difference: group, variable, number of differing values, largest difference.
        """
        rows = [("group", "variable", "differing", "max |difference|", "")]
        for item in self.differences:
            largest = "" if item.max_abs != item.max_abs else f"{item.max_abs:.3g}"
            rows.append((item.group, item.variable, f"{item.differing} of {item.total}", largest, item.what))
        return _columns(rows)

    def how(self) -> str:
        """How each variable was compared, as a table.

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


@expecting(ArchiveError, path=PATH)
@expecting(SettingsError, workers=COUNT, report=FUNCTION)
def verify(
    path: str | os.PathLike[str], *, workers: int = 1, report: Callable[[str], Any] | None = None
) -> Verification:
    """Run the scene of an archive again and compare every variable.

    An archive that was saved from Python has no scene. Each of its groups is recomputed from the definition of its
    system, its numbers and its arguments; a group that cannot be recomputed counts as different, with the reason.
    Attributes that were added later are not compared.

    With the versions and the platform of the archive, numbers are compared bit for bit. With others, cycles,
    multipliers and regular attractors must agree within the error of the method, and averages in chaos within their
    errors; ``checks`` names the criterion of each variable. In either case a variable whose digest shows an alteration
    counts as different.

    Parameters
    ----------
    path : path-like
        The archive.
    workers : int
        Points computed at a time.
    report : callable, optional
        As for `run`.

    Returns
    -------
    Verification
        ``equal`` says whether the archive is reproduced, ``differences`` where it is not.

    Raises
    ------
    ArchiveError
        If the archive cannot be opened, or holds neither a scene nor an analysis that can be run again.
    """
    tree = read_archive(path)
    text = tree.attrs.get("scene")
    if isinstance(text, str):
        differences, checks, notes = _from_scene(path, tree, text, workers, report)
    else:
        differences, checks, notes = _from_definitions(path, tree, workers, report)
    differences, checks = _with_digests(tree, differences, checks)
    exact = not notes
    return Verification(Path(path), tuple(differences), tuple(notes), tuple(checks), exact, unsealed(tree))


Compared = tuple[list[Difference], list[Check], list[str]]


def _from_scene(
    path: str | os.PathLike[str], tree: DataTree, text: str, workers: int, report: Callable[[str], Any] | None
) -> Compared:
    import xarray as xr

    from chaosdrill.scene import parse_scene

    try:
        scene = parse_scene(text, str(tree.attrs.get("scene_name", "scene.toml")))
        again = compute(scene, workers=workers, report=report)
    except ChaosdrillError as fault:
        raise ArchiveError(f"{path}: the scene in it cannot be run:\n{fault}") from fault
    notes = _notes(tree.attrs, again.attrs)
    computed = groups_of(again)
    known = {path: _only_known_attributes(ds, computed.get(path, ds)) for path, ds in groups_of(tree).items()}
    first = xr.DataTree.from_dict(known)
    differences, checks = examine(first, again, exact=not notes, older=_is_older(tree.attrs))
    return differences, checks, notes


def _from_definitions(
    path: str | os.PathLike[str], tree: DataTree, workers: int, report: Callable[[str], Any] | None
) -> Compared:
    """Every group by itself, each with the versions that wrote it."""
    import xarray as xr

    differences: list[Difference] = []
    checks: list[Check] = []
    notes: list[str] = []
    refused: dict[str, str] = {}
    groups = {place: ds for place, ds in groups_of(tree).items() if ds.variables or "kind" in ds.attrs}
    for place, ds in groups.items():
        again = _computed(path, ds, workers, report(place.strip("/") or "result") if report else None)
        if isinstance(again, str):
            refused[place] = again
            continue
        ours = _notes(ds.attrs, again.attrs)
        pair = (_only_known_attributes(ds, again), again)
        found, compared = examine(
            *(xr.DataTree.from_dict({place: one}) for one in pair), exact=not ours, older=_is_older(ds.attrs)
        )
        differences += found
        checks += compared
        notes += [note for note in ours if note not in notes]
    if len(refused) == len(groups):
        reasons = "\n".join(f"{place}: {reason}" for place, reason in refused.items())
        raise ArchiveError(f"{path}: contains no scene, and nothing in it can be computed again:\n{reasons}")
    differences += [Difference(place, "", f"cannot be computed again: {reason}") for place, reason in refused.items()]
    return differences, checks, notes


def _computed(
    path: str | os.PathLike[str], ds: Dataset, workers: int, progress: Callable[..., None] | None
) -> Dataset | str:
    """The recomputed group, or why it cannot be recomputed."""
    if (reason := hindrance(ds)) is not None:
        return reason
    try:
        with error_context(path, [ds], "computed again"):
            return rerun(ds, workers=workers, progress=progress)
    except ChaosdrillError as fault:
        return str(fault)


def _only_known_attributes(ds: Dataset, again: Dataset) -> Dataset:
    """The dataset without attributes that were added to the result of its analysis."""
    ds = ds.copy()
    ds.attrs = {name: value for name, value in ds.attrs.items() if name in again.attrs}
    for name in ds.variables:
        if name in again.variables:
            known = again[name].attrs
            ds[name].attrs = {key: value for key, value in ds[name].attrs.items() if key in known}
    return ds


def _is_older(attributes: Mapping[Any, Any]) -> bool:
    """Whether the attributes were written by another version, whose descriptions in words may differ."""
    return (
        format_of(attributes) < FORMAT
        or stored_versions(attributes).get("chaosdrill") != library_versions()["chaosdrill"]
    )


def _with_digests(
    tree: DataTree, differences: list[Difference], checks: list[Check]
) -> tuple[list[Difference], list[Check]]:
    """Differences and checks, completed by variables that only the archive's digests show to be altered."""
    named = {(item.group, item.variable.split(":")[0]) for item in differences}
    found = list(differences)
    clocked = set()
    for path, group in groups_of(tree).items():
        changed = altered(group)
        if changed is None:
            continue
        clocked |= {(path, str(name)) for name in group.variables}
        for name in changed:
            if (path, name.split(":")[0]) not in named:
                found.append(Difference(path, name, "is not as it was written, by its digest"))
    checks = [
        replace(check, how="by the checksum of its values alone: measured time", agrees=True)
        if check.how == CLOCKED and (check.group, check.variable) in clocked
        else check
        for check in checks
    ]
    wrong = {(item.group, item.variable) for item in found}
    return found, [replace(c, agrees=False) if (c.group, c.variable) in wrong else c for c in checks]


def _notes(first: Mapping[Any, Any], second: Mapping[Any, Any]) -> list[str]:
    """Versions and platforms in which the two runs differ."""
    before, now = stored_versions(first), stored_versions(second)
    changed = [name for name in now if before.get(name) != now[name]]
    notes = [f"made with {name} {before.get(name, 'unknown')}, now {now[name]}" for name in changed]
    if first.get("platform") != second["platform"]:
        notes.append(f"made on {first.get('platform', 'unknown')}, now on {second['platform']}")
    return notes


def _columns(rows: Sequence[tuple[str, ...]]) -> str:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )

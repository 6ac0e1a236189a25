"""Run a scene, into an archive or into memory, or repeat an analysis from the contents of its dataset.

Finished parts of a scene survive any interruption of the run.
"""

import json
import os
from collections.abc import Callable, Mapping
from inspect import Parameter
from time import perf_counter
from typing import TYPE_CHECKING, Any

from chaosdrill.analysis.registry import function
from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.archive.write import check_writable, save
from chaosdrill.dataset import described_again, provenance
from chaosdrill.dataset.provenance import DERIVED
from chaosdrill.declared import ANALYSES
from chaosdrill.errors import ArchiveError, SceneError, SettingsError
from chaosdrill.typed import COUNT, FUNCTION, PATH, SWITCH, TABLE, expecting, refuse

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.progress import Progress
    from chaosdrill.scene import Scene
    from chaosdrill.sweep import Parts

_NEEDED = ("definition", "parameters", "initial", "settings")


@expecting(SettingsError, output=PATH, changes=TABLE, workers=COUNT, resume=SWITCH, report=FUNCTION, tell=FUNCTION)
def run(
    scene: "str | os.PathLike[str] | Scene",
    output: str | os.PathLike[str] | None = None,
    *,
    changes: Mapping[str, Any] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    resume: bool = False,
    report: "Callable[[str], Progress] | None" = None,
    tell: Callable[[str], None] | None = None,
) -> "DataTree":
    """Run every analysis of a scene and write one archive, whole or not at all, as ``chaosdrill run`` does.

    Parameters
    ----------
    scene : path-like or Scene
        A scene file, ``"-"`` for standard input, or what `load_scene` returned.
    output : path-like, optional
        Archive to write; an earlier one is replaced. Without it nothing is written.
    changes : mapping of str to value, optional
        Values to change in the scene, as for `load_scene`; only with a path.
    workers : int
        Points computed at a time; results do not depend on it.
    scheduler : str, optional
        Address of a Dask scheduler whose workers compute the points instead.
    resume : bool
        Continue an unfinished run from the folder ``output.parts``; without such a folder start a new run.
    report : callable, optional
        Called with the name of each analysis as it begins; returns a function to call with its progress.
    tell : callable, optional
        Called with lines about finished parts that are kept.

    Returns
    -------
    xarray.DataTree
        The contents of the archive: one group per analysis; the attributes of the root hold the scene and its
        provenance.

    Raises
    ------
    SceneError
        If the scene cannot be read or run.
    SettingsError
        If the arguments contradict each other, if the scheduler cannot be used, or if there is an unfinished run and
        ``resume`` is not set.
    ArchiveError
        If the archive or a part of it cannot be written.
    """
    from chaosdrill.scene import load_scene
    from chaosdrill.scene.scene import Scene
    from chaosdrill.sweep import Parts

    if scheduler is not None and workers != 1:
        raise SettingsError(
            f"--workers is {workers}, but the scheduler at {scheduler} has its own workers; give only one of the two"
        )
    if output is not None and os.fspath(output) == "-":
        raise SettingsError("--output is '-', but an archive is a file, not a stream; name one, such as result.nc")
    if isinstance(scene, Scene):
        if changes:
            raise SettingsError("changes: a loaded scene cannot be changed; pass them to load_scene")
        loaded = scene
    else:
        refuse(SceneError, "scene", scene, PATH)
        loaded = load_scene(scene, changes)
        if output is not None and os.path.exists(output) and os.path.exists(scene) and os.path.samefile(scene, output):
            raise SettingsError(
                f"--output is {os.fspath(output)!r}, which is the scene itself; name another file, such as result.nc"
            )
    loaded.check_period()
    if output is None:
        if resume:
            raise SettingsError(
                "resume: a run is resumed from the folder beside its archive; name the archive as output"
            )
        return compute(loaded, workers=workers, scheduler=scheduler, report=report)
    check_writable(output)
    with Parts(f"{os.fspath(output)}.parts", loaded.fingerprint(), resume=resume) as parts:
        for name, state in parts.kept().items():
            if tell:
                tell(f"{name}: found {state}")
        try:
            tree = compute(
                loaded,
                workers=workers,
                scheduler=scheduler,
                parts=parts,
                report=report,
                command=loaded.command("-o", os.fspath(output)),
            )
            save(tree, output)
        except BaseException:
            if tell and parts.kept():
                tell(f"finished parts are kept in {parts.folder}; continue with --resume")
            raise
    return tree


def compute(
    scene: "Scene",
    *,
    workers: int = 1,
    scheduler: str | None = None,
    parts: "Parts | None" = None,
    report: "Callable[[str], Progress] | None" = None,
    command: str | None = None,
) -> DataTree:
    """Run every analysis of a scene that has been read; further arguments, and what it returns, as for `run`.

    ``parts``: where finished chunks and analyses are kept; existing ones are not run again. ``command``: entry in the
    archive's history; default: ``run`` with the scene's name and its changes.

    Raises `SceneError` if the scene contains no analysis, `SettingsError` if the scheduler cannot be used, and
    `ArchiveError` if a part cannot be kept.
    """
    import xarray as xr

    from chaosdrill.scene.in_si import in_si, si_table

    if not scene.analyses:
        raise SceneError(f"{scene.name}: the scene contains no analysis; add a table such as [analysis.spectrum]")
    system = scene.system
    if scheduler is not None:
        # an address that does not answer is reported before hours of other analyses
        from chaosdrill.sweep.schedule import connect

        connect(scheduler).close()
    start = perf_counter()
    groups = {}
    for group, analysis in scene.analyses.items():
        begin = perf_counter()
        finished = None if parts is None or analysis.parallel else parts.finished(group)
        if parts is not None and finished is not None:
            finished = described_again(finished, analysis.kind, system=system)
            if finished is None:
                parts.recomputed(group, f"holds what no {analysis.kind} gives")
        if finished is not None:
            groups[group] = finished
            continue
        result = analysis.run(
            system,
            scene.numerics,
            workers=workers,
            scheduler=scheduler,
            store=parts.store(group) if parts else None,
            progress=report(group) if report else None,
        )
        groups[group] = in_si(result, analysis.kind, system, scene.scales)
        groups[group].attrs["wall_time_s"] = perf_counter() - begin
        if parts and not analysis.parallel:
            parts.keep(group, groups[group])
    root = provenance(scene.title, action=command or scene.command(), scene=scene)
    root["wall_time_s"] = perf_counter() - start
    return xr.DataTree.from_dict({"/": xr.Dataset(si_table(scene.si, system), attrs=root), **groups})


def hindrance(ds: Dataset) -> str | None:
    """Why a dataset cannot be recomputed from its own contents; None if it can."""
    kind = ds.attrs.get("kind")
    if not isinstance(kind, str) or kind not in ANALYSES:
        return "it is not the result of an analysis"
    if DERIVED in ds.attrs:
        return f"it was derived from the result of an analysis: {ds.attrs[DERIVED]!s:.200}"
    if any(str(name).endswith("_si") for name in ds.variables):
        return "it contains SI units, which only the archive of its scene can reproduce"
    if "definition" not in ds.attrs and "definition_missing" in ds.attrs:
        return f"its system cannot be written as text: {ds.attrs['definition_missing']!s:.500}"
    missing = [name for name in _NEEDED if name not in ds.attrs]
    if missing:
        number = ds.attrs.get("format_version", 1)
        who = f"versions of format {number!s:.20}" if number in (1, 2) else "other programs"
        return f"it has no attribute {missing[0]!r}, as in archives written by {who}"
    return None


def system_of(ds: Dataset) -> "HybridSystem":
    """The system of a dataset, from its definition.

    Raises `ChaosdrillError` if the definition, the parameters or the initial state cannot be read.
    """
    from chaosdrill.model.definition import build_defined

    definition, parameters, initial = (_table(ds, name) for name in _NEEDED[:3])
    return build_defined(definition, parameters, initial)


def known_system(ds: Dataset) -> "HybridSystem":
    """The same where only its equations and parameters are asked for: that of this process, if it has one.

    Raises `ChaosdrillError` as `system_of` does.
    """
    from chaosdrill.model.system import recent

    return recent(_table(ds, "definition"), _table(ds, "parameters")) or system_of(ds)


def rerun(ds: Dataset, *, workers: int = 1, progress: Callable[..., None] | None = None) -> Dataset:
    """Repeat the analysis of a dataset.

    ``ds``: one without `hindrance`. ``workers``: points computed at a time, where the analysis has several.
    ``progress``: as for the analyses.

    Raises `ChaosdrillError` if the system cannot be read, or the analysis cannot be run with its arguments.
    """
    entry = ANALYSES[ds.attrs["kind"]]
    keywords = _table(ds, "settings")
    if unknown := [name for name in keywords if name not in entry.told()]:
        raise ArchiveError(f"settings: {entry.function} of this version has no argument {unknown[0]!r:.60}")
    if entry.settings.parallel:
        keywords["workers"] = workers
    missing = [
        one.name
        for one in entry.signature().parameters.values()
        if one.default is Parameter.empty and one.name not in ("system", *keywords)
    ]
    if missing:
        raise ArchiveError(f"settings: lack {missing[0]!r}, which {entry.function} needs")
    result: Dataset = function(entry.function)(system_of(ds), **keywords, progress=progress)
    return result


def _table(ds: Dataset, name: str) -> dict[str, Any]:
    try:
        found = json.loads(ds.attrs[name])
    except (TypeError, ValueError, RecursionError) as fault:
        raise ArchiveError(f"{name}: not JSON: {fault!s:.200}") from None
    if not isinstance(found, Mapping):
        raise ArchiveError(f"{name}: expected a table, received {found!r:.60}")
    return dict(found)

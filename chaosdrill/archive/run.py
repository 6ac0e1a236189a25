"""A scene is run into an archive; what has finished outlives whatever stops it."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chaosdrill.archive.write import check_writable, save
from chaosdrill.errors import SceneError, SettingsError
from chaosdrill.files import followed, remove_drafts
from chaosdrill.typed import COUNT, FUNCTION, PATH, SWITCH, TABLE, expecting, refuse

if TYPE_CHECKING:
    import xarray as xr

    from chaosdrill.scene import Scene


@expecting(SettingsError, output=PATH, changes=TABLE, workers=COUNT, resume=SWITCH, report=FUNCTION, tell=FUNCTION)
def run(
    scene: "str | os.PathLike[str] | Scene",
    output: str | os.PathLike[str],
    *,
    changes: Mapping[str, Any] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    resume: bool = False,
    report: Callable[[str], Any] | None = None,
    tell: Callable[[str], None] | None = None,
) -> "xr.DataTree":
    """Run every analysis of a scene and write one archive, whole or not at all, as ``chaosdrill run`` does.

    Parameters
    ----------
    scene : path-like or Scene
        A scene file, ``"-"`` for standard input, or what `load_scene` returned.
    output : path-like
        Archive to write; an earlier one is replaced.
    changes : mapping of str to value, optional
        Values that the scene is to have, as for `load_scene`; only with a path.
    workers : int
        Points computed at a time; results do not depend on it.
    scheduler : str, optional
        Address of a Dask scheduler whose workers compute the points instead.
    resume : bool
        Go on with a run that did not end, from what the folder ``output.parts`` holds; begin one if there is none.
    report : callable, optional
        As for `Scene.run`.
    tell : callable, optional
        Called with lines about parts that are kept.

    Returns
    -------
    xarray.DataTree
        What the archive holds.

    Raises
    ------
    SceneError
        If the scene cannot be read or run.
    SettingsError
        If the arguments do not fit together, or an unfinished run is there and ``resume`` is not set.
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
    if os.fspath(output) == "-":
        raise SettingsError("--output is '-', but an archive is a file, not a stream; name one, such as result.nc")
    if isinstance(scene, Scene):
        if changes:
            raise SettingsError("changes: a loaded scene cannot be changed; pass them to load_scene")
        loaded = scene
    else:
        refuse(SceneError, "scene", scene, PATH)
        loaded = load_scene(scene, changes)
        if os.path.exists(output) and os.path.exists(scene) and os.path.samefile(scene, output):
            raise SettingsError(
                f"--output is {os.fspath(output)!r}, which is the scene itself; name another file, such as result.nc"
            )
    loaded.check_period()
    check_writable(output)
    with Parts(f"{os.fspath(output)}.parts", loaded.fingerprint(), resume=resume) as parts:
        remove_drafts(followed(Path(output)))
        for name, state in parts.kept().items():
            if tell:
                tell(f"{name}: {state} before")
        try:
            tree = loaded.run(
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
        parts.finish()
    return tree

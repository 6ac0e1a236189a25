"""Finished parts of an unfinished run: the folder ``OUT.nc.parts`` next to the future archive.

A sweep keeps its finished chunks in a folder of its own there (`store`), any other analysis its dataset. The file
``_scene.json`` holds the scene of the parts, so that a changed scene is not continued.
"""

import fcntl
import json
import os
import warnings
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from chaosdrill.annotations import Dataset
from chaosdrill.archive.digest import append_checksum, has_checksum
from chaosdrill.archive.trial import DamagedError, borrowed
from chaosdrill.declared import unstorable
from chaosdrill.errors import ArchiveError, SceneError, SettingsError
from chaosdrill.files import (
    draft_of,
    drafts_of,
    flush,
    netcdf_name,
    open_ordinary,
    open_own,
    read_json,
    remove,
    remove_drafts,
    replacing,
    signals_wait,
    small_netcdf_cache,
)
from chaosdrill.sweep.fingerprint import changes, plain
from chaosdrill.sweep.store import explained, kept_points
from chaosdrill.sweep.tuning import TUNING

# no analysis can have a name that begins like this
_LOCK, _SCENE = "_lock", "_scene.json"
_DATASET = "result.nc"


class Parts:
    """Finished parts of a run, as a context manager; the folder is removed on exit, unless a fault leaves parts in it.

    ``folder``: created if it does not exist. ``scene``: everything that determines the numbers: ``"analysis"`` (by
    name) and what all analyses depend on. ``resume``: whether to continue an unfinished run found there.

    Raises, on entering, `SettingsError` if an unfinished run is found and ``resume`` is false, `SceneError` if
    ``resume`` is set but its parts are of another scene, with what has changed, and `ArchiveError` if the folder cannot
    be used, or another process uses it.
    """

    def __init__(self, folder: str | os.PathLike[str], scene: Mapping[str, Any], *, resume: bool) -> None:
        self.folder = Path(folder)
        self.scene = plain(scene)
        self.resume = resume

    def __enter__(self) -> Self:
        with explained(self.folder, "cannot be used for finished parts"):
            self._refuse_link(self.folder)
            remove_drafts(self.folder)
            self.folder.mkdir(exist_ok=True)
            self._lock = open_own(self.folder / _LOCK, os.O_RDWR)
        try:
            self._take_over()
        except BaseException:
            os.close(self._lock)
            raise
        return self

    def __exit__(self, fault: type[BaseException] | None, *_: object) -> None:
        with suppress(OSError):
            if fault is None or not self.kept():
                # out of the way first, so that what a kill leaves of it is of no run
                away = draft_of(self.folder)
                os.replace(self.folder, away)
                flush(away.parent)
                remove(away)
        os.close(self._lock)

    def kept(self) -> dict[str, str]:
        """Progress by analysis: ``"finished"`` or ``"1200 of 5000 points"``; empty if the folder is gone."""
        found: dict[str, str] = {}
        if not self.folder.is_dir():
            return found
        for folder in sorted(self.folder.iterdir()):
            # a stranger's name might make lines of its own
            if unstorable(folder.name) is not None:
                continue
            done, points = kept_points(folder)
            if (folder / _DATASET).exists() or 0 < done == points:
                found[folder.name] = "finished"
            elif done:
                found[folder.name] = f"{done} of {points} points"
        return found

    def store(self, group: str) -> Path:
        """Folder for the finished chunks of a sweep.

        Raises `ArchiveError` if it is a link, since writing to it would change other files.
        """
        self._refuse_link(self.folder / group)
        return self.folder / group

    def finished(self, group: str) -> Dataset | None:
        """The stored dataset of an analysis; None if it is missing or, with a warning, if it is damaged."""
        path = self.folder / group / _DATASET
        if not path.exists():
            return None
        try:
            with open_ordinary(path, TUNING.result_bytes) as file:
                whole = has_checksum(file)
        except (OSError, ValueError):
            whole = False
        told = "is damaged, or its checksum"
        if whole:
            try:
                # nothing is decoded, so that every bit comes back
                with borrowed() as reader:
                    groups = reader.read(path, decoded=False)
                if list(groups) == ["/"]:
                    return groups["/"].drop_encoding()
                told = "holds several results"
            except DamagedError as fault:
                told = f"cannot be used ({str(fault).removeprefix(f'{path}: ')})"
        self.recomputed(group, told)
        return None

    def recomputed(self, group: str, told: str) -> None:
        """Warn that the stored dataset of an analysis is of no use, and why."""
        warnings.warn(f"{self.folder / group / _DATASET} {told}; {group} is recomputed", stacklevel=3)

    def keep(self, group: str, dataset: Dataset) -> None:
        """Store the dataset of a finished analysis."""
        folder = self.store(group)
        with explained(self.folder, f"cannot keep the result of {group}"):
            # a folder that was removed during the work is not made again: it would hold a part of the parts
            os.stat(self.folder / _LOCK)
            folder.mkdir(exist_ok=True)
            encoding = {str(name): {"_FillValue": None} for name in dataset.variables}
            target = folder / _DATASET
            with signals_wait(), replacing(target) as draft, small_netcdf_cache(), netcdf_name(draft) as known:
                dataset.to_netcdf(known, engine="netcdf4", encoding=encoding)
                append_checksum(draft)

    def _take_over(self) -> None:
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            fault = f"{self.folder}: another run is using this folder; wait until it ends, or stop it"
            raise ArchiveError(fault) from None
        except OSError:
            # some network file systems know no locks
            pass
        with explained(self.folder, "cannot be used for finished parts"):
            before = self._read()
            kept = self.kept()
            if not kept:
                for entry in self.folder.iterdir():
                    if entry.name not in (_LOCK, _SCENE):
                        remove(entry)
            elif not self.resume:
                raise SettingsError(
                    f"{self.folder}: holds an unfinished run ({_listed(kept)}); continue it with --resume, "
                    "or remove the folder to start over"
                )
            else:
                self._compare(before, kept)
            with replacing(self.folder / _SCENE) as draft:
                draft.write_text(json.dumps(self.scene), encoding="utf-8")

    def _read(self) -> dict[str, Any]:
        """What the folder says that it holds; nothing if it is empty, but for what a kill has left of saying it."""
        path = self.folder / _SCENE
        try:
            read: dict[str, Any] = read_json(path)
            if not isinstance(read["analysis"], dict):
                raise ValueError(path)
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            drafts = {draft.name for draft in drafts_of(path)}
            if not path.exists() and set(os.listdir(self.folder)) - drafts == {_LOCK}:
                return {}
            raise ArchiveError(
                f"{path}: missing or damaged, so it is unknown what {self.folder} holds; move it away or remove it"
            ) from None
        return read

    def _compare(self, before: dict[str, Any], kept: Mapping[str, str]) -> None:
        """Refuse a scene other than that of the parts; analyses of which nothing is kept may differ."""
        was, now = (
            {**scene, "analysis": {name: value for name, value in scene["analysis"].items() if name in kept}}
            for scene in (before, self.scene)
        )
        if found := "\n  ".join(changes(was, now)):
            raise SceneError(
                f"{self.folder}: holds an unfinished run ({_listed(kept)}) of another scene. What has changed:\n  "
                f"{found}\nRestore it and continue with --resume, or remove the folder to start over"
            )

    def _refuse_link(self, folder: Path) -> None:
        if folder.is_symlink():
            raise ArchiveError(f"{folder}: is a link; remove it to start over")


def _listed(kept: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {state}" for name, state in kept.items())

"""Write an archive whole, or leave what was there."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from chaosdrill.annotations import Dataset, DataTree, Variable
from chaosdrill.archive.digest import append_checksum, with_digests
from chaosdrill.archive.read import groups_of
from chaosdrill.archive.tuning import TUNING
from chaosdrill.dataset.label import without_lost_codes
from chaosdrill.declared import unstorable
from chaosdrill.errors import ArchiveError
from chaosdrill.files import (
    draft_of,
    followed,
    is_read_only,
    netcdf_name,
    reason_of,
    remove_drafts,
    replacing,
    signals_wait,
    small_netcdf_cache,
)
from chaosdrill.names import brief
from chaosdrill.typed import PATH, RESULT, expecting

_OTHER_FORMATS = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat"), "or write a table by ds.to_dataframe().to_csv(path)"),
    **dict.fromkeys((".xls", ".xlsx"), "or write a table by ds.to_dataframe().to_excel(path)"),
    ".parquet": "or write a table by ds.to_dataframe().to_parquet(path)",
    ".json": "or write what ds.to_dict() returns",
    **dict.fromkeys((".npy", ".npz", ".mat", ".pkl", ".pickle"), "or write its arrays, as ds[name].values"),
    ".zarr": "or write it by ds.to_zarr(path)",
    ".toml": "or write the scene by chaosdrill.save_scene",
    **dict.fromkeys((".html", ".htm"), "and then a report by chaosdrill.report"),
    **dict.fromkeys((".png", ".pdf", ".svg", ".jpg", ".jpeg", ".gif", ".mp4"), "and draw it by chaosdrill.plot"),
}
"""Advice for file names with the ending of another format."""

_DECODED = {"_FillValue", "missing_value", "scale_factor", "add_offset", "_Unsigned", "dtype", "coordinates"}
"""Attributes that readers take for rules by which they change values."""

COMPRESSION = {"zlib": True, "complevel": TUNING.level, "shuffle": True}


@expecting(ArchiveError, tree=RESULT, path=PATH)
def save(tree: "DataTree | Dataset", path: str | os.PathLike[str]) -> Path:
    """Write an archive.

    The file is written beside its target, flushed to the disk and only then moved into place, so that a full disk or an
    interrupt leaves only the earlier file; Ctrl-C takes effect when the file is complete. Every group gets the digests
    of its variables, which show `verify` and `info` what was altered later.

    Parameters
    ----------
    tree : xarray.DataTree or xarray.Dataset
        The result of an analysis or a scene.
    path : path-like
        Target file; an earlier one is replaced.

    Returns
    -------
    pathlib.Path
        The target.

    Raises
    ------
    ArchiveError
        If the file cannot be written, if ``tree`` holds no result of an analysis, which `open` would refuse, or if it
        holds something that NetCDF cannot store, such as an attribute that is None.
    """
    import xarray as xr

    if isinstance(tree, xr.Dataset):
        groups = {"/": tree}
    elif isinstance(tree, xr.DataTree):
        groups = groups_of(tree)
    else:
        ways = {
            xr.DataArray: "; save the dataset that it is part of",
            dict: "; xarray.DataTree.from_dict makes a tree of datasets by name",
            list: "; name them: xarray.DataTree.from_dict({'spectrum': ds, ...})",
        }
        received = f"{type(tree).__name__} {brief(tree)}{ways.get(type(tree), '')}"
        raise ArchiveError(f"tree: expected an xarray.DataTree or an xarray.Dataset, received {received}")
    if not any("kind" in group.attrs for group in groups.values()):
        held = ", ".join(str(name) for group in groups.values() for name in group.data_vars) or "nothing"
        raise ArchiveError(
            f"tree: holds {held:.200}, and no result of an analysis, which has the attribute 'kind'; put what analyses "
            "return into it, or write other data with its own method to_netcdf"
        )
    target = Path(path)
    check_writable(target)
    for path, group in groups.items():
        if fault := _lost(path.rpartition("/")[2], group):
            raise ArchiveError(f"{target}: {'' if path == '/' else f'{path!r:.60}: '}{fault}")
    # how a file was packed that the values come from would round them
    plain = {path: with_digests(without_lost_codes(group).drop_encoding()) for path, group in groups.items()}
    tree = xr.DataTree.from_dict(plain)
    with signals_wait(), writing(target, "archive") as draft, small_netcdf_cache(), netcdf_name(draft) as known:
        try:
            tree.to_netcdf(known, engine="netcdf4", format="NETCDF4", encoding=_encoding(plain))
        except RuntimeError as fault:
            # of a full disk the NetCDF library knows no more than that it failed
            raise OSError(f"{fault} (is the disk full?)") from fault
        except (AttributeError, TypeError, ValueError) as fault:
            # the libraries below name what NetCDF has no type or name for: None, complex numbers, objects, a "/"
            raise ArchiveError(f"{target}: NetCDF cannot hold what was added: {fault}") from fault
        append_checksum(draft)
    return target


@contextmanager
def writing(target: Path, what: str, *, named: bool = True) -> Iterator[Path]:
    """Name of a file to write, which takes the place of ``target`` when the block ends without a fault.

    What processes that were killed have left beside it is removed.

    ``target``: as for `replacing`. ``what``: what is written: "archive", "report", "picture". ``named``: whether the
    user has named the target. A link is followed only then.

    Raises `ArchiveError` if the file cannot be written, with the reason.
    """
    try:
        place = followed(target) if named else target
        remove_drafts(place)
        with replacing(place) as draft:
            yield draft
    except OSError as fault:
        raise ArchiveError(
            f"{target}: cannot write the {what}: {reason_of(fault)}; an earlier file is unchanged"
        ) from fault


def check_writable(path: str | os.PathLike[str], ending: str = ".nc", *, named: bool = True) -> None:
    """Refuse a target that cannot be written, before any work is done for it.

    ``path``: the target. ``ending``: of the name that a message proposes. ``named``: whether the user has named the
    target. Where the name was made for him, no link is followed.

    Raises `ArchiveError`, with the reason.
    """
    target = Path(path)
    way = _OTHER_FORMATS.get(target.suffix.lower())
    if ending == ".nc" and way is not None:
        raise ArchiveError(
            f"{target}: archives are NetCDF, but {target.suffix!r} says another format; name the file "
            f"{target.stem[:100]}.nc, {way}"
        )
    # os.path says no where a name is too long or holds a zero byte, which Path.is_dir raises
    if os.path.isdir(target):
        raise ArchiveError(f"{target}: is a folder; name a file, as in {target / f'result{ending}'}")
    if os.path.exists(target) and not os.path.isfile(target):
        raise ArchiveError(f"{target}: not an ordinary file, and will not be replaced; name another file")
    if not named and os.path.islink(target):
        raise ArchiveError(
            f"{target}: is a link to {os.path.realpath(target)}, which you have not named; name the file to write with "
            "-o, or remove the link"
        )
    try:
        place = followed(target)
        trial = draft_of(place)
        # the name of the trial is short, so that it does not reveal a name that is too long
        with suppress(FileNotFoundError):
            place.lstat()
    except OSError as fault:
        raise ArchiveError(f"{target}: cannot be written: {reason_of(fault)}; name another file") from fault
    if is_read_only(place):
        raise ArchiveError(f"{target}: is read-only, and will not be replaced; chmod u+w would allow it")
    if not os.path.isdir(place.parent):
        raise ArchiveError(f"{target}: the folder {place.parent} does not exist; create it first")
    try:
        with signals_wait():
            trial.touch(exist_ok=False)
            trial.unlink()
            with netcdf_name(trial):
                pass
    except OSError as fault:
        raise ArchiveError(
            f"{target}: cannot write into {place.parent}: {reason_of(fault)}; name a file in another folder"
        ) from fault


def _lost(place: str, group: Dataset) -> str:
    """What readers would not get back of a group as it is, and what to do; empty if nothing is lost."""
    keys = [key for attributes in (group.attrs, *(one.attrs for one in group.variables.values())) for key in attributes]
    for name in (*filter(None, [place]), *group.dims, *group.variables, *keys):
        if (reason := unstorable(name) if isinstance(name, str) else "is no text") is not None:
            return f"the name {name!r:.60} {reason}; rename it"
    if fault := _lost_attribute(group.attrs, {"coordinates"}):
        return f"the group {fault}"
    for name, one in group.variables.items():
        if fault := _lost_attribute(one.attrs, _DECODED) or _lost_values(str(name), one):
            return f"{name!s:.60} {fault}"
    return ""


def _lost_attribute(attributes: Mapping[Any, Any], decoded: set[str]) -> str:
    import numpy as np

    for name, value in attributes.items():
        if name in decoded:
            return f"has the attribute {name!r}, with which readers change values; remove it"
        entries = np.asarray(value, object).ravel().tolist()
        if any(isinstance(entry, bytes) or (isinstance(entry, str) and "\0" in entry) for entry in entries):
            return f"has the attribute {name!r:.60} with bytes; give text without a zero byte"
    return ""


def _lost_values(name: str, variable: Variable) -> str:
    import numpy as np

    kind, values, unit = variable.dtype.kind, variable.values, str(variable.attrs.get("units", ""))
    if kind == "m":
        way = f"ds[{name!r:.60}] / numpy.timedelta64(1, 's')"
        return f"holds spans of time, which NetCDF stores as numbers with a unit; divide them by one, as in {way}"
    if kind in "iuf" and " since " in unit:
        return f"holds numbers with the unit {unit!r:.60}, which readers such as xarray.decode_cf turn into dates"
    if kind == "M" and (np.abs(values[~np.isnat(values)].astype("M8[s]").astype("i8")) >= 2**63 // 10**9).any():
        return "holds dates before 1678 or after 2261, which readers cannot restore; give numbers"
    entries = values.ravel().tolist() if kind in "OUT" else []
    texts = [entry for entry in entries if isinstance(entry, str)]
    missing = [entry for entry in entries if entry is None or (isinstance(entry, float) and entry != entry)]
    others = len(texts) + len(missing) < len(entries) or not isinstance(variable.dtype, np.dtype)
    if others or (missing and not texts):
        return "holds objects; give numbers or texts"
    if any("\0" in text for text in texts):
        return "holds a text with a zero byte; remove it"
    return ""


def _encoding(groups: dict[str, Dataset]) -> dict[str, dict[str, dict[str, Any]]]:
    encoding: dict[str, dict[str, dict[str, Any]]] = {}
    for path, dataset in groups.items():
        encoding[path] = {}
        for name, variable in dataset.variables.items():
            chosen: dict[str, Any] = {}
            if variable.dtype.kind in "iufb" and variable.ndim and variable.size:
                chosen |= COMPRESSION
            if name in dataset.coords:
                # CF: a coordinate has no missing values
                chosen["_FillValue"] = None
            if chosen:
                encoding[path][str(name)] = chosen
    return encoding

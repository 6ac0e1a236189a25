"""Which pictures an archive gives, and the one function that draws them."""

from collections import Counter
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.plots.companions import fits, limits, swept
from chaosdrill.plots.picture import PICTURES, Picture
from chaosdrill.typed import PATH, TEXT, expecting

if TYPE_CHECKING:
    import xarray as xr

FORMATS = ("png", "pdf", "svg")


@expecting(SettingsError, path=PATH, output=PATH, group=TEXT)
def plot_archive(
    path: str | PathLike[str], output: str | PathLike[str] | None = None, group: str | None = None
) -> list[Path]:
    """Draw every picture that suits what is in an archive.

    Parameters
    ----------
    path : path
        The archive.
    output : path, optional
        The picture's file; its suffix (png, pdf or svg) is the format. Where there are several pictures, the group's
        and the picture's names are put in front of the suffix. Default: beside the archive, under its name, as png.
    group : str, optional
        Only this group of the archive.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ArchiveError
        The archive cannot be read, has no such group, or holds nothing that a picture suits; or a picture cannot be
        written.
    SettingsError
        The suffix of ``output`` names no known format.
    """
    from chaosdrill.archive import check_writable, writing
    from chaosdrill.archive import open as open_archive
    from chaosdrill.archive.digest import error_context
    from chaosdrill.plots.style import style

    if output is not None and fspath(output) == "-":
        raise SettingsError("output is '-', but pictures are files, one or several; name one, such as figure.png")
    if output is not None and Path(output).suffix.lstrip(".").lower() not in FORMATS:
        raise SettingsError(
            f"output: {fspath(output)!r} has no picture format as its ending; use one of {', '.join(FORMATS)}"
        )
    groups = {node.path.strip("/"): node.to_dataset() for node in open_archive(path).subtree if "kind" in node.attrs}
    # what can be opened has a name, from which that of a picture is made
    target = Path(output) if output is not None else Path(path).with_suffix(".png")
    if group is not None and group.strip("/") not in groups:
        raise ArchiveError(f"{path}: no group {group!r}; groups are {', '.join(groups) or 'none'}")
    wanted = groups if group is None else {group.strip("/"): groups[group.strip("/")]}
    with error_context(path, groups.values(), "drawn"):
        planned = plan(wanted)
    if not planned:
        kinds = ", ".join(f"{name} ({ds.attrs['kind']})" for name, ds in wanted.items())
        raise ArchiveError(f"{path}: there is no picture for {kinds or 'an archive without analyses'}")

    stems = stems_of(target.stem, planned) if output is None or len(planned) > 1 else [target.stem]
    files = [target.with_name(stem + target.suffix) for stem in stems]
    for file in files:
        check_writable(file, target.suffix)
    for (names, picture), file in zip(planned, files, strict=True):
        with error_context(path, groups.values(), "drawn"), style():
            figure = picture.draw(*(wanted[name] for name in names), over=behind(picture, wanted[names[0]], groups))
            with writing(file, "picture") as draft:
                figure.savefig(draft, format=target.suffix.lstrip(".").lower())
            # it holds itself in circles, and a million cells would wait for the collector
            figure.clear()
    return files


def plan(wanted: "dict[str, xr.Dataset]") -> list[tuple[list[str], Picture]]:
    """The pictures that suit some groups, each with the names of the groups that go into it."""
    planned: list[tuple[list[str], Picture]] = []
    for name, dataset in wanted.items():
        for picture in PICTURES:
            if not picture.suits(dataset):
                continue
            together = (
                names
                for names, other in planned
                if other is picture and picture.over and _alike(wanted[names[0]], dataset)
            )
            if (names := next(together, None)) is not None:
                names.append(name)
            else:
                planned.append(([name], picture))
    return planned


def stems_of(stem: str, planned: list[tuple[list[str], Picture]]) -> list[str]:
    """Names of the files of planned pictures, without their suffix, all different.

    A group that is named as its picture, or as the archive, need not say so twice, unless two pictures would then
    have one name and the later would replace the earlier.
    """
    whole = [[stem, *(name.replace("/", "-") for name in names), picture.name] for names, picture in planned]
    brief = ["-".join(part for part in dict.fromkeys(parts) if part) for parts in whole]
    times = Counter(brief)
    return [
        name if times[name] == 1 else "-".join(filter(None, parts)) for name, parts in zip(brief, whole, strict=True)
    ]


def _alike(dataset: "xr.Dataset", other: "xr.Dataset") -> bool:
    """Whether two datasets go into one picture: in that of a wide range nothing would be seen of a narrow one.

    Curves over two parameters have ranges that only say where to look for them.
    """
    return fits(dataset, other) and (len(swept(dataset)) > 1 or limits(dataset) == limits(other))


def behind(picture: Picture, dataset: "xr.Dataset", groups: "dict[str, xr.Dataset]") -> "xr.Dataset | None":
    """What a picture is drawn over: the first group of the archive that fits, also if it was not asked for itself."""
    return next((ds for ds in groups.values() if ds.attrs["kind"] == picture.over and fits(dataset, ds)), None)

"""Pictures: their declaration, the choice for a result or an archive, and the functions that draw them."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial, wraps
from inspect import signature
from itertools import count
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from chaosdrill.archive import check_writable, writing
from chaosdrill.archive import open as open_archive
from chaosdrill.archive.digest import error_context
from chaosdrill.dataset.dates import undated
from chaosdrill.dataset.label import axes_of
from chaosdrill.dataset.schema import RUN, STARTS_OF_RUNS, SWEEP, table_of
from chaosdrill.errors import ArchiveError, ChaosdrillError, SettingsError
from chaosdrill.names import brief, visible
from chaosdrill.plots._types import Axes, Dataset, Figure, States
from chaosdrill.plots.animation import MOVING, animate
from chaosdrill.plots.contents import SINGLE, OtherCountError, check_names, fits, limits, settings, shown_in_si, swept
from chaosdrill.plots.figures import made_by
from chaosdrill.plots.markers import failures, tell, tell_on
from chaosdrill.plots.style import keep_ticks, lettering, saved_alike, style
from chaosdrill.typed import AXES, NAMED, PATH, SWITCH, TEXT, expecting

FORMATS = ("png", "pdf", "svg")
# the same picture is the same file
_UNDATED: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}

F = TypeVar("F", bound="Callable[..., Figure]")


@dataclass(frozen=True)
class Picture:
    """A picture that can be drawn of one kind of dataset."""

    kind: str  # kind of analysis that it shows
    name: str  # its name, part of the file's name
    summary: str  # what it shows, in a few words
    function: Callable[..., Any]
    """It takes the dataset and returns a matplotlib figure. That of a picture with ``over`` takes all datasets that
    belong together, and what they lie over as ``over``."""
    states: int = 1
    seeds: int = 1
    """How many states the system, and how many seeds the dataset, must have for it."""
    needs: str = ""  # variable of which the dataset must contain a finite value
    parameters: int = 0  # how many parameters the analysis ran through; 0 if that does not matter
    sweeps: bool | None = None  # whether it shows a sweep or a single run; default: either
    listed: bool | None = None
    """Whether it shows a list of runs, with the dimension ``run``, or others; default: either."""
    values: int = 0  # how many values of them there must be; 0 if that does not matter
    over: str = ""
    """Kinds of datasets used as background, separated by blanks: the first that the archive holds of the same
    system over the same parameters. All groups over these parameters, and over the same range of a single one, go
    into one picture."""

    @property
    def shows_states(self) -> bool:
        """Whether it shows states that can be chosen."""
        return "state" in signature(self.function).parameters

    def draw(
        self, *datasets: Dataset, over: Dataset | None = None, ax: Axes | None = None, state: States = None
    ) -> Figure:
        """Return the figure of a dataset, or of several that belong together.

        ``over``: what it is drawn over. ``ax``: where its main panel alone is drawn. ``state``: states that it shows.

        Raises `SettingsError` if no state can be chosen for it, or it has no main panel.
        """
        given = {name: value for name, value in (("ax", ax), ("state", state)) if value is not None}
        taken = signature(self.function).parameters
        if "ax" in given and "ax" not in taken:
            raise SettingsError(f"ax is one axes, but the picture {self.name!r} has several panels; leave it out")
        if "state" in given and not self.shows_states:
            raise SettingsError(f"state is {state!r:.60}, but the picture {self.name!r} shows no single states")
        return self.function(*datasets, **given, **({"over": over} if self.over else {}))

    def suits(self, dataset: Dataset) -> bool:
        """Return whether the picture can be drawn of this dataset."""
        return (
            dataset.attrs.get("kind") == self.kind
            and dataset.sizes.get("state", self.states) >= self.states
            and dataset.sizes.get("seed", 1) >= self.seeds
            and self.listed in (None, "run" in (dataset.dims if self.listed else dataset.coords))
            and self.sweeps in (None, bool(swept(dataset)))
            and self.parameters in (0, len(swept(dataset)))
            and self.values in (0, *(dataset.sizes.get(name, 1) for name in swept(dataset)))
            and (
                not self.needs
                or (self.needs in dataset.variables and bool(np.isfinite(dataset[self.needs].values).any()))
            )
        )


MOTION = Picture("trajectory", "animation", "the run as a moving picture", animate)
PICTURES: list[Picture] = []
"""All pictures; `chaosdrill.plots` imports every module that has some."""


def picture(kind: str, name: str, summary: str, **when: Any) -> Callable[[F], F]:
    """Register a function as a picture: its kind, name and summary, and the datasets that it suits, as in `Picture`.

    The function takes the dataset, of that kind and in SI units if its scene was, or several that belong together. It
    returns the figure, with all panels, or only the main one on the user's axes if it has the keyword ``ax``; with the
    keyword ``state`` it shows the states that are named, by default those that its docstring says. `plot` draws the
    first picture that suits a dataset, in the order of files and lines.
    """

    def wrap(function: F) -> F:
        made = _complete(function)
        PICTURES.append(Picture(kind, name, summary, made, **when))
        return made

    return wrap


def _complete(function: F) -> F:
    """The same function in the project's style, with results in SI units if they exist; it reports failed runs."""
    # a function may draw several pictures
    if hasattr(function, "is_complete"):
        return function

    @wraps(function)
    def drawn(*datasets: Dataset, **options: Any) -> Figure:
        if options.get("over") is not None:
            options["over"] = shown_in_si(options["over"])
        ax = options.get("ax")
        with style() if ax is None else lettering():
            figure = function(*map(shown_in_si, datasets), **options)
            if ax is None:
                keep_ticks(figure)
                tell(figure, failures(datasets))
            else:
                tell_on(ax, failures(datasets))
        return figure

    drawn.is_complete = True  # type: ignore[attr-defined]
    return cast(F, drawn)


@expecting(SettingsError, kind=TEXT, ax=AXES, state=NAMED)
def plot(
    ds: "Dataset",
    kind: str | None = None,
    ax: "Axes | None" = None,
    state: States = None,
    over: "Dataset | None" = None,
) -> "Axes":
    """Draw a result.

    A notebook shows the picture below its cell, a script by ``matplotlib.pyplot.show()``. The pictures are those of
    `plot_archive` and of reports.

    Parameters
    ----------
    ds : xarray.Dataset
        The result of an analysis, a group of an archive, or a part of it.
    kind : str, optional
        Name of the picture, such as ``"phase-portrait"`` or ``"lyapunov-chart"``; default: the first that suits.
    ax : matplotlib.axes.Axes, optional
        Axes to draw on; a picture with several panels draws its main one. Default: a new figure with all panels.
    state : str or pair of str, optional
        State to show, or two to plot against each other; default: the first ones, for a section the first that varies.
        A trajectory shows any number of states over time.
    over : xarray.Dataset, optional
        Background: a bifurcation diagram behind branches, or a parameter chart behind curves, of the same
        system over the same parameters; basins or a section behind manifolds.

    Returns
    -------
    matplotlib.axes.Axes
        The main panel; ``axes.figure`` is the figure.

    Raises
    ------
    SettingsError
        If ``ds`` is not a single result, if ``kind`` or ``state`` is unknown, if the picture needs more than one axes,
        or if ``over`` does not fit.
    """
    import xarray as xr
    from matplotlib import pyplot

    if isinstance(ds, xr.DataTree) and "kind" in ds.attrs:
        ds = ds.to_dataset()
    if not isinstance(ds, xr.Dataset) or "kind" not in ds.attrs:
        raise SettingsError(f"ds is {brief(ds)}; give what an analysis has returned, {_result_of(ds)}")
    if lost := [name for name in swept(ds) if name in ds.coords and name not in ds.dims]:
        raise SettingsError(f"{lost[0]} has been selected to one value; give several, as in ds.sel({lost[0]}=[value])")
    ds = _with_dimensions(undated(ds))
    _check_dimensions(ds)
    _check_special_points(ds)
    suited = {picture.name: picture for picture in PICTURES if picture.suits(ds)}
    if not suited or (kind is not None and kind not in suited):
        raise SettingsError(
            f"there is no picture {'' if kind is None else repr(kind) + ' '}of this {ds.attrs['kind']}"
            + (f"; choose from {', '.join(suited)}" if suited else "")
        )
    picture = next(iter(suited.values())) if kind is None else suited[kind]
    if over is not None:
        _check_behind(picture, ds, over)
    try:
        if ax is not None:
            picture.draw(ds, ax=ax, state=state, over=over)
            return ax
        with made_by(pyplot.figure):
            return picture.draw(ds, state=state, over=over).axes[0]
    except (ChaosdrillError, MemoryError):
        raise
    except Exception as fault:
        # the table of variables is that of all analyses, which a first picture need not wait for
        if (told := _lacks(ds)) is None:
            raise
        raise SettingsError(told) from fault


def _lacks(ds: Dataset) -> str | None:
    """What a part of a result lacks, of which a picture may fail; None for a whole one."""
    declared, axes = table_of(str(ds.attrs["kind"]), map(str, ds.variables)), axes_of(settings(ds))
    placeholders = {SWEEP: axes, STARTS_OF_RUNS: () if "run" in ds.coords else axes}
    for name, declaration in declared.items():
        if declaration.required and name not in ds.variables and "{" not in name:
            return f"ds lacks the variable {name!r}; draw the whole result, or what ds.sel or ds.isel select of it"
        for dim in declaration.dims if name in ds.variables else ():
            for one in placeholders.get(dim, () if dim.startswith("{") else (dim,)):
                if one not in ds[name].dims:
                    return f"ds has one entry of {one!r} alone; select it as a list, as in ds.isel({one}=[0])"
    return _without_entries(ds, map(str, ds.sizes))


def _without_entries(ds: Dataset, dims: Iterable[str]) -> str | None:
    """What to do where a dataset has no entry of one of some dimensions; None where it has."""
    empty = next((dim for dim in dims if ds.sizes.get(dim) == 0), None)
    return None if empty is None else f"ds has no entry of {empty!r}; select some, as in ds.isel({empty}=[0])"


def _result_of(value: Any) -> str:
    """How the result of an analysis comes of what was given for it."""
    if PATH.holds(value):
        return f"or one group of the archive, as in chaosdrill.open({brief(value)})['motion'], or take plot_archive"
    if hasattr(value, "with_parameters"):
        return "as in chaosdrill.plot(chaosdrill.trajectory(system, ...))"
    if isinstance(value, list | tuple):
        return "one after the other, on the axes of your own (ax) if they belong together"
    if hasattr(value, "dims") and not hasattr(value, "subtree"):
        return (
            "or one group of an archive, with its variables and attributes; a part of it is ds.isel(...) or ds.sel(...)"
        )
    return "or one group of an archive, as in chaosdrill.open(path)['motion']"


def _check_behind(picture: Picture, ds: Dataset, over: Any) -> None:
    """Raise a SettingsError if a picture cannot be drawn over something."""
    import xarray as xr

    if not picture.over:
        raise SettingsError(f"over is given, but the picture {picture.name!r} has no background; leave it out")
    kind = over.attrs.get("kind") if isinstance(over, xr.Dataset) else None
    kinds = picture.over.split()
    if kind not in kinds:
        what = f"a {kind}" if kind else type(over).__name__
        raise SettingsError(f"over is {what}, but the picture {picture.name!r} lies over a {' or a '.join(kinds)}")
    if not fits(ds, over):
        along = f" over {', '.join(swept(ds))}" if swept(ds) else ""
        raise SettingsError(
            "over is of another system, other parameters or another section"
            + (f", or over {', '.join(swept(over))}" if swept(over) else "")
            + f"; give a {' or a '.join(kinds)}{along} that was made as ds"
        )


def _with_dimensions(ds: Dataset) -> Dataset:
    """The dataset with the dimension of which one seed or one state has been selected."""
    for dim in ("seed", "state"):
        if dim in ds.coords and dim not in ds.dims:
            declared = table_of(str(ds.attrs["kind"]), map(str, ds.variables))
            names = [n for n in ds.variables if n in declared and dim in declared[str(n)].dims and n != dim]
            ds = ds.drop_vars([*names, dim]).assign({n: ds[n].expand_dims(dim) for n in names})
    return ds


def _check_dimensions(ds: Dataset) -> None:
    """Raise a SettingsError for no entry of a dimension, or for several results in one, which no picture separates."""
    if told := _without_entries(ds, ("seed", "state", "exponent")):
        raise SettingsError(told)
    kind = str(ds.attrs["kind"])
    ended = "outcome" in ds.variables and ds["outcome"].ndim > 0
    # the table of variables is that of all analyses, which a first picture need not wait for
    if "run" not in ds.dims and not (kind in SINGLE and ended):
        return
    declared = table_of(kind, map(str, ds.variables))
    for name, variable in ds.variables.items():
        dims = declared[str(name)].dims if name in declared else ()
        further = [str(dim) for dim in variable.dims if dim not in dims]
        # a name in braces stands for dimensions that a dataset may have
        if not further or name not in declared or any(dim.startswith("{") for dim in dims):
            continue
        if kind == "trajectory" and further == [RUN.strip("{}")]:
            continue
        raise SettingsError(
            f"ds has the dimension {further[0]!r}, which a {kind} has not; choose one of it, as in "
            f"ds.isel({further[0]}=0), or draw one after the other on the axes of your own (ax)"
        )


def _check_special_points(ds: Dataset) -> None:
    """Raise a SettingsError if points of branches were left out, so that the special points stand at other ones."""
    if not {"special_index", "special_point"} <= ds.variables.keys():
        return
    places, kinds = ds["special_index"].values, ds["special_point"].values
    if any(place >= kinds.size or not kinds[place] for place in places.ravel().tolist()):
        raise SettingsError(
            "ds lacks points of branches, and special_index counts all of them; draw the whole result and narrow the "
            "axes, as in cd.plot(result).set_xlim(low, high)"
        )


@expecting(SettingsError, path=PATH, output=PATH, group=TEXT, animated=SWITCH, state=NAMED)
def plot_archive(
    path: str | PathLike[str],
    output: str | PathLike[str] | None = None,
    group: str | None = None,
    animated: bool = False,
    state: States = None,
) -> list[Path]:
    """Draw every picture that suits the contents of an archive.

    Parameters
    ----------
    path : path
        The archive.
    output : path, optional
        File of the picture; its suffix (png, pdf or svg) is the format. If there are several, the names of group and
        picture are inserted before the suffix. Default: next to the archive, under its name, as png.
    group : str, optional
        Only this group of the archive.
    animated : bool, default False
        An animation of each run instead, as by `animate`: gif, the default, or mp4.
    state : str or pair of str, optional
        State to show, or two to plot against each other. It does not affect pictures with another number of states.
        Default: as in `plot`.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ArchiveError
        If the archive cannot be read, has no such group or nothing to draw, or if a picture cannot be written.
    SettingsError
        If the suffix of ``output`` is not a known format, if a state is unknown, or if no picture shows this number of
        states.
    """
    if output is not None and fspath(output) == "-":
        raise SettingsError("output is '-', but pictures are files, one or several; name one, such as figure.png")
    formats, what = (MOVING, "animation") if animated else (FORMATS, "picture")
    if output is not None and Path(output).suffix.lstrip(".").lower() not in formats:
        raise SettingsError(
            f"output: {fspath(output)!r} has no {what} format as its ending; use one of {', '.join(formats)}"
        )
    results = (node for node in open_archive(path).subtree if "kind" in node.attrs)
    groups = {node.path.strip("/"): undated(node.to_dataset()) for node in results}
    # what can be opened has a name, from which that of a picture is made
    target = Path(output) if output is not None else Path(path).with_suffix(f".{formats[0]}")
    if group is not None and group.strip("/") not in groups:
        raise ArchiveError(f"{path}: no group {group!r}; groups are {', '.join(groups) or 'none'}")
    wanted = groups if group is None else {group.strip("/"): groups[group.strip("/")]}
    with error_context(path, groups.values(), "drawn"):
        planned = [([name], MOTION) for name, ds in wanted.items() if MOTION.suits(ds)] if animated else plan(wanted)
    if not planned:
        kinds = ", ".join(f"{name} ({ds.attrs['kind']})" for name, ds in wanted.items())
        raise ArchiveError(f"{path}: there is no {what} for {kinds or 'an archive without analyses'}")

    if state is not None:
        _check_names(state, [wanted[name] for names, picture in planned if picture.shows_states for name in names])
    stems = stems_of(target.stem, planned) if output is None or len(planned) > 1 else [target.stem]
    files = [target.with_name(stem + target.suffix) for stem in stems]
    # a name that was made here may be that of a link to anything
    named = output is not None and files == [target]
    for file in files:
        check_writable(file, target.suffix, named=named)
    shown, unshown = False, list[OtherCountError]()
    with error_context(path, groups.values(), "drawn"):
        for (names, picture), file in zip(planned, files, strict=True):
            first, *others = (wanted[name] for name in names)
            has_states = picture.shows_states and set(_listed(state)) <= set(first["state"].values.tolist())
            chosen = state if has_states else None
            if animated:
                animate(first, file, chosen)
                continue
            draw = partial(picture.draw, first, *others, over=behind(picture, first, groups))
            if fault := _draw_into(file, draw, chosen, named):
                unshown.append(fault)
            else:
                shown = shown or chosen is not None
    if unshown and not shown:
        raise unshown[-1]
    return files


def _draw_into(file: Path, draw: Callable[..., Figure], state: States, named: bool) -> OtherCountError | None:
    """Write a picture; returns why it does not show the states, where it shows another number of them."""
    unshown = None
    with saved_alike():
        try:
            figure = draw(state=state)
        except OtherCountError as fault:
            unshown, figure = fault, draw()
        ending = file.suffix.lstrip(".").lower()
        with writing(file, "picture", named=named) as draft:
            figure.savefig(draft, format=ending, metadata=_UNDATED.get(ending))
        # it holds itself in circles, and a million cells would wait for the collector
        figure.clear()
    return unshown


def _check_names(state: str | Sequence[str], datasets: list[Dataset]) -> None:
    """Raise a SettingsError if no dataset has a state of a name."""
    known = dict.fromkeys(name for ds in datasets for name in ds["state"].values.tolist())
    if not known:
        raise SettingsError(f"state is {state!r:.60}, but no picture shows single states")
    check_names(_listed(state), list(known))


def _listed(state: States) -> list[str]:
    return [state] if isinstance(state, str) else list(state or ())


def plan(wanted: dict[str, Dataset]) -> list[tuple[list[str], Picture]]:
    """The pictures that suit the given groups, each with the names of the groups in it."""
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
    """Distinct file names of planned pictures, without their suffix.

    A group with the name of its picture, or of the archive, is not repeated, unless two pictures would then have the
    same name and the later one would replace the earlier.
    """
    whole = [[stem, *(visible(name).replace("/", "-") for name in names), picture.name] for names, picture in planned]
    brief = ["-".join(part for part in dict.fromkeys(parts) if part) for parts in whole]
    times = Counter(brief)
    stems: dict[str, str] = {}
    for name, parts in zip(brief, whole, strict=True):
        full = name if times[name] == 1 else "-".join(filter(None, parts))
        # the groups a/b and a-b, and A and a where names of files know no case
        counted = (full if number == 1 else f"{full}-{number}" for number in count(1))
        distinct = next(one for one in counted if one.casefold() not in stems)
        stems[distinct.casefold()] = distinct
    return list(stems.values())


def _alike(dataset: Dataset, other: Dataset) -> bool:
    """Whether two datasets go into one picture: a narrow range would be invisible in a wide one.

    The ranges of curves over two parameters only say where to look for them.
    """
    return fits(dataset, other) and (len(swept(dataset)) > 1 or limits(dataset) == limits(other))


def behind(picture: Picture, dataset: Dataset, groups: dict[str, Dataset]) -> Dataset | None:
    """The background of a picture: the first group of the archive that fits, even if it was not itself requested."""
    behind_it = (ds for kind in picture.over.split() for ds in groups.values() if ds.attrs["kind"] == kind)
    return next((ds for ds in behind_it if fits(dataset, ds)), None)

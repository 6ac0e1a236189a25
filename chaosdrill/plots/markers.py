"""Markers on branches of periodic orbits: special points, ends, colours of periods, and warnings."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from chaosdrill.dataset.outcomes import ADVICE, flag_names
from chaosdrill.plots._types import Artist, Axes, Dataset, Figure, Floats, Integers
from chaosdrill.plots.categories import MOTIONS, Category
from chaosdrill.plots.contents import MEASURES, SINGLE
from chaosdrill.plots.figures import font_size, owner, title_legend
from chaosdrill.plots.labels import readable, wrapped
from chaosdrill.plots.palette import LINE_COLOURS
from chaosdrill.plots.tuning import TUNING

_SPECIAL = {
    "fold": ("s", "fold"),
    "period_doubling": ("^", "period doubling"),
    "neimark_sacker": ("D", "Neimark-Sacker"),
    "grazing": ("o", "grazing"),
    "event_swap": ("X", "event swap"),
    "outcome_switch": ("P", "outcome switch"),
    "branch_point": ("*", "branch point"),
    "border_collision": ("h", "border collision"),
    "cusp": ("v", "cusp"),
    "resonance_1_1": ("$1$", "1:1 resonance"),
    "resonance_1_2": ("$2$", "1:2 resonance"),
    "resonance_1_3": ("$3$", "1:3 resonance"),
    "resonance_1_4": ("$4$", "1:4 resonance"),
    "fold_flip": ("d", "fold-flip"),
    "generalised_flip": (">", "generalised flip"),
    "chenciner": ("<", "Chenciner"),
    "fold_neimark_sacker": ("p", "fold-Neimark-Sacker"),
    "flip_neimark_sacker": ("H", "flip-Neimark-Sacker"),
    "double_neimark_sacker": ("8", "double Neimark-Sacker"),
    "grazing_fold": ("$+$", "grazing with fold"),
    "grazing_flip": ("$-$", "grazing with flip"),
    "grazing_neimark_sacker": ("$\\circ$", "grazing with Neimark-Sacker"),
    "level": ("$=$", "level of a function"),
    "optimum": ("$!$", "optimum of a function"),
    "hopf": ("$H$", "Hopf"),
    "crossing_sliding": ("$\\ne$", "crossing-sliding"),
    "grazing_sliding": ("$\\cap$", "grazing-sliding"),
    "adding_sliding": ("$\\cup$", "adding-sliding"),
    "switching_sliding": ("$\\wr$", "switching-sliding"),
    "resonant_grazing": ("$\\sim$", "resonant grazing"),
    "degenerate_sliding": ("$\\bowtie$", "degenerate sliding"),
    "sliding_fold": ("$\\oplus$", "sliding with fold"),
    "sliding_flip": ("$\\ominus$", "sliding with flip"),
    "sliding_neimark_sacker": ("$\\odot$", "sliding with Neimark-Sacker"),
    "boundary": ("o", "boundary equilibrium"),
}
"""Shape and name of each kind of special point; white with a black edge, or black for hard ones, seen on any line."""
WARNING = "#B3261E"
_ENDS = {
    "joined": "meets another branch",
    "doubling": "shrinks onto half the period",
    "no_effect": "the parameter has no effect",
    "rest": "shrinks onto an equilibrium",
}
_QUIET_ENDS = ("limit", "closed")
"""Ends without a mark: the line runs to the edge of the picture, or is closed."""


def special_name(name: str) -> str:
    """Return the name of a kind of special point in the legend."""
    return _SPECIAL.get(name, ("", readable(name)))[1]


def specials(dataset: Dataset) -> list[tuple[str, Integers]]:
    """Return each kind of special point that a ``continuation`` dataset has, with the numbers of its points."""
    kinds, index = dataset["special_kind"].values, dataset["special_index"].values.astype(np.int64)
    names = flag_names(dataset["special_kind"])
    return [(name, index[kinds == code]) for code, name in names.items() if (kinds == code).any()]


def soft_and_hard(dataset: Dataset) -> list[tuple[str, bool, Integers]]:
    """Return the same, apart for points at which the new motion repels and others jump away, where that is known."""
    jumps = np.zeros(0, dtype=np.int64)
    if "special_criticality" in dataset:
        names = flag_names(dataset["special_criticality"])
        subcritical = [code for code, name in names.items() if name == "subcritical"]
        jumps = dataset["special_index"].values[np.isin(dataset["special_criticality"].values, subcritical)]
    groups = [
        (kind, off, points[np.isin(points, jumps) == off])
        for kind, points in specials(dataset)
        for off in (False, True)
    ]
    return [group for group in groups if group[2].size]


def mark(axes: Axes, x: ArrayLike, y: ArrayLike, name: str, size: float, jumps: bool = False, **options: Any) -> None:
    """Draw special points of one kind, and name them in the legend; ``options``: further ones of ``Axes.plot``.

    ``x``, ``y``: where they are; NaN draws nothing. ``size``: width of the marks in points. ``jumps``: whether they are
    hard, as from `soft_and_hard`.
    """
    axes.plot(
        np.ravel(x),
        np.ravel(y),
        linestyle="none",
        marker=_SPECIAL.get(name, "*")[0],
        markersize=size,
        markerfacecolor="black" if jumps else "white",
        markeredgecolor="black",
        markeredgewidth=0.8,
        zorder=4,
        label=special_name(name) + ", hard" * jumps,
        **options,
    )


def room(axes: Axes, places: Floats) -> Floats:
    """Return the width of a mark at each place, shape (k, 2), that its neighbours allow, in steps of half a point."""
    if len(places) < 2:
        return np.full(len(places), np.inf)
    box = axes.get_position()
    width, height = owner(axes).get_size_inches()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    scale = 72 * np.array([box.width * width / (right - left), box.height * height / (high - low)])
    apart = np.hypot(*((places[:, None] - places[None]) * scale).transpose(2, 0, 1))
    # what lies on the same spot is one mark
    apart[apart < TUNING.merged_marks] = np.inf
    wide: Floats = np.maximum(TUNING.smallest_mark, np.floor(2 * apart.min(axis=1)) / 2)
    return wide


def bar(axes: Axes, x: ArrayLike, y: ArrayLike, size: float, text: str | None = None) -> None:
    """Draw upright bars at the ends of branches; parameters as for `mark`, with the text for the legend."""
    options: dict[str, Any] = {"marker": "|", "markeredgewidth": 1.4, "color": "black", "zorder": 3}
    axes.plot(np.ravel(x), np.ravel(y), markersize=size, linestyle="none", label=text, **options)


def ends(dataset: Dataset) -> tuple[Integers, list[str]]:
    """Return the last points of the branches that end before the parameter's limit, and the name of each end.

    A part of a branch without its last point does not end where it was cut.
    """
    names = flag_names(dataset["branch_end"])
    branch, way = dataset["branch"].values, dataset["arclength"].values
    # archives of 0.2.0 do not hold it
    lengths = dataset.get("branch_length")
    ended = np.ones(len(way), bool) if lengths is None else way == lengths.values[branch]
    last = [(branch == number) & ended for number in range(dataset.sizes["branch_number"])]
    found = [
        (int(np.flatnonzero(here)[-1]), names[int(code)])
        for here, code in zip(last, dataset["branch_end"].values, strict=True)
        if names[int(code)] not in _QUIET_ENDS and here.any()
    ]
    return np.array([point for point, _ in found], dtype=np.int64), [name for _, name in found]


def period_categories(datasets: Sequence[Dataset]) -> dict[int, Category]:
    """Return the colour and the name of each period that occurs; if there are many, the longest ones share both."""
    periods = sorted({int(period) for dataset in datasets for period in np.unique(dataset["branch_period"].values)})
    found = {n: Category(f"period {n}", colour) for n, colour in zip(periods, LINE_COLOURS, strict=False)}
    if len(periods) > len(LINE_COLOURS):
        longest = periods[len(LINE_COLOURS) - 1 :]
        found |= dict.fromkeys(longest, Category(f"periods {longest[0]} to {longest[-1]}", LINE_COLOURS[-1]))
    return found


def end_label(names: Iterable[str]) -> str:
    """Return the legend's text for ends of branches, broken into lines that fit."""
    return wrapped(f"end: {', '.join(_ENDS.get(name, readable(name)) for name in names)}", 32)


def named_once(axes: Axes) -> list[Artist]:
    """Return handles for a legend without repeated texts: the first one of each."""
    first: dict[str, Artist] = {}
    for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
        first.setdefault(text, handle)
    return list(first.values())


def caveat(dataset: Dataset) -> str:
    """Return the reason to doubt a dataset of orbits; empty if there is no reason.

    It is an outcome other than an orbit found, the message of the analysis, or inconsistent numbers of an orbit.
    """
    codes = np.ravel(dataset["outcome"].values)
    names = np.array([flag_names(dataset["outcome"])[int(code)] for code in codes], dtype=str)
    failed = dict.fromkeys(str(name) for name in names if name != "periodic")
    message, disagreement = (str(dataset.attrs.get(name, "")) for name in ("message", "disagreement"))
    parts = [readable(name) for name in failed] or ["no orbit found"] * (codes.size == 0)
    parts += [message] * bool(message)
    if "consistent" in dataset.variables:
        apart = (np.ravel(dataset["consistent"].values) == 0) & (names == "periodic")
        of = f" of {apart.sum()} of {apart.size} orbits" if apart.size > 1 else ""
        parts += [f"the numbers{of} disagree: {disagreement or 'see the differences'}"] * bool(apart.any())
    return "; ".join(parts)


def warn(figure: Figure, datasets: Sequence[Dataset]) -> None:
    """Write the caveats of all datasets over a figure whose legend is there already."""
    tell(figure, "\n".join(dict.fromkeys(text for text in map(caveat, datasets) if text)))


def tell(figure: Figure, text: str, colour: str = WARNING) -> None:
    """Write a warning, or a note, over a figure whose legend and title are there already; nothing if it is empty."""
    if not text:
        return
    if figure.legends:
        # a title of its own would lie on the legend
        title_legend(figure.legends[0], text, colour)
        return
    whole = "\n".join(filter(None, [figure.get_suptitle(), text]))
    figure.suptitle(whole, x=0.01, ha="left", fontsize="medium", color=colour)


def tell_on(axes: Axes, text: str) -> None:
    """Write a warning into the user's axes; nothing if it is empty."""
    if text:
        letters = max(20, int(axes.get_window_extent().width / owner(axes).dpi * 72 / (0.55 * font_size())))
        place: dict[str, Any] = {"transform": axes.transAxes, "ha": "left", "va": "top", "zorder": 6}
        axes.text(0.02, 0.98, wrapped(text, letters), color=WARNING, fontsize="small", **place)


def failures(datasets: Iterable[Dataset]) -> str:
    """Return the outcomes of runs that did not reach their end, or came to rest, with advice; empty if nothing lacks.

    It covers single and joined runs; sweeps show the outcome of each point themselves.
    """
    told: dict[str, None] = {}
    for dataset in datasets:
        kind = str(dataset.attrs.get("kind", ""))
        if "outcome" not in dataset.variables:
            continue
        one = MEASURES.get(kind) in dataset and dataset["outcome"].ndim == 0
        if not (one or kind in SINGLE):
            continue
        measured = not one or not np.isnan(dataset[MEASURES[kind]].values).all()
        names = flag_names(dataset["outcome"])
        codes = np.atleast_1d(dataset["outcome"].values)
        runs = np.atleast_1d(dataset["run"].values) if "run" in dataset.variables else np.arange(1, codes.size + 1)
        for code, run in zip(codes, runs, strict=True) if codes.ndim == 1 and codes.size == runs.size else ():
            name = names.get(int(code), "") if np.isfinite(code) else ""
            if name in ADVICE and (name not in MOTIONS or (name == "equilibrium" and not measured)):
                whose = f"run {run}: " if codes.size > 1 else ""
                told[f"{whose}{readable(name)}. {ADVICE[name]}"] = None
    return "\n".join(told)

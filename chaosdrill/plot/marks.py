"""What stands on branches of periodic orbits: special points, ends, colours of periods, and words of warning."""

from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.plot.style import PALETTE, flag_names, readable, wrapped

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

SPECIAL_MARKERS = {
    "fold": "s",
    "period_doubling": "^",
    "neimark_sacker": "D",
    "grazing": "o",
    "event_swap": "X",
    "outcome_switch": "P",
}
"""Shape of each kind of special point; all are white with a black edge, and so read on lines of any colour."""
WARNING = "#B3261E"
_NAMES = {"neimark_sacker": "Neimark-Sacker"}
_QUIET_ENDS = ("limit", "closed")
"""Ends that need no mark: the line runs to the edge of the picture, or has no end."""


def special_name(name: str) -> str:
    """Return what a kind of special point is called in a legend."""
    return _NAMES.get(name, readable(name))


def specials(dataset: "xr.Dataset") -> "list[tuple[str, NDArray[np.int64]]]":
    """Return each kind of special point that a ``continuation`` dataset has, with the numbers of its points."""
    kinds, index = dataset["special_kind"].values, dataset["special_index"].values.astype(np.int64)
    names = flag_names(dataset["special_kind"])
    return [(name, index[kinds == code]) for code, name in names.items() if (kinds == code).any()]


def mark(axes: "Axes", x: "ArrayLike", y: "ArrayLike", name: str, size: float, **options: Any) -> None:
    """Draw special points of one kind, and name them in the legend.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    x, y : array_like, the same shape
        Where they are; NaN draws nothing.
    name : str
        Kind of the points.
    size : float
        Width of the marks in points.
    **options
        Further options of ``Axes.plot``.
    """
    axes.plot(
        np.ravel(x),
        np.ravel(y),
        linestyle="none",
        marker=SPECIAL_MARKERS.get(name, "*"),
        markersize=size,
        markerfacecolor="white",
        markeredgecolor="black",
        markeredgewidth=0.8,
        zorder=4,
        label=special_name(name),
        **options,
    )


def bar(axes: "Axes", x: "ArrayLike", y: "ArrayLike", size: float, text: str | None = None) -> None:
    """Draw upright bars at the ends of branches; parameters as for `mark`, with the text for the legend."""
    look: dict[str, Any] = {"linestyle": "none", "marker": "|", "markeredgewidth": 1.4, "color": "black", "zorder": 3}
    axes.plot(np.ravel(x), np.ravel(y), markersize=size, label=text, **look)


def ends(dataset: "xr.Dataset") -> "tuple[NDArray[np.int64], list[str]]":
    """Return the last points of the branches that end before the parameter's limit, and the names of these ends."""
    names = flag_names(dataset["branch_end"])
    branch = dataset["branch"].values
    found = [
        (int(np.flatnonzero(branch == number)[-1]), names[int(code)])
        for number, code in enumerate(dataset["branch_end"].values)
        if names[int(code)] not in _QUIET_ENDS and (branch == number).any()
    ]
    return np.array([point for point, _ in found], dtype=np.int64), list(dict.fromkeys(name for _, name in found))


def period_colours(datasets: "Sequence[xr.Dataset]") -> dict[int, str]:
    """Return a colour for each period that occurs; the longest ones share the last."""
    periods = sorted({int(period) for dataset in datasets for period in np.unique(dataset["branch_period"].values)})
    return {period: PALETTE[min(place, len(PALETTE) - 1)] for place, period in enumerate(periods)}


def end_label(names: "Iterable[str]") -> str:
    """Return the legend's text for ends of branches, in lines that find room."""
    return wrapped(f"end: {', '.join(map(readable, names))}", 32)


def named_once(axes: "Axes") -> "list[Artist]":
    """Return handles for a legend in which every text stands once: the first that has it."""
    first: dict[str, Artist] = {}
    for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
        first.setdefault(text, handle)
    return list(first.values())


def caveat(dataset: "xr.Dataset") -> str:
    """Return what keeps a dataset of orbits from being taken at its word; empty if nothing does.

    It is an outcome other than an orbit found, or numbers of the orbit that do not agree with each other.
    """
    parts = []
    if "outcome" in dataset.variables:
        names = flag_names(dataset["outcome"])
        bad = dict.fromkeys(names[int(code)] for code in np.ravel(dataset["outcome"].values))
        text = str(dataset.attrs.get("message", ""))
        parts += [f"outcome: {readable(name)}" + (f" ({text})" if text else "") for name in bad if name != "periodic"]
    if "consistent" in dataset.variables and not np.all(dataset["consistent"].values):
        count, total = int(np.sum(dataset["consistent"].values == 0)), dataset["consistent"].size
        text = str(dataset.attrs.get("disagreement", "")) or "see the differences in the archive"
        parts.append(f"the numbers disagree{f' for {count} of {total} orbits' if total > 1 else ''}: {text}")
    return "; ".join(parts)


def warn(figure: "Figure", datasets: "Sequence[xr.Dataset]") -> None:
    """Write the caveats of all datasets over a figure whose legend is there already."""
    texts = dict.fromkeys(text for text in map(caveat, datasets) if text)
    text = "\n".join(wrapped(text, 100) for text in texts)
    if text and figure.legends:
        # a title of its own would lie on the legend
        legend = figure.legends[0]
        legend.set_alignment("left")
        legend.set_title(text)
        legend.get_title().set(color=WARNING, fontsize=9)
    elif text:
        figure.suptitle(text, x=0.01, ha="left", fontsize=9, color=WARNING)

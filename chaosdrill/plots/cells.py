"""Cells of a grid with their true bounds: colours, hatching, and names in large regions."""

from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.plots.style import Category

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.patches import Patch
    from numpy.typing import NDArray

_TEXT = 8.0
"""Size of the names in regions, in points."""
_WIDTH = 0.62
"""Mean width of a letter, in sizes of the text."""
_INSIDE = 0.88
"""Part of a name's box that must lie within its region."""
_NAMED = 3
"""Regions of one kind that are named, largest first."""


def bounds(values: "NDArray[np.float64]") -> "NDArray[np.float64]":
    """Return the bounds of cells around ascending values, shape (n + 1,).

    They are half way between neighbours, and as far outside of the first and the last value as inside. A value that is
    alone stands in the middle of a cell that is a tenth of it wide.
    """
    if len(values) == 1:
        half = 0.05 * abs(values[0]) or 0.5
        return np.array([values[0] - half, values[0] + half])
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def draw_kinds(
    axes: "Axes",
    x: "NDArray[np.float64]",
    y: "NDArray[np.float64]",
    kinds: "NDArray[np.int64]",
    looks: "Sequence[Category]",
    size: tuple[float, float],
    colours: "NDArray[np.float64] | None" = None,
    names: bool = True,
) -> None:
    """Draw cells in the looks of their kinds.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    x, y : ndarray, shapes (n + 1,) and (m + 1,)
        Bounds of the cells.
    kinds : ndarray, shape (m, n)
        Index of each cell's look; -1 for a cell that has a colour of its own.
    looks : sequence of Category
    size : (float, float)
        Width and height of the axes in inches, for the finest detail that hatchings and names heed.
    colours : ndarray, shape (m, n, 3), optional
        Colours of the cells whose kind is -1.
    names : bool, default True
        Whether large regions carry the short name of their kind.
    """
    from matplotlib.colors import to_rgb

    shown = np.zeros((*kinds.shape, 3), dtype=np.float32) if colours is None else colours.copy()
    for index, look in enumerate(looks):
        shown[kinds == index] = to_rgb(look.colour)
    axes.pcolormesh(x, y, shown, rasterized=True)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    sampled = _sample(x, y, kinds, size)
    columns, rows = _even(x, y, sampled)
    for index, look in enumerate(looks):
        if look.hatch:
            hatch(axes, x, y, kinds == index, look, size)
        if names and look.short:
            _name(axes, columns, rows, sampled == index, look)


def hatch(
    axes: "Axes",
    x: "NDArray[np.float64]",
    y: "NDArray[np.float64]",
    mask: "NDArray[np.bool_]",
    look: Category,
    size: tuple[float, float],
) -> None:
    """Draw the hatching of a look over the cells of a mask, shape (m, n); parameters as for `draw_kinds`.

    It is one patch, and runs on across neighbours. A grid finer than a point is hatched at every point.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    coarse = _sample(x, y, mask, size)
    if mask.shape[0] > coarse.shape[0] or mask.shape[1] > coarse.shape[1]:
        x, y, mask = *_even(x, y, coarse), coarse
    turns = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    row, first = np.nonzero(turns == 1)
    _, last = np.nonzero(turns == -1)
    corners = np.stack(
        [
            np.stack([x[first], x[last], x[last], x[first], x[first]], axis=1),
            np.stack([y[row], y[row], y[row + 1], y[row + 1], y[row]], axis=1),
        ],
        axis=-1,
    )
    codes = np.tile([Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY], len(row))
    path = Path(corners.reshape(-1, 2), codes)
    axes.add_patch(
        PathPatch(path, facecolor="none", edgecolor=look.ink, hatch=look.hatch, linewidth=0, rasterized=True)
    )


def legend_entry(look: Category) -> "Patch":
    """Return the legend's handle of a look."""
    from matplotlib.patches import Patch

    return Patch(facecolor=look.colour, hatch=look.hatch, edgecolor=look.ink, linewidth=0, label=look.name)


def _sample(
    x: "NDArray[np.float64]", y: "NDArray[np.float64]", kinds: "NDArray[Any]", size: tuple[float, float]
) -> "NDArray[Any]":
    """The kinds on an even grid with one place a point (1/72 inch)."""
    places = [
        np.searchsorted(edges, edges[0] + (np.arange(count) + 0.5) / count * (edges[-1] - edges[0])) - 1
        for edges, count in ((y, max(1, round(72 * size[1]))), (x, max(1, round(72 * size[0]))))
    ]
    return kinds[np.ix_(*places)]


def _even(
    x: "NDArray[np.float64]", y: "NDArray[np.float64]", sampled: "NDArray[Any]"
) -> "tuple[NDArray[np.float64], NDArray[np.float64]]":
    """The bounds of the places of an even grid."""
    return np.linspace(x[0], x[-1], sampled.shape[1] + 1), np.linspace(y[0], y[-1], sampled.shape[0] + 1)


def _name(
    axes: "Axes", x: "NDArray[np.float64]", y: "NDArray[np.float64]", mask: "NDArray[np.bool_]", look: Category
) -> None:
    """Write a look's short text into the largest connected regions of a mask, where its box fits."""
    from matplotlib.patheffects import withStroke
    from scipy import ndimage

    box = np.array([1.3 * _TEXT, (len(look.short) + 1) * _WIDTH * _TEXT])
    regions, count = ndimage.label(mask)
    areas = np.bincount(regions.ravel(), minlength=count + 1)[1:]
    for region in np.argsort(-areas)[:_NAMED]:
        if areas[region] < _INSIDE * box.prod():
            return
        place = _roomiest((regions == region + 1).astype(np.float32), box)
        if place is not None:
            axes.text(
                (x[place[1]] + x[place[1] + 1]) / 2,
                (y[place[0]] + y[place[0] + 1]) / 2,
                look.short,
                ha="center",
                va="center",
                fontsize=_TEXT,
                color=look.ink,
                path_effects=[withStroke(linewidth=3.0 if look.hatch else 1.5, foreground=look.colour)],
            )


def _roomiest(region: "NDArray[np.float32]", box: "NDArray[np.float64]") -> "tuple[int, int] | None":
    """The place in a region with most room around a box, which is whole in it if it can be; None if it does not fit."""
    from scipy import ndimage

    inside = ndimage.uniform_filter(region, tuple(int(side) for side in box), mode="constant")
    most = inside >= min(float(inside.max()), 1.0) - 1e-4
    for scale in (8, 4, 2, 1):
        cover = most * ndimage.uniform_filter(region, tuple(int(scale * side) for side in box), mode="constant")
        best = cover.max()
        if best >= _INSIDE:
            places = np.argwhere(cover >= best - 1e-4)
            row, column = places[np.argmin(np.sum((places - places.mean(axis=0)) ** 2, axis=1))]
            return int(row), int(column)
    return None

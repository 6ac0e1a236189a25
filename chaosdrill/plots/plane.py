"""A plane of cells with their true bounds, coloured by category or value: hatching, names, legend and colour bar."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import to_rgb
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from chaosdrill.errors import SettingsError
from chaosdrill.plots._types import (
    Artist,
    Axes,
    Colormap,
    DataArray,
    Dataset,
    Floats,
    Integers,
    Normalize,
    Patch,
    Truths,
)
from chaosdrill.plots.categories import MOTIONS, NO_RESULT, Category, by_outcome
from chaosdrill.plots.figures import font_size, is_narrow, legend_outside, new_figure, owner, size_of
from chaosdrill.plots.labels import axis_label, label, seed_names, shorten
from chaosdrill.plots.tuning import TUNING


class Plane:
    """A figure of a variable over two coordinates, with a panel for each seed where it has some.

    ``dataset``: with ``outcome`` over the two coordinates, and perhaps ``seed``. ``variable``: variable with the
    dimensions of everything that is drawn. With ``seed`` among them at most nine panels are drawn; the title counts the
    rest. ``ax``: where it is drawn; for one panel.

    ``across``, ``up``: the coordinates.

    Raises `SettingsError` if there are several panels, but ``ax`` is one axes.
    """

    def __init__(self, dataset: Dataset, variable: str, ax: Axes | None = None) -> None:
        self.across, self.up = (str(name) for name in dataset["outcome"].dims if name != "seed")
        self._dataset, self._values, self._ax = dataset, dataset[variable], ax
        self._x, self._y = (bounds(np.sort(dataset[name].values)) for name in (self.across, self.up))
        self._shown: dict[Category, None] = {}
        names = seed_names(dataset) if "seed" in self._values.dims else [""]
        if ax is None:
            self._lay_out(names)
        elif len(names) > 1:
            raise SettingsError(
                f"ax is one axes, but {len(names)} seeds have a panel each; choose one, as in ds.isel(seed=[0])"
            )
        else:
            self.figure, self.panels = owner(ax), [ax]
            box = ax.get_window_extent()
            self._size = (box.width / self.figure.dpi, box.height / self.figure.dpi)
        if len(names) == 1:
            self.panels[0].set(xlabel=axis_label(dataset, self.across), ylabel=axis_label(dataset, self.up))

    def _lay_out(self, names: list[str]) -> None:
        dataset, count = self._dataset, min(len(names), TUNING.most_planes)
        columns = 1 if count == 1 else 2 if count <= 4 or is_narrow() else 3
        rows = -(-count // columns)
        side = size_of(0.0)[0] - TUNING.beside
        width = side / columns
        height = 4.4 / 6.3 * side if columns == 1 else 0.8 * width
        detail = max(dataset.sizes[self.across] / width, dataset.sizes[self.up] / height)
        self.figure, self._size = new_figure(1.0 + rows * (height + 0.15), detail), (width, height)
        grid = self.figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel().tolist()
        self.panels = grid[:count]
        for axes in grid[count:]:
            axes.set_axis_off()
        for place, axes in enumerate(self.panels):
            if place + columns >= count:
                axes.tick_params(labelbottom=True)
            if count > 1:
                axes.set_title(names[place] + _start(dataset, place))
            for name, set_ticks in ((self.across, axes.set_xticks), (self.up, axes.set_yticks)):
                if dataset.sizes[name] == 1:
                    set_ticks(dataset[name].values)
        if count > 1:
            self.figure.supxlabel(axis_label(dataset, self.across), fontsize="medium")
            self.figure.supylabel(axis_label(dataset, self.up), fontsize="medium")
        if len(names) > count:
            self.figure.suptitle(f"seeds 1 to {count} of {len(names)}", x=0.01, ha="left", fontsize="medium")

    def _parts(self, *arrays: NDArray[Any]) -> Iterator[tuple[Axes, list[NDArray[Any]]]]:
        """Each panel with its part of some arrays, in the order of its cells."""
        for place, axes in enumerate(self.panels):
            parts = [self._values.copy(data=array).isel(seed=place, missing_dims="ignore") for array in arrays]
            ordered = [part.sortby([self.across, self.up]).transpose(self.up, self.across) for part in parts]
            yield axes, [part.values for part in ordered]

    def categorise(self, codes: Integers, categories: Sequence[Category]) -> None:
        """Draw cells by category, as indices into ``categories`` over the dimensions of the variable."""
        for axes, (part,) in self._parts(codes):
            draw_cells(axes, self._x, self._y, part, categories, self._size)
        self._shown |= dict.fromkeys(categories)

    def shade(
        self,
        values: DataArray,
        norm: Normalize,
        colours: Colormap,
        extend: str,
        apart: Sequence[tuple[float, Category]] = (),
        dotted: tuple[Truths, Category] | None = None,
    ) -> None:
        """Draw cells by value, with legend and colour bar; those without a value show the outcome of their run.

        ``values``: over the dimensions of the variable. ``extend``: ends at which values exceed the colour bar, in
        matplotlib's words. ``apart``: values with their own category, such as minus infinity. ``dotted``: cells that
        are hatched over their colour, and their category.
        """
        codes, ended = by_outcome(self._dataset)
        categories = [NO_RESULT if category.name in MOTIONS else category for category in ended]
        codes[np.isfinite(values.values)] = -1
        for value, category in apart:
            codes[values.values == value] = len(categories)
            categories.append(category)
        marked, over = dotted if dotted is not None else (np.zeros(codes.shape, dtype=bool), NO_RESULT)
        for axes, (part, numbers, mask) in self._parts(codes, values.values, marked):
            shades = colours(norm(np.where(np.isfinite(numbers), numbers, 0)))[..., :3].astype(np.float32)
            draw_cells(axes, self._x, self._y, part, categories, self._size, shades)
            # black dots are not seen on the dark ends of a scale, nor white ones on the rest
            dark = shades.mean(axis=-1) < TUNING.dark
            for ground, here in (("#FFFFFF", ~dark), ("#000000", dark)):
                hatch(axes, self._x, self._y, mask & here, replace(over, colour=ground), self._size)
        self._shown |= {category: None for code, category in enumerate(categories) if (codes == code).any()}
        self._shown |= {over: None} if marked.any() else {}
        self.legend()
        mappable = ScalarMappable(norm, colours)
        bar = self.figure.colorbar(mappable, ax=self.panels, extend=extend, aspect=30, pad=0.02)
        bar.set_label(label(values))
        bar.outline.set_linewidth(0.5)

    def legend(self, further: Sequence[Artist] = (), **options: Any) -> None:
        """Put one legend above all panels: categories, each named once, and what else is drawn over the cells."""
        handles = [*map(legend_entry, self._shown), *further]
        legend_outside(self.figure, handles, ax=self._ax, handlelength=1.6, handleheight=1.1, borderpad=0, **options)


def _start(dataset: Dataset, seed: int) -> str:
    """Initial state of a seed, by the states in which the seeds differ; empty if the archive does not give it."""
    if "initial_state" not in dataset.variables:
        return ""
    states = dataset["initial_state"].values
    names = dataset["state"].values
    apart = np.flatnonzero(np.ptp(states, axis=0) > 0)
    return ": " * bool(apart.size) + ", ".join(f"{names[i]} = {shorten(float(states[seed, i]))}" for i in apart)


def bounds(values: Floats) -> Floats:
    """Return the bounds of cells around ascending values, shape (n + 1,).

    They lie half-way between neighbours, and as far outside the first and the last value as inside. A single value is
    the middle of a cell whose width is a tenth of it.
    """
    if len(values) == 1:
        half = 0.05 * abs(values[0]) or 0.5
        return np.array([values[0] - half, values[0] + half])
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def draw_cells(
    axes: Axes,
    x: Floats,
    y: Floats,
    codes: Integers,
    categories: Sequence[Category],
    size: tuple[float, float],
    colours: Floats | None = None,
    names: bool = True,
) -> None:
    """Draw cells in the colours, hatchings and names of their categories.

    ``x``, ``y``: bounds of the cells, shapes (n + 1,) and (m + 1,). ``codes``: index of each cell's category, shape (m,
    n); -1 for a cell with its own colour. ``size``: width and height of the axes in inches, for the finest detail of
    hatchings and names. ``colours``: of the cells of code -1, shape (m, n, 3). ``names``: whether large regions carry
    the short name of their category.
    """
    shown = np.zeros((*codes.shape, 3), dtype=np.float32) if colours is None else colours.copy()
    for index, category in enumerate(categories):
        shown[codes == index] = to_rgb(category.colour)
    axes.pcolormesh(x, y, shown, rasterized=True)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    sampled = _sample(x, y, codes, size)
    columns, rows = _even(x, y, sampled)
    for index, category in enumerate(categories):
        if category.hatch:
            hatch(axes, x, y, codes == index, category, size)
        if names and category.short:
            _name(axes, columns, rows, sampled == index, category)


def hatch(axes: Axes, x: Floats, y: Floats, mask: Truths, category: Category, size: tuple[float, float]) -> None:
    """Draw the hatching of a category over the cells of a mask, shape (m, n); parameters as for `draw_cells`.

    It is one patch, continuous across neighbours. A grid finer than a point is hatched at every point.
    """
    coarse = _sample(x, y, mask, size)
    if mask.shape[0] > coarse.shape[0] or mask.shape[1] > coarse.shape[1]:
        x, y, mask = *_even(x, y, coarse), coarse
    turns = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    row, first = np.nonzero(turns == 1)
    _, last = np.nonzero(turns == -1)
    across = np.stack([x[first], x[last], x[last], x[first], x[first]], axis=1)
    up = np.stack([y[row], y[row], y[row + 1], y[row + 1], y[row]], axis=1)
    codes = np.tile([Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY], len(row))
    look: dict[str, Any] = {"facecolor": "none", "linewidth": 0, "rasterized": True}
    path = Path(np.column_stack([across.ravel(), up.ravel()]), codes)
    axes.add_patch(PathPatch(path, edgecolor=category.ink, hatch=category.hatch, **look))


def legend_entry(category: Category) -> Patch:
    """Return the legend's handle of a category."""
    name, colour, ink = category.name, category.colour, category.ink
    return Patch(facecolor=colour, hatch=category.hatch, edgecolor=ink, linewidth=0.4, label=name)


def _sample(x: Floats, y: Floats, codes: NDArray[Any], size: tuple[float, float]) -> NDArray[Any]:
    """The codes on an even grid with one place a point (1/72 inch)."""
    places = [
        np.searchsorted(edges, edges[0] + (np.arange(count) + 0.5) / count * (edges[-1] - edges[0])) - 1
        for edges, count in ((y, max(1, round(72 * size[1]))), (x, max(1, round(72 * size[0]))))
    ]
    return codes[np.ix_(*places)]


def _even(x: Floats, y: Floats, sampled: NDArray[Any]) -> tuple[Floats, Floats]:
    """The bounds of the places of an even grid."""
    return np.linspace(x[0], x[-1], sampled.shape[1] + 1), np.linspace(y[0], y[-1], sampled.shape[0] + 1)


def _name(axes: Axes, x: Floats, y: Floats, mask: Truths, category: Category) -> None:
    """Write a category's short text into the largest connected regions of a mask, where its box fits."""
    from scipy import ndimage

    size = font_size(TUNING.region_text)
    box = np.array([1.3 * size, (len(category.short) + 1) * TUNING.letter_width * size])
    regions, count = ndimage.label(mask)
    areas = np.bincount(regions.ravel(), minlength=count + 1)[1:]
    for region in np.argsort(-areas)[: TUNING.named_regions]:
        if areas[region] < TUNING.inside_region * box.prod():
            return
        place = _roomiest((regions == region + 1).astype(np.float32), box)
        if place is not None:
            axes.text(
                (x[place[1]] + x[place[1] + 1]) / 2,
                (y[place[0]] + y[place[0] + 1]) / 2,
                category.short,
                ha="center",
                va="center",
                fontsize=size,
                color=category.ink,
                path_effects=[withStroke(linewidth=3.0 if category.hatch else 1.5, foreground=category.colour)],
            )


def _roomiest(region: NDArray[np.float32], box: Floats) -> tuple[int, int] | None:
    """The place in a region with most room around a box, wholly inside if possible; None if it does not fit."""
    from scipy import ndimage

    inside = ndimage.uniform_filter(region, tuple(int(side) for side in box), mode="constant")
    most = inside >= min(float(inside.max()), 1.0) - 1e-4
    for scale in (8, 4, 2, 1):
        cover = most * ndimage.uniform_filter(region, tuple(int(scale * side) for side in box), mode="constant")
        best = cover.max()
        if best >= TUNING.inside_region:
            places = np.argwhere(cover >= best - 1e-4)
            row, column = places[np.argmin(np.sum((places - places.mean(axis=0)) ** 2, axis=1))]
            return int(row), int(column)
    return None

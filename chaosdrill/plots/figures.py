"""Figures and legends that keep the size given by the user or, by default, by the picture."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import matplotlib as mpl
import numpy as np

from chaosdrill.plots._layout import FittedLayout, LegendSource, entries, fit_legend
from chaosdrill.plots._types import Artist, Axes, Figure, Legend
from chaosdrill.plots.style import is_changed, width
from chaosdrill.plots.tuning import TUNING

_figures: ContextVar[Callable[..., Figure] | None] = ContextVar("figures", default=None)


@contextmanager
def made_by(figures: Callable[..., Figure]) -> Iterator[None]:
    """Let `new_figure` make figures by another function than matplotlib's class, such as that of pyplot."""
    token = _figures.set(figures)
    try:
        yield
    finally:
        _figures.reset(token)


def new_figure(height: float, detail: float = 0.0, least: float = 0.0) -> Figure:
    """Return an empty figure of the common width, outside pyplot's global list except for `made_by`.

    If ``figure.figsize`` of matplotlib has been changed, that size is used.

    ``height``: in inches. ``least``: height below which the panels have no room, for text of the default size; a lower
    figure, or one with larger text, is made as high. ``detail``: cells per inch; for many cells the resolution rises,
    up to 300 dots per inch, so that each cell has a dot.
    """
    figure = (_figures.get() or Figure)(figsize=size_of(height, least), layout=FittedLayout())
    # labels and colour bars take their part of the width that the cells were counted over
    figure.set_dpi(float(np.clip(1.25 * detail, figure.dpi, max(figure.dpi, TUNING.densest))))
    return figure


def size_of(height: float, least: float = 0.0) -> tuple[float, float]:
    """Return the width and height in inches of a new figure with this default height; ``least`` as for `new_figure`."""
    across, least = width(), least * font_size() / TUNING.font_size
    if is_changed("figure.figsize"):
        across, height = mpl.rcParams["figure.figsize"]
    return float(across), max(float(height), least)


def is_narrow() -> bool:
    """Return whether a new figure has no room for panels side by side."""
    return size_of(0.0)[0] < TUNING.narrow * font_size() / TUNING.font_size


def font_size(part: float = 1.0) -> float:
    """Return a fraction of the size of text, in points."""
    return part * float(mpl.rcParams["font.size"])


def one_panel(ax: Axes | None, height: float) -> tuple[Figure, Axes]:
    """Return the axes that are given with their figure, or those of a new one."""
    if ax is None:
        figure = new_figure(height)
        return figure, figure.subplots()
    return owner(ax), ax


def stacked(heights: Sequence[float], edge: float, least: float = 0.0) -> tuple[Figure, list[Axes]]:
    """Return a new figure of panels below each other, at least one, as high as given beside an ``edge`` of inches."""
    figure = new_figure(edge + sum(heights), least=least)
    return figure, figure.subplots(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0].tolist()


def owner(part: Axes | Legend) -> Figure:
    """Return the figure that axes or a legend stand in."""
    figure = part.get_figure(root=True)
    assert figure is not None
    return figure


def note(axes: Axes, text: str, place: Any, offset: tuple[float, float], **options: Any) -> None:
    """Write a small text beside a place of the axes, at an offset in points."""
    axes.annotate(text, place, xytext=offset, textcoords="offset points", **{"fontsize": "small", **options})


def legend_outside(
    figure: Figure,
    handles: Sequence[Artist],
    ax: Axes | None = None,
    ncols: int = 6,
    loc: Any = "outside upper left",
    **options: Any,
) -> None:
    """Put one legend outside all panels of a figure, in up to ``ncols`` columns, as many as fit.

    The handles carry their labels. The legend of a picture on the user's axes, ``ax``, stands inside them.
    """
    if not handles:
        return
    if ax is not None:
        legend_inside(ax, handles=handles)
        return
    _fitted(figure.legend(handles=handles, loc=loc, ncols=ncols, **options), handles, loc, ncols)


def legend_above(axes: Axes, columns: int = 6, handles: Sequence[Artist] | None = None, **options: Any) -> None:
    """Put the legend above the axes, where it covers no data, in up to ``columns`` columns; none without entries."""
    if handles := axes.get_legend_handles_labels()[0] if handles is None else handles:
        anchor: dict[str, Any] = {"bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2, "handlelength": 1.4}
        legend = axes.legend(handles=handles, loc="lower left", ncols=columns, **anchor, **options)
        _fitted(legend, handles, "lower left", columns)
        # the power of ten of the axis would stand where the legend begins
        axes.yaxis.get_offset_text().set_horizontalalignment("right")


def make_room_for_legends(figure: Figure, lines: int) -> None:
    """Make a narrow figure higher by the lines of its legends beyond a number of them."""
    if not is_narrow():
        return
    legends = [legend for ax in figure.axes if (legend := ax.get_legend()) is not None]
    found = sum(-(-len(entries[legend].labels) // entries[legend].columns) for legend in legends)
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + TUNING.legend_line * font_size() / 72 * max(found - lines, 0))


def legend_inside(axes: Axes, handles: Sequence[Artist] | None = None, **options: Any) -> None:
    """Put the legend inside the axes, where it covers least; none without entries."""
    if handles := axes.get_legend_handles_labels()[0] if handles is None else handles:
        _fitted(axes.legend(handles=handles, **options), handles, options.get("loc"), 1)


def _fitted(legend: Legend, handles: Sequence[Artist], loc: Any, most: int) -> None:
    entries[legend] = LegendSource(handles, loc, most)
    fit_legend(legend, owner(legend))


def title_legend(legend: Legend, text: str, colour: str) -> None:
    """Give a fitted legend a title, broken into lines that fit the figure."""
    text = "\n".join(filter(None, [entries[legend].title, text]))
    entries[legend].title = text
    legend.set_alignment("left")
    legend.set_title(text)
    legend.get_title().set(color=colour, fontsize=font_size())

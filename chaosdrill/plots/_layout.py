"""A layout in which legends and labels keep within their figure, whatever its size becomes."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, cast
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.text import Text

from chaosdrill.plots._types import Artist, Axes, Figure, FontProperties, Legend
from chaosdrill.plots.labels import wrapped
from chaosdrill.plots.tuning import TUNING


class LegendSource:
    """What a legend was made from, to remake it for another width."""

    def __init__(self, handles: Sequence[Artist], loc: Any, most: int) -> None:
        self.handles, self.loc, self.most, self.columns = list(handles), loc, most, most
        self.labels = [str(handle.get_label()) for handle in handles]
        self.title = ""


entries: WeakKeyDictionary[Legend, LegendSource] = WeakKeyDictionary()
"""Legends that are fitted."""

_sizes: WeakKeyDictionary[Text, tuple[float, float]] = WeakKeyDictionary()
"""Size of each fitted text as it was, and as it is drawn."""


class FittedLayout(ConstrainedLayoutEngine):
    """Constrained layout that breaks labels and chooses the columns of legends to fit the available room."""

    def __init__(self) -> None:
        super().__init__()
        self._whole: WeakKeyDictionary[Text, tuple[str, str]] = WeakKeyDictionary()
        self._done: tuple[object, ...] | None = None

    def execute(self, fig: Figure) -> None:
        """Fit and lay out."""
        if self._done != self._state(fig):
            self._fit(fig)
        else:
            super().execute(fig)

    def _fit(self, fig: Figure) -> None:
        for text in _texts(fig):
            whole, broken = self._whole.get(text, ("", None))
            shown = text.get_text()
            self._whole[text] = (whole, broken) if shown == broken else (shown, shown)
            text.set_text(self._whole[text][0])
        changed = True
        for _ in range(TUNING.label_rounds):
            for legend in _legends(fig) if changed else ():
                fit_legend(legend, fig)
            super().execute(fig)
            # only now does the layout know where axes begin, and so how much room a legend above them has
            refitted = [fit_legend(legend, fig) for legend in _legends(fig)]
            changed = any(refitted)
            for text, room in _rooms(fig):
                whole, _ = self._whole[text]
                before = text.get_text()
                _break(text, whole, room)
                self._whole[text] = whole, text.get_text()
                changed |= text.get_text() != before
            if not changed:
                break
        else:
            super().execute(fig)
        self._done = self._state(fig)

    def _state(self, fig: Figure) -> tuple[object, ...]:
        texts = tuple(text.get_text() for text in _texts(fig))
        return (fig.dpi, *fig.get_size_inches().tolist(), texts, tuple(entries[one].title for one in _legends(fig)))


def _legends(fig: Figure) -> list[Legend]:
    every = [*fig.legends, *(ax.get_legend() for ax in fig.axes)]
    return [legend for legend in every if legend is not None and legend in entries]


def _shown(fig: Figure) -> Iterator[Axes]:
    return (ax for ax in fig.axes if ax.axison and ax.get_visible())


def _titles(ax: Axes) -> list[Text]:
    return [child for child in ax.get_children() if isinstance(child, Text) and child not in ax.texts]


def _texts(fig: Figure) -> Iterator[Text]:
    """Texts beside the axes."""
    yield from fig.texts
    for ax in _shown(fig):
        yield from (*_titles(ax), ax.xaxis.label, ax.yaxis.label)


def _rooms(fig: Figure) -> Iterator[tuple[Text, float]]:
    """Texts beside the axes, each with the length that it may have in pixels."""
    page, edge = fig.bbox, TUNING.edge * fig.dpi / 72
    middle, boxes = page.y0 + page.height / 2, [legend.get_window_extent() for legend in fig.legends]
    top = min([box.y0 for box in boxes if box.y0 > middle], default=page.y1)
    bottom = max([box.y1 for box in boxes if box.y1 < middle], default=page.y0)
    for text in fig.texts:
        yield text, (page.height if text.get_rotation() == 90 else page.width) - 2 * edge
    for ax in _shown(fig):
        ax.apply_aspect()
        box, first, last, high, low = ax.bbox, *_outermost(ax)
        for title in _titles(ax):
            # that of a round picture in a wide place begins further to the right
            begins = title.get_window_extent().x0 if title.get_text() else box.x0
            yield title, (page.x1 - edge if last else max(box.x1, begins)) - begins
        across, up = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
        alone = min(across, page.x1 - across) - edge
        yield ax.xaxis.label, 2 * alone if first and last else box.width
        upright = 2 * (min(up - bottom, top - up) - edge) if high and low else box.height
        yield ax.yaxis.label, upright


def _outermost(ax: Axes) -> tuple[bool, bool, bool, bool]:
    """Whether axes stand in the first and last column, and in the first and last row; those of a colour bar do."""
    place = ax.get_subplotspec()
    if place is None:
        return True, True, True, True
    return place.is_first_col(), place.is_last_col(), place.is_first_row(), place.is_last_row()


def _break(text: Text, whole: str, room: float) -> None:
    """Show a text in lines of at most a length in pixels, in smaller letters if its words are longer than that."""
    size, drawn = _sizes.get(text, (0.0, -1.0))
    if float(text.get_fontsize()) != drawn:
        size = float(text.get_fontsize())
    text.set_fontsize(size)
    _sizes[text] = size, size
    if not whole:
        text.set_text(whole)
        return

    def length(shown: str) -> float:
        text.set_text(shown)
        extent = text.get_window_extent()
        return float(extent.height if text.get_rotation() == 90 else extent.width)

    _, found = _broken(whole, room, length)
    if found > room > 0:
        text.set_fontsize(size * max(TUNING.smallest_text, room / found))
        _sizes[text] = size, float(text.get_fontsize())


def fit_legend(legend: Legend, fig: Figure) -> bool:
    """Give a legend as many columns as fit, break entries that are too long; return whether it changed."""
    own = entries[legend]
    em = legend.prop.get_size_in_points() * fig.dpi / 72
    room = (
        fig.bbox.width if legend in fig.legends else fig.bbox.x1 - legend.axes.bbox.x0
    ) - 2 * TUNING.edge * fig.dpi / 72
    if own.loc is None:
        room = legend.axes.bbox.width
    pads = em * (legend.handlelength + legend.handletextpad)
    width = partial(_width, font=legend.prop, fig=fig)
    widths = np.array([width(label) for label in own.labels])
    for columns in range(min(own.most, len(widths)), 0, -1):
        parts = [part.max() + pads for part in np.array_split(widths, columns)]
        if sum(parts) + em * (legend.columnspacing * (columns - 1) + 2 * legend.borderpad) <= room:
            break
    most = room - pads - 2 * em * legend.borderpad
    labels = [_broken(label, most, width)[0] for label in own.labels]
    changed = columns != own.columns or labels != [text.get_text() for text in legend.texts]
    if changed:
        _make_again(legend, own, labels, columns)
    if own.title:
        title = legend.get_title()
        title.set_text(_broken(own.title, room, partial(_width, font=title.get_fontproperties(), fig=fig))[0])
    return changed


def _broken(whole: str, room: float, length: Callable[[str], float]) -> tuple[str, float]:
    """A text in lines that fit, and its length; letters differ in width, so that the lines themselves are measured."""
    text, longest = whole, max(map(len, whole.split("\n")))
    while (found := length(text)) > room > 0 and longest > TUNING.fewest_letters:
        longest = max(TUNING.fewest_letters, min(longest - 1, int(longest * room / found)))
        text = "\n".join(wrapped(line, longest) for line in whole.split("\n"))
    return text, found


def _width(label: str, font: FontProperties, fig: Figure) -> float:
    text = Text(text=label, fontproperties=font)
    text.set_figure(fig)
    return float(text.get_window_extent().width)


def _make_again(legend: Legend, own: LegendSource, labels: list[str], columns: int) -> None:
    """Refill a legend in place: when the layout runs, the artists to draw are already chosen."""
    title, own.columns, filled = legend.get_title(), columns, cast("Any", legend)
    legend.set_ncols(columns)
    # matplotlib itself has no other way to fill a legend
    filled._init_legend_box(own.handles, labels)
    legend.set_loc(own.loc)
    filled.set_title(title.get_text() or None)
    legend.get_title().set(color=title.get_color(), fontproperties=title.get_fontproperties())

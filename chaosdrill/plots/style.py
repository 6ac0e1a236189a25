"""The settings of matplotlib in which pictures are drawn, for as long as they are."""

import os
import threading
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from typing import Any, cast

import matplotlib as mpl

from chaosdrill.plots._types import Figure
from chaosdrill.plots.tuning import TUNING

# by any name, of which the types of matplotlib know some
_settings = cast("MutableMapping[str, Any]", mpl.rcParams)
_defaults = cast("Mapping[str, Any]", mpl.rcParamsDefault)

WIDTH = 7.2
"""Of a figure in inches."""
_LOOK: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "figure.dpi": 150,
    "font.size": TUNING.font_size,
    "hatch.linewidth": 0.5,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "svg.fonttype": "none",
}
# parts of the font size
_SIZES = {
    "axes.labelsize": 1.0,
    "axes.titlesize": 1.0,
    "figure.labelsize": 1.0,
    "figure.titlesize": 10 / 9,
    "legend.fontsize": 8 / 9,
    "xtick.labelsize": 8 / 9,
    "ytick.labelsize": 8 / 9,
}
# the colours of pictures are chosen for white paper
_PAPER: dict[str, Any] = {
    "axes.edgecolor": "black",
    "axes.facecolor": "white",
    "axes.labelcolor": "black",
    "figure.facecolor": "white",
    "savefig.facecolor": "auto",
    "text.color": "black",
    "xtick.color": "black",
    "xtick.labelcolor": "inherit",
    "ytick.color": "black",
    "ytick.labelcolor": "inherit",
}
_COMPLETE_FONT = "DejaVu Sans"
"""It comes with matplotlib and has every letter, index and sign of our labels, which many other fonts have not."""
_NOT_OF_PICTURES = (
    *("_internal", "animation.", "backend", "datapath", "docstring.", "interactive", "keymap.", "macosx."),
    *("timezone", "tk.", "toolbar", "webagg."),
)


class _Turn:
    """Lets threads change matplotlib's settings, which are global to the process, one after the other.

    A child process that another thread forks meanwhile gets the original settings.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._owner: int | None = None
        self._before: list[tuple[dict[str, Any], dict[str, Any]]] = []
        os.register_at_fork(after_in_child=self._in_child)

    @contextmanager
    def holding(self, wanted: Callable[[], dict[str, Any]]) -> Iterator[None]:
        with self._lock:
            self._owner = threading.get_ident()
            settings = wanted()
            before = {name: _settings[name] for name in settings}
            _settings.update(settings)
            self._before.append((before, {name: _settings[name] for name in settings}))
            try:
                yield
            finally:
                _restore(*self._before.pop())
                self._owner = self._owner if self._before else None

    def _in_child(self) -> None:
        if self._owner not in (None, threading.get_ident()):
            while self._before:
                _restore(*self._before.pop())
            self._lock, self._owner = threading.RLock(), None


def _restore(before: dict[str, Any], set_to: dict[str, Any]) -> None:
    """Undo settings that have not been changed since."""
    # never all settings at once: a backend that is chosen meanwhile has some of its own, such as being interactive
    _settings.update({name: value for name, value in before.items() if _settings[name] == set_to[name]})


_turn = _Turn()
_width: ContextVar[float] = ContextVar("width", default=WIDTH)
_SAME = {"svg.hashsalt": "chaosdrill"}


def style() -> AbstractContextManager[None]:
    """Return a context in which matplotlib draws in the project's style.

    Sizes, fonts and other settings that the user has changed stay, but colours are always those of white paper.
    Afterwards every setting is restored, and nothing else is touched. Threads wait for each other.
    """
    return _turn.holding(_of_user)


@contextmanager
def page_style() -> Iterator[None]:
    """Draw pictures for a page: as wide as the page, and independent of matplotlib's settings."""
    token = _width.set(TUNING.page_width)
    try:
        # a picture inside of a page has no fonts of its own, and its ids are the same whenever it is drawn
        with _turn.holding(lambda: _of_nobody() | {"svg.fonttype": "path", **_SAME}):
            yield
    finally:
        _width.reset(token)


def saved_alike() -> AbstractContextManager[None]:
    """Return a context in which saving the same figure gives the same file."""
    return _turn.holding(lambda: _of_user() | _SAME)


def width() -> float:
    """Return the width of a figure in inches, if the user has not set another size."""
    return _width.get()


def lettering() -> AbstractContextManager[None]:
    """Return a context with fonts for every letter of our labels, for axes that already have a style."""
    return _turn.holding(_letters)


def is_changed(name: str) -> bool:
    """Return whether a setting of matplotlib differs from its default, and so was chosen by the user."""
    return bool(_settings[name] != _defaults[name])


def _of_user() -> dict[str, Any]:
    look = {name: value for name, value in _LOOK.items() if not is_changed(name)}
    size = float(look.get("font.size", _settings["font.size"]))
    sizes = {name: part * size for name, part in _SIZES.items() if not is_changed(name)}
    return look | sizes | _PAPER | _letters()


def _of_nobody() -> dict[str, Any]:
    changed = [name for name in _settings if not name.startswith(_NOT_OF_PICTURES) and is_changed(name)]
    sizes = {name: part * TUNING.page_font_size for name, part in _SIZES.items()} | {"font.size": TUNING.page_font_size}
    default = {name: _defaults[name] for name in changed}
    return default | _LOOK | sizes | _PAPER | {"font.family": [_COMPLETE_FONT]}


def _letters() -> dict[str, Any]:
    """Fonts that complement each other; TeX would fail at the letters, indices and signs of our labels."""
    family = _settings["font.family"]
    family = [family] if isinstance(family, str) else list(family)
    # a font that is named twice is looked up twice for each text; a generic name stands for its first font
    first = {name: _settings.get(f"font.{name}", [name])[0] for name in family}
    return {"font.family": [*family, *[_COMPLETE_FONT] * (_COMPLETE_FONT not in first.values())], "text.usetex": False}


def keep_ticks(figure: Figure) -> None:
    """Give the present style to ticks that are made later, when the figure is drawn."""
    for ax in figure.axes:
        for name in ("x", "y"):
            ax.tick_params(
                axis=name,
                labelsize=_settings[f"{name}tick.labelsize"],
                color=_settings[f"{name}tick.color"],
                labelcolor=_settings[f"{name}tick.color"],
                labelfontfamily=_settings["font.family"],
            )

"""Pieces of a page. Text becomes HTML in one place, where it is escaped: archives may hold anything."""

import html
import re
from collections.abc import Iterable, Sequence
from typing import Any

from chaosdrill.reports.numbers import number

LONGEST_TEXT = 20_000
MOST_ROWS = 200
_SHORT = 24
"""Letters that a narrow column may have; more want some width."""

_VOID = frozenset({"br", "img", "input"})
# what is not seen, or turns the order of letters around, is shown as its code
_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ufff0-\uffff\ud800-\udfff]"
)


class Quantity(str):
    """A number that has been written out already."""

    __slots__ = ()


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


def text(value: Any, most: int = LONGEST_TEXT) -> Html:
    """Any value as HTML: what is not ``Html`` is escaped, shortened to ``most`` characters, and told to be so."""
    if isinstance(value, Html):
        return value
    plain = str(value)
    more = len(plain) - most
    shown = _UNSEEN.sub(lambda found: f"\\u{ord(found[0]):04x}", plain[:most])
    escaped = html.escape(shown)
    return Html(escaped if more <= 0 else f"{escaped}… ({more} more characters)")


def element(name: str, *children: Any, **attributes: Any) -> Html:
    """One element; ``class_`` and ``aria_label`` stand for ``class`` and ``aria-label``, None leaves one out."""
    pairs = ""
    for key, value in attributes.items():
        key = key.rstrip("_").replace("_", "-")
        if value is True:
            pairs += f" {key}"
        elif value is not None and value is not False:
            pairs += f' {key}="{text(value)}"'
    if name in _VOID:
        return Html(f"<{name}{pairs}>")
    return Html(f"<{name}{pairs}>{joined(children)}</{name}>")


def joined(children: Iterable[Any], between: str = "") -> Html:
    """Pieces one after the other; None is nothing."""
    return Html(between.join(text(child) for child in children if child is not None))


def table(caption: str, head: Sequence[Any], rows: Iterable[Sequence[Any]], most: int = MOST_ROWS) -> Html:
    """A table whose first column names its rows; nothing if it has none.

    Parameters
    ----------
    caption : str
        What it shows.
    head : sequence
        Names of the columns.
    rows : iterable of sequences
        Cells; numbers are set with their digits below each other.
    most : int
        Rows shown; a line says how many more there are.
    """
    listed = list(rows)
    if not listed:
        return Html("")
    columns = element("tr", *(_cell("th", n, scope="col", like=v) for n, v in zip(head, listed[0], strict=True)))
    body = joined((_row(row) for row in listed[:most]), "\n")
    more = len(listed) - most
    return joined(
        [
            scrolled(
                caption,
                element("table", element("caption", caption), element("thead", columns), element("tbody", body)),
            ),
            element("p", f"{more} more rows are in the archive.", class_="left-out") if more > 0 else None,
        ]
    )


def scrolled(name: str, *children: Any) -> Html:
    """What may be wider than the window: it can be moved with the arrow keys, and says what it is."""
    return element("div", *children, class_="scroll", role="group", aria_label=name, tabindex="0")


def facts(pairs: Iterable[tuple[Any, Any]]) -> Html:
    """Names with what belongs to each."""
    return element("dl", *(element("div", element("dt", name), element("dd", value)) for name, value in pairs))


def _row(values: Sequence[Any]) -> Html:
    first, *rest = values
    return element("tr", _cell("th", first, scope="row"), *(_cell("td", value) for value in rest))


def _cell(tag: str, value: Any, scope: str | None = None, like: Any = None) -> Html:
    """A cell; words stand at the left, numbers at the right, and names of columns as what is below them."""
    kind = value if like is None else like
    long = tag == "td" and not isinstance(kind, Html) and len(str(kind)) > _SHORT
    look = "text" if long else None
    if not isinstance(kind, bool | str) or isinstance(kind, Quantity):
        look = "number"
    return element(tag, value if isinstance(value, bool | str) else number(value), scope=scope, class_=look)

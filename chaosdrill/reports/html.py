"""Pieces of a page, from templates. Only templates turn text into HTML, and they escape it."""

import re
from base64 import b64encode
from collections.abc import Iterable, Sequence
from hashlib import sha256
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from chaosdrill.model.grammar import PLAIN_NAME
from chaosdrill.reports.tuning import TUNING

MISSING = "–"
NOTHING = Markup("")

GREEK = {"eps": "epsilon", "lam": "lambda"}
"""Programmers' short names of Greek letters."""
_TIMES = "<mo>&InvisibleTimes;</mo>"

# what is not seen, or turns the order of letters around, is shown as its code
_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ufff0-\uffff\ud800-\udfff]"
)


class Quantity(str):
    """A number that is already formatted."""

    __slots__ = ()


def shown(value: Any, most: int = TUNING.text) -> str:
    """Any value as readable text, shortened to ``most`` characters with a note; HTML unchanged."""
    if isinstance(value, Markup):
        return value
    plain = str(value)
    more = len(plain) - most
    seen = _UNSEEN.sub(lambda found: f"\\u{ord(found[0]):04x}", plain[:most])
    return seen if more <= 0 else f"{seen}… ({more} more characters)"


def mathml(expression: Any) -> Markup:
    """The expression in MathML; sympy typesets words of letters and digits itself, other names are inserted as text."""
    import sympy
    from sympy.printing.mathml import mathml as written_by_sympy

    if isinstance(expression, str):
        expression = sympy.Symbol(expression)
    expression = expression.xreplace(_greek(expression))
    symbols = expression.free_symbols
    longest = max((len(s.name) for s in symbols), default=0)
    strange = [s for s in symbols if not PLAIN_NAME.fullmatch(s.name)]
    # longer than any name, so that none of them is called so
    stands_for = {s: sympy.Symbol(f"{'q' * longest}q{i}q", real=True) for i, s in enumerate(strange)}
    written = written_by_sympy(expression.xreplace(stands_for), printer="presentation")
    # browsers set a hyphen as a hyphen, and the entity for e as a doubled letter
    written = written.replace("<mo>-</mo>", "<mo>−</mo>").replace("&ExponentialE;", "e")
    # names of factors would run into each other, and into that of a function
    written = written.replace(_TIMES, f'{_TIMES}<mspace width="0.17em"></mspace>')
    for symbol, placeholder in stands_for.items():
        written = written.replace(f"<mi>{placeholder.name}</mi>", f"<mi>{escape(shown(symbol.name))}</mi>")
    return Markup(written)


def _greek(expression: Any) -> dict[Any, Any]:
    """Short names of Greek letters with their symbols; empty where the full name occurs beside the short one."""
    import sympy

    names = {symbol.name for symbol in expression.free_symbols}
    return {
        symbol: sympy.Symbol(GREEK[symbol.name], real=True)
        for symbol in expression.free_symbols
        if symbol.name in GREEK and GREEK[symbol.name] not in names
    }


def csp_hash(content: str) -> str:
    """Hash by which a Content-Security-Policy recognises a style or script."""
    return f"sha256-{b64encode(sha256(content.encode()).digest()).decode()}"


TEMPLATES = Environment(
    loader=PackageLoader("chaosdrill.reports"),
    autoescape=True,
    finalize=shown,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters |= {"mathml": mathml, "csp_hash": csp_hash}
TEMPLATES.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}


def render(template: str, **values: Any) -> Markup:
    """A template filled with these values; everything but ``Markup`` is escaped."""
    return Markup(TEMPLATES.get_template(template).render(values))


def part(name: str, *arguments: Any) -> Markup:
    """One of the small pieces in ``parts.html``."""
    made: Markup = getattr(TEMPLATES.get_template("parts.html").module, name)(*arguments)
    return made


def joined(pieces: Iterable[Markup]) -> Markup:
    """Concatenate pieces."""
    return NOTHING.join(pieces)


def known_columns(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> tuple[list[str], list[list[Any]]]:
    """Names and rows of a table without the columns in which nothing is known."""
    kept = [k for k in range(len(head)) if any(_is_known(row[k]) for row in rows)]
    return [head[k] for k in kept], [[row[k] for k in kept] for row in rows]


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[Any]], most: int = TUNING.rows) -> Markup:
    """A table whose first column names its rows; empty without rows. The digits of numbers are aligned.

    ``head``: names of the columns. ``most``: rows shown; a line counts the others.
    """
    listed = list(rows)
    if not listed:
        return NOTHING
    columns = [(name, _look(value)) for name, value in zip(head, listed[0], strict=True)]
    cells = (
        [
            (value if isinstance(value, bool | str) else number(value), _look(value, is_wide=place > 0))
            for place, value in enumerate(row)
        ]
        for row in listed[:most]
    )
    return part("table", caption, columns, cells, len(listed) - most)


def _is_known(value: Any) -> bool:
    return value not in ("", MISSING) if isinstance(value, str) else isinstance(value, bool) or value == value


def _look(value: Any, is_wide: bool = False) -> str | None:
    """Class of a cell: words are aligned left, numbers right, and names of columns like the cells below them."""
    if isinstance(value, Quantity) or not isinstance(value, bool | str):
        return "number"
    return "text" if is_wide and not isinstance(value, Markup) and len(str(value)) > TUNING.narrow else None


def number(value: Any, digits: int = 6) -> str:
    """A number with the given significant digits; NaN is a dash, and integers keep all digits."""
    if isinstance(value, int) or getattr(getattr(value, "dtype", None), "kind", None) in ("i", "u"):
        return str(int(value)).replace("-", "−")
    value = float(value)
    if value != value:
        return MISSING
    if value in (float("inf"), float("-inf")):
        return "∞" if value > 0 else "−∞"
    return f"{value:.{digits}g}".replace("-", "−")


def uncertain(value: Any, error: Any) -> str:
    """A number with its standard error, where it has one."""
    from chaosdrill.plots.labels import uncertain as written

    value, error = float(value), float(error)
    return MISSING if value != value else written(value, error)


def seconds(value: Any) -> str:
    """A time in a suitable unit."""
    value = float(value)
    if not value < float("inf"):
        return MISSING
    for end, factor, unit in ((1e-3, 1e6, "µs"), (1, 1000, "ms"), (120, 1, "s")):
        if value < end:
            return f"{factor * value:.3g} {unit}"
    minutes, left = divmod(round(value), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {left} s"


def count(items: int, one: str) -> str:
    """``1 point``, ``2 points``."""
    return f"{items} {one if items == 1 else one + 's'}"

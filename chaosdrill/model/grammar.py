"""Expressions as text, such as ``-x - 2*zeta*v + cos(omega*t)``, and the tree that they stand for.

A small language of its own: numbers, names, ``+ - * / **``, calls, comparisons, ``and``, ``or`` and ``not``. Reading it
makes a tree and nothing else; text of any kind takes bounded time and depth, or is refused.

Python's own `ast` would not do: it compiles, an audit event that no input may cause; it takes ``ﬁ`` for ``fi``, refuses
names such as ``lambda`` and ``ω₀``, and fails at a sum of 3000 terms.
"""

import re
from dataclasses import dataclass
from typing import NoReturn

from chaosdrill.model.tuning import TUNING

WORDS = frozenset({"and", "or", "not", "True", "False"})
"""Names that stand for themselves only in backquotes."""

BRANCHED = frozenset({"Piecewise", "piecewise"})
"""Functions of values and conditions in turn: a value, where it holds, ..., and the value elsewhere."""

PLAIN_NAME = re.compile(r"[^\W\d]\w*")

_BLANK = re.compile(r"\s*+")
_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][+-]?[0-9]++)?)|(?P<name>[^\W\d]\w*+)|`(?P<quoted>[^`]*+)`"
    r"|(?P<sign>\*\*|<=|>=|==|!=|//|&&|\|\||.)",
    re.DOTALL,
)
_OR, _AND, _NOT, _COMPARE, _SUM, _PRODUCT, _UNARY, _POWER = range(1, 9)
_LEVELS = {"or": _OR, "and": _AND, "+": _SUM, "-": _SUM, "*": _PRODUCT, "/": _PRODUCT, "**": _POWER}
_LEVELS |= dict.fromkeys(("<", "<=", ">", ">=", "==", "!="), _COMPARE)
_CASES = "write Piecewise(a, x > 0, b) for cases"
_PAIRS = re.compile(r"[Pp]iecewise\s*+\(\s*+\(")
_NAMED = re.compile(r"\b[^\W\d]\w*\s$")
_INSTEAD = {
    "^": "write ** for a power",
    "%": "write Mod(a, b) for a remainder",
    "//": "write floor(a/b)",
    "=": "write == to compare; a guard and a rate are the expression alone",
    "&": "write 'and'",
    "&&": "write 'and'",
    "|": "write 'or'",
    "||": "write 'or'",
    "~": "write 'not'",
    "!": "write 'not'",
    ".": "names and functions stand alone, as in sin(x); a number begins or ends with digits",
    "[": "there are no lists; use parentheses",
    "{": "there are no lists; use parentheses",
    "'": "there is no text in an expression; a name is written plainly, or in `backquotes`",
    '"': "there is no text in an expression; a name is written plainly, or in `backquotes`",
}


class ExpressionError(ValueError):
    """A text that is no expression, with what is wrong and where."""


@dataclass(frozen=True)
class Node:
    """A part of an expression.

    ``kind``: ``number``, ``name``, ``truth``, ``call``, ``sum``, ``product``, ``negative``, ``inverse``, ``power``,
    ``compare``, ``and``, ``or`` or ``not``. A term that is subtracted is a ``negative`` in a sum, a divisor an
    ``inverse`` in a product. ``value``: digits, name, or the signs of a comparison in order, separated by blanks.
    """

    kind: str
    value: str = ""
    parts: "tuple[Node, ...]" = ()

    @property
    def is_condition(self) -> bool:
        """Whether it is true or false; else it has a number as its value."""
        return self.kind in ("truth", "compare", "and", "or", "not")


def parse(text: str) -> Node:
    """Read a text; raises `ExpressionError` if it is no expression, or longer or deeper than allowed."""
    if len(text) > TUNING.letters:
        raise ExpressionError(f"is {len(text)} letters long; at most {TUNING.letters} are read, name its parts instead")
    return _Parser(text).whole()


class _Parser:
    """Precedence climbing; ``kind`` and ``value`` are those of the token ahead, which begins at ``start``."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.end = self.depth = 0
        self._next()

    def whole(self) -> Node:
        found = self._expression(_OR)
        if self.kind != "end":
            self._refuse("an operator or the end")
        return found

    def _next(self) -> None:
        self.start = _BLANK.match(self.text, self.end).end()  # type: ignore[union-attr]
        found = _TOKEN.match(self.text, self.start)
        if found is None:
            self.kind, self.value, self.end = "end", "", self.start
            return
        self.kind, self.end = str(found.lastgroup), found.end()
        self.value = found[self.kind]
        if self.kind == "name" and self.value in WORDS:
            self.kind = "sign"

    def _expression(self, least: int) -> Node:
        self.depth += 1
        if self.depth > TUNING.depth:
            raise ExpressionError(f"is nested more than {TUNING.depth} deep; name its parts instead")
        left = self._prefix()
        while (level := _LEVELS.get(self.value, 0) if self.kind == "sign" else 0) >= least:
            left = self._power(left) if level == _POWER else self._chain(left, level)
        self.depth -= 1
        return left

    def _power(self, base: Node) -> Node:
        self._next()
        return Node("power", parts=(self._number(base), self._number(self._expression(_UNARY))))

    def _chain(self, first: Node, level: int) -> Node:
        """All operands of operators of one level: sums and products have any number of parts."""
        signs, parts = [], [first]
        while self.kind == "sign" and _LEVELS.get(self.value) == level:
            signs.append(self.value)
            self._next()
            part = self._expression(level + 1)
            wrap = {"-": "negative", "/": "inverse"}.get(signs[-1])
            parts.append(Node(wrap, parts=(self._number(part),)) if wrap else part)
        if level in (_AND, _OR):
            return Node(signs[0], parts=tuple(self._condition(part, signs[0]) for part in parts))
        kind = {_SUM: "sum", _PRODUCT: "product", _COMPARE: "compare"}[level]
        return Node(kind, " ".join(signs) if kind == "compare" else "", tuple(self._number(part) for part in parts))

    def _prefix(self) -> Node:
        kind, value = self.kind, self.value
        if kind in ("number", "name", "quoted"):
            self._next()
            if kind == "name" and (self.kind, self.value) == ("sign", "("):
                return self._call(value)
            return Node("number" if kind == "number" else "name", value)
        if kind != "sign" or value not in ("-", "+", "not", "(", "True", "False"):
            self._refuse("a number, a name or a parenthesis")
        self._next()
        if value in ("True", "False"):
            return Node("truth", value)
        if value == "not":
            return Node("not", parts=(self._condition(self._expression(_NOT), "not"),))
        if value == "(":
            inner = self._expression(_OR)
            self._close()
            return inner
        operand = self._number(self._expression(_UNARY))
        return Node("negative", parts=(operand,)) if value == "-" else operand

    def _call(self, name: str) -> Node:
        parts: list[Node] = []
        while not parts or (self.kind, self.value) == ("sign", ","):
            self._next()
            part = self._expression(_OR)
            if name not in BRANCHED or len(parts) % 2 == 0:
                part = self._number(part)
            elif not part.is_condition:
                raise ExpressionError(f"{self._shown()!r}: argument {len(parts) + 1} of {name} must be a comparison")
            parts.append(part)
        self._close()
        return Node("call", name, tuple(parts))

    def _close(self) -> None:
        if (self.kind, self.value) != ("sign", ")"):
            self._refuse("a ')' or an operator")
        self._next()

    def _number(self, node: Node) -> Node:
        if node.is_condition:
            raise ExpressionError(f"{self._shown()!r}: a comparison is not a number and cannot be calculated with")
        return node

    def _condition(self, node: Node, word: str) -> Node:
        if not node.is_condition:
            raise ExpressionError(f"{self._shown()!r}: {word!r} stands between comparisons, as in x > 0 {word} v < 1")
        return node

    def _shown(self) -> str:
        return self.text if len(self.text) <= 40 else f"...{self.text[max(0, self.end - 37) : self.end]}"

    def _refuse(self, expected: str) -> NoReturn:
        if not self.text.strip():
            raise ExpressionError("is empty; give an expression such as '-x'")
        if self.kind == "end":
            raise ExpressionError(f"{self._shown()!r} ends where {expected} should follow")
        hint = _INSTEAD.get(self.value, f"expected {expected}")
        if self.value in ("if", "else"):
            hint = f"{_CASES}, or a mode for each case"
        elif self.value == "," and "')'" in expected and _PAIRS.search(self.text, 0, self.start):
            hint = f"{_CASES}, without further parentheses"
        elif self.value == "," and self.text[self.start - 1 : self.start].isdigit():
            hint = "write a point for a decimal comma"
        elif self.kind == "name" and "')'" in expected:
            hint = "write * for a product, or close the parenthesis before it"
        elif expected.startswith("an operator") and self.kind != "sign" and _NAMED.search(self.text[: self.start]):
            hint = "write * for a product, or parentheses for a function, as in sin(x)"
        elif expected.startswith("an operator") and (self.kind != "sign" or self.value == "("):
            hint = "write * for a product"
        place = f"letter {self.start + 1} of {self.text!r:.60}"
        raise ExpressionError(f"{self.value!r:.30} cannot stand at {place}; {hint}")

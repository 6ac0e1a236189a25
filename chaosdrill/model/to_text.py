"""Sympy expressions as text that `from_text` reads back."""

from functools import cache
from typing import Any

from chaosdrill.model.grammar import PLAIN_NAME, WORDS


def write_text(expression: Any) -> str:
    """An expression or a condition as text.

    Whether the text gives the expression back to the last bit is for the caller to see: `from_text` reads no function
    or number that it does not know.

    Raises
    ------
    RecursionError
        If it is nested too deeply.
    """
    return str(_printer().doprint(expression))


@cache
def _printer() -> Any:
    from sympy.printing.precedence import PRECEDENCE
    from sympy.printing.str import StrPrinter

    class Printer(StrPrinter):
        def _print_Symbol(self, expr: Any) -> str:
            name = str(expr.name)
            return name if PLAIN_NAME.fullmatch(name) and name not in WORDS else f"`{name}`"

        def _print_Float(self, expr: Any) -> str:
            return repr(float(expr))

        def _print_Exp1(self, expr: Any) -> str:
            return "exp(1)"

        def _print_Relational(self, expr: Any) -> str:
            level = PRECEDENCE["Relational"]
            left, right = (self.parenthesize(side, level, strict=True) for side in (expr.lhs, expr.rhs))
            return f"{left} {expr.rel_op} {right}"

        def _print_And(self, expr: Any) -> str:
            return self._joined(expr, "and")

        def _print_Or(self, expr: Any) -> str:
            return self._joined(expr, "or")

        def _print_Not(self, expr: Any) -> str:
            return f"not ({self._print(expr.args[0])})"

        def _joined(self, expr: Any, word: str) -> str:
            level = PRECEDENCE[type(expr).__name__]
            return f" {word} ".join(self.parenthesize(part, level, strict=True) for part in expr.args)

    return Printer()

"""Expressions of parameters alone, which a run evaluates once."""

import re
from typing import TYPE_CHECKING, Any

import sympy

if TYPE_CHECKING:
    from chaosdrill.codegen.expression import ExpressionPrinter
    from chaosdrill.model.system import HybridSystem


class Constants:
    """Parameter-only expressions, computed once a run into the array that every kernel receives."""

    def __init__(self, system: "HybridSystem", printer: "ExpressionPrinter") -> None:
        self.printer = printer
        self.first = len(system.parameters)
        self.expressions: list[Any] = []

    def text(self, expression: Any) -> str:
        """Source text that stands for the value of the expression."""
        expression = sympy.sympify(expression)
        if not expression.free_symbols:
            return self.printer.doprint(expression)
        if expression.is_Symbol:
            return self.printer.doprint(expression).replace("[", "").replace("]", "")
        if expression not in self.expressions:
            self.expressions.append(expression)
        return f"c{self.first + self.expressions.index(expression)}"


def with_constants(lines: list[str]) -> list[str]:
    """The lines after those that load the constants which they name."""
    used = sorted({int(i) for line in lines for i in re.findall(r"\bc(\d+)\b", line)})
    return [*(f"c{i} = c[{i}]" for i in used), *lines]

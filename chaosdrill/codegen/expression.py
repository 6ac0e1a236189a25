"""Expressions printed as Python source for numba."""

from typing import TYPE_CHECKING, Any

import sympy
from sympy.core.sorting import default_sort_key
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pycode import PythonCodePrinter

from chaosdrill.model.places import UnsupportedError, parameter
from chaosdrill.model.special import SPECIAL

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


class ExpressionPrinter(PythonCodePrinter):
    """Prints states as ``x0``, time as ``t`` and parameters as ``c[0]``; exact numbers become doubles."""

    def __init__(self, system: "HybridSystem") -> None:
        super().__init__({"fully_qualified_modules": True})
        self.names = {s: f"x{i}" for i, s in enumerate(system.states)}
        self.names.update({parameter(p): f"c[{i}]" for i, p in enumerate(system.parameters)})
        if system.time is not None:
            self.names[system.time] = "t"

    def _print_Symbol(self, expr: Any) -> str:
        return self.names.get(expr, expr.name)

    def _print_Integer(self, expr: Any) -> str:
        return f"{int(expr)}.0"

    def _print_Rational(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_NumberSymbol(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Pow(self, expr: Any, **kwargs: Any) -> str:
        base = self.parenthesize(expr.base, 1000)
        if expr.exp == -1:
            return f"(1.0/{base})"
        if expr.exp.is_Integer and 2 <= expr.exp <= 4:
            return "(" + "*".join([base] * int(expr.exp)) + ")"
        if expr.exp == sympy.Rational(1, 2):
            return f"math.sqrt({self._print(expr.base)})"
        return f"({base}**{self.parenthesize(expr.exp, 1000)})"

    def _print_Mod(self, expr: Any) -> str:
        return f"(({self._print(expr.args[0])}) % ({self._print(expr.args[1])}))"

    def _print_floor(self, expr: Any) -> str:
        return f"math.floor({self._print(expr.args[0])})"

    def _print_Abs(self, expr: Any) -> str:
        return f"abs({self._print(expr.args[0])})"

    def _print_sign(self, expr: Any) -> str:
        return f"math.copysign(1.0, {self._print(expr.args[0])})"

    def _print_And(self, expr: Any) -> str:
        return self._tests(expr, "and")

    def _print_Or(self, expr: Any) -> str:
        return self._tests(expr, "or")

    def _tests(self, expr: Any, word: str) -> str:
        """Tests that call a special function come last: often they are not needed."""
        tests = sorted(expr.args, key=lambda e: (bool(_special_functions(e)), default_sort_key(e)))
        return f" {word} ".join(self.parenthesize(e, PRECEDENCE[type(expr).__name__]) for e in tests)

    def _print_Function(self, expr: Any) -> str:
        name = type(expr).__name__
        if name not in SPECIAL:
            raise UnsupportedError(
                expr, f": no numerical code for the function {name!r}; known special ones: {sorted(SPECIAL)}"
            )
        return f"{name}({', '.join(self._print(a) for a in expr.args)})"

    _print_not_supported = _print_Function


def statements(printer: ExpressionPrinter, targets: list[str], expressions: list[Any]) -> list[str]:
    """Assignments ``target = expression`` after those of their common subexpressions."""
    shared, reduced = sympy.cse(expressions, symbols=sympy.numbered_symbols("s_", real=True))
    lines = [f"{symbol.name} = {printer.doprint(value)}" for symbol, value in shared]
    return lines + [f"{target} = {printer.doprint(value)}" for target, value in zip(targets, reduced, strict=True)]


def _special_functions(expression: Any) -> set[str]:
    return {type(f).__name__ for f in expression.atoms(sympy.Function)} & set(SPECIAL)


def special_imports(expressions: list[Any]) -> list[str]:
    """Import lines for the special functions that the expressions name."""
    names = sorted({name for e in expressions for name in _special_functions(e)})
    lines = []
    for name in names:
        module, function = SPECIAL[name].split(":")
        lines.append(f"from {module} import {function}" + ("" if function == name else f" as {name}"))
    return lines

"""Expressions that depend on parameters only, evaluated once per run."""

import math
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.model.places import parameter

if TYPE_CHECKING:
    from chaosdrill.codegen.emitter import Function, Number, Row
    from chaosdrill.model.system import HybridSystem


class Constants:
    """The parameters, then expressions of them, computed once a run into the array that every kernel receives."""

    def __init__(self, system: "HybridSystem") -> None:
        self.symbols = [parameter(name) for name in system.parameters]
        self.places: dict[Any, int] = {symbol: i for i, symbol in enumerate(self.symbols)}

    def place(self, expression: Any) -> int:
        """Index of the value of an expression of parameters."""
        return self.places.setdefault(expression, len(self.places))

    def derived(self) -> list[tuple[int, Any]]:
        """Indices and expressions of all derived constants."""
        return [(place, e) for e, place in self.places.items() if place >= len(self.symbols)]

    def loaded(self, function: "Function", row: "Row") -> "Loaded":
        """The constants as numbers of a function."""
        return Loaded(self, function, row)


class Loaded:
    """Numbers of one function that stand for expressions of parameters, each loaded once."""

    def __init__(self, constants: Constants, function: "Function", row: "Row") -> None:
        self._constants, self._function, self._row = constants, function, row
        self._numbers: dict[Any, Number] = {}

    def __getitem__(self, expression: Any) -> "Number":
        if expression not in self._numbers:
            expression = sympy.sympify(expression)
            if not expression.free_symbols:
                self._numbers[expression] = self._function.number(double(expression))
            else:
                with self._function.at_entry():
                    self._numbers[expression] = self._row[self._constants.place(expression)]
        return self._numbers[expression]

    def times(self, weight: Any, value: "Number") -> "Number":
        """A number with a weight of parameters."""
        return value if weight == 1 else self[weight] * value


def double(expression: Any) -> float:
    """The double nearest to an expression without symbols; NaN if it has no real value."""
    if expression.is_Float or expression.is_Rational:
        return float(expression)
    value = expression.evalf(25)
    return float(value) if value.is_number and value.is_extended_real else math.nan

"""Numbers for symbolic expressions, without the code generator."""

from functools import cache

import pytest
import sympy

from chaosdrill.codegen.special import CODE


@pytest.fixture(scope="session")
def number():
    """Value of an expression at numbers given by symbol name."""

    @cache
    def function(expression):
        symbols = sorted(expression.free_symbols, key=lambda s: s.name)
        return sympy.lambdify(symbols, expression, [CODE, "math"]), [s.name for s in symbols]

    def evaluate(expression, values):
        called, names = function(sympy.sympify(expression))
        return called(*(values[name] for name in names))

    return evaluate

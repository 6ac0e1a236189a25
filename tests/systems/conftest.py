"""Numbers for symbolic expressions, without the code generator."""

import pytest
import sympy

from chaosdrill.codegen.special import CODE


@pytest.fixture(scope="session")
def number():
    """Value of an expression at numbers given by symbol name."""

    def evaluate(expression, values):
        symbols = sorted(sympy.sympify(expression).free_symbols, key=lambda s: s.name)
        return sympy.lambdify(symbols, expression, [CODE, "math"])(*(values[s.name] for s in symbols))

    return evaluate

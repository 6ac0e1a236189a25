"""Numbers for symbolic expressions, without the code generator."""

from importlib import import_module

import pytest
import sympy

from chaosdrill.model.special import SPECIAL


def _compiled(name):
    module, function = SPECIAL[name].split(":")
    return getattr(import_module(module), function)


@pytest.fixture(scope="session")
def number():
    """Value of an expression at numbers given by symbol name."""
    functions = {name: _compiled(name) for name in SPECIAL}

    def evaluate(expression, values):
        symbols = sorted(sympy.sympify(expression).free_symbols, key=lambda s: s.name)
        return sympy.lambdify(symbols, expression, [functions, "math"])(*(values[s.name] for s in symbols))

    return evaluate

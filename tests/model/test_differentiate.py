"""Derivatives between jumps: those of Mod and floor against finite differences away from the jumps."""

import pytest
import sympy

from chaosdrill.model.derive import differentiate

X, Y = sympy.symbols("x y", real=True)

EXPRESSIONS = [
    sympy.Mod(X, 1),
    sympy.Mod(3 * Y, 1) * X,
    sympy.Mod(X**2 + Y, sympy.Rational(3, 7)),
    sympy.Mod(X, Y),
    sympy.Mod(-X * Y, 2),
    sympy.floor(3 * X) * Y,
    sympy.sin(sympy.floor(X) + Y**2),
    sympy.Mod(sympy.floor(5 * X) * Y, 1) + X,
    sympy.exp(-X) * Y,
    sympy.Mod(sympy.Mod(X, 2) * Y, 1),
]


def value(expression, x, y):
    return float(expression.subs({X: sympy.Rational(x), Y: sympy.Rational(y)}).evalf(40))


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
@pytest.mark.parametrize("symbol", [X, Y])
@pytest.mark.parametrize("place", [("1.2345", "0.6789"), ("-2.7182", "1.4142")])
def test_derivative_is_that_of_the_branch(expression, symbol, place):
    x, y = (sympy.Rational(p) for p in place)
    step = sympy.Rational(1, 10**9)
    dx, dy = (step, 0) if symbol == X else (0, step)
    # the differences are taken of 40-digit values: only the third derivative is left, of order 1e-18
    ahead, behind = (expression.subs({X: x + s * dx, Y: y + s * dy}).evalf(40) for s in (1, -1))
    slope = float((ahead - behind) / (2 * step))
    assert value(differentiate(expression, symbol), *place) == pytest.approx(slope, rel=1e-12, abs=1e-12)


def test_no_derivative_of_a_jump_is_left_behind():
    assert differentiate(sympy.floor(X), X) == 0
    assert differentiate(sympy.Mod(X, 1), X) == 1
    assert differentiate(sympy.Mod(X, 1), Y) == 0

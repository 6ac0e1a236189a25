"""Bounds that keep sympy from calculating for ever while an expression is made of text.

Sympy calculates with constants when an expression is made. All of them are to be finite doubles, and exponents and
exact numbers bounded, so that ``9**9**9`` is refused before it is tried.
"""

import math
from collections.abc import Callable
from typing import Any

import sympy

from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.text_functions import FUNCTIONS

MOST_EXPONENT = 1000
"""Largest numerator and denominator of a rational exponent."""

MOST_BITS = 4096
"""Bits of a whole number, and of numerator and denominator of a fraction."""

_LOWEST = 1e-300


def check_power(base: Any, exponent: Any) -> None:
    """Refuse a power whose numbers would have too many digits."""
    if exponent.is_Rational:
        check_exponent(exponent)
        bits = sum(_bits(number) for number in base.atoms(sympy.Rational))
        if bits * abs(exponent.p) > 16 * MOST_BITS * exponent.q:
            raise ExpressionError("has a power that is too large a number")


def check_exponent(exponent: Any) -> None:
    """Refuse a rational exponent beyond the bound."""
    if max(abs(exponent.p), exponent.q) > MOST_EXPONENT:
        raise ExpressionError(f"has the exponent {exponent!s:.40}; exponents up to {MOST_EXPONENT} are read")


def check_size(expression: Any, most: int) -> None:
    """Refuse an expression of more operations."""
    count = sum(1 for _ in sympy.preorder_traversal(expression))
    if count > most:
        raise ExpressionError(
            f"compares, or takes by a function with kinks, {count} operations; at most {most} are read"
        )


def checked(made: Any) -> Any:
    """The expression, if sympy made no number of it that is too large."""
    if any(_bits(number) > MOST_BITS for number in made.atoms(sympy.Rational)):
        raise ExpressionError(f"holds a whole number of more than {MOST_BITS} bits")
    return made


def _bits(number: Any) -> int:
    return max(int(number.p).bit_length(), int(number.q).bit_length())


def check_finite(name: str, function: Callable[..., float], arguments: list[Any]) -> None:
    """Refuse a constant that is no finite double before sympy calculates it with all its digits."""
    given = [_double(argument) for argument in arguments]
    values = [value for value in given if value is not None]
    if len(values) < len(given):
        return
    if name == "**" and values[0] == 0 and values[1] < 0:
        raise ExpressionError("divides by zero")
    shown = ", ".join(f"{value:.6g}" for value in values)
    try:
        value = function(*values)
        if isinstance(value, complex):
            raise ValueError
    except (ArithmeticError, ValueError):
        raise ExpressionError(f"{name} of {shown} is no finite real number") from None
    if not math.isfinite(value) or (abs(value) < _LOWEST and name in ("exp", "**") and values[0] != 0):
        raise ExpressionError(f"{name} of {shown} is out of the range of doubles")


def _double(expression: Any) -> float | None:
    """Value of a constant, None if it holds a special function."""
    if expression.is_Rational:
        try:
            return int(expression.p) / int(expression.q)
        except OverflowError:
            raise ExpressionError("holds a number that is larger than any double") from None
    if expression.is_Float or expression.is_NumberSymbol:
        return float(expression)
    parts = [_double(part) for part in expression.args]
    if any(part is None for part in parts):
        return None
    name = type(expression).__name__
    known: dict[str, Callable[..., float]] = {
        "Add": lambda *p: math.fsum(p),
        "Mul": lambda *p: math.prod(p),
        "Pow": lambda x, y: x**y,
    }
    function = known.get(name) or (FUNCTIONS[name].value if name in FUNCTIONS else None)
    if function is None:
        return None
    try:
        value = function(*parts)
    except (ArithmeticError, ValueError):
        return None
    return None if isinstance(value, complex) else float(value)


def has_doubles(expression: Any) -> bool:
    """Whether every number of the expression is a double, whole numbers and fractions rounded."""
    try:
        return all(math.isfinite(float(number)) for number in expression.atoms(sympy.Rational, sympy.Float))
    except OverflowError:
        return False

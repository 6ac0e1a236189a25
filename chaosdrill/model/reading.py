"""What a user writes, read into sympy, or refused with its place, its value and what is allowed."""

from collections.abc import Mapping
from typing import Any

import sympy
from sympy.concrete.expr_with_limits import ExprWithLimits

from chaosdrill.errors import ModelError
from chaosdrill.model.grammar import ExpressionError
from chaosdrill.model.text import read_open_text

_UNREADABLE = (sympy.SympifyError, TypeError, ValueError, AttributeError)
_UNDONE = (ExprWithLimits, sympy.Derivative, sympy.Subs, sympy.Limit, sympy.Order)

NAMES = (
    "a name must not be empty, begin or end with a blank, or hold a slash, a line break or another sign that cannot be "
    "seen"
)


def canonical(expression: Any) -> Any:
    """The expression with every symbol replaced by the real symbol of the same name."""
    return expression.xreplace({s: sympy.Symbol(s.name, real=True) for s in expression.free_symbols})


def is_name(name: str) -> bool:
    """Whether a state, a parameter or a quadrature may be called so."""
    return bool(name) and name == name.strip() and "/" not in name and name.isprintable()


def read_expression(where: str, value: Any) -> Any:
    """A real expression of states, parameters and time; ModelError, which begins with ``where``, for anything else.

    Text is read by the grammar of scenes, `chaosdrill.model.grammar`; nothing of it is evaluated as code.
    """
    expression = _read(where, value, condition=False)
    if isinstance(expression, sympy.logic.boolalg.Boolean) and not isinstance(expression, sympy.Expr):
        raise ModelError(f"{where} is {value}, a relation; it must be an expression with a value, such as x - 1")
    if not isinstance(expression, sympy.Expr) or getattr(expression, "is_Matrix", False):
        raise ModelError(f"{where} is {value!r}; it must be one number or sympy expression")
    if expression.has(sympy.I):
        raise ModelError(f"{where}: {expression} is complex; only real expressions can be simulated")
    if expression.has(*_UNDONE):
        raise ModelError(
            f"{where}: {expression} holds an integral, a derivative or a sum that is not carried out; write its value "
            "(doit()), or make it a state or a quadrature"
        )
    return canonical(expression)


def read_condition(where: str, value: Any) -> Any:
    """A relation between expressions, or None."""
    return None if value is None else canonical(_read(where, value, condition=True))


def read_symbol(where: str, value: Any) -> Any:
    """The real symbol of a name or of a symbol."""
    if isinstance(value, str):
        return sympy.Symbol(value, real=True)
    if not isinstance(value, sympy.Symbol):
        raise ModelError(f"{where} is {value!r}; it must be a sympy symbol or its name")
    return canonical(value)


def read_mapping(where: str, value: Any, example: str) -> Mapping[Any, Any]:
    """The value, if it is a mapping."""
    if not isinstance(value, Mapping):
        raise ModelError(f"{where} is {value!r}; it must be a mapping, as in {example}")
    return value


def read_name(where: str, value: Any) -> str:
    """The value, if it is text that names something."""
    if not isinstance(value, str) or not value.strip():
        raise ModelError(f"{where} is {value!r}; it must be a text that is not empty")
    return value


def _read(where: str, value: Any, *, condition: bool) -> Any:
    try:
        if isinstance(value, str):
            return read_open_text(value, condition=condition)
        found = sympy.sympify(value, strict=True)
    except ExpressionError as fault:
        raise ModelError(f"{where}: {fault}") from None
    except _UNREADABLE as fault:
        raise ModelError(f"{where} is {value!r}, which sympy cannot read; give a number or an expression") from fault
    if not isinstance(found, sympy.Expr | sympy.logic.boolalg.Boolean):
        raise ModelError(f"{where} is {value!r}; give a number or an expression")
    return found

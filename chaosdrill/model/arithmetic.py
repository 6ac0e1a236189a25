"""Arithmetic of parameters as plain data: nested lists of operations, evaluated without sympy and without running code.

What is evaluated is what sympy prints for Python, operation by operation, so that the numbers are those of its code.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any

from chaosdrill.model.values import System

_OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "Add": operator.add,
    "Sub": operator.sub,
    "Mult": operator.mul,
    "Div": operator.truediv,
    "Pow": operator.pow,
    "USub": operator.neg,
}
_CONSTANTS = {"pi": math.pi, "e": math.e}
_FUNCTIONS = (
    *("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asin", "acos", "atan"),
    *("arcsin", "arccos", "arctan"),
)
_PARAMETER, _CONSTANT = "parameter", "constant"


def period(system: System, numbers: Sequence[Any], functions: ModuleType) -> Any:
    """The period of a forced system at numbers of all its parameters, in order.

    ``functions``: the module ``math``, or numpy if the numbers are arrays.
    """
    name = f"period by {functions.__name__}"
    if name not in system.shared:
        from chaosdrill.model.places import parameter, placed

        form = placed(system)
        plain = written(form.period, tuple(form.parameters), of_arrays=functions is not math)
        if plain is None:
            from sympy import lambdify

            from chaosdrill.model.special import WithFormula

            whole = form.period.replace(lambda e: isinstance(e, WithFormula), lambda e: e.formula())
            plain = lambdify([parameter(one) for one in form.parameters], whole, functions.__name__)
        system.shared[name] = plain
    found = system.shared[name]
    return found(*numbers) if callable(found) else value(found, numbers, functions)


def written(expression: Any, names: Sequence[str], *, of_arrays: bool) -> list[Any] | None:
    """An expression as plain data, its parameters by their places among ``names``; None if it is more than arithmetic.

    ``of_arrays``: whether it is written for numpy, or else for the module ``math``.
    """
    if of_arrays:
        from sympy.printing.numpy import NumPyPrinter as Printer
    else:
        from sympy.printing.pycode import PythonCodePrinter as Printer
    text = Printer({"fully_qualified_modules": False, "allow_unknown_functions": True}).doprint(expression)
    try:
        return [_plain(ast.parse(text, mode="eval").body, {name: i for i, name in enumerate(names)})]
    except (SyntaxError, LookupError, RecursionError):
        return None


def _plain(node: ast.expr, places: Mapping[str, int]) -> Any:
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return node.value
    if isinstance(node, ast.Name):
        if node.id in places:
            return [_PARAMETER, places[node.id]]
        if node.id in _CONSTANTS:
            return [_CONSTANT, node.id]
    if isinstance(node, ast.BinOp | ast.UnaryOp) and type(node.op).__name__ in _OPERATIONS:
        parts = [node.left, node.right] if isinstance(node, ast.BinOp) else [node.operand]
        return [type(node.op).__name__, *(_plain(part, places) for part in parts)]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
        return [node.func.id, *(_plain(part, places) for part in node.args)]
    raise LookupError(ast.dump(node))


def value(plain: list[Any], numbers: Sequence[Any], functions: ModuleType) -> Any:
    """The value of an expression that was `written` as plain data; other arguments as of `period`."""
    return _value(plain[0], numbers, functions)


def _value(plain: Any, numbers: Sequence[Any], functions: ModuleType) -> Any:
    if not isinstance(plain, list):
        return plain
    name, *parts = plain
    if name == _PARAMETER:
        return numbers[parts[0]]
    if name == _CONSTANT:
        return _CONSTANTS[parts[0]]
    found = [_value(part, numbers, functions) for part in parts]
    if name in _OPERATIONS:
        return _OPERATIONS[name](*found)
    return getattr(functions, _FUNCTIONS[_FUNCTIONS.index(name)])(*found)


def parameters_in(plain: Any) -> set[int]:
    """Places of the parameters in an expression that was written as plain data."""
    if not isinstance(plain, list):
        return set()
    if plain and plain[0] == _PARAMETER:
        return {plain[1]}
    return set().union(*map(parameters_in, plain))

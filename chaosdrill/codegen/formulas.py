"""Expressions of a system as functions of numbers, for what is asked of a few points only.

What was derived is kept as the text of a formula. A process that finds it reads it by a grammar of its own, in which
nothing but arithmetic, the functions of `math` or numpy and the special functions can be said, and needs no sympy.
"""

import ast
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen.addresses import ARGUMENTS, python_function

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

_OF_MATH = {name: getattr(math, name) for name in dir(math) if not name.startswith("_")}
_OF_MATH |= {"abs": abs, "max": max, "min": min}
_OF_NUMPY: dict[str, Any] = {name: one for name, one in vars(np).items() if isinstance(one, np.ufunc)}
_OF_NUMPY |= {"pi": np.pi, "e": np.e, "nan": np.nan, "inf": np.inf}

_ALLOWED = (
    *(ast.Expression, ast.Name, ast.Load, ast.List, ast.Tuple, ast.IfExp, ast.Call),
    *(ast.UnaryOp, ast.USub, ast.UAdd, ast.Not, ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.Mod),
    *(ast.BoolOp, ast.And, ast.Or, ast.Compare, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq),
)
"""What a formula may hold, beside numbers."""


def function_of(
    system: "HybridSystem",
    name: str,
    derive: "Callable[[HybridSystem], Any]",
    *,
    of: "Callable[[HybridSystem], list[Any]] | None" = None,
    arrays: bool = False,
) -> Any:
    """An expression of time, states and parameters, or of other symbols, as a function of numbers in this order.

    ``name``: what it is called among the formulas of the system. ``derive``: gives the expression of the system in its
    places; None for one that is nothing but zero, for which there is no function. ``of``: gives the symbols that it is
    a function of; what its terms have in common is then computed once. ``arrays``: whether any of its arguments may be
    an array.
    """
    known = system.shared.setdefault("functions", {})
    if name not in known:
        formulas = system.shared.setdefault("formulas", {})
        if name in formulas:
            text = formulas[name]
            known[name] = None if text == "" else _read(text, arrays)
        else:
            known[name] = _derived(system, name, derive(system.placed), of, arrays)
    return known[name]


def rates_of(system: "HybridSystem", mode: str) -> Any:
    """The rates of the states in a mode as a function of arrays."""
    return function_of(system, f"rates by numpy {mode}", lambda placed: list(placed.modes[mode].values()), arrays=True)


def _derived(
    system: "HybridSystem", name: str, expression: Any, of: "Callable[[HybridSystem], list[Any]] | None", arrays: bool
) -> Any:
    formulas = system.shared["formulas"]
    if expression is None:
        formulas[name] = ""
        return None
    import inspect

    import sympy

    from chaosdrill.codegen import python
    from chaosdrill.model.places import arguments

    parts = map(sympy.sympify, sympy.flatten([expression]))
    needed = {type(f).__name__ for part in parts for f in part.atoms(sympy.Function)}
    own = _special(needed & ARGUMENTS.keys(), arrays)
    own["Called"] = np.vectorize(python.evaluate, otypes=[float]) if arrays else python.evaluate
    modules = [own, "numpy" if arrays else "math"]
    if of is None:
        found = sympy.lambdify(arguments(system.placed), expression, modules=modules)
    else:
        found = sympy.lambdify(of(system.placed), sympy.sympify(expression), modules=modules, cse=True)
    text = inspect.getsource(found)
    try:
        _read(text, arrays)
    except (ValueError, SyntaxError, RecursionError):
        return found
    formulas[name] = text
    return found


def _special(names: "set[str]", arrays: bool) -> dict[str, Any]:
    """Special functions by name."""
    found = {name: python_function(name) for name in names}
    return {name: np.vectorize(one, otypes=[float]) for name, one in found.items()} if arrays else dict(found)


def _read(text: str, arrays: bool) -> Any:
    """The function that a formula says; raises `ValueError` or `SyntaxError` if it says anything but arithmetic."""
    (made,) = ast.parse(text).body
    if not isinstance(made, ast.FunctionDef) or made.decorator_list or made.returns:
        raise ValueError(text)
    given = made.args
    if given.defaults or given.kwonlyargs or given.vararg or given.kwarg or any(one.annotation for one in given.args):
        raise ValueError(text)
    names = {one.arg for one in given.args}
    named = {node.id for node in ast.walk(made) if isinstance(node, ast.Name)}
    known = (_OF_NUMPY if arrays else _OF_MATH) | _special((named & ARGUMENTS.keys()) - names, arrays)
    *terms, last = made.body
    for term in terms:
        # a part that several terms have in common
        if not (isinstance(term, ast.Assign) and [*map(type, term.targets)] == [ast.Name]):
            raise ValueError(text)
        _check(term.value, names, known)
        names |= {one.id for one in term.targets if isinstance(one, ast.Name)}
    if not (isinstance(last, ast.Return) and last.value is not None):
        raise ValueError(text)
    _check(last.value, names, known)
    within = {"__builtins__": {}, **known}
    exec(compile(ast.Module([made], []), "<formula>", "exec"), within)
    return within[made.name]


def _check(expression: ast.expr, names: set[str], known: dict[str, Any]) -> None:
    """Raise a ValueError if an expression holds anything but arithmetic of names."""
    for node in ast.walk(expression):
        if isinstance(node, ast.Constant):
            fits = type(node.value) in (int, float)
        elif isinstance(node, ast.Name):
            fits = node.id in names or node.id in known
        elif isinstance(node, ast.Call):
            fits = isinstance(node.func, ast.Name) and node.func.id not in names and not node.keywords
        else:
            fits = isinstance(node, _ALLOWED)
        if not fits:
            raise ValueError(f"a formula holds {type(node).__name__}")

"""Expressions of a system as functions of numbers, for what is asked of a few points only.

What was derived is kept as the text of a formula. A process that finds it reads it by a grammar of its own, in which
nothing but arithmetic and the functions of `math` or numpy can be said, and needs no sympy.
"""

import ast
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

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
    system: "HybridSystem", name: str, derive: "Callable[[HybridSystem], Any]", *, arrays: bool = False
) -> Any:
    """An expression of time, states and parameters as a function of numbers.

    Parameters
    ----------
    system : HybridSystem
    name : str
        What it is called among the formulas of the system.
    derive : callable
        Gives the expression of the system in its places; None for one that is nothing but zero.
    arrays : bool
        Whether any of its arguments may be an array.

    Returns
    -------
    callable or None
        Of time, all states and all parameters, in order.
    """
    known = system.shared.setdefault("functions", {})
    if name not in known:
        formulas = system.shared.setdefault("formulas", {})
        if name in formulas:
            text = formulas[name]
            known[name] = None if text == "" else _read(text, arrays)
        else:
            known[name] = _derived(system, name, derive(system.placed), arrays)
    return known[name]


def _derived(system: "HybridSystem", name: str, expression: Any, arrays: bool) -> Any:
    formulas = system.shared["formulas"]
    if expression is None:
        formulas[name] = ""
        return None
    import inspect

    import sympy

    from chaosdrill.codegen import python
    from chaosdrill.codegen.special import CODE
    from chaosdrill.model.places import arguments

    own: dict[str, Any] = {**CODE, "Called": python.evaluate}
    if arrays:
        own = {name: np.vectorize(function, otypes=[float]) for name, function in own.items()}
    modules = [own, "numpy" if arrays else "math"]
    found = sympy.lambdify(arguments(system.placed), expression, modules=modules)
    text = inspect.getsource(found).partition("(")[2]
    text = f"lambda {text.replace('):', ':', 1).replace('return ', '', 1)}"
    try:
        _read(text, arrays)
    except (ValueError, SyntaxError, RecursionError):
        return found
    formulas[name] = text
    return found


def _read(text: str, arrays: bool) -> Any:
    """The function that a formula says.

    Raises
    ------
    ValueError, SyntaxError
        If it says anything but arithmetic.
    """
    tree = ast.parse(" ".join(text.split()), mode="eval")
    made = tree.body
    if not isinstance(made, ast.Lambda) or made.args.defaults or made.args.kwonlyargs or made.args.vararg:
        raise ValueError(text)
    names, known = {one.arg for one in made.args.args}, _OF_NUMPY if arrays else _OF_MATH
    for node in ast.walk(made.body):
        if isinstance(node, ast.Constant):
            fits = type(node.value) in (int, float)
        elif isinstance(node, ast.Name):
            fits = node.id in names or node.id in known
        elif isinstance(node, ast.Call):
            fits = isinstance(node.func, ast.Name) and node.func.id not in names and not node.keywords
        else:
            fits = isinstance(node, _ALLOWED)
        if not fits:
            raise ValueError(f"{text:.60} holds {type(node).__name__}")
    found: Any = eval(compile(tree, "<formula>", "eval"), {"__builtins__": {}, **known})
    return found

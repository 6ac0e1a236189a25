"""Functions that may stand in an expression as text."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import sympy

from chaosdrill.model import special


@dataclass(frozen=True)
class Function:
    """A function that may stand in an expression.

    Parameters
    ----------
    make : callable
        That of sympy.
    least, most : int
        Number of arguments.
    smooth : bool
        Whether rates, guards and quadratures may hold it: it has a Taylor series.
    value : callable, optional
        Its value as a double.
    """

    make: Callable[..., Any]
    least: int = 1
    most: int = 1
    smooth: bool = True
    value: Callable[..., float] | None = None


_ELEMENTARY = (
    *("exp", "log", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan"),
    *("sinh", "cosh", "tanh", "asinh", "atanh"),
)


def _functions() -> dict[str, Function]:
    found = {name: Function(getattr(sympy, name), value=getattr(math, name)) for name in _ELEMENTARY}
    found["acosh"] = Function(sympy.acosh, smooth=False, value=math.acosh)
    found["Abs"] = Function(sympy.Abs, smooth=False, value=abs)
    found["sign"] = Function(sympy.sign, smooth=False, value=lambda x: math.copysign(1.0, x))
    found["floor"] = Function(sympy.floor, smooth=False, value=math.floor)
    found["ceiling"] = Function(sympy.ceiling, smooth=False, value=math.ceil)
    found["Mod"] = Function(sympy.Mod, 2, 2, smooth=False, value=lambda x, y: x % y)
    found["atan2"] = Function(sympy.atan2, 2, 2, smooth=False, value=math.atan2)
    found["Max"] = Function(sympy.Max, 2, 16, smooth=False, value=max)
    found["Min"] = Function(sympy.Min, 2, 16, smooth=False, value=min)
    for name in special.SPECIAL:
        function = getattr(special, name)
        (count,) = function.nargs
        found[name] = Function(function, int(count), int(count), smooth=name == "positive_power")
    return found


FUNCTIONS = _functions()
PLAIN = [name for name in FUNCTIONS if name not in special.SPECIAL]

INSTEAD = {
    "abs": "write Abs(x)",
    "fabs": "write Abs(x)",
    "max": "write Max(x, y)",
    "min": "write Min(x, y)",
    "mod": "write Mod(x, y)",
    "fmod": "write Mod(x, y)",
    "ceil": "write ceiling(x)",
    "ln": "write log(x)",
    "log10": "write log(x)/log(10)",
    "log2": "write log(x)/log(2)",
    "pow": "write x**n",
    "cbrt": "write x**(1/3)",
    "arcsin": "write asin(x)",
    "arccos": "write acos(x)",
    "arctan": "write atan(x)",
    "sec": "write 1/cos(x)",
    "csc": "write 1/sin(x)",
    "cot": "write 1/tan(x)",
    "sech": "write 1/cosh(x)",
    "coth": "write 1/tanh(x)",
    "Piecewise": "write the branches as modes, or as transitions with a condition each",
    "Heaviside": "write the branches as modes, or as transitions with a condition each",
}

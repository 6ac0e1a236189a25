"""Bounds of expressions over all values of their symbols, and the kinks at which, by these, they never are."""

import math
from functools import reduce
from itertools import permutations
from typing import Any

import sympy

BOUNDED = (sympy.sin, sympy.cos, sympy.tanh, sympy.erf)
"""Functions with values from -1 to 1."""


def sign_of(expression: Any) -> int:
    """Sign of an expression for all real values of its symbols; 0 if it changes or is not known."""
    if expression.is_positive:
        return 1
    if expression.is_negative:
        return -1
    low, high = bounds_of(expression)
    return 1 if low > 0 else -1 if high < 0 else 0


def bounds_of(e: Any) -> tuple[float, float]:
    """Lower and upper bound of an expression over all values of its symbols."""
    everything = (-math.inf, math.inf)
    if e.is_number:
        value = complex(e.evalf())
        return (value.real, value.real) if value.imag == 0 else everything
    if isinstance(e, BOUNDED):
        return -1.0, 1.0
    if isinstance(e, (sympy.atan, sympy.asin)):
        return -math.pi / 2, math.pi / 2
    if e.is_Add:
        parts = [bounds_of(term) for term in e.args]
        return sum(low for low, _ in parts), sum(high for _, high in parts)
    if e.is_Mul:
        return reduce(_times, map(bounds_of, e.args))
    if e.is_Pow and e.exp.is_Integer and e.exp.is_positive:
        low, high = bounds_of(e.base)
        try:
            ends = low ** int(e.exp), high ** int(e.exp)
        except OverflowError:
            return (0.0, math.inf) if e.exp.is_even else everything
        return ends if e.exp.is_odd else (0.0 if low < 0 < high else min(ends), max(ends))
    if e.is_nonnegative or (e.is_Pow and e.exp.is_even):
        return 0.0, math.inf
    if e.is_nonpositive:
        return -math.inf, 0.0
    return everything


def _times(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    """Bounds of a product; what is zero times what has no bound is zero."""
    ends = [a * b if a and b else 0.0 for a in one for b in other]
    return min(ends), max(ends)


def decided(expression: Any) -> Any:
    """An expression without the kinks and jumps at which, for all values of its symbols, it never is."""
    return expression.replace(lambda e: isinstance(e, (sympy.Abs, sympy.sign, sympy.Max, sympy.Min)), _decided)


def _decided(part: Any) -> Any:
    if isinstance(part, sympy.Abs | sympy.sign):
        (g,) = part.args
        if isinstance(part, sympy.sign):
            return sympy.Integer(sign_of(g)) if sign_of(g) else part
        low, high = bounds_of(g)
        return g if low >= 0 else -g if high <= 0 else part
    way = 1 if isinstance(part, sympy.Max) else -1
    left = list(part.args)
    for one, other in permutations(part.args, 2):
        if one in left and other in left and bounds_of(way * (one - other))[0] >= 0:
            left.remove(other)
    return part.func(*left)

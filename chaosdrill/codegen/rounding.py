"""Bounds of the rounding error of an expression, from its operations.

A bound in units of the rounding unit, itself an expression: every operation adds its own rounding to what those of its
operands become in it (running error analysis: Wilkinson 1963; Higham, Accuracy and Stability of Numerical Algorithms,
2nd ed. 2002, section 3.3, doi:10.1137/1.9780898718027). What a symbol is off by enters a sum through the derivative of
the whole sum: ``sin(x)**2 + cos(x)**2`` does not depend on x. Terms of higher order are left out.
"""

import math
from collections.abc import Mapping
from typing import Any

import sympy
from sympy.core.function import Application, ArgumentIndexError

from chaosdrill.codegen.layout import UNIT
from chaosdrill.codegen.tape import inverse_of
from chaosdrill.model.python import Called, Doubt
from chaosdrill.model.special import SPECIAL, even_rest, power_rest, taylor_rest


def rounding_bound(expression: Any, doubts: Mapping[Any, Any] | None = None) -> Any:
    """Bound of the rounding error of an expression whose symbols are known to one rounding each, in rounding units.

    ``doubts``: by how much more a symbol may be off, in the same units. The bound is an expression of the same symbols.
    """
    known: dict[Any, Any] = {symbol: _size(symbol) + more for symbol, more in (doubts or {}).items()}

    operations: dict[Any, Any] = {}

    def bound(e: Any) -> Any:
        if e not in known:
            slopes = _slopes_of_sum(e)
            known[e] = (
                sympy.Add(of_operations(e), *(_size(slope) * bound(x) for x, slope in slopes.items()))
                if slopes
                else _bound(e, bound)
            )
        return known[e]

    def of_operations(e: Any) -> Any:
        if e not in operations:
            operations[e] = sympy.Integer(0) if e.is_Symbol else _bound(e, of_operations)
        return operations[e]

    return bound(sympy.sympify(expression))


def _size(e: Any) -> Any:
    """The absolute value of a real number; of a logarithm or a root sympy gives that of a complex one."""
    size = sympy.Abs(e)
    return sympy.sqrt(e**2) if size.has(sympy.arg, sympy.re, sympy.im) else size


def _slopes_of_sum(e: Any) -> dict[Any, Any]:
    """Derivatives of a sum by its symbols, if some of its terms share one and no derivative has a pole or overflows."""
    if not e.is_Add or any(not isinstance(f, (sympy.sin, sympy.cos)) for f in e.atoms(Application)):
        return {}
    if len(e.free_symbols) == sum(len(a.free_symbols) for a in e.args):
        return {}
    found = {x: sympy.diff(e, x) for x in sorted(e.free_symbols, key=str)}
    poles = (p for slope in found.values() for p in slope.atoms(sympy.Pow) if p.exp.could_extract_minus_sign())
    return {} if any(p.base.free_symbols for p in poles) else found


def _bound(e: Any, bound: Any) -> Any:
    if e.is_Symbol or e.is_NumberSymbol:
        return _size(e)
    if e.is_Number:
        exact = e.is_Float or e.is_Integer or (e.is_Rational and e.q & (e.q - 1) == 0)
        return sympy.Integer(0) if exact else abs(e)
    if e.is_Add:
        return sympy.Add(*(bound(a) + _size(a) for a in e.args))
    if e.is_Mul:
        sizes = [_size(a) for a in e.args]
        spread = [bound(a) * sympy.Mul(*sizes[:i], *sizes[i + 1 :]) for i, a in enumerate(e.args)]
        return sympy.Add(*spread, (len(sizes) - 1) * sympy.Mul(*sizes))
    if e.is_Pow and e.exp.is_Integer and e.exp.is_negative and (whole := inverse_of(e.base)):
        # the rate of such a gate or pulse is no larger than itself, and known where its parts are infinite
        return _size(e) * (-e.exp * bound(whole[1]) + 2 - e.exp)
    if e.is_Pow and not e.exp.free_symbols:
        slope = _size(e.exp) * _size(e.base) ** (e.exp - 1)
        return slope * bound(e.base) + _size(e.exp) * _size(e.base) ** e.exp
    if isinstance(e, sympy.Piecewise):
        return sympy.Max(*(bound(value) for value, _ in e.args))
    if isinstance(e, (sympy.Max, sympy.Min)):
        return sympy.Max(*map(bound, e.args))
    if isinstance(e, (sympy.Mod, sympy.floor, sympy.sign)):
        return sympy.Add(*map(bound, e.args)) + _size(e)
    if isinstance(e, sympy.Abs):
        return bound(e.args[0])
    if isinstance(e, Called):
        return Doubt(*e.args, *map(bound, e.args[3:]))
    # any other function: what its arguments may be off by, through its derivatives
    carried = sympy.Add(*(_size(_slope(e, i)) * bound(a) for i, a in enumerate(e.args)))
    special = SPECIAL.get(type(e).__name__)
    if isinstance(e, (taylor_rest, power_rest, even_rest)) and e.args[1].is_number:
        # far from 0 it is what is left of the function itself, divided
        distance = sympy.sqrt(_size(e.args[0])) if isinstance(e, even_rest) else _size(e.args[0])
        carried += _size(e.whole()) / (distance ** e.args[2] + sympy.Rational(1, 2) ** e.args[2])
    return carried + _size(e) * (1 if special is None else math.ceil(special.error / UNIT))


def _slope(e: Any, i: int) -> Any:
    if e.is_Pow:
        base, exponent = e.args
        return exponent * base ** (exponent - 1) if i == 0 else e * sympy.log(base)
    try:
        return e.fdiff(i + 1)
    except (ArgumentIndexError, AttributeError):
        return sympy.Integer(1)

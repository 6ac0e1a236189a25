"""Evaluation of expressions in the code of a function."""

from collections.abc import Iterable, Mapping
from copy import copy
from typing import TYPE_CHECKING, Any

import sympy
from sympy.core.sorting import default_sort_key

from chaosdrill.codegen.constants import double
from chaosdrill.codegen.emitter import total
from chaosdrill.codegen.mathematics import LIBRARY, START, power, remainder, root, special
from chaosdrill.codegen.python import write_call
from chaosdrill.codegen.tuning import TUNING
from chaosdrill.errors import ModelError
from chaosdrill.model.python import Along, Called, Doubt
from chaosdrill.model.special import SPECIAL

if TYPE_CHECKING:
    from chaosdrill.codegen.emitter import Function, Number, Test

_RELATIONS = {
    sympy.StrictLessThan: "<",
    sympy.LessThan: "<=",
    sympy.StrictGreaterThan: ">",
    sympy.GreaterThan: ">=",
    sympy.Equality: "==",
    sympy.Unequality: "!=",
}


class Expressions:
    """Values of expressions, each of whose parts is computed once, where it is first needed.

    ``values``: what is known, by symbol. ``expressions``: all that will be asked for, so that parts which they have in
    common are found.
    """

    def __init__(self, function: "Function", values: "Mapping[Any, Number]", expressions: Iterable[Any] = ()) -> None:
        self.function = function
        self.known: dict[Any, Number] = dict(values)
        wanted = list(dict.fromkeys(sympy.sympify(e) for e in expressions))
        shared, reduced = sympy.cse(wanted, symbols=sympy.numbered_symbols("s_", real=True))
        self.definitions = dict(shared)
        self.reduced = dict(zip(wanted, reduced, strict=True))

    def inside(self) -> "Expressions":
        """The same in a branch: what is computed there is not known outside of it."""
        other = copy(self)
        other.known = dict(self.known)
        return other

    def __getitem__(self, expression: Any) -> "Number":
        expression = sympy.sympify(expression)
        return self._value(self.reduced.get(expression, expression))

    def _value(self, e: Any) -> "Number":
        if e not in self.known:
            self.known[e] = self._value(self.definitions[e]) if e in self.definitions else self._made(e)
        return self.known[e]

    def _made(self, e: Any) -> "Number":
        if not e.free_symbols and not e.has(sympy.Function):
            return self.function.number(double(e))
        if e.is_Add:
            return total([self._value(a) for a in e.as_ordered_terms()])
        if e.is_Mul:
            return self._product(e)
        if e.is_Pow:
            return self._power(e.base, e.exp)
        if isinstance(e, sympy.Piecewise):
            return self._piecewise(e)
        if isinstance(e, Called | Along | Doubt):
            self.known |= write_call(self.function, e, self._value)
            return self.known[e]
        return self._function(e)

    def _product(self, e: Any) -> "Number":
        factors = e.as_ordered_factors()
        above = [f for f in factors if not _is_below(f)]
        below = [f.base**-f.exp for f in factors if _is_below(f)]
        top = self._chain(above) if above else self.function.number(1.0)
        return top / self._chain(below) if below else top

    def _chain(self, factors: list[Any]) -> "Number":
        signs = [f for f in factors if f == -1]
        first, *rest = (self._value(f) for f in factors if f != -1) if len(signs) < len(factors) else (1.0,)
        for factor in rest:
            first = first * factor
        return -first if len(signs) % 2 else first

    def _power(self, base: Any, exponent: Any) -> "Number":
        if base == sympy.E:
            return START["exp"](self._value(exponent))
        if exponent.is_number and exponent < 0:
            return 1.0 / self._value(base**-exponent)
        value = self._value(base)
        if exponent.is_Integer and exponent <= TUNING.multiplied:
            result = value
            for _ in range(int(exponent) - 1):
                result = result * value
            return result
        return root(value) if exponent == sympy.Rational(1, 2) else power(value, self._value(exponent))

    def _piecewise(self, e: Any) -> "Number":
        *others, (last, condition) = e.args
        result = self._value(last)
        if condition != sympy.true:
            result = self.function.choose(self.test(condition), result, float("nan"))
        for value, condition in reversed(others):
            result = self.function.choose(self.test(condition), self._value(value), result)
        return result

    def _function(self, e: Any) -> "Number":
        f, name = self.function, type(e).__name__
        a = [self._value(argument) for argument in e.args]
        if name in START:
            return START[name](a[0])
        if name in SPECIAL:
            return special(f, name, a)
        if isinstance(e, (sympy.Max, sympy.Min)):
            symbol, result = (">" if isinstance(e, sympy.Max) else "<"), a[0]
            for other in a[1:]:
                result = f.choose(other.compare(symbol, result), other, result)
            return result
        if isinstance(e, sympy.Mod):
            return remainder(*a)
        if isinstance(e, sympy.Abs):
            return f.intrinsic("fabs", a[0])
        if isinstance(e, sympy.sign):
            return f.intrinsic("copysign", 1.0, a[0])
        if isinstance(e, (sympy.floor, sympy.ceiling)):
            return f.intrinsic("floor" if isinstance(e, sympy.floor) else "ceil", a[0])
        if name in LIBRARY:
            return f.external(LIBRARY[name], *a)
        raise ModelError(f"no numerical code for the function {name!r}")

    def test(self, condition: Any) -> "Test":
        """Whether a condition holds; parts that call a special function are computed only if they are needed."""
        condition = self.definitions.get(condition, condition)
        if condition in (sympy.true, sympy.false):
            return self.function.truth(condition == sympy.true)
        if isinstance(condition, sympy.Not):
            return ~self.test(condition.args[0])
        if isinstance(condition, (sympy.And, sympy.Or)):
            both = isinstance(condition, sympy.And)
            parts = sorted(condition.args, key=lambda e: (_is_special(e), default_sort_key(e)))
            result = self.test(parts[0])
            for part in parts[1:]:
                result = self.joined(result, part, both)
            return result
        left, right = (self._value(self.reduced.get(side, side)) for side in condition.args)
        return left.compare(_RELATIONS[type(condition)], right)

    def joined(self, first: "Test", part: Any, both: bool) -> "Test":
        """Both tests hold, or one of them does; what takes long is done only where the first leaves it open."""
        f = self.function
        if not _is_special(part):
            other = self.test(part)
            return first & other if both else first | other
        held = f.variable(f.choose(first, 1.0, 0.0))
        with f.when(first if both else ~first):
            held.become(f.choose(self.inside().test(part), 1.0, 0.0))
        return held.now.compare("!=", 0.0)


def _is_below(factor: Any) -> bool:
    return bool(factor.is_Pow and factor.exp.is_number and factor.exp.is_negative and factor.base != sympy.E)


def _is_special(expression: Any) -> bool:
    return any(type(f).__name__ in SPECIAL for f in expression.atoms(sympy.Function))

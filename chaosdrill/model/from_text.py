"""Text becomes a sympy expression, by a list of what may stand in it; nothing of it is evaluated as code."""

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import sympy

from chaosdrill.model.grammar import ExpressionError, Node, parse
from chaosdrill.model.text_bounds import (
    MOST_BITS,
    check_exponent,
    check_finite,
    check_power,
    check_size,
    checked,
    has_doubles,
)
from chaosdrill.model.text_functions import FUNCTIONS, INSTEAD, PLAIN
from chaosdrill.names import remedy

MOST_FACTORS = 100
MOST_PARTS = 200
"""Operations in what is compared, or in the argument of a function with kinks: sympy looks for the sign of it."""

MOST_OF_MOD = 30

_UNBOUNDED = (sympy.zoo, sympy.nan, sympy.oo, -sympy.oo)
_RELATIONS = {"<": sympy.Lt, "<=": sympy.Le, ">": sympy.Gt, ">=": sympy.Ge, "==": sympy.Eq, "!=": sympy.Ne}


def read_text(
    text: str,
    names: Mapping[str, Any],
    *,
    condition: bool = False,
    moving: "set[Any] | None" = None,
    hints: Mapping[str, str] | None = None,
) -> Any:
    """Read an expression.

    Parameters
    ----------
    text : str
        As `grammar.parse` reads it; ``pi`` is the number, unless it is a name.
    names : mapping of str to sympy.Symbol
        The names that it may hold.
    condition : bool
        Whether it is to be true or false rather than a number.
    moving : set of sympy.Symbol, optional
        States and time, if functions of these are to have Taylor series.
    hints : mapping of str to str, optional
        What to do about names that are likely to be meant but are not among those.

    Returns
    -------
    sympy expression

    Raises
    ------
    ExpressionError
        With all that is wrong with it.
    """
    return _read_tree(text, parse(text), names, condition=condition, moving=moving, hints=hints)


def read_open_text(text: str, *, condition: bool = False) -> Any:
    """Read an expression whose names are not known yet: each is a symbol, ``pi`` among them.

    Raises
    ------
    ExpressionError
        With all that is wrong with it.
    """
    tree = parse(text)
    names = {name: sympy.Symbol(name, real=True) for name in _names(tree) if name not in FUNCTIONS}
    return _read_tree(text, tree, names, condition=condition)


def _names(node: Node) -> Iterator[str]:
    if node.kind == "name":
        yield node.value
    for part in node.parts:
        yield from _names(part)


def _read_tree(
    text: str,
    tree: Node,
    names: Mapping[str, Any],
    *,
    condition: bool,
    moving: "set[Any] | None" = None,
    hints: Mapping[str, str] | None = None,
) -> Any:
    if tree.is_condition != condition:
        wanted = "a comparison, such as x > 0" if condition else "a number, and no comparison"
        raise ExpressionError(f"{text!r:.60} is to be {wanted}")
    faults = list(dict.fromkeys(_unknown(tree, names, hints or {})))
    if faults:
        raise ExpressionError("; ".join(faults[:10]))
    try:
        found = _Builder(names, moving).build(tree)
    except (ExpressionError, MemoryError):
        raise
    except RecursionError:
        raise ExpressionError("is nested too deeply; name its parts instead") from None
    # sympy evaluates what it is given, and fails in ways of its own
    except Exception as fault:
        raise ExpressionError(f"{text!r:.60} cannot be made an expression: {fault!s:.100}") from None
    if found.has(*_UNBOUNDED):
        raise ExpressionError(f"{text!r:.60} divides by zero, or is not finite")
    if not has_doubles(found):
        raise ExpressionError(f"{text!r:.60} holds a number that is larger than any double")
    if found.has(sympy.I):
        raise ExpressionError(f"{text!r:.60} is complex")
    return found


def _unknown(node: Node, names: Mapping[str, Any], hints: Mapping[str, str]) -> Iterator[str]:
    if node.kind == "name" and node.value not in names and node.value != "pi":
        if node.value in FUNCTIONS:
            yield f"{node.value!r} is a function; give it an argument, as in {node.value}(x)"
        else:
            hint = hints.get(node.value) or remedy(node.value, (*names, "pi"))
            yield f"unknown name {node.value[:40]!r}; {hint}"
    elif node.kind == "call":
        function = FUNCTIONS.get(node.value)
        if function is None and node.value in names:
            yield f"{node.value[:40]!r} is no function; write {node.value:.40}*(...) for a product"
        elif function is None:
            yield f"unknown function {node.value[:40]!r}; {INSTEAD.get(node.value) or remedy(node.value, PLAIN)}"
        elif not function.least <= len(node.parts) <= function.most:
            count = function.least if function.least == function.most else f"{function.least} to {function.most}"
            yield f"{node.value} takes {count} argument{'s' if count != 1 else ''}, received {len(node.parts)}"
    for part in node.parts:
        yield from _unknown(part, names, hints)


class _Builder:
    def __init__(self, names: Mapping[str, Any], moving: "set[Any] | None") -> None:
        self.names, self.moving = names, moving

    def build(self, node: Node) -> Any:
        made = self._make(node)
        if made in _UNBOUNDED:
            raise ExpressionError("divides by zero, or is not finite")
        return made

    def _make(self, node: Node) -> Any:
        match node.kind:
            case "number":
                return _number(node.value)
            case "name":
                return self.names.get(node.value, sympy.pi)
            case "truth":
                return sympy.true if node.value == "True" else sympy.false
            case "sum":
                return checked(sympy.Add(*(self.build(part) for part in node.parts)))
            case "product" | "negative" | "inverse":
                factors = list(self._factors(node))
                if len(factors) > MOST_FACTORS:
                    raise ExpressionError(f"has a product of {len(factors)} factors; at most {MOST_FACTORS} are read")
                return checked(sympy.Mul(*factors))
            case "power":
                return _power(*(self.build(part) for part in node.parts))
            case "call":
                return self._call(node.value, [self.build(part) for part in node.parts])
            case "compare":
                return self._compare(node)
            case "not":
                return sympy.Not(self.build(node.parts[0]))
            case _:
                joined = sympy.And if node.kind == "and" else sympy.Or
                return joined(*(self.build(part) for part in node.parts))

    def _factors(self, node: Node) -> Iterator[Any]:
        """Factors of a product, so that it is made at once: 2*(x + y)*z is not 2*x + 2*y, times z."""
        if node.kind == "negative":
            yield sympy.S.NegativeOne
            yield from self._factors(node.parts[0])
        elif node.kind == "product":
            for part in node.parts:
                yield from self._factors(part)
        elif node.kind == "inverse":
            # a divisor that is a product divides factor by factor, as sympy has it
            for factor in self._factors(node.parts[0]):
                yield _power(factor, sympy.S.NegativeOne)
        else:
            yield self.build(node)

    def _call(self, name: str, arguments: list[Any]) -> Any:
        function = FUNCTIONS[name]
        if not function.smooth:
            if self.moving and any(a.free_symbols & self.moving for a in arguments):
                raise ExpressionError(
                    f"{name} has no Taylor series, and can stand in resets and conditions only; write its branches as "
                    "modes with a guard between them"
                )
            for argument in arguments:
                check_size(argument, MOST_OF_MOD if name == "Mod" else MOST_PARTS)
                # sympy expands what stands in it
                powers = argument.atoms(sympy.Pow) if name == "Mod" else ()
                if any(power.exp.is_Rational and power.exp > 8 for power in powers):
                    raise ExpressionError("takes the remainder of a power larger than 8")
        if name == "exp" and arguments[0].has(sympy.log):
            # sympy makes a power of it
            for number in arguments[0].atoms(sympy.Rational):
                check_exponent(number)
        if name in ("sqrt", "positive_power"):
            base, exponent = (*arguments, sympy.S.Half)[:2]
            check_power(base, exponent)
        if function.value is not None and not any(a.free_symbols for a in arguments):
            check_finite(name, function.value, arguments)
        return checked(function.make(*arguments))

    def _compare(self, node: Node) -> Any:
        sides = [self.build(part) for part in node.parts]
        for side in sides:
            check_size(side, MOST_PARTS)
        signs = node.value.split()
        pairs = [_RELATIONS[sign](*pair) for sign, pair in zip(signs, pairwise(sides), strict=True)]
        return pairs[0] if len(pairs) == 1 else sympy.And(*pairs)


def _number(digits: str) -> Any:
    if digits.isdecimal():
        if len(digits) > MOST_BITS // 4:
            raise ExpressionError(f"has a whole number of {len(digits)} digits; at most {MOST_BITS // 4} are read")
        return checked(sympy.Integer(int(digits)))
    if not math.isfinite(value := float(digits)):
        raise ExpressionError(f"{digits!r:.40} is larger than any double")
    return sympy.Float(value)


def _power(base: Any, exponent: Any) -> Any:
    check_power(base, exponent)
    if not base.free_symbols and not exponent.free_symbols:
        check_finite("**", lambda x, y: x**y, [base, exponent])
    made = checked(sympy.Pow(base, exponent))
    if isinstance(made, sympy.Pow) and made.exp.is_Rational:
        check_exponent(made.exp)
    return made

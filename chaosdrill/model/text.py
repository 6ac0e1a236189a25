"""Text becomes a sympy expression, by a list of what may stand in it, and sympy expressions become text.

Nothing of a text is evaluated as code. Sympy calculates with constants when an expression is made: all of them are to
be finite doubles, and exponents and exact numbers are bounded, so that ``9**9**9`` is refused before it is tried.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import sympy
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from chaosdrill.model.grammar import BRANCHED, PLAIN_NAME, WORDS, ExpressionError, Node, parse
from chaosdrill.model.special import CONDITION, FLOW, RESET, SPECIAL
from chaosdrill.model.tuning import TUNING
from chaosdrill.names import remedy
from chaosdrill.units import VANISHES, vanishes

_UNBOUNDED = (sympy.zoo, sympy.nan, sympy.oo, -sympy.oo)
_RELATIONS = {"<": sympy.Lt, "<=": sympy.Le, ">": sympy.Gt, ">=": sympy.Ge, "==": sympy.Eq, "!=": sympy.Ne}


def read_text(
    text: str,
    names: Mapping[str, Any],
    *,
    condition: bool = False,
    hints: Mapping[str, str] | None = None,
    clock: str | None = None,
) -> Any:
    """Read an expression, as `grammar.parse` reads it; ``pi`` is the number, unless it is a name.

    ``names``: symbols of the names that it may hold. ``condition``: whether it is to be true or false rather than a
    number. ``hints``: what to do about names that are likely to be meant but are not among those. ``clock``: what the
    time is called.

    Raises `ExpressionError` with all that is wrong with it.
    """
    tree = parse(text)
    if tree.is_condition != condition:
        wanted = "a comparison, such as x > 0" if condition else "a number, not a comparison"
        raise ExpressionError(f"{text!r:.60} must be {wanted}")
    faults = list(dict.fromkeys(_unknown(tree, names, hints or {}, clock)))
    if faults:
        raise ExpressionError("; ".join(faults[:10]))
    try:
        found = _Builder(names).build(tree)
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
        raise ExpressionError(f"{text!r:.60} holds a number that is larger than any double, or nearer to 0")
    if found.has(sympy.I):
        raise ExpressionError(f"{text!r:.60} is complex")
    return found


def read_open_text(text: str, *, condition: bool = False) -> Any:
    """Read an expression whose names are not known yet: each is a symbol, ``pi`` among them; raises as `read_text`."""
    names = {name: sympy.Symbol(name, real=True) for name in _names(parse(text)) if name not in FUNCTIONS}
    return read_text(text, names, condition=condition)


def _names(node: Node) -> Iterator[str]:
    if node.kind == "name":
        yield node.value
    for part in node.parts:
        yield from _names(part)


def _unknown(node: Node, names: Mapping[str, Any], hints: Mapping[str, str], clock: str | None) -> Iterator[str]:
    if node.kind == "name" and node.value not in names and node.value != "pi":
        if node.value in FUNCTIONS:
            yield f"{node.value!r} is a function; give it an argument, as in {node.value}(x)"
        else:
            yield unknown_name(node.value, names, hints)
    elif node.kind == "call":
        function = FUNCTIONS.get(ALIASES.get(node.value, node.value))
        if function is None and node.value in names:
            yield no_function(node.value, delayed=clock is not None and clock in _names(node))
        elif function is None:
            yield f"unknown function {node.value[:40]!r}; {unknown_function(node.value)}"
        elif not function.least <= len(node.parts) <= function.most:
            count = function.least if function.least == function.most else f"{function.least} to {function.most}"
            yield f"{node.value} takes {count} argument{'s' if count != 1 else ''}, received {len(node.parts)}"
        elif node.value in BRANCHED and len(node.parts) % 2 == 0:
            yield f"{node.value} ends with the value that it has elsewhere, as in {node.value}(x, x > 0, -x)"
    for part in node.parts:
        yield from _unknown(part, names, hints, clock)


def no_function(name: str, *, delayed: bool) -> str:
    """The message for a name that is called like a function; ``delayed``: with a shifted time."""
    if delayed:
        return (
            f"{name[:40]!r} is written as a function of time: its present value is {name[:40]}, and a value at another "
            "time, a delay, cannot be simulated, for the states are all that a system remembers; a chain of states can "
            "approximate it"
        )
    return f"{name[:40]!r} is no function; write {name:.40}*(...) for a product"


def unknown_name(name: str, names: Mapping[str, Any], hints: Mapping[str, str]) -> str:
    """The message for an unknown name."""
    return f"unknown name {name[:40]!r}; {hints.get(name) or remedy(name, (*names, 'pi'))}"


def unknown_function(name: str) -> str:
    """The remedy for an unknown function."""
    return INSTEAD.get(name) or remedy(name, PLAIN)


class _Builder:
    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

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
                return _checked(sympy.Add(*(self.build(part) for part in node.parts)))
            case "product" | "negative" | "inverse":
                factors = list(self._factors(node))
                if len(factors) > TUNING.factors:
                    raise ExpressionError(f"has a product of {len(factors)} factors; at most {TUNING.factors} are read")
                return _checked(sympy.Mul(*factors))
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

    def _call(self, called: str, arguments: list[Any]) -> Any:
        name = ALIASES.get(called, called)
        function = FUNCTIONS[name]
        if function.level != FLOW:
            for argument in arguments:
                if name == "Mod":
                    _check_size(argument, TUNING.parts_of_mod, "; write x - y*floor(x/y) for Mod(x, y)")
                else:
                    _check_size(argument, TUNING.compared_parts)
                # sympy expands what stands in it
                powers = argument.atoms(sympy.Pow) if name == "Mod" else ()
                if any(power.exp.is_Rational and power.exp > 8 for power in powers):
                    raise ExpressionError("takes the remainder of a power larger than 8")
        if name == "exp" and arguments[0].has(sympy.log):
            # sympy makes a power of it
            for number in arguments[0].atoms(sympy.Rational):
                _check_exponent(number)
        if name in ("sqrt", "positive_power"):
            base, exponent = (*arguments, sympy.S.Half)[:2]
            _check_power(base, exponent)
        if function.value is not None and not any(a.free_symbols for a in arguments):
            _check_finite(name, function.value, arguments)
        if name == "exp":
            arguments = [undivided(arguments[0])]
        return _checked(function.make(*arguments))

    def _compare(self, node: Node) -> Any:
        sides = [self.build(part) for part in node.parts]
        for side in sides:
            _check_size(side, TUNING.compared_parts)
        signs = node.value.split()
        pairs = [_RELATIONS[sign](*pair) for sign, pair in zip(signs, pairwise(sides), strict=True)]
        return pairs[0] if len(pairs) == 1 else sympy.And(*pairs)


def _number(digits: str) -> Any:
    if digits.isdecimal():
        if len(digits) > TUNING.bits // 4:
            raise ExpressionError(f"has a whole number of {len(digits)} digits; at most {TUNING.bits // 4} are read")
        return _checked(sympy.Integer(int(digits)))
    if not math.isfinite(value := float(digits)):
        raise ExpressionError(f"{digits!r:.40} is larger than any double")
    if vanishes(digits):
        raise ExpressionError(f"{digits!r:.40} {VANISHES}")
    return sympy.Float(value)


def undivided(exponent: Any) -> Any:
    """An exponent whose number is exact: of exp(x + 2000.0) sympy makes exp(2000.0)*exp(x), which no double holds."""
    if not exponent.is_Add:
        return exponent
    return sympy.Add(*(sympy.Rational(float(term)) if term.is_Float else term for term in exponent.args))


def rejoined(expression: Any) -> Any:
    """An expression of sympy's without products of an exponential and a number that only their product brings back."""
    divided = {
        part: _joined_again(part)
        for part in expression.atoms(sympy.Mul)
        if part.args[0].is_Float and any(isinstance(factor, sympy.exp) for factor in part.args)
    }
    return expression.xreplace({part: made for part, made in divided.items() if made is not part})


def _joined_again(product: Any) -> Any:
    number, size = product.args[0], sympy.log(abs(product.args[0]))
    if abs(size) < TUNING.far:
        return product
    place = next(i for i, factor in enumerate(product.args) if isinstance(factor, sympy.exp))
    factors = list(product.args[1:])
    exponential = factors.pop(place - 1)
    made = sympy.exp(sympy.Add(exponential.args[0], sympy.Rational(float(size))))
    return sympy.Mul(sympy.sign(number), made, *factors)


def _power(base: Any, exponent: Any) -> Any:
    _check_power(base, exponent)
    if not base.free_symbols and not exponent.free_symbols:
        _check_finite("**", lambda x, y: x**y, [base, exponent])
    made = _checked(sympy.Pow(base, exponent))
    if isinstance(made, sympy.Pow) and made.exp.is_Rational:
        _check_exponent(made.exp)
    return made


def write_text(expression: Any) -> str:
    """An expression or a condition as text.

    Whether the text gives the expression back to the last bit is for the caller to see: `read_text` reads no function
    or number that it does not know. Raises `RecursionError` if it is nested too deeply.
    """
    return str(_Printer().doprint(expression))


class Digits(StrPrinter):
    """Writes expressions as sympy does, with all digits of their numbers."""

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))


class _Printer(Digits):
    def _print_Symbol(self, expr: Any) -> str:
        name = str(expr.name)
        return name if PLAIN_NAME.fullmatch(name) and name not in WORDS else f"`{name}`"

    def _print_exp(self, expr: Any) -> str:
        terms = sympy.Add.make_args(expr.args[0])
        decimal = {t: sympy.Float(float(t)) for t in terms if t.is_Rational and t.q > TUNING.written_fraction}
        return super()._print_Function(expr.func(expr.args[0].xreplace(decimal), evaluate=False))

    def _print_ITE(self, expr: Any) -> str:
        condition, then, other = expr.args
        return str(self._print(sympy.Or(sympy.And(condition, then), sympy.And(~condition, other), evaluate=False)))

    def _print_Exp1(self, expr: Any) -> str:
        return "exp(1)"

    def _print_Relational(self, expr: Any) -> str:
        level = PRECEDENCE["Relational"]
        left, right = (self.parenthesize(side, level, strict=True) for side in (expr.lhs, expr.rhs))
        return f"{left} {expr.rel_op} {right}"

    def _print_And(self, expr: Any) -> str:
        return self._joined(expr, "and")

    def _print_Or(self, expr: Any) -> str:
        return self._joined(expr, "or")

    def _print_Not(self, expr: Any) -> str:
        return f"not ({self._print(expr.args[0])})"

    def _print_Piecewise(self, expr: Any) -> str:
        parts = [self._print(part) for value, condition in expr.args for part in (value, condition)]
        return f"Piecewise({', '.join(parts[:-1] if expr.args[-1].cond == sympy.true else parts)})"

    def _joined(self, expr: Any, word: str) -> str:
        level = PRECEDENCE[type(expr).__name__]
        return f" {word} ".join(self.parenthesize(part, level, strict=True) for part in expr.args)


@dataclass(frozen=True)
class Function:
    """A function that may stand in an expression, with its numbers of arguments.

    ``make``: that of sympy. ``level``: what may hold it where states or time stand in it; None: nothing, until it is
    taken apart into modes. ``value``: its value as a double.
    """

    make: Callable[..., Any]
    least: int = 1
    most: int = 1
    level: int | None = FLOW
    value: Callable[..., float] | None = None


_ELEMENTARY = (
    *("exp", "log", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan"),
    *("sinh", "cosh", "tanh", "asinh", "atanh"),
)


def _piecewise(*parts: Any) -> Any:
    """A value, where it holds, ..., and the value elsewhere."""
    return sympy.Piecewise(*zip(parts[:-1:2], parts[1::2], strict=True), (parts[-1], True))


def _functions() -> dict[str, Function]:
    found = {name: Function(getattr(sympy, name), value=getattr(math, name)) for name in _ELEMENTARY}
    found["acosh"] = Function(sympy.acosh, level=RESET, value=math.acosh)
    found["Abs"] = Function(sympy.Abs, level=RESET, value=abs)
    found["sign"] = Function(sympy.sign, level=CONDITION, value=lambda x: math.copysign(1.0, x))
    found["floor"] = Function(sympy.floor, level=RESET, value=math.floor)
    found["ceiling"] = Function(sympy.ceiling, level=CONDITION, value=math.ceil)
    found["Mod"] = Function(sympy.Mod, 2, 2, RESET, value=lambda x, y: x % y)
    found["atan2"] = Function(sympy.atan2, 2, 2, RESET, value=math.atan2)
    found["Max"] = Function(sympy.Max, 2, 16, CONDITION, value=max)
    found["Min"] = Function(sympy.Min, 2, 16, CONDITION, value=min)
    found["Heaviside"] = Function(sympy.Heaviside, level=None)
    found["Piecewise"] = Function(_piecewise, 3, 17, CONDITION)
    for name, special in SPECIAL.items():
        (count,) = special.make.nargs
        found[name] = Function(special.make, int(count), int(count), special.level)
    return found


FUNCTIONS = _functions()
ALIASES = {"abs": "Abs", "heaviside": "Heaviside", "max": "Max", "min": "Min", "mod": "Mod", "piecewise": "Piecewise"}
"""Calls that are read too; what is called so otherwise is a name."""

PLAIN = [name for name in FUNCTIONS if name not in SPECIAL]
SMOOTH = [name for name in PLAIN if FUNCTIONS[name].level == FLOW]

_OF_SYMPY_ALONE = {"erf": RESET, "erfc": RESET, "gamma": CONDITION, "loggamma": CONDITION}
"""Levels of functions that no text can hold."""


def level_of(name: str) -> int | None:
    """Where a function may stand; None for an unknown function."""
    return FUNCTIONS[name].level if name in FUNCTIONS else _OF_SYMPY_ALONE.get(name)


INSTEAD = {
    "fabs": "write Abs(x)",
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
    "frac": "write Mod(x, 1)",
    **dict.fromkeys(("deg", "degrees", "rad", "radians"), "angles are in radians; write x*180/pi or x*pi/180"),
    "sec": "write 1/cos(x)",
    "csc": "write 1/sin(x)",
    "cot": "write 1/tan(x)",
    "sech": "write 1/cosh(x)",
    "coth": "write 1/tanh(x)",
    "Heaviside": "write the branches as modes, or as transitions with a condition each",
}


def _check_power(base: Any, exponent: Any) -> None:
    """Refuse a power whose numbers would have too many digits."""
    if exponent.is_Rational:
        _check_exponent(exponent)
        bits = sum(_bits(number) for number in base.atoms(sympy.Rational))
        if bits * abs(exponent.p) > 16 * TUNING.bits * exponent.q:
            raise ExpressionError("has a power that is too large a number")


def _check_exponent(exponent: Any) -> None:
    """Refuse a rational exponent beyond the bound."""
    if max(abs(exponent.p), exponent.q) > TUNING.exponent:
        raise ExpressionError(f"has the exponent {exponent!s:.40}; exponents up to {TUNING.exponent} are read")


def _check_size(expression: Any, most: int, instead: str = "") -> None:
    """Refuse an expression of more operations, and say what may be written instead."""
    count = sum(1 for _ in sympy.preorder_traversal(expression))
    if count > most:
        raise ExpressionError(
            f"compares, or takes by a function with kinks, {count} operations; at most {most} are read{instead}"
        )


def _checked(made: Any) -> Any:
    """The expression, if sympy made no number of it that is too large."""
    if any(_bits(number) > TUNING.bits for number in made.atoms(sympy.Rational)):
        raise ExpressionError(f"holds a whole number of more than {TUNING.bits} bits")
    return made


def _bits(number: Any) -> int:
    return max(int(number.p).bit_length(), int(number.q).bit_length())


def _check_finite(name: str, function: Callable[..., float], arguments: list[Any]) -> None:
    """Refuse a constant that is no finite double before sympy calculates it with all its digits."""
    given = [double(argument) for argument in arguments]
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
        raise ExpressionError(f"{name} of {shown} is not a finite real number") from None
    if not math.isfinite(value) or (abs(value) < TUNING.smallest_value and name in ("exp", "**") and values[0] != 0):
        raise ExpressionError(f"{name} of {shown} is out of the range of doubles")


def double(
    expression: Any, symbols: Mapping[Any, float] | None = None, special: Callable[..., float] | None = None
) -> float | None:
    """Value of an expression at values of its symbols, with ``special`` for all special functions; None without one."""
    if symbols and expression in symbols:
        return symbols[expression]
    if expression.is_Rational:
        try:
            return int(expression.p) / int(expression.q)
        except OverflowError:
            raise ExpressionError("holds a number that is larger than any double") from None
    if expression.is_Float or expression.is_NumberSymbol:
        return float(expression)
    parts = [double(part, symbols, special) for part in expression.args]
    if not parts or None in parts:
        return None
    name = type(expression).__name__
    known: dict[str, Callable[..., float]] = {
        "Add": lambda *p: math.fsum(p),
        "Mul": lambda *p: math.prod(p),
        "Pow": lambda x, y: x**y,
    }
    function = known.get(name) or (FUNCTIONS[name].value or special if name in FUNCTIONS else None)
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
        numbers = {number: float(number) for number in expression.atoms(sympy.Rational, sympy.Float)}
        return all(math.isfinite(value) and (value or number.is_zero) for number, value in numbers.items())
    except OverflowError:
        return False

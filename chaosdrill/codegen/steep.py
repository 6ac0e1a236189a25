"""Operations that may hide something from a step, although what they are applied to is smooth along it.

The last coefficients of a series, and the stages of a Runge-Kutta step, tell of sums, products, sines and low powers
all that there is. They do not tell of a tanh far from its slope, of a pulse ahead, of a pole or a branch point beside
the path: there the coefficients are zero to the last digit, and the next stage lies behind it. But what such an
operation is applied to is smooth, so that its range over the step is known, and how far it may move before the
operation has to be looked at again is a property of the operation. These arguments are watched, see
`chaosdrill.engine.checked`.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import sympy

from chaosdrill.codegen.layout import AT_ALL, AT_SERIES, CROSSED, ONE_SIDED, Shape
from chaosdrill.codegen.tape import inverse_of
from chaosdrill.codegen.tuning import TUNING
from chaosdrill.model.special import (
    RESTS,
    SPECIAL,
    bernoulli_ratio,
    even_rest,
    gate,
    log_cosh,
    log_sum,
    positive_power,
    power_rest,
    taylor_rest,
)

# exp(w) grows by the factor that the last terms of a series of that order still show; below 745 it is zero to doubles
EXPONENTIAL = Shape(0.6, 1.0, 745.0, 4.0, 0.3, 0.0, CROSSED)
# 1 - tanh(w) decays twice as fast, and 1 is all that doubles see of tanh from 19 on
SIGMOID = Shape(0.3, 1.0, 19.0, 1.5, 0.3, 0.0, CROSSED)
# one over cosh(w) and over 1 + exp(w) have the poles of tanh, and the tails of exp
PULSE = Shape(0.15, 0.9, 745.0, 0.5, 0.25, 0.0, CROSSED)
# the range of a sine, in what another operation is applied to, is known where it moves by a part of a turn
TURN = Shape(0.2, 0.0, 0.0, 1.0, 0.0, 0.0, CROSSED)


def _singular(exponent: float, through: int = AT_ALL) -> Shape:
    """That of w**exponent, log(w), 1/w, whose scale is w itself."""
    return Shape(0.0, min(0.8, 6.0 / exponent), 0.0, 0.0, min(0.5, 2.0 / exponent), 0.0, through)


def _monomial(exponent: float) -> Shape:
    """That of a high whole power, whose scale is w where it matters: near the largest w."""
    return Shape(0.0, min(0.8, 6.0 / exponent), 0.0, 0.0, 2.0 / exponent, 0.25, CROSSED)


@dataclass(frozen=True)
class Steep:
    """An operation to watch: what it is applied to, how that may move, and the whole of it, to be named."""

    argument: Any
    shape: Shape
    term: Any


def steep_operations(expressions: Iterable[Any], moving: Iterable[Any]) -> tuple[Steep, ...]:
    """The operations of expressions that are to be watched, each argument once for each kind of operation.

    ``moving``: states and time; what is made of parameters alone hides nothing.
    """
    symbols = frozenset(moving)
    found: dict[tuple[Any, float, float], Steep] = {}
    seen: set[Any] = set()
    for expression in expressions:
        for part in _parts(sympy.sympify(expression), seen):
            for argument, shape in _with_turns(_watched(part, symbols)):
                if argument.free_symbols.isdisjoint(symbols):
                    continue
                key = (argument, shape.dead + shape.through, shape.unit)
                if key not in found or found[key].shape.part > shape.part:
                    found[key] = Steep(argument, shape, part)
    return tuple(found.values())


def _with_turns(watched: Iterable[tuple[Any, Shape]]) -> Iterator[tuple[Any, Shape]]:
    """What is watched, each after the angles of which it is made."""
    for argument, shape in watched:
        for wave in sorted(argument.atoms(sympy.sin, sympy.cos, sympy.tan), key=sympy.default_sort_key):
            yield wave.args[0], TURN
        yield argument, shape


def _parts(expression: Any, seen: set[Any]) -> Iterator[Any]:
    """The parts of an expression that are compound and not yet seen, each before what it is made of."""
    waiting = [expression]
    while waiting:
        part = waiting.pop()
        if part.args and part not in seen:
            seen.add(part)
            if isinstance(part, sympy.Expr):
                yield part
            waiting.extend(reversed(part.args))


def _watched(part: Any, symbols: frozenset[Any]) -> Iterator[tuple[Any, Shape]]:
    """What one operation is watched by."""
    name = type(part).__name__
    if isinstance(part, positive_power):
        yield part.args[0], _singular(_size(part.args[1]), ONE_SIDED)
    elif isinstance(part, gate):
        yield from _gate(*part.args)
    elif isinstance(part, log_sum):
        m, n, u = part.args
        yield from _gate(m, n, u, sympy.S.Zero)
    elif isinstance(part, log_cosh):
        yield part.args[0], SIGMOID
    elif isinstance(part, bernoulli_ratio):
        yield part.args[0], PULSE
    elif isinstance(part, even_rest):
        yield from _even(*part.args[:2])
    elif isinstance(part, (taylor_rest, power_rest)):
        yield from _watched(part.whole(), symbols)
    elif name in SPECIAL:
        yield from ((part.args[i], _singular(1.0)) for i in SPECIAL[name].moving)
    elif part.is_Pow:
        yield from _power(part, symbols)
    elif part.is_Mul and _degree(part, symbols) >= TUNING.hiding_degree:
        for factor in part.args:
            base, exponent = factor.as_base_exp()
            if exponent.is_Integer and exponent > 1:
                yield base, _monomial(float(exponent))
    elif isinstance(part, (sympy.exp, sympy.sinh, sympy.cosh)):
        yield part.args[0], EXPONENTIAL
    elif isinstance(part, sympy.tanh):
        yield part.args[0], SIGMOID
    elif isinstance(part, sympy.log):
        yield part.args[0], _singular(1.0)
    elif isinstance(part, sympy.tan):
        yield sympy.cos(part.args[0]), _singular(1.0)
    elif isinstance(part, (sympy.atan, sympy.asinh)):
        yield 1 + part.args[0] ** 2, _singular(1.0)
    elif isinstance(part, (sympy.asin, sympy.acos, sympy.atanh)):
        yield 1 - part.args[0] ** 2, _singular(1.0)
    elif isinstance(part, sympy.acosh):
        yield part.args[0] ** 2 - 1, _singular(1.0)


def _power(part: Any, symbols: frozenset[Any]) -> Iterator[tuple[Any, Shape]]:
    base, exponent = part.args
    if not exponent.free_symbols.isdisjoint(symbols):
        if base != sympy.E:
            yield base, _singular(1.0)
        yield exponent * sympy.log(base), EXPONENTIAL
    elif _is_whole(exponent) and exponent > 0:
        if exponent * _degree(base, symbols) >= TUNING.hiding_degree:
            yield base, _monomial(float(exponent))
    elif _is_whole(exponent) and (whole := inverse_of(base)):
        yield whole[1], PULSE
    else:
        yield base, _singular(_size(exponent), AT_ALL if exponent.is_negative else AT_SERIES)


def _gate(m: Any, n: Any, u: Any, e: Any) -> Iterator[tuple[Any, Shape]]:
    """What exp(e)/(m + n exp(u)) and log(m + n exp(u)) are watched by: the poles of a gate, and that where m + n exp(u)
    is zero, as a sum that stays finite."""
    yield u, PULSE
    yield e, EXPONENTIAL
    if not (m * n).is_positive:
        yield m / (1 + sympy.exp(u)) + n / (1 + sympy.exp(-u)), _singular(1.0)


def _even(s: Any, told: Any) -> Iterator[tuple[Any, Shape]]:
    """What an even function of the root of s is watched by: the pole that is nearest to the path, or its growth."""
    function = RESTS[int(told)]
    if function in (sympy.sinh, sympy.cosh):
        yield sympy.sqrt(1 + s), EXPONENTIAL
    elif function in (sympy.asin, sympy.atanh):
        yield 1 - s, _singular(1.0)
    elif function in (sympy.atan, sympy.asinh):
        yield 1 + s, _singular(1.0)
    elif function in (sympy.tanh, log_cosh):
        yield sympy.pi**2 / 4 + s, _singular(1.0)


def _is_whole(exponent: Any) -> bool:
    return bool(exponent.is_Integer or (exponent.is_Float and float(exponent).is_integer()))


def _size(exponent: Any) -> float:
    return max(abs(float(exponent)), 1.0) if exponent.is_number else float(TUNING.unknown_exponent)


def _degree(expression: Any, symbols: frozenset[Any]) -> float:
    """Degree of an expression as a polynomial; whatever is no polynomial counts as one symbol."""
    if expression.is_Atom:
        return 1.0 if expression in symbols else 0.0
    if expression.is_Add:
        return max(_degree(a, symbols) for a in expression.args)
    if expression.is_Mul:
        return float(sum(_degree(a, symbols) for a in expression.args))
    if expression.is_Pow and _is_whole(expression.exp) and expression.exp > 0:
        return float(expression.exp) * _degree(expression.base, symbols)
    return 0.0 if expression.free_symbols.isdisjoint(symbols) else 1.0

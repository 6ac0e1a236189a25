"""Gates and pulses, however they are written, become functions whose tails are finite numbers.

``exp(x)/(1 + exp(x))`` is infinity over infinity far out, ``1 + tanh(x)`` the rounding of two ones; both are the
logistic function of x and of 2 x. What an expression is made of is looked at before the whole of it: quotients
(`chaosdrill.model.quotients`), logarithms, powers and comparisons (`chaosdrill.model.logarithms`), exponentials of
exponentials, and sums of which one term nearly cancels another; then what is 0/0 at one place
(`chaosdrill.model.removable`).
"""

from collections.abc import Iterator
from typing import Any

import sympy

from chaosdrill.model.logarithms import (
    EXPONENTIAL,
    area_sine,
    comparison,
    exponential,
    exponentials,
    logarithm,
    power,
    with_parts,
)
from chaosdrill.model.quotients import Divisor, quotient
from chaosdrill.model.removable import of_squares, without_removable
from chaosdrill.model.special import gate, log_cosh, log_sum
from chaosdrill.model.tuning import TUNING


def without_overflow(expression: Any) -> Any:
    """An expression without quotients of exponentials that overflow, and without sums that leave a tail to rounding."""
    expression = of_squares(expression)
    made = _once(expression, TUNING.rewritten)
    # what has been made may be what more can be made of
    for _ in range(TUNING.passes):
        if made is expression or (more := _once(made, TUNING.rewritten)) == made:
            break
        made = more
    return without_removable(_bounded(made, {}) if made.has(*EXPONENTIAL) else made)


def _once(expression: Any, again: int) -> Any:
    """An expression rewritten; what comes of a part is rewritten itself, ``again`` times."""
    return _rewritten(expression, {}, again) if expression.has(*EXPONENTIAL, sympy.tanh) else expression


def _rewritten(e: Any, known: dict[Any, Any], again: int) -> Any:
    if not (e.args and e.free_symbols):
        return e
    if e not in known:
        made = with_parts(e, [_divisor_or_part(e, a, known, again) for a in e.args])
        if made.is_Pow:
            made = power(made)
        if again and (made.is_Mul or made.is_Pow):
            divided = quotient(made)
            made = made if divided == made else _once(divided, again - 1)
        elif isinstance(made, sympy.log):
            made = logarithm(made)
        elif isinstance(made, sympy.asinh):
            made = area_sine(made)
        elif made.is_Relational:
            made = comparison(made)
        known[e] = _tail(made, again - 1) if again and made.is_Add else made
    return known[e]


_SATURATED = (sympy.exp, sympy.atan, sympy.tanh)
"""Functions that end, or are larger than any double, long before an exponential that they are applied to is none."""


def _bounded(e: Any, known: dict[Any, Any]) -> Any:
    """An expression whose exponentials within a function end where the whole function does.

    What is left of its slope, of that of ``exp(-exp(-x))`` say, would be zero times infinity there.
    """
    if not e.args:
        return e
    if e not in known:
        made = with_parts(e, [_bounded(a, known) for a in e.args])
        if isinstance(made, _SATURATED):
            terms = map(sympy.Mul.make_args, sympy.Add.make_args(made.args[0]))
            made = with_parts(made, [sympy.Add(*(sympy.Mul(*map(_ended, factors)) for factors in terms))])
        known[e] = made
    return known[e]


def _ended(f: Any) -> Any:
    """An exponential, or a hyperbolic function with its digits near zero, ended at a double; other factors as is."""
    if not (isinstance(f, EXPONENTIAL) and f.free_symbols):
        return f
    (a,), most, one = f.args, sympy.Integer(TUNING.bounded), sympy.S.One
    if isinstance(most - a, log_sum):
        return f
    up, down = (sympy.exp(most - log_sum(one, one, most - exponent)) for exponent in (a, -a))
    if isinstance(f, sympy.exp):
        return up
    return (up + down) / 2 if isinstance(f, sympy.cosh) else sympy.tanh(a) * (up + down) / 2


def _divisor_or_part(whole: Any, part: Any, known: dict[Any, Any], again: int) -> Any:
    """A part, of which a divisor is left to the product that it divides."""
    if whole.is_Mul and part.is_Pow and part.exp.is_Integer and part.exp.is_negative:
        return with_parts(part, [_rewritten(part.base, known, again), part.exp])
    return _rewritten(part, known, again)


def _tail(total: Any, again: int) -> Any:
    """A sum with each term that another one nearly cancels far out joined with that."""
    left, joined = dict.fromkeys(total.args), []
    for term in total.args:
        for partner, both in _partners(term):
            # a double that is whole is no integer
            other = next((one for one in left if one == partner or (one.is_Number and one - partner == 0)), None)
            if term in left and other is not None:
                del left[term], left[other]
                joined.append(both)
                break
    return _once(sympy.Add(*left, *joined), again) if joined else total


def _partners(term: Any) -> Iterator[tuple[Any, Any]]:
    """Terms that a term nearly cancels somewhere, and what both are together."""
    for factor in sympy.Mul.make_args(term):
        base, power = factor.as_base_exp()
        size = term / factor
        for sign, both in _joined(base, power, size):
            yield sign * size, both


def _joined(base: Any, power: Any, size: Any) -> Iterator[tuple[Any, Any]]:
    """What a gate or a logarithm of that size nearly cancels somewhere, over the size, and what both are together."""
    if isinstance(base, sympy.tanh) and power == 1:
        for sign in (1, -1):
            yield sign, sign * 2 * size / (1 + exponential(-sign * 2 * base.args[0]))
    elif isinstance(base, sympy.tanh) and power == 2:
        yield -1, -size / sympy.cosh(base.args[0]) ** 2
    elif isinstance(base, log_sum) and power == 1:
        m, n, u = base.args
        yield -u, size * log_sum(n, m, -u)
    elif isinstance(base, log_cosh) and power == 1:
        (u,) = base.args
        for sign in (1, -1):
            yield sign * u, size * log_sum(sympy.S.Half, sympy.S.Half, sign * 2 * u)
    elif isinstance(base, gate) and power.is_Integer and power.is_positive and base.args[3] == 0:
        m, n, u, _ = base.args
        less = base ** (power - 1)
        yield -less / m, -size * n / m * less * gate(m, n, u, u)
    elif power == -1 and (divisor := Divisor.of(base)) and {divisor.m, divisor.n} == {1} and base.is_Add:
        exponent = next((a for a in exponentials(base) if a != 0), sympy.S.Zero)
        yield -1, -size / (1 + exponential(-exponent))

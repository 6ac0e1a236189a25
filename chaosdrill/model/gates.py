"""Gates and pulses, however they are written, become functions whose tails are finite numbers.

``exp(x)/(1 + exp(x))`` is infinity over infinity far out, ``1 + tanh(x)`` the rounding of two ones; both are the
logistic function of x and of 2 x. A sum of two exponentials in a divisor is the larger of them times ``1 + exp(-u)``,
or both around ``cosh(u/2)``, and what stands above it is divided term by term.
"""

from collections.abc import Iterator
from typing import Any

import sympy

from chaosdrill.model.text import undivided
from chaosdrill.model.tuning import TUNING

_EXPONENTIAL = (sympy.exp, sympy.cosh, sympy.sinh)


def without_overflow(expression: Any) -> Any:
    """An expression without quotients of exponentials that overflow, and without sums that leave a tail to rounding."""
    return _rewritten(expression, {}) if expression.has(*_EXPONENTIAL, sympy.tanh) else expression


def _rewritten(e: Any, known: dict[Any, Any]) -> Any:
    if not e.args:
        return e
    if e not in known:
        made = _with_parts(e, [_divisor_or_part(e, a, known) for a in e.args])
        if made.is_Mul or made.is_Pow:
            made = _quotient(made)
        known[e] = _tail(made) if made.is_Add else made
    return known[e]


def _divisor_or_part(whole: Any, part: Any, known: dict[Any, Any]) -> Any:
    """A part, of which a divisor is left to the product that it divides."""
    if whole.is_Mul and part.is_Pow and part.exp.is_Integer and part.exp.is_negative:
        return _with_parts(part, [_rewritten(part.base, known), part.exp])
    return _rewritten(part, known)


def _with_parts(e: Any, parts: list[Any]) -> Any:
    return e if all(new is old for new, old in zip(parts, e.args, strict=True)) else e.func(*parts)


def _exp(exponent: Any) -> Any:
    return sympy.exp(undivided(sympy.expand(exponent)))


def _exponentials(expression: Any) -> dict[Any, Any]:
    """Factors of exponentials of different exponents, whose sum an expression is; none if that sum is a long one."""
    found: dict[Any, Any] = {}
    for term in sympy.Add.make_args(expression):
        # each of these doubles the number of exponentials
        if sum(isinstance(f, (sympy.cosh, sympy.sinh)) for f in sympy.Mul.make_args(term)) > TUNING.multiplied_out:
            return {}
        for exponent, factor in _split(term):
            found[exponent] = found.get(exponent, sympy.S.Zero) + factor
    return found


def _split(term: Any) -> Iterator[tuple[Any, Any]]:
    parts: list[tuple[Any, Any]] = [(sympy.S.Zero, sympy.S.One)]
    for factor in sympy.Mul.make_args(term):
        if isinstance(factor, sympy.exp):
            more = [(factor.args[0], sympy.S.One)]
        elif isinstance(factor, (sympy.cosh, sympy.sinh)):
            a, sign = factor.args[0], 1 if isinstance(factor, sympy.cosh) else -1
            more = [(a, sympy.S.Half), (-a, sign * sympy.S.Half)]
        else:
            more = [(sympy.S.Zero, factor)]
        parts = [(a + b, m * n) for a, m in parts for b, n in more]
    yield from parts


class _Divisor:
    """The sum of two exponentials with positive numbers, ``m exp(a) + n exp(b)``."""

    def __init__(self, m: Any, a: Any, n: Any, b: Any) -> None:
        self.m, self.n, self.b = m, n, b
        self.apart = sympy.expand(a - b)
        # exact, for sympy takes other numbers out of an exponential
        offset = sympy.S.Zero if m == n else sympy.Rational(float(sympy.log(m) - sympy.log(n)))
        self.u = self.apart + offset

    @classmethod
    def of(cls, base: Any) -> "_Divisor | None":
        """That which an expression is, if it is one."""
        if not base.has(*_EXPONENTIAL) or not (base.is_Add or isinstance(base, sympy.cosh)):
            return None
        found = _exponentials(base)
        if len(found) != 2 or not all(c.is_number and c.is_positive for c in found.values()):
            return None
        (a, m), (b, n) = found.items()
        return cls(m, a, n, b)

    def gate(self, up: bool) -> Any:
        """The part of the sum that its first term is, or the other one."""
        return 1 / (1 + _exp(-self.u if up else self.u))

    def steps(self, exponent: Any) -> tuple[Any, Any]:
        """How many times the difference of the two exponents an exponent is, None if no number of times, but for a
        number that it is larger by."""
        (offset, moving), (own, apart) = (sympy.expand(e).as_coeff_Add() for e in (exponent, self.apart))
        ratio = sympy.cancel(moving / apart)
        if ratio.is_Float:
            ratio = sympy.nsimplify(ratio, rational=True, tolerance=1e-15)
        rest = offset - ratio * own
        return (ratio, rest) if ratio.is_Rational and abs(rest) < TUNING.far else (None, rest)

    def below(self, exponent: Any, power: int) -> Any:
        """The exponential of an exponent over a power of the sum; None if that may stay as it is."""
        r, rest = self.steps(exponent - power * self.b)
        if r is None:
            return None
        if 2 * r == power:
            return sympy.exp(rest) * (4 * self.m * self.n) ** (-r) / sympy.cosh(self.u / 2) ** power
        if not r.is_Integer:
            return None
        first = min(max(int(r), 0), power)
        left = _exp((r - first) * self.apart)
        return (
            sympy.exp(rest)
            * left
            * (self.gate(True) / self.m) ** first
            * (self.gate(False) / self.n) ** (power - first)
        )

    def under(self, sum_: Any) -> Any:
        """A sum that has the same exponentials, or these shifted, over this one; None if it has others."""
        found = _exponentials(sum_)
        if not found:
            return None
        first = next(iter(found))
        for shift in (first - self.b, first - self.b - self.apart):
            where = {a: self.steps(a - self.b - shift) for a in found}
            if all(r in (0, 1) for r, _ in where.values()):
                up, down = (
                    sympy.Add(*(f * sympy.exp(where[a][1]) for a, f in found.items() if where[a][0] == r))
                    for r in (1, 0)
                )
                up, down = up / self.m, down / self.n
                if sympy.expand(up - down) == 0:
                    return up * _exp(shift)
                if sympy.expand(up + down) == 0:
                    return up * sympy.tanh(self.u / 2) * _exp(shift)
                return (up * self.gate(True) + down * self.gate(False)) * _exp(shift)
        return None


def _quotient(product: Any) -> Any:
    """A product whose divisors have been divided into what stands above them."""
    factors = list(sympy.Mul.make_args(product))
    for place, divisor in enumerate(factors):
        base, power = divisor.as_base_exp()
        if not (power.is_Integer and power.is_negative):
            continue
        below = _Divisor.of(base)
        if below is None:
            continue
        rest, power = factors[:place] + factors[place + 1 :], int(-power)
        changed = []
        for i, factor in enumerate(rest):
            above, times = factor.as_base_exp() if not isinstance(factor, sympy.exp) else (factor, sympy.S.One)
            if above.has(*_EXPONENTIAL) and (above.is_Add or isinstance(above, (sympy.sinh, sympy.cosh))):
                while times.is_Integer and times.is_positive and power > 0:
                    divided = below.under(above)
                    if divided is None:
                        break
                    changed.append(divided)
                    times, power = times - 1, power - 1
                rest[i] = above**times
        exponent = sympy.Add(*(f.args[0] for f in rest if isinstance(f, sympy.exp)))
        whole = below.below(exponent, power)
        if whole is not None:
            rest = [f for f in rest if not isinstance(f, sympy.exp)]
        else:
            whole = base ** (-power)
        made = sympy.Mul(*changed, *rest, whole)
        if made != product:
            return without_overflow(made)
    return product


def _tail(total: Any) -> Any:
    """A sum with each term that another one nearly cancels far out joined with that."""
    left, joined = dict.fromkeys(total.args), []
    for term in total.args:
        for other, both in _partners(term):
            if term in left and other in left:
                del left[term], left[other]
                joined.append(both)
                break
    return without_overflow(sympy.Add(*left, *joined)) if joined else total


def _partners(term: Any) -> Iterator[tuple[Any, Any]]:
    """Terms that a term nearly cancels somewhere, and what both are together."""
    for factor in sympy.Mul.make_args(term):
        base, power = factor.as_base_exp()
        size = term / factor
        for sign, both in _joined(base, power, size):
            yield sign * size, both


def _joined(base: Any, power: Any, size: Any) -> Iterator[tuple[int, Any]]:
    """Signs of a number that a gate of that size nearly cancels somewhere, and what both are together."""
    if isinstance(base, sympy.tanh) and power == 1:
        for sign in (1, -1):
            yield sign, sign * 2 * size / (1 + _exp(-sign * 2 * base.args[0]))
    elif isinstance(base, sympy.tanh) and power == 2:
        yield -1, -size / sympy.cosh(base.args[0]) ** 2
    elif power == -1 and (divisor := _Divisor.of(base)) and {divisor.m, divisor.n} == {1} and base.is_Add:
        exponent = next(a for a in _exponentials(base) if a != 0)
        yield -1, -size / (1 + _exp(-exponent))

"""Quotients of exponentials that do not overflow.

A sum of two exponentials in a divisor is the larger of them times ``1 + exp(-u)``, or both around ``cosh(u/2)``, and
what stands above it is divided term by term. Where their factors are no positive numbers but parameters, or the
exponents no multiples of each other, the quotient is a `gate`; what is zero where a difference of two exponentials is,
as in the rates of ion channels, becomes a `bernoulli_ratio`.
"""

from itertools import combinations
from typing import Any

import sympy

from chaosdrill.model.logarithms import (
    EXPONENTIAL,
    base_and_power,
    exponential,
    exponentials,
    is_positive_number,
    multiplied_out,
    squared,
    two_in,
)
from chaosdrill.model.special import bernoulli_ratio, exact_logarithm, gate
from chaosdrill.model.text import undivided
from chaosdrill.model.tuning import TUNING


def _multiple(part: Any, of: Any) -> Any:
    """How many times an expression is another one, beside rounding of their numbers; None if no simple multiple."""
    if part.is_number or not part.free_symbols & of.free_symbols:
        return None
    above, below = (sympy.expand(e).as_coefficients_dict() for e in (part, of))
    if above.keys() == below.keys():
        ratios = [sympy.sympify(above[key] / below[key]) for key in below]
        if all(abs(ratio - ratios[0]) <= TUNING.same_ratio * abs(ratios[0]) for ratio in ratios):
            return ratios[0]
    ratio = sympy.cancel(sympy.nsimplify(part, rational=True) / sympy.nsimplify(of, rational=True))
    simpler = ratio.free_symbols < of.free_symbols and not ratio.has(sympy.exp)
    return ratio if simpler else None


class Divisor:
    """A sum of two exponentials with factors, ``m exp(a) + n exp(b)``."""

    def __init__(self, m: Any, a: Any, n: Any, b: Any) -> None:
        if a == 0:
            (m, a), (n, b) = (n, b), (m, a)
        self.m, self.n, self.b = m, n, b
        self.apart = multiplied_out(a - b)
        self.numbers = is_positive_number(m) and is_positive_number(n)
        self.u = self.apart + (exact_logarithm(m, n) if self.numbers else 0)

    @classmethod
    def of(cls, base: Any) -> "Divisor | None":
        """That which an expression is, if it is one."""
        if (two := two_in(base)) is None:
            return None
        (a, m), (b, n) = two
        return cls(m, a, n, b)

    def gate(self, up: bool) -> Any:
        """The part of the sum that its first term is, or the other one; of one with positive numbers."""
        return 1 / (1 + exponential(-self.u if up else self.u))

    def zero(self) -> Any:
        """What is zero where the sum is, as an exponent; None if it is not known."""
        ratio = -self.m / self.n
        if ratio == 1:
            return self.apart
        return self.apart + exact_logarithm(ratio, sympy.S.One) if is_positive_number(ratio) else None

    def steps(self, exponent: Any) -> tuple[Any, Any]:
        """How many times the difference of the two exponents an exponent is, None if no number of times, but for a
        number that it is larger by."""
        (offset, moving), (own, apart) = (multiplied_out(e).as_coeff_Add() for e in (exponent, self.apart))
        ratio = sympy.cancel(moving / apart)
        if ratio.is_Float:
            ratio = sympy.nsimplify(ratio, rational=True, tolerance=1e-15)
        rest = offset - ratio * own
        return (ratio, rest) if ratio.is_Rational and abs(rest) < TUNING.far else (None, rest)

    def below(self, exponent: Any, power: int) -> Any:
        """The exponential of an exponent over a power of the sum; None if that may stay as it is."""
        r, rest = self.steps(exponent - power * self.b)
        if self.numbers and r is not None:
            if 2 * r == power:
                return sympy.exp(rest) * (4 * self.m * self.n) ** (-r) / sympy.cosh(self.u / 2) ** power
            if r.is_Integer:
                first = min(max(int(r), 0), power)
                left = exponential((r - first) * self.apart)
                return (
                    sympy.exp(rest)
                    * left
                    * (self.gate(True) / self.m) ** first
                    * (self.gate(False) / self.n) ** (power - first)
                )
        alone = sympy.S.Zero
        if r is None and not exponent.free_symbols & self.apart.free_symbols:
            # a factor of its own
            exponent, alone = sympy.S.Zero, exponent
        return exponential(alone) * self.part(exponent / power) ** power

    def part(self, exponent: Any) -> Any:
        """The exponential of an exponent over the sum."""
        return gate(self.n, self.m, undivided(self.apart), undivided(multiplied_out(exponent - self.b)))

    def removable(self, zero: Any, exponent: Any) -> Any:
        """An exponential of an exponent times that which is zero where the sum is, over the sum."""
        r, _ = self.steps(exponent - self.b)
        s = sympy.S.Zero if r is None else min(max(sympy.floor(2 * r) / sympy.Integer(2), 0), 1)
        # of m exp(a) + n exp(b) with n = -m exp(...), exp(b) is -1/n times one over exp(zero) - 1
        left = multiplied_out(exponent - self.b - s * zero)
        return -exponential(left) * bernoulli_ratio(undivided(zero), s, sympy.S.Zero) / self.n

    def under(self, sum_: Any) -> Any:
        """A sum that has the same exponentials, or these shifted, over this one; None if it has others."""
        found = exponentials(sum_)
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
                    return up * exponential(shift)
                if sympy.expand(up + down) == 0 and self.numbers:
                    return up * sympy.tanh(self.u / 2) * exponential(shift)
                if sympy.expand(up + down) == 0 and (zero := self.zero()) is not None:
                    return up / sympy.tanh(zero / 2) * exponential(shift)
                if self.numbers:
                    return (up * self.gate(True) + down * self.gate(False)) * exponential(shift)
        if len(found) == 2 and sympy.expand(sympy.Add(*found.values())) == 0:
            # the difference, exact where it is small
            (a, f), (b, _) = found.items()
            w = multiplied_out(a - b) / 2
            zero = None if self.numbers else self.zero()
            if zero is not None and not (ratio := sympy.cancel(w / zero)).free_symbols & zero.free_symbols:
                # one over exp(zero) - 1 is 1/tanh(zero/2) over exp(zero) + 1
                whole = Divisor(sympy.S.One, zero, sympy.S.One, sympy.S.Zero)
                parts = whole.below(a - self.b, 1) + whole.below(b - self.b, 1)
                return -2 * f / self.n * ratio * _around(zero / 2) / _around(w) * parts
            return f * sympy.tanh(w) * (self.part(a) + self.part(b))
        return sympy.Add(*(f * self.part(a) for a, f in found.items()))


def quotient(product: Any) -> Any:
    """A product whose divisors have been divided into what stands above them."""
    factors = list(sympy.Mul.make_args(_with_halves(sympy.Mul(*map(squared, sympy.Mul.make_args(product))))))
    divisors = [(i, *f.as_base_exp()) for i, f in enumerate(factors)]
    divisors = [(i, base, power) for i, base, power in divisors if power.is_Integer and power.is_negative]
    for place, base, power in sorted(divisors, key=_last):
        rest = factors[:place] + factors[place + 1 :]
        if (made := _removed(base, int(-power), rest)) is not None:
            return made
        below = Divisor.of(base)
        if below is None:
            continue
        power = int(-power)
        changed = []
        for i, factor in enumerate(rest):
            above, times = base_and_power(factor)
            if above.has(*EXPONENTIAL) and (above.is_Add or isinstance(above, (sympy.sinh, sympy.cosh))):
                while times.is_Integer and times.is_positive and power > 0:
                    divided = below.under(above)
                    if divided is None:
                        break
                    changed.append(divided)
                    times, power = times - 1, power - 1
                rest[i] = above**times
        exponent = sympy.Add(*(f.args[0] for f in rest if isinstance(f, sympy.exp)))
        whole = below.below(exponent, power) if power else None
        if whole is not None:
            rest = [f for f in rest if not isinstance(f, sympy.exp)]
        else:
            whole = base ** (-power)
        made = sympy.Mul(*changed, *rest, whole)
        if made != product:
            return made
    return _multiplied(sympy.Mul(*factors))


def _last(divisor: tuple[int, Any, Any]) -> int:
    """How late a divisor's turn is: what grows like an exponential is first, and of this what may be zero."""
    base = divisor[1]
    return 2 - int(base.has(*EXPONENTIAL)) - int(_with_zero(base) is not None)


def _with_halves(product: Any) -> Any:
    """A product with ``2 sinh(u) cosh(u)`` for ``sinh(2 u)`` where it has one of these already."""
    bases = {factor.as_base_exp()[0] for factor in sympy.Mul.make_args(product)}
    angles = {multiplied_out(f.args[0]) for f in bases if isinstance(f, (sympy.sinh, sympy.cosh))}
    halves = {f: multiplied_out(f.args[0] / 2) for f in bases if isinstance(f, sympy.sinh)}
    made = product.xreplace(
        {f: 2 * sympy.sinh(u) * sympy.cosh(u) for f, u in halves.items() if {u, multiplied_out(-u)} & angles}
    )
    return product if made == product else _with_halves(made)


def _removed(base: Any, power: int, rest: list[Any]) -> Any:
    """A quotient by a base that is zero where another factor is; None if there is none.

    ``u/(exp(u) - 1)``, ``u/tanh(u)`` and one over these are analytic there.
    """
    if isinstance(base, sympy.tanh):
        ratio, others = _without(rest, base.args[0])
        return None if ratio is None else sympy.Mul(ratio * _around(base.args[0]), base ** (1 - power), *others)
    if (found := _with_zero(base)) is not None:
        below, zero = found
        ratio, others = _without(rest, zero)
        if ratio is None:
            return None
        pure = [f for f in others if isinstance(f, sympy.exp)]
        others = [f for f in others if not isinstance(f, sympy.exp)]
        terms = {sympy.S.Zero: sympy.S.One}
        for j, factor in enumerate(others):
            above, times = base_and_power(factor)
            several = times.is_Integer and times > 1 and (power > 1 or not exponentials(factor))
            one = above if several else factor
            if (parts := exponentials(one)) and set(parts) != {sympy.S.Zero}:
                terms = parts
                others[j] = factor / one
                break
        alone = sympy.Add(*(f.args[0] for f in pure))
        slope = sympy.S.One
        if power == 1 and len(terms) == 2 and sympy.expand(sympy.Add(*terms.values())) == 0:
            # a difference, exact where it is small
            (a, f), (b, _) = terms.items()
            terms, slope = {a: f, b: f}, sympy.tanh(multiplied_out(a - b) / 2)
        made = [f * below.removable(zero, a + alone) for a, f in terms.items()]
        return sympy.Mul(ratio, base ** (1 - power), *others, slope, sympy.Add(*made))
    for i, factor in enumerate(rest):
        if isinstance(factor, sympy.tanh) and (ratio := _multiple(base, factor.args[0])) is not None:
            left = base ** (1 - power)
            return sympy.Mul(left, *rest[:i], *rest[i + 1 :], 1 / (ratio * _around(factor.args[0])))
        if (found := _with_zero(factor)) is None:
            continue
        above, zero = found
        if (ratio := _multiple(base, zero)) is not None:
            left = base ** (1 - power)
            return sympy.Mul(left, *rest[:i], *rest[i + 1 :], 1 / (ratio * above.removable(zero, sympy.S.Zero)))
    return None


def _with_zero(expression: Any) -> tuple[Divisor, Any] | None:
    """An expression as a sum of two exponentials, and what is zero where it is."""
    whole = Divisor.of(expression)
    zero = None if whole is None else whole.zero()
    return None if whole is None or zero is None else (whole, zero)


def _without(factors: list[Any], zero: Any) -> tuple[Any, list[Any]]:
    """How many times an expression the first of some factors is that is a multiple of it, and the others."""
    for i, factor in enumerate(factors):
        base, power = factor.as_base_exp()
        whole = power.is_Integer and power.is_positive and not base.has(*EXPONENTIAL)
        if whole and (ratio := _multiple(base, zero)) is not None:
            return ratio, [*factors[:i], base ** (power - 1), *factors[i + 1 :]]
    return None, factors


def _around(w: Any) -> Any:
    """w/tanh(w)."""
    zero = sympy.S.Zero
    return (bernoulli_ratio(2 * w, zero, zero) + bernoulli_ratio(2 * w, sympy.S.One, zero)) / 2


def _multiplied(product: Any) -> Any:
    """A product with an exponential multiplied into a hyperbolic function or a sum that grows the other way."""
    factors = list(sympy.Mul.make_args(product))
    exponents = [f.args[0] for f in factors if isinstance(f, sympy.exp)]
    if not exponents:
        return product
    exponent = sympy.Add(*exponents)
    if any(a.free_symbols & b.free_symbols for a, b in combinations(exponents, 2)):
        others = [f for f in factors if not isinstance(f, sympy.exp)]
        return sympy.Mul(exponential(exponent), *others)
    for i, factor in enumerate(factors):
        if not (isinstance(factor, (sympy.cosh, sympy.sinh)) or factor.is_Add) or not factor.has(*EXPONENTIAL):
            continue
        found = exponentials(factor)
        if not any(a != 0 and (ratio := sympy.cancel(exponent / a)).is_number and ratio < 0 for a in found):
            continue
        others = [f for j, f in enumerate(factors) if j != i and not isinstance(f, sympy.exp)]
        made = sympy.Add(*(f * exponential(exponent + a) for a, f in found.items()))
        if isinstance(factor, sympy.sinh):
            (a, f), (b, _) = found.items()
            made = sympy.tanh(factor.args[0]) * sympy.Add(*(abs(f) * exponential(exponent + c) for c in (a, b)))
        return sympy.Mul(made, *others)
    return product

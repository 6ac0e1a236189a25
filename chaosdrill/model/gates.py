"""Gates and pulses, however they are written, become functions whose tails are finite numbers.

``exp(x)/(1 + exp(x))`` is infinity over infinity far out, ``1 + tanh(x)`` the rounding of two ones; both are the
logistic function of x and of 2 x. A sum of two exponentials in a divisor is the larger of them times ``1 + exp(-u)``,
or both around ``cosh(u/2)``, and what stands above it is divided term by term. Where their factors are no positive
numbers but parameters, or the exponents no multiples of each other, the quotient is a `gate`, the logarithm of such a
sum a `log_sum`; what is zero where a difference of two exponentials is, as in the rates of ion channels, becomes a
`bernoulli_ratio`.
"""

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import sympy

from chaosdrill.model.removable import without_removable
from chaosdrill.model.special import bernoulli_ratio, exact_logarithm, gate, log_cosh, log_sum
from chaosdrill.model.text import undivided
from chaosdrill.model.tuning import TUNING

_EXPONENTIAL = (sympy.exp, sympy.cosh, sympy.sinh)


def without_overflow(expression: Any) -> Any:
    """An expression without quotients of exponentials that overflow, and without sums that leave a tail to rounding."""
    made = _once(expression)
    # what has been made may be what more can be made of
    for _ in range(TUNING.passes):
        if made is expression or (more := _once(made)) == made:
            break
        made = more
    return without_removable(made)


def _once(expression: Any) -> Any:
    return _rewritten(expression, {}) if expression.has(*_EXPONENTIAL, sympy.tanh) else expression


def _rewritten(e: Any, known: dict[Any, Any]) -> Any:
    if not e.args:
        return e
    if e not in known:
        made = _with_parts(e, [_divisor_or_part(e, a, known) for a in e.args])
        if made.is_Pow:
            made = _power(made)
        if made.is_Mul or made.is_Pow:
            made = _quotient(made)
        elif isinstance(made, sympy.log):
            made = _logarithm(made)
        elif isinstance(made, sympy.exp):
            made = _bounded(made)
        elif made.is_Relational:
            made = _comparison(made)
        known[e] = _tail(made) if made.is_Add else made
    return known[e]


def _bounded(e: Any) -> Any:
    """An exponential of exponentials, each of which ends where the whole is zero, or larger than any double.

    What is left of their product with a rate, of ``exp(-exp(-x))`` say, would be zero times infinity there.
    """
    if not any(isinstance(f, sympy.exp) for term in sympy.Add.make_args(e.args[0]) for f in sympy.Mul.make_args(term)):
        return e
    terms = []
    for term in sympy.Add.make_args(e.args[0]):
        factors = sympy.Mul.make_args(term)
        grown = [f.args[0] for f in factors if isinstance(f, sympy.exp) and f.free_symbols]
        most = sympy.Float(math.exp(TUNING.bounded)) if grown else sympy.S.One
        ended = [1 / (1 + sympy.exp(undivided(sympy.expand(sympy.Integer(TUNING.bounded) - v)))) for v in grown]
        others = [f for f in factors if not (isinstance(f, sympy.exp) and f.free_symbols)]
        terms.append(sympy.Mul(most ** len(grown), *ended, *others))
    return sympy.exp(sympy.Add(*terms))


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


def _two(found: dict[Any, Any]) -> "tuple[tuple[Any, Any], tuple[Any, Any]] | None":
    """Two exponentials whose sum is that of several, as exponents and factors.

    Those with positive numbers become one.
    """
    if len(found) < 2:
        return None
    positive = {a: m for a, m in found.items() if _is_positive_number(m)}
    while len(found) > 2 and len(positive) > 1:
        (a, m), (b, n), *_ = positive.items()
        joined = _log_of_two(m, a, n, b)
        for exponents in (found, positive):
            del exponents[a], exponents[b]
            exponents[joined] = sympy.S.One
    if len(found) > 2:
        return None
    first, second = found.items()
    return first, second


def _is_positive_number(m: Any) -> bool:
    return bool(m.is_number and m.is_positive)


def _log_of_two(m: Any, a: Any, n: Any, b: Any) -> Any:
    """log(m exp(a) + n exp(b))."""
    if m == n and sympy.expand(a + b) == 0 and _is_positive_number(m):
        return sympy.log(2 * m) + log_cosh(a if a.could_extract_minus_sign() is False else b)
    if a == 0:
        (m, a), (n, b) = (n, b), (m, a)
    return b + log_sum(n, m, undivided(sympy.expand(a - b)))


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


class _Divisor:
    """A sum of two exponentials with factors, ``m exp(a) + n exp(b)``."""

    def __init__(self, m: Any, a: Any, n: Any, b: Any) -> None:
        if a == 0:
            (m, a), (n, b) = (n, b), (m, a)
        self.m, self.n, self.b = m, n, b
        self.apart = sympy.expand(a - b)
        self.numbers = _is_positive_number(m) and _is_positive_number(n)
        self.u = self.apart + (exact_logarithm(m, n) if self.numbers else 0)

    @classmethod
    def of(cls, base: Any) -> "_Divisor | None":
        """That which an expression is, if it is one."""
        if not base.has(*_EXPONENTIAL) or not (base.is_Add or isinstance(base, (sympy.cosh, sympy.sinh))):
            return None
        two = _two(_exponentials(base))
        if two is None:
            return None
        (a, m), (b, n) = two
        return cls(m, a, n, b)

    def gate(self, up: bool) -> Any:
        """The part of the sum that its first term is, or the other one; of one with positive numbers."""
        return 1 / (1 + _exp(-self.u if up else self.u))

    def zero(self) -> Any:
        """What is zero where the sum is, as an exponent; None if it is not known."""
        ratio = -self.m / self.n
        if ratio == 1:
            return self.apart
        return self.apart + exact_logarithm(ratio, sympy.S.One) if _is_positive_number(ratio) else None

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
        if self.numbers and r is not None:
            if 2 * r == power:
                return sympy.exp(rest) * (4 * self.m * self.n) ** (-r) / sympy.cosh(self.u / 2) ** power
            if r.is_Integer:
                first = min(max(int(r), 0), power)
                left = _exp((r - first) * self.apart)
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
        return _exp(alone) * self.part(exponent / power) ** power

    def part(self, exponent: Any) -> Any:
        """The exponential of an exponent over the sum."""
        return gate(self.n, self.m, undivided(self.apart), undivided(sympy.expand(exponent - self.b)))

    def removable(self, zero: Any, exponent: Any) -> Any:
        """An exponential of an exponent times that which is zero where the sum is, over the sum."""
        r, _ = self.steps(exponent - self.b)
        s = sympy.S.Zero if r is None else min(max(sympy.floor(2 * r) / sympy.Integer(2), 0), 1)
        # of m exp(a) + n exp(b) with n = -m exp(...), exp(b) is -1/n times one over exp(zero) - 1
        left = sympy.expand(exponent - self.b - s * zero)
        return -_exp(left) * bernoulli_ratio(undivided(zero), s, sympy.S.Zero) / self.n

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
                if sympy.expand(up + down) == 0 and self.numbers:
                    return up * sympy.tanh(self.u / 2) * _exp(shift)
                if sympy.expand(up + down) == 0 and (zero := self.zero()) is not None:
                    return up / sympy.tanh(zero / 2) * _exp(shift)
                if self.numbers:
                    return (up * self.gate(True) + down * self.gate(False)) * _exp(shift)
        if len(found) == 2 and sympy.expand(sympy.Add(*found.values())) == 0:
            # the difference, exact where it is small
            (a, f), (b, _) = found.items()
            return f * sympy.tanh(sympy.expand(a - b) / 2) * (self.part(a) + self.part(b))
        return sympy.Add(*(f * self.part(a) for a, f in found.items()))


def _quotient(product: Any) -> Any:
    """A product whose divisors have been divided into what stands above them."""
    factors = list(sympy.Mul.make_args(sympy.Mul(*map(_squared, sympy.Mul.make_args(product)))))
    divisors = [(i, *f.as_base_exp()) for i, f in enumerate(factors)]
    divisors = [(i, base, power) for i, base, power in divisors if power.is_Integer and power.is_negative]
    # what grows like an exponential first
    for place, base, power in sorted(divisors, key=lambda found: not found[1].has(*_EXPONENTIAL)):
        rest = factors[:place] + factors[place + 1 :]
        if (made := _removed(base, int(-power), rest)) is not None:
            return _once(made)
        below = _Divisor.of(base)
        if below is None:
            continue
        power = int(-power)
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
        whole = below.below(exponent, power) if power else None
        if whole is not None:
            rest = [f for f in rest if not isinstance(f, sympy.exp)]
        else:
            whole = base ** (-power)
        made = sympy.Mul(*changed, *rest, whole)
        if made != product:
            return _once(made)
    return _multiplied(product)


def _squared(factor: Any) -> Any:
    """A factor, as a square if it is ``exp(u) + exp(-u) - 2`` but for a number, which loses its digits near 0."""
    base, power = factor.as_base_exp()
    if not (base.is_Add and power.is_Integer and base.has(*_EXPONENTIAL)) or len(found := _exponentials(base)) != 3:
        return factor
    (_, alone), *others = sorted(found.items(), key=lambda one: one[0] != 0)
    (a, m), (b, n) = others
    if m != n or alone + 2 * m != 0 or sympy.expand(a + b) != 0 or 0 not in found:
        return factor
    return (4 * m * sympy.sinh(sympy.expand(a / 2 if b.could_extract_minus_sign() else b / 2)) ** 2) ** power


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
        exponentials = [f for f in others if isinstance(f, sympy.exp)]
        others = [f for f in others if not isinstance(f, sympy.exp)]
        terms = {sympy.S.Zero: sympy.S.One}
        for j, factor in enumerate(others):
            if (parts := _exponentials(factor)) and set(parts) != {sympy.S.Zero}:
                terms = parts
                del others[j]
                break
        alone = sympy.Add(*(f.args[0] for f in exponentials))
        made = [f * below.removable(zero, a + alone) for a, f in terms.items()]
        return sympy.Mul(ratio, base ** (1 - power), *others, sympy.Add(*made))
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


def _with_zero(expression: Any) -> tuple[_Divisor, Any] | None:
    """An expression as a sum of two exponentials, and what is zero where it is."""
    whole = _Divisor.of(expression)
    zero = None if whole is None else whole.zero()
    return None if whole is None or zero is None else (whole, zero)


def _without(factors: list[Any], zero: Any) -> tuple[Any, list[Any]]:
    """How many times an expression the first of some factors is that is a multiple of it, and the others."""
    for i, factor in enumerate(factors):
        base, power = factor.as_base_exp()
        whole = power.is_Integer and power.is_positive and not base.has(*_EXPONENTIAL)
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
        return _once(sympy.Mul(_exp(exponent), *others))
    for i, factor in enumerate(factors):
        if not (isinstance(factor, (sympy.cosh, sympy.sinh)) or factor.is_Add) or not factor.has(*_EXPONENTIAL):
            continue
        found = _exponentials(factor)
        if not any(a != 0 and (ratio := sympy.cancel(exponent / a)).is_number and ratio < 0 for a in found):
            continue
        others = [f for j, f in enumerate(factors) if j != i and not isinstance(f, sympy.exp)]
        made = sympy.Add(*(f * _exp(exponent + a) for a, f in found.items()))
        if isinstance(factor, sympy.sinh):
            (a, f), (b, _) = found.items()
            made = sympy.tanh(factor.args[0]) * sympy.Add(*(abs(f) * _exp(exponent + c) for c in (a, b)))
        return _once(sympy.Mul(made, *others))
    return product


def _power(e: Any) -> Any:
    """A power, no whole one, of a sum of exponentials with positive numbers as an exponential."""
    base, power = e.as_base_exp()
    if power.is_Integer or not base.has(*_EXPONENTIAL) or not (base.is_Add or isinstance(base, sympy.cosh)):
        return e
    found = _exponentials(base)
    if len(found) < 2 or not all(map(_is_positive_number, found.values())):
        return e
    return sympy.exp(power * _log_of(base))


def _comparison(e: Any) -> Any:
    """A comparison of exponentials on both sides, which may be infinity against infinity, as that of one of them."""
    if not all(side.has(*_EXPONENTIAL) for side in e.args):
        return e
    found: dict[Any, Any] = {}
    for side, sign in zip(e.args, (1, -1), strict=True):
        for exponent, factor in _exponentials(side).items():
            offset, moving = exponent.as_coeff_Add()
            if abs(offset) >= TUNING.far:
                return e
            found[moving] = found.get(moving, sympy.S.Zero) + sign * factor * sympy.exp(offset)
    if not 1 <= len(found) <= 2:
        return e
    (b, n), *others = sorted(found.items(), key=lambda one: sympy.default_sort_key(one[0]))
    return e.func(sympy.Add(n, *(m * _exp(a - b) for a, m in others)), 0)


def _logarithm(e: Any) -> Any:
    """A logarithm of exponentials, of sums of them, or of powers of these."""
    inner = e.args[0]
    if not inner.has(*_EXPONENTIAL):
        return e
    found, rest = [], []
    for factor in sympy.Mul.make_args(inner):
        base, power = (factor, sympy.S.One) if isinstance(factor, sympy.exp) else factor.as_base_exp()
        whole = _log_of(base)
        # the square of what may be negative is positive
        known = isinstance(factor, sympy.exp) or inner == factor == base or _is_positive(base)
        found += [power * whole] if whole is not None and known else []
        rest += [] if whole is not None and known else [factor]
    left = sympy.Mul(*rest)
    if not found or left.is_nonpositive:
        return e
    return sympy.Add(*found, sympy.log(left) if left != 1 else 0)


def _is_positive(base: Any) -> bool:
    """Whether an expression is a sum of exponentials with positive numbers."""
    return bool(base.has(*_EXPONENTIAL)) and all(map(_is_positive_number, _exponentials(base).values()))


def _log_of(base: Any) -> Any:
    """The logarithm of an exponential, or of a sum of two; None if it is neither."""
    if isinstance(base, sympy.exp):
        return base.args[0]
    if isinstance(base, sympy.cosh):
        return log_cosh(base.args[0])
    if not base.has(*_EXPONENTIAL) or not (base.is_Add or isinstance(base, sympy.sinh)):
        return None
    two = _two(_exponentials(base))
    if two is None:
        return None
    (a, m), (b, n) = two
    return _log_of_two(m, a, n, b)


def _tail(total: Any) -> Any:
    """A sum with each term that another one nearly cancels far out joined with that."""
    left, joined = dict.fromkeys(total.args), []
    for term in total.args:
        for other, both in _partners(term):
            if term in left and other in left:
                del left[term], left[other]
                joined.append(both)
                break
    return _once(sympy.Add(*left, *joined)) if joined else total


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
            yield sign, sign * 2 * size / (1 + _exp(-sign * 2 * base.args[0]))
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
    elif power == -1 and (divisor := _Divisor.of(base)) and {divisor.m, divisor.n} == {1} and base.is_Add:
        exponent = next((a for a in _exponentials(base) if a != 0), sympy.S.Zero)
        yield -1, -size / (1 + _exp(-exponent))

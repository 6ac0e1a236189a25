"""Sums of exponentials, and logarithms, powers and comparisons of them that do not overflow.

``log(1 + exp(x))`` is x far out, where the exponential is no double, and a comparison of two exponentials is one of
their quotient. The logarithm of a sum of two becomes a `log_sum`, that of ``cosh(x)`` a `log_cosh`.
"""

from collections.abc import Iterator
from typing import Any

import sympy

from chaosdrill.model.special import log_cosh, log_sum
from chaosdrill.model.text import undivided
from chaosdrill.model.tuning import TUNING

EXPONENTIAL = (sympy.exp, sympy.cosh, sympy.sinh)


def exponential(exponent: Any) -> Any:
    return sympy.exp(undivided(multiplied_out(exponent)))


def multiplied_out(exponent: Any) -> Any:
    """An exponent as a sum, if that has no more terms: those of ``((x - c)/w)**2`` cancel, and leave its rounding.

    Exponentials in it, and what they divide by, stay whole, as quotients leave them.
    """
    below = {p: sympy.Dummy(real=True) for p in exponent.atoms(sympy.Pow) if p.exp.is_negative and p.has(*EXPONENTIAL)}
    expanded = sympy.expand(exponent.xreplace(below), power_exp=False)
    if len(sympy.Add.make_args(expanded)) > len(sympy.Add.make_args(exponent)):
        return exponent
    return expanded.xreplace({whole: p for p, whole in below.items()})


def exponentials(expression: Any) -> dict[Any, Any]:
    """Factors of exponentials of different exponents, whose sum an expression is; none if that sum is a long one."""
    found: dict[Any, Any] = {}
    for term in sympy.Add.make_args(expression):
        # each of these doubles the number of exponentials
        if sum(isinstance(f, (sympy.cosh, sympy.sinh)) for f in _factors(term)) > TUNING.multiplied_out:
            return {}
        for exponent, factor in _split(term):
            found[exponent] = found.get(exponent, sympy.S.Zero) + factor
    return found


def _split(term: Any) -> Iterator[tuple[Any, Any]]:
    parts: list[tuple[Any, Any]] = [(sympy.S.Zero, sympy.S.One)]
    for factor in _factors(term):
        if isinstance(factor, sympy.exp):
            more = [(factor.args[0], sympy.S.One)]
        elif isinstance(factor, (sympy.cosh, sympy.sinh)):
            a, sign = factor.args[0], 1 if isinstance(factor, sympy.cosh) else -1
            more = [(a, sympy.S.Half), (-a, sign * sympy.S.Half)]
        else:
            more = [(sympy.S.Zero, factor)]
        parts = [(a + b, m * n) for a, m in parts for b, n in more]
    yield from parts


def _factors(term: Any) -> Iterator[Any]:
    """Factors of a term, a whole power of a hyperbolic function as that number of equal ones."""
    for factor in sympy.Mul.make_args(term):
        base, times = factor.as_base_exp()
        whole = isinstance(base, (sympy.cosh, sympy.sinh)) and times.is_Integer and 0 < times <= TUNING.multiplied_out
        yield from [base] * int(times) if whole else [factor]


def squared(factor: Any) -> Any:
    """A factor, as a square if it is ``exp(u) + exp(-u) + 2`` but for an exponential, or the same with -2, which loses
    its digits near 0."""
    base, power = factor.as_base_exp()
    if not (base.is_Add and base.has(*EXPONENTIAL)) or len(found := exponentials(base)) != 3:
        return factor
    for middle, number in found.items():
        (a, m), (b, n) = ((exponent, one) for exponent, one in found.items() if exponent != middle)
        if m != n or multiplied_out(a + b - 2 * middle) != 0:
            continue
        half = multiplied_out((b if a.could_extract_minus_sign() else a) - middle) / 2
        if number == 2 * m and is_positive_number(m):
            return (4 * m) ** power * exponential(power * middle) * sympy.cosh(half) ** (2 * power)
        if number == -2 * m and power.is_Integer:
            return (4 * m * exponential(middle) * sympy.sinh(half) ** 2) ** power
    return factor


def two_of(found: dict[Any, Any]) -> "tuple[tuple[Any, Any], tuple[Any, Any]] | None":
    """Two exponentials whose sum is that of several, as exponents and factors.

    Those with positive numbers become one.
    """
    if len(found) < 2:
        return None
    positive = {a: m for a, m in found.items() if is_positive_number(m)}
    while len(found) > 2 and len(positive) > 1:
        (a, m), (b, n), *_ = positive.items()
        joined = log_of_two(m, a, n, b)
        for exponents in (found, positive):
            del exponents[a], exponents[b]
            exponents[joined] = sympy.S.One
    if len(found) > 2:
        return None
    first, second = found.items()
    return first, second


def two_in(expression: Any) -> "tuple[tuple[Any, Any], tuple[Any, Any]] | None":
    """Two exponentials whose sum an expression is, as `two_of`; None if it is no such sum."""
    summed = expression.is_Add or isinstance(expression, (sympy.cosh, sympy.sinh))
    return two_of(exponentials(expression)) if summed and expression.has(*EXPONENTIAL) else None


def is_positive_number(m: Any) -> bool:
    return bool(m.is_number and m.is_positive)


def log_of_two(m: Any, a: Any, n: Any, b: Any) -> Any:
    """log(m exp(a) + n exp(b))."""
    if m == n and multiplied_out(a + b) == 0 and is_positive_number(m):
        return sympy.log(2 * m) + log_cosh(a if a.could_extract_minus_sign() is False else b)
    if a == 0:
        (m, a), (n, b) = (n, b), (m, a)
    return b + log_sum(n, m, undivided(multiplied_out(a - b)))


def power(e: Any) -> Any:
    """A power, no whole one, of a sum of exponentials with positive numbers as an exponential."""
    base, power = e.as_base_exp()
    inner, times = base.as_base_exp()
    if times.is_Integer and times != 1 and _is_positive(inner):
        e = inner ** (times * power)
        base, power = e.as_base_exp()
    if power.is_Integer or not base.has(*EXPONENTIAL) or not (base.is_Add or isinstance(base, sympy.cosh)):
        return e
    if (whole := squared(e)) != e:
        return whole
    found = exponentials(base)
    if len(found) < 2 or not all(map(is_positive_number, found.values())):
        return e
    return sympy.exp(power * _log_of(base))


def comparison(e: Any) -> Any:
    """A comparison of exponentials on both sides, which may be infinity against infinity, as that of one of them."""
    if not all(side.has(*EXPONENTIAL) for side in e.args):
        return e
    found: dict[Any, Any] = {}
    for side, sign in zip(e.args, (1, -1), strict=True):
        for exponent, factor in exponentials(side).items():
            offset, moving = exponent.as_coeff_Add()
            if abs(offset) >= TUNING.far:
                return e
            found[moving] = found.get(moving, sympy.S.Zero) + sign * factor * sympy.exp(offset)
    if not 1 <= len(found) <= 2:
        return e
    (b, n), *others = sorted(found.items(), key=lambda one: sympy.default_sort_key(one[0]))
    return e.func(sympy.Add(n, *(m * exponential(a - b) for a, m in others)), 0)


def logarithm(e: Any) -> Any:
    """A logarithm of exponentials, of sums of them, or of powers of these."""
    inner = e.args[0]
    if not inner.has(*EXPONENTIAL):
        return e
    found, rest = [], []
    for factor in sympy.Mul.make_args(inner):
        base, power = base_and_power(factor)
        whole = _log_of(base)
        # the square of what may be negative is positive
        known = isinstance(factor, sympy.exp) or inner == factor == base or _is_positive(base)
        found += [power * whole] if whole is not None and known else []
        rest += [] if whole is not None and known else [factor]
    left = sympy.Mul(*rest)
    if not found or left.is_nonpositive:
        return e
    return sympy.Add(*found, sympy.log(left) if left != 1 else 0)


def area_sine(e: Any) -> Any:
    """asinh(w) of a sum of exponentials with positive numbers, as log(w + sqrt(1 + w**2))."""
    if not _is_positive(e.args[0]):
        return e
    found, one = exponentials(e.args[0]), sympy.S.One
    terms = [*found.items()] if len(found) == 1 else two_of(found)
    if terms is None:
        return e
    (a, m), *others = terms
    w = log_of_two(m, a, others[0][1], others[0][0]) if others else a + sympy.log(m)
    return log_of_two(one, w, one, log_of_two(one, 2 * w, one, sympy.S.Zero) / 2)


def _is_positive(base: Any) -> bool:
    """Whether an expression is a sum of exponentials with positive numbers."""
    return bool(base.has(*EXPONENTIAL)) and all(map(is_positive_number, exponentials(base).values()))


def _log_of(base: Any) -> Any:
    """The logarithm of an exponential, or of a sum of two; None if it is neither."""
    if isinstance(base, sympy.exp):
        return base.args[0]
    if isinstance(base, sympy.cosh):
        return log_cosh(base.args[0])
    if (two := two_in(base)) is None:
        return None
    (a, m), (b, n) = two
    return log_of_two(m, a, n, b)


def base_and_power(factor: Any) -> tuple[Any, Any]:
    """Base and exponent of a factor; an exponential is its own base, not a power of e."""
    return (factor, sympy.S.One) if isinstance(factor, sympy.exp) else factor.as_base_exp()


def with_parts(e: Any, parts: list[Any]) -> Any:
    return e if all(new is old for new, old in zip(parts, e.args, strict=True)) else e.func(*parts)

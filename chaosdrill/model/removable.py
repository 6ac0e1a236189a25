"""Quotients whose sides are zero together become functions that are analytic at that place.

``sin(x)/x`` is 0/0 at x = 0, and ``(1 - cos(x))/x**2`` has lost its digits long before. A place is taken from what
divides: in the distance u from it each side is a sum of products of polynomials and elementary functions g, and each of
these is the first terms of its Taylor series and a power of u times a `taylor_rest`. The terms below the first that
does not cancel are zero, the power is taken out, and what is left is divided. Poles that cancel each other, as in
``1/tanh(x) - 1/x``, are put on one divisor before.

What is even in the root r of a sum of squares, as ``sin(r)/r`` or ``cos(r)``, is analytic where all of them are zero,
and r is not: it becomes a function of r^2, an `even_rest`.
"""

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import permutations, product
from typing import Any

import sympy

from chaosdrill.model.logarithms import base_and_power, is_positive_number, with_parts
from chaosdrill.model.special import RESTS, even_rest, gate, log1p, log_cosh, power_rest, taylor_rest
from chaosdrill.model.touching import degree_bound, exact, is_long
from chaosdrill.model.tuning import TUNING

_BY_TYPE: dict[Any, int] = {g: i for i, g in enumerate(RESTS) if isinstance(g, type)}
_LOG1P = sympy.Integer(RESTS.index(log1p))
_ANGLES = (sympy.tan, sympy.acos)
_FUNCTIONS = (*_BY_TYPE, *_ANGLES, sympy.log, gate)

_EVEN, _NEITHER = (sympy.cos, sympy.cosh, log_cosh), (sympy.exp, log1p)

_U = sympy.Dummy("u", real=True)
_ROOT = sympy.Dummy("r", nonnegative=True)


class _Unknown(Exception):
    """A factor is no such sum of products."""


def without_removable(expression: Any) -> Any:
    """An expression without quotients that are 0/0 at a place where they have a limit."""
    return _filled(expression, {}) if _divides(expression) else expression


def of_squares(expression: Any) -> Any:
    """An expression in which what is even in the root of a sum of squares is a function of that sum."""
    inner: list[Any] = [f for f in expression.atoms(sympy.Function) if isinstance(f, (*_BY_TYPE, sympy.tan))]
    found = {r.base for f in inner for r in f.atoms(sympy.Pow) if r.exp == sympy.S.Half and r.base.is_Add}
    for square in sorted((s for s in found if s.is_nonnegative), key=sympy.default_sort_key):
        powers = {p: _power_of_root(p, square) for p in expression.atoms(sympy.Pow) if p.base.is_Add}
        put = expression.xreplace(powers)
        angles = {f: sympy.sin(f.args[0]) / sympy.cos(f.args[0]) for f in put.atoms(sympy.tan) if f.has(_ROOT)}
        whole = {f: log_cosh(f.args[0].args[0]) for f in put.atoms(sympy.log) if isinstance(f.args[0], sympy.cosh)}
        made = _even_parts(_filled(put.xreplace({**angles, **whole}), {}), square).xreplace({_ROOT: sympy.sqrt(square)})
        # quotients and products of exponentials are left to what keeps them finite
        below = any(p.exp.could_extract_minus_sign() and _grows(p.base) for p in made.atoms(sympy.Pow))
        if made.has(even_rest) and not (below or (expression.has(sympy.exp) and _grows(made))):
            expression = made
    return expression


def _power_of_root(p: Any, square: Any) -> Any:
    """A power of a sum, of the root if the sum is the square but for a number."""
    number, core = p.base.primitive()
    return number**p.exp * _ROOT ** (2 * p.exp) if core == square and (2 * p.exp).is_Integer else p


def _grows(e: Any) -> bool:
    """Whether what is made of an expression overflows like an exponential."""
    return any(RESTS[int(f.args[1])] in (sympy.sinh, sympy.cosh) for f in e.atoms(even_rest))


def _even_parts(e: Any, square: Any) -> Any:
    """An expression with functions of the square for its largest parts that are even in the root."""
    if not e.args or _ROOT not in e.free_symbols:
        return e
    if (found := _halved(e, square)) is not None:
        return e if found[0] else found[1]
    if e.is_Mul:
        known = {f: _halved(f, square) for f in e.args}
        odd, even = _halved(sympy.Mul(*(f for f, one in known.items() if one)), square) or (1, e)
        if not odd:
            return even * sympy.Mul(*(_even_parts(f, square) for f, one in known.items() if one is None))
    return with_parts(e, [_even_parts(a, square) for a in e.args])


def _halved(e: Any, square: Any) -> tuple[int, Any] | None:
    """Whether an expression is odd in the root, and the function of the square that it is, over the root if it is odd.

    None if it is neither.
    """
    if _ROOT not in e.free_symbols:
        return 0, e
    if e == _ROOT:
        return 1, sympy.S.One
    parts = [part for a in e.args if (part := _halved(a, square))]
    if len(parts) < len(e.args):
        return None
    odd, halves = [p for p, _ in parts], [half for _, half in parts]
    if e.is_Add:
        return (odd[0], sympy.Add(*halves)) if len(set(odd)) == 1 else None
    if e.is_Mul:
        return sum(odd) % 2, square ** (sum(odd) // 2) * sympy.Mul(*halves)
    if e.is_Pow and e.exp.is_Integer:
        times = odd[0] * e.exp
        return int(times % 2), square ** (times // 2) * halves[0] ** e.exp
    if not any(odd):
        return 0, e.func(*halves)
    if isinstance(e, taylor_rest) and e.args[3] == 0:
        told, m = int(e.args[1]), int(e.args[2])
    elif type(e) in _BY_TYPE:
        told, m = _BY_TYPE[type(e)], 0
    else:
        return None
    if RESTS[told] in _NEITHER or m == TUNING.rest_terms:
        return None
    # an odd rest is that of one more term, times the argument
    way = (m + (RESTS[told] not in _EVEN)) % 2
    return way, halves[0] ** way * even_rest(square * halves[0] ** 2, sympy.Integer(told), m + way, 0)


def with_factor(guard: Any, moving: Iterable[Any]) -> Any:
    """A guard as a product with what moves, if it is a polynomial that this divides although no term of it shows it.

    Near zero ``(x + 7)**2 - 49`` is what rounding leaves of 49; ``x*(x + 14)`` has all its digits, and shows that it is
    zero where x is.
    """
    symbols = sorted(guard.free_symbols & set(moving), key=lambda s: s.name)
    if not (guard.is_Add and symbols and guard.is_polynomial(*symbols)):
        return guard
    degree = degree_bound(guard)
    if degree < 2 or math.comb(degree + len(symbols), len(symbols)) > TUNING.terms:
        return guard
    polynomial = sympy.Poly(exact(guard), *symbols)
    shared = {s: min(powers) for s, powers in zip(symbols, zip(*polynomial.monoms(), strict=True), strict=True)}
    hidden = [s for s, power in shared.items() if power and not all(term.has(s) for term in guard.args)]
    if not hidden or polynomial.is_zero:
        return guard
    divisor = sympy.Mul(*(s ** shared[s] for s in hidden))
    return divisor * polynomial.quo(sympy.Poly(divisor, *symbols)).as_expr()


def _filled(e: Any, known: dict[Any, Any]) -> Any:
    if not e.args or not isinstance(e, sympy.Basic):
        return e
    if e not in known:
        made = with_parts(e, [_filled(a, known) for a in e.args])
        if made.is_Mul and _divides(made):
            made = _conjugated(_cancelled(made))
        if (made.is_Mul or made.is_Add) and _divides(made) and _has_functions(made):
            made = _joined(made) if made.is_Add else _quotient(made)
        known[e] = made
    return known[e]


def _has_functions(e: Any) -> bool:
    return bool(e.has(*_FUNCTIONS)) or any(not p.exp.is_Integer for p in e.atoms(sympy.Pow))


def _divides(e: Any) -> bool:
    """Whether something in an expression divides by what has symbols."""
    return e.has(gate) or any(
        p.exp.is_Integer and p.exp.is_negative and p.base.free_symbols for p in e.atoms(sympy.Pow)
    )


@lru_cache(maxsize=512)
def _cancelled(e: Any) -> Any:
    """A product without what its polynomials above and below have in common."""
    factors = [base_and_power(f) for f in sympy.Mul.make_args(e)]
    for (a, times), (b, by) in permutations(factors, 2):
        if not (times.is_Integer and by.is_Integer and times > 0 > by and b.is_Add and a.free_symbols & b.free_symbols):
            continue
        if all(f.is_polynomial(*f.free_symbols) and degree_bound(f) <= TUNING.zeros for f in (a, b)):
            common, above, below = sympy.cofactors(exact(a), exact(b))
            if common.free_symbols:
                return _cancelled(e / a**times / b**by * above**times * below**by * common ** (times + by))
    return e


def _conjugated(e: Any) -> Any:
    """A product in which a difference of roots that is zero where a divisor is, or divides what is, is that of the
    squares over a sum.
    """
    factors = [base_and_power(f) for f in sympy.Mul.make_args(e)]
    for (a, times), (b, by) in permutations(factors, 2):
        if not (times.is_Integer and by.is_Integer and times * by < 0 and (difference := _conjugate(a))):
            continue
        apart, total = difference
        for other, over in filter(None, ((exact(b), 1), _conjugate(b))):
            if other.has(sympy.Piecewise):
                continue
            common, one, rest = sympy.cofactors(apart, other)
            if common.free_symbols:
                left = (one / total) ** times * (rest / over) ** by * common ** (times + by)
                return _conjugated(e / a**times / b**by * left)
    return e


def _conjugate(e: Any) -> tuple[Any, Any] | None:
    """Of a difference of two terms, one of them a root: the difference of their squares, and their sum; or None."""
    if not (e.is_Add and len(e.args) == 2):
        return None
    p, q = sorted(exact(e).args, key=lambda term: term.as_coeff_Mul()[0], reverse=True)
    shared = sympy.Mul(*set(sympy.Mul.make_args(p)).intersection(sympy.Mul.make_args(q)))
    p, q = p / shared, q / shared
    factors = [f for term in (p, q) for f in sympy.Mul.make_args(term.as_coeff_Mul()[1])]
    roots = [f.is_Pow and f.exp == sympy.S.Half for f in factors]
    if not any(roots):
        return None
    one, other = sympy.expand(p**2), sympy.expand(q**2)
    apart, total = sympy.expand(one - other), p - q
    if all(root or f.is_nonnegative for root, f in zip(roots, factors, strict=True)):
        return (apart * shared, total) if p.as_coeff_Mul()[0] * q.as_coeff_Mul()[0] < 0 else None
    # where the sign of what is no root makes p - q the difference, this is p - q with all its digits
    return apart * shared, (apart * (p + q) + total**3) / (2 * (one + other))


@lru_cache(maxsize=512)
def _quotient(e: Any) -> Any:
    """A product without such a quotient; itself if it has none."""
    if is_long(e):
        return e
    # poles that are a sum are factors of one divisor
    parted = _factored(
        sympy.Mul(*(sympy.together(f) if f.is_Add and _divides(f) else f for f in sympy.Mul.make_args(e)))
    )
    found = {place: made for place in _places(parted) if (made := _divided(parted, *place)) is not None}
    if not found:
        return e
    first = next(iter(found))
    made = _blended(parted, [place for place in found if place[0] == first[0]])
    if made is not None:
        return made
    return found[first] if all(symbol == first[0] for symbol, _ in found) else _quotient(found[first])


def _factored(e: Any) -> Any:
    """A product with the factors of its divisors that are polynomials."""
    made: list[Any] = []
    for factor in sympy.Mul.make_args(e):
        base, power = factor.as_base_exp()
        below = base.is_Add and power.is_Integer and power.is_negative and base.is_polynomial(*base.free_symbols)
        number, parts = sympy.S.One, []
        if below and degree_bound(base) <= TUNING.zeros:
            number, parts = sympy.factor_list(exact(base))
        factors = (number**power, *(part ** (times * power) for part, times in parts))
        made += factors if parts else [factor]
    return sympy.Mul(*made)


def _blended(e: Any, places: list[tuple[Any, Any]]) -> Any:
    """The mean of a product's forms, each filled at one place or exact where a function is zero with its argument.

    The weights are positive and fall to zero at the others' places: nothing cancels. None if there is one form, or two
    places may be one.
    """
    symbol, powers = places[0][0], dict(factor.as_base_exp() for factor in sympy.Mul.make_args(e))
    divisors = {distance: sympy.diff(distance, symbol) for _, distance in places}
    if not all(powers.get(distance, sympy.S.Half).is_Integer for distance in divisors):
        return None
    most = max(2, *(int(-powers[distance] + powers[distance] % 2) for distance in divisors))
    if not all(_apart(*a, *b).is_number for a, b in permutations(divisors.items(), 2)):
        return None
    for factor in sympy.Mul.make_args(_turned(e)):
        function = distance = base_and_power(factor)[0]
        while isinstance(distance, _FUNCTIONS) and len(distance.args) == 1 and distance.func(0) == 0:
            distance = distance.args[0].as_independent(sympy.Symbol, as_Add=False)[1]
        slope = sympy.diff(distance, symbol)
        if distance == function or slope == 0 or symbol in slope.free_symbols:
            continue
        if all((apart := _apart(distance, slope, *known)).is_number and apart != 0 for known in divisors.items()):
            divisors[distance] = slope
    if len(divisors) < 2:
        return None
    first, made, total = divisors[places[0][1]], [], []
    for base, slope in divisors.items():
        weight = sympy.Mul(sympy.cancel(slope / first), *(other for other in divisors if other != base)) ** most
        filled = _divided(e * weight, symbol, base)
        made.append(_quotient(e * weight if filled is None else filled))
        total.append(weight)
    return sympy.Add(*made) / sympy.Add(*total)


def _apart(base: Any, slope: Any, other: Any, by: Any) -> Any:
    """What one linear expression is where another one is zero."""
    return sympy.expand(base - sympy.cancel(slope / by) * other)


@lru_cache(maxsize=512)
def _joined(e: Any) -> Any:
    """A sum whose poles that cancel each other are one quotient that has none."""
    if is_long(e) or sum(map(_divides, e.args)) < 2:
        return e
    for symbol, distance in dict.fromkeys(place for term in e.args for place in _places(term)):
        terms = [one for term in e.args for one in sympy.Add.make_args(sympy.expand(_turned(term)))]
        poles = [term for term in terms if _divides(term) and _order(term, symbol, distance) < 0]
        if len(poles) < 2:
            continue
        others = [term for term in terms if term not in poles]
        whole = sympy.together(sympy.Add(*poles))
        found = _divided(whole, symbol, distance) or _conjugated(whole)
        if found != whole:
            return sympy.Add(found, *others)
    return e


def _places(e: Any) -> Iterator[tuple[Any, Any]]:
    """Symbols with expressions, linear in them, that may be zero where a divisor of a product is."""
    seen = set()
    for factor in sympy.Mul.make_args(e):
        base, power = factor.as_base_exp()
        if isinstance(factor, gate):
            base, power = sympy.exp(factor.args[2]), sympy.S.NegativeOne
        if not (power.is_Integer and power.is_negative) or isinstance(factor, sympy.exp):
            continue
        inner: list[Any] = [a for f in base.atoms(sympy.Function) for a in f.args if isinstance(f, _FUNCTIONS)]
        inner += [p.base - 1 for p in base.atoms(sympy.Pow) if not p.exp.is_Integer]
        inner += [a - 1 for f in base.atoms(sympy.log) for a in f.args]
        for distance in inner or [base]:
            for symbol in sorted(distance.free_symbols, key=lambda s: s.name):
                slope = sympy.diff(distance, symbol)
                if slope == 0 or symbol in slope.free_symbols or slope.has(sympy.Function):
                    continue
                found = symbol, sympy.expand(distance / slope)
                if found not in seen:
                    seen.add(found)
                    yield symbol, distance


def _divided(e: Any, symbol: Any, distance: Any) -> Any:
    """A product whose powers of a distance have been divided; None if it has a pole there, or nothing is 0/0."""
    try:
        factors = list(_near(e, symbol, distance))
    except _Unknown:
        return None
    order = sum(power * times for power, times, _ in factors)
    above = any(power > 0 and times > 0 for power, times, _ in factors)
    below = any(power > 0 and times < 0 for power, times, _ in factors)
    if order < 0 or not (above and below):
        return None
    made = sympy.Mul(_U**order, *(sympy.factor_terms(rest) ** times for _, times, rest in factors))
    # the distance itself may divide by another symbol
    return made.xreplace({_U: distance}).replace(
        lambda f: isinstance(f, (taylor_rest, power_rest)), lambda f: f.func(sympy.expand(f.args[0]), *f.args[1:])
    )


def _order(e: Any, symbol: Any, distance: Any) -> int:
    """How often a product is zero at a place; negative at a pole."""
    try:
        return sum(power * times for power, times, _ in _near(e, symbol, distance))
    except _Unknown:
        return 0


def _near(e: Any, symbol: Any, distance: Any) -> Iterator[tuple[int, int, Any]]:
    """Factors of a product about a place: how often each is zero there, its power, and what it is over that."""
    put = {symbol: (_U - distance.subs(symbol, 0)) / sympy.diff(distance, symbol)}
    for factor in sympy.Mul.make_args(_turned(e)):
        base, times = base_and_power(factor)
        if not times.is_Integer:
            base, times = factor, sympy.S.One
        if symbol not in base.free_symbols:
            yield 0, int(times), base
            continue
        moved = _centred(exact(base).xreplace(put))
        if _start(moved) not in (0, None):
            yield 0, int(times), base
            continue
        above, below = sympy.fraction(sympy.together(moved)) if _divides(moved) else (moved, sympy.S.One)
        for side, way in ((above, 1), (below, -1)):
            for one in sympy.Mul.make_args(side):
                inner, again = base_and_power(one)
                if not (again.is_Integer and again.is_positive):
                    inner, again = one, sympy.S.One
                power, rest = _zeros(inner)
                yield power, way * int(times * again), rest


def _turned(e: Any) -> Any:
    """An expression with sines and cosines for tangents, arc sines for arc cosines, poles for gates, and logarithms of
    bases for those of their powers.
    """
    if not e.has(*_ANGLES, gate, sympy.log):
        return e
    made = e.replace(sympy.tan, lambda a: sympy.sin(a) / sympy.cos(a))
    made = made.replace(sympy.acos, lambda a: sympy.pi / 2 - sympy.asin(a))
    return made.replace(gate, _gate).replace(sympy.log, _logarithm)


def _logarithm(a: Any) -> Any:
    """A logarithm of a positive number times a power that is positive only where its base is."""
    number, whole = a.as_coeff_Mul()
    base, power = base_and_power(whole)
    if power == 1 or not (power.is_Rational and number.is_positive) or power.is_even:
        return sympy.log(a)
    return sympy.log(number) + power * sympy.log(base)


def _gate(m: Any, n: Any, u: Any, e: Any) -> Any:
    """A gate with a pole where u is zero, by a function that is finite beyond it; any other as it is."""
    if m + n != 0 or e not in (0, u):
        return gate(m, n, u, e)
    return (1 / sympy.tanh(u / 2) + (1 if e == u else -1)) / (2 * n)


def _centred(e: Any) -> Any:
    """An expression whose functions have arguments that are zero where u is."""
    if not e.args or _U not in e.free_symbols:
        return e
    e = e.func(*(_centred(a) for a in e.args))
    if e.is_Pow and not e.exp.is_Integer and _U not in e.exp.free_symbols:
        start = _start(e.base)
        return start**e.exp * (1 + sympy.expand(e.base / start - 1)) ** e.exp if _is_positive(start) else e
    if not isinstance(e, _FUNCTIONS):
        return e
    start = _start(e.args[0])
    if isinstance(e, sympy.log):
        return sympy.log(start) + sympy.log(1 + sympy.expand(e.args[0] / start - 1)) if _is_positive(start) else e
    if start is None or start == 0:
        return e
    rest = sympy.expand(e.args[0] - start)
    if isinstance(e, sympy.exp):
        return sympy.exp(start) * sympy.exp(rest)
    for odd, even, sign in ((sympy.sin, sympy.cos, -1), (sympy.sinh, sympy.cosh, 1)):
        if isinstance(e, odd):
            return odd(start) * even(rest) + even(start) * odd(rest)
        if isinstance(e, even):
            return even(start) * even(rest) + sign * odd(start) * odd(rest)
    return e


def _is_positive(number: Any) -> bool:
    return number is not None and is_positive_number(number)


def _start(e: Any) -> Any:
    """What an expression is where u is zero; None if it is not finite there."""
    found = e.subs(_U, 0)
    return None if found.has(sympy.nan, sympy.zoo, sympy.oo) else sympy.expand(found)


def _zeros(e: Any) -> tuple[int, Any]:
    """How often an expression is zero where u is, and what it is over that power of u."""
    if _U not in e.free_symbols:
        return 0, e
    if (start := _start(e)) is not None and start != 0:
        return 0, e
    above, below = sympy.fraction(sympy.together(e)) if _divides(e) else (e, sympy.S.One)
    if _U in below.free_symbols and _start(below) not in (0, None):
        power, rest = _zeros(above)
        return power, rest / below
    # asin(sin(u)) has kinks, to be seen by its name
    may_fold = isinstance(e, sympy.asin) and e.has(sympy.sin, sympy.cos)
    if not may_fold and (known := _elementary(e)) is not None and not known[2].is_polynomial(_U):
        rest_of, told, inner = known
        power, rest = _zeros(inner)
        own = next((p for p in range(1, TUNING.rest_terms) if rest_of.term(told, p) != 0), 0)
        if power and own and rest_of.term(told, 0) == 0:
            return own * power, rest_of(inner, told, own, 0) * rest**own
    terms = [_Term(term) for term in sympy.Add.make_args(sympy.expand(e))]
    last = e
    for power in range(1, TUNING.zeros + 1):
        rests: list[Any] = []
        sums: dict[int, Any] = {}
        for term in terms:
            for degree, coefficient in term.beyond(power, rests).items():
                sums[degree] = sums.get(degree, sympy.S.Zero) + coefficient
        if any(sympy.expand(sums.get(degree, 0)) != 0 for degree in range(power)):
            return power - 1, last
        polynomial = (c * _U ** (degree - power) for degree, c in sums.items() if degree >= power)
        last = sympy.Add(*polynomial, *rests)
    raise _Unknown


def _elementary(e: Any) -> tuple[Any, Any, Any] | None:
    """What gives the rests of a function, what tells which function it is, and its argument."""
    if isinstance(e, sympy.log):
        return taylor_rest, _LOG1P, sympy.expand(e.args[0] - 1)
    if e.is_Pow and not e.exp.is_Integer and _U not in e.exp.free_symbols:
        return power_rest, e.exp, sympy.expand(e.base - 1)
    return (taylor_rest, sympy.Integer(_BY_TYPE[type(e)]), e.args[0]) if type(e) in _BY_TYPE else None


class _Term:
    """A product of a constant, a power of u, and elementary functions of polynomials that are zero where u is."""

    def __init__(self, term: Any) -> None:
        self.constant, self.power, self.functions = sympy.S.One, 0, []
        for factor in sympy.Mul.make_args(term):
            if _U not in factor.free_symbols:
                self.constant *= factor
                continue
            base, times = base_and_power(factor)
            whole = times.is_Integer and times.is_positive
            if base == _U and whole:
                self.power += int(times)
                continue
            base, times = (base, int(times)) if whole else (factor, 1)
            known = _elementary(base)
            if known is None or not known[2].is_polynomial(_U) or known[2].subs(_U, 0) != 0:
                raise _Unknown
            self.functions += [known] * times
        if len(self.functions) > TUNING.rest_factors:
            raise _Unknown

    def beyond(self, power: int, rests: list[Any]) -> dict[int, Any]:
        """Coefficients of the term's polynomial by powers of u; what is left, over the power, is added to the rests."""
        if self.power >= power or not self.functions:
            if not self.functions:
                return {self.power: self.constant}
            whole = sympy.Mul(*(rest_of.of(told, w) for rest_of, told, w in self.functions))
            rests.append(self.constant * _U ** (self.power - power) * whole)
            return {}
        choices = []
        for rest_of, told, w in self.functions:
            lowest = min(degree for (degree,) in sympy.Poly(w, _U).monoms())
            terms = math.ceil((power - self.power) / lowest)
            if terms >= TUNING.rest_terms:
                raise _Unknown
            first = sympy.Add(*(rest_of.term(told, p) * w**p for p in range(terms)))
            over = sympy.expand(w / _U**lowest) ** terms
            choices.append(((first, 0), (over * rest_of(w, told, terms, 0), lowest * terms)))
        found: dict[int, Any] = {}
        for chosen in product(*choices):
            raised = sum(by for _, by in chosen)
            whole = self.constant * sympy.Mul(*(part for part, _ in chosen))
            if raised:
                rests.append(whole * _U ** (self.power + raised - power))
                continue
            for (degree,), coefficient in sympy.Poly(whole, _U).terms():
                place = degree + self.power
                found[place] = found.get(place, sympy.S.Zero) + coefficient
        return found

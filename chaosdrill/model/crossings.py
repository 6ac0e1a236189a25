"""The surfaces on which guards vanish: guards that vanish on the same set, and change sign there together, share one.

``2*x``, ``-3*x``, ``x*(1 + v**2)``, ``sinh(x)`` and ``x + x**3`` are one surface, ``x``, crossed in one or the other
way. The expressions decide: constant factors, factors that cannot vanish, odd powers, monotone
functions, sums of these. Whatever else vanishes together is seen when a run crosses it (`chaosdrill.engine.guards`).
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import sympy
from sympy.utilities.iterables import sift

from chaosdrill.model.bounds import BOUNDED, bounds_of, sign_of
from chaosdrill.model.logarithms import multiplied_out
from chaosdrill.model.touching import degree_bound
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING

INCREASING = (sympy.sinh, sympy.tanh, sympy.atan, sympy.asinh, sympy.asin, sympy.erf)
"""Functions that grow with their argument and vanish with it."""


class Crossing(NamedTuple):
    """A surface, as an expression that vanishes on it and nowhere else, and the way in which it is crossed."""

    surface: Any
    direction: int
    """+1 where the expression grows, -1 where it falls, 0 for both"""


def crossings(transitions: Sequence[Transition]) -> tuple[Crossing, ...]:
    """The surface and direction of each transition in order, independent of how its guard is written.

    Of guards that differ by a constant factor the simplest one stands for all.
    """
    return _crossings(tuple((t.guard, t.direction) for t in transitions))


@lru_cache(maxsize=256)
def _crossings(events: tuple[tuple[Any, int], ...]) -> tuple[Crossing, ...]:
    found = [stripped(guard) for guard, _ in events]
    # each stands for all that follow it here and are proportional to it
    simplest = sorted(dict.fromkeys(core for core, _ in found), key=_simplicity)
    stands: dict[Any, tuple[Any, int]] = {}
    for core in simplest:
        ratios = ((other, ratio(core, other)) for other in dict.fromkeys(one for one, _ in stands.values()))
        stands[core] = next(((other, 1 if r > 0 else -1) for other, r in ratios if r is not None), (core, 1))
    return tuple(
        Crossing(stands[core][0], direction * way * stands[core][1])
        for (core, way), (_, direction) in zip(found, events, strict=True)
    )


def _simplicity(core: Any) -> Any:
    turned = sum(1 for term, number in core.as_coefficients_dict().items() if number < 0 and not term.is_number)
    return sympy.count_ops(core), turned, sympy.default_sort_key(core)


def hidden(transitions: Sequence[Transition]) -> Iterator[tuple[int, str]]:
    """Outcomes that can never be taken, by number, and what stands before each."""
    first: dict[Any, str] = {}
    for place, (transition, crossing) in enumerate(zip(transitions, crossings(transitions), strict=True)):
        # one that completes another is taken in its place, wherever it stands
        if transition.completes is not None:
            continue
        events = [(mode, *crossing) for mode in transition.source]
        before = [first[event] for event in events if event in first]
        if len(before) == len(events):
            yield place, before[0]
        for event in events:
            if transition.conditions.get(event[0], sympy.true) == sympy.true:
                first.setdefault(event, transition.name)


def stripped(guard: Any) -> tuple[Any, int]:
    """The simplest expression with the zeros of a guard, and its sign relative to the guard: +1 or -1."""
    guard, way = sympy.sympify(guard), 1
    while True:
        core, turn = _stripped_once(guard)
        if core == guard:
            return guard, way
        guard, way = core, way * turn


def _stripped_once(g: Any) -> tuple[Any, int]:
    if g.is_Mul:
        return _without_factors(g)
    if g.is_Pow and g.exp.is_Integer and g.exp > 0 and g.exp % 2 == 1:
        return g.base, 1
    if isinstance(g, INCREASING):
        return g.args[0], 1
    undone = _undone(g)
    if undone:
        return undone
    if not g.is_Add:
        return g, 1
    ways = [(term, *stripped(term)) for term in g.args]
    tried: list[Any] = []
    for term, core, way in ways:
        if core == term or any(ratio(one, core) is not None for one in tried):
            continue
        tried.append(core)
        # a term and all others that vanish together and grow together, each by itself or as what is left; without
        # looking at all parts of what is left, of which there are more than anybody can wait for
        like = [one for one, other, turn in ways if other != one and (ratio(other, core) or 0) * turn * way > 0]
        rest, other = _as_a_whole(g - sympy.Add(*like))
        if rest == 0 or (ratio(rest, core) or 0) * other * way > 0:
            return core, way
    return _as_a_whole(g)


def _undone(g: Any) -> tuple[Any, int] | None:
    """What vanishes with a sum of a monotone function and a number, as u - log(3) with exp(u) - 3; None if g is none.

    Roots and logarithms stay: where they are no numbers, the guard has no value, and its run ends. So do exponentials
    that may be pulses, upward: far from one the exponent is so large that its rounding hides both roots.
    """
    terms = [term.as_coeff_Mul() for term in g.args] if g.is_Add else []
    if len(terms) == 2 and all(isinstance(f, sympy.exp) for _, f in terms):
        (m, a), (n, b) = terms
        quotient = sympy.exp(multiplied_out(a.args[0] - b.args[0]))
        if _grows_both_ways(-quotient.args[0]):
            return m * quotient + n, 1
        # far out both are no doubles, or zero, where their exponents differ
        even = (quotient.args[0] + sympy.log(-m / n), 1 if m > 0 else -1) if m * n < 0 else None
        return _undone(m * quotient + n) or even
    number, rest = g.as_independent(*g.free_symbols, as_Add=True)
    factor, f = rest.as_coeff_Mul()
    value, there = -number / factor, None
    if not (value.is_real and g.free_symbols):
        return None
    if isinstance(f, sympy.exp) and value > 0:
        if _grows_both_ways(u := f.args[0]):
            return 1 / value - sympy.exp(-u), 1 if factor > 0 else -1
        if _may_turn_back(u):
            return None
        there = sympy.log(value)
    elif f.is_Pow and f.exp.is_Integer and f.exp > 0 and f.exp % 2 == 1 and number:
        there = sympy.sign(value) * abs(value) ** (1 / f.exp)
    elif (gate := _of_gate(f, value)) is not None:
        return factor * gate, 1
    return None if there is None else (f.args[0] - there, 1 if factor > 0 else -1)


def _of_gate(f: Any, value: Any) -> Any:
    """What vanishes where f, as 1/(1 + exp(u)) or tanh(u) of a pulse u, has a value, as fast as f; None for others.

    Far from a narrow pulse the gate is flat to the last digit: nothing but the exponential shows that it opens.
    """
    if isinstance(f, sympy.tanh) and abs(value) < 1:
        e, there, slope = sympy.exp(2 * f.args[0]), (1 + value) / (1 - value), (1 - value) ** 2 / 2
    elif value and (f.is_Mul or f.is_Pow):
        number, rest = sympy.expand_mul(1 / f, deep=False).as_independent(*f.free_symbols, as_Add=True)
        factor, e = rest.as_coeff_Mul()
        there, slope = (1 / value - number) / factor, -factor * value**2
        if not (isinstance(e, sympy.exp) and number * factor > 0 and there > 0):
            return None
    else:
        return None
    if _grows_both_ways(u := e.args[0]):
        return slope * there**2 * (1 / there - sympy.exp(-u))
    return slope * (e - there) if _may_turn_back(u) and bounds_of(u)[1] < math.inf else None


def _may_turn_back(u: Any) -> bool:
    """Whether a value may have a maximum: it is bounded above, or has even parts of a sign that is not known."""
    low, high = bounds_of(u)
    parts = sympy.preorder_traversal(u)
    even = any(isinstance(p, BOUNDED) or (p.is_Pow and p.exp.is_even) for p in parts)
    return high < math.inf or (low == -math.inf and even)


def _grows_both_ways(u: Any) -> bool:
    """Whether a value grows with a polynomial in a symbol, and is for no values of all symbols far below zero."""
    if not any(u.is_polynomial(symbol) for symbol in u.free_symbols) or degree_bound(u) > TUNING.zeros:
        return False
    parts = sift(sympy.Add.make_args(u), lambda term: frozenset(term.free_symbols))
    return sum(_least(sympy.Add(*terms)) for terms in parts.values()) > -TUNING.bounded


def _least(e: Any) -> float:
    """A lower bound of an expression; of a polynomial in one symbol, the least value."""
    import numpy as np

    low, _ = bounds_of(e)
    if low == -math.inf and len(e.free_symbols) == 1 and e.is_polynomial(*e.free_symbols):
        polynomial = sympy.Poly(e, *e.free_symbols)
        if polynomial.degree() % 2 == 0 and polynomial.LC() > 0 and not polynomial.is_ground:
            turns = np.roots([float(k) for k in polynomial.diff().all_coeffs()]).real
            return min(float(e.subs(polynomial.gen, sympy.Float(x, 30))) for x in turns)
    return low


def _as_a_whole(g: Any) -> tuple[Any, int]:
    """A sum without the factors of all its terms that vanish nowhere."""
    together = sympy.factor_terms(g)
    if together.is_Mul and not all(f.is_Number or f.is_Add for f in together.args):
        core, way = _without_factors(together)
        if core != together:
            return core, way
    return g, 1


def _without_factors(product: Any) -> tuple[Any, int]:
    """A product without its number and the factors that vanish nowhere, and of the others what they vanish with.

    If all that this takes away is the number, it stays as it is.
    """
    number, rest = product.as_coeff_Mul()
    factors = sympy.Mul.make_args(rest)
    signs = [sign_of(factor) for factor in factors]
    left = [stripped(factor) for factor, sign in zip(factors, signs, strict=True) if sign == 0]
    core = sympy.Mul(*(one for one, _ in left))
    if not left or core == rest:
        return product, 1
    return core, math.prod([*filter(None, signs), *(way for _, way in left), 1 if number > 0 else -1])


def ratio(a: Any, b: Any) -> float | None:
    """The number a/b, up to the rounding of constants; None if a/b depends on symbols."""
    mine, others = a.as_coefficients_dict(), b.as_coefficients_dict()
    if mine.keys() != others.keys():
        return None
    ratios = [float(mine[term] / others[term]) for term in mine]
    first = ratios[0]
    return first if all(abs(r - first) <= TUNING.same_constants * abs(first) for r in ratios) else None


def same_surface(guards: Iterable[Any]) -> bool:
    """Whether all guards provably vanish on one surface."""
    cores = [stripped(guard)[0] for guard in guards]
    return all(ratio(core, cores[0]) is not None for core in cores)

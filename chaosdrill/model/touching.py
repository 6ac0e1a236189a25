"""Kinks that no name tells: roots and inverse functions that touch their branch points, written with Abs and sign.

A root has a kink where its base touches zero without crossing it, as that of 1 - cos(t)**2 does, which is |sin(t)|; so
have asin(g) and acos(g) where 1 - g**2 does, and atan(g) jumps where the tangent in g has a pole. What crosses its
branch point instead, such as the level under the root of a tank, has no kink: the motion ends there.

An expression becomes a quotient of polynomials in what it is made of, the sine and cosine of u in the tangent of u/2.
The square-free decomposition tells how often each factor divides it (Yun 1976, doi:10.1145/800205.806320). Where one
that does so an even number of times changes its sign, the expression touches zero.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial, reduce
from itertools import islice
from numbers import Real
from typing import Any

import sympy
from sympy.polys.polyerrors import BasePolynomialError
from sympy.simplify.fu import TR8

from chaosdrill.model.python import opaque
from chaosdrill.model.special import positive_power
from chaosdrill.model.tuning import TUNING

_CIRCULAR, _HYPERBOLIC = (sympy.sin, sympy.cos, sympy.tan), (sympy.exp, sympy.sinh, sympy.cosh, sympy.tanh)

_HALF = sympy.Rational(1, 2)


@dataclass(frozen=True)
class Fold:
    """A part of an expression with a kink or a jump, where something is zero."""

    part: Any  # as it is written
    instead: Any  # with Abs and sign; None if factors touch together that have nothing in common to be taken out
    where: Any  # what is zero; None if the part has no kink, since it is smooth where its base is zero


def find_fold(
    expression: Any, moving: Iterable[Any], numbers: Mapping[str, float], *, smooth: bool = False
) -> Fold | None:
    """The first part of an expression that has a kink or a jump by what it does.

    ``moving``: states and time. ``numbers``: values of the parameters, at which zeros are looked for. ``smooth``: look
    for the first part, instead, whose base touches zero and which is smooth there.
    """
    moving = frozenset(moving)
    for part in sympy.postorder_traversal(expression):
        if _may_fold(part, moving):
            held = sorted(symbol.name for symbol in part.free_symbols - moving)
            found = _fold(part, moving & part.free_symbols, tuple((one, _number(numbers.get(one))) for one in held))
            if found is not None and (found.where is None) == smooth:
                return found
    return None


def without_smooth_zeros(expression: Any, moving: Iterable[Any], numbers: Mapping[str, float]) -> Any:
    """The expression with powers that are smooth where their bases are zero, as ``sqrt(x**4)``, taken out of roots."""
    for _ in range(TUNING.passes):
        fold = find_fold(expression, moving, numbers, smooth=True)
        if fold is None:
            break
        expression = expression.xreplace({fold.part: fold.instead})
    return expression


def unfolded(expression: Any, moving: Iterable[Any], numbers: Mapping[str, float]) -> Any:
    """The expression with its kinks and jumps written as ``Abs`` and ``sign``; parameters as for `find_fold`."""
    while (fold := find_fold(expression, moving, numbers)) is not None and fold.instead is not None:
        expression = expression.xreplace({fold.part: fold.instead})
    return expression


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, Real) and math.isfinite(value) else None


def _may_fold(part: Any, moving: frozenset[Any]) -> bool:
    if isinstance(part, sympy.Pow | positive_power):
        base, exponent = part.args
        return bool(base.free_symbols & moving) and not (exponent.is_Integer or exponent.free_symbols & moving)
    return isinstance(part, sympy.asin | sympy.acos | sympy.atan | sympy.Abs) and bool(part.free_symbols & moving)


@lru_cache(maxsize=512)
def _fold(part: Any, moving: frozenset[Any], values: tuple[tuple[str, float | None], ...]) -> Fold | None:
    """The kink or the jump of a part; None if it has none."""
    numbers = {sympy.Symbol(name, real=True): value for name, value in values}
    if isinstance(part, sympy.atan):
        return _arctangent(part, moving, numbers)
    if isinstance(part, sympy.Abs):
        # its kinks are seen by its name
        touched = _touched(part.args[0] ** 2, _HALF, moving, numbers)
        if touched is None or not touched.is_smooth:
            return None
        return Fold(part, touched.root * sympy.sqrt(touched.rest), None)
    if isinstance(part, sympy.asin | sympy.acos):
        g = part.args[0]
        touched = _touched(1 - g**2, _HALF, moving, numbers)
        if touched is None or touched.root is None or touched.is_smooth:
            return None if touched is None or touched.is_smooth else Fold(part, None, touched.where)
        angle = 2 * sympy.atan(g / (1 + sympy.Abs(touched.root) * sympy.sqrt(touched.rest)))
        return Fold(part, angle if isinstance(part, sympy.asin) else sympy.pi / 2 - angle, touched.where)
    base, exponent = part.args[0], exact(part.args[1])
    known = exponent.xreplace({p: sympy.Float(value) for p, value in numbers.items() if value is not None})
    power = exact(known) if known.is_number and known.is_real else sympy.Float(math.pi)
    touched = None if power.is_Integer else _touched(base, power, moving, numbers)
    if touched is None or touched.root is None:
        return None if touched is None else Fold(part, None, touched.where)
    if touched.is_smooth:
        return Fold(part, touched.root * part.func(touched.rest, exponent), None)
    return Fold(part, sympy.Abs(touched.root) ** (2 * exponent) * part.func(touched.rest, exponent), touched.where)


def _arctangent(part: Any, moving: frozenset[Any], numbers: Mapping[Any, Any]) -> Fold | None:
    """The jump of an arc tangent where the periodic denominator of its argument changes its sign; None if it does not.

    That of n/d is the angle of (d, n) on one side, that of (-d, -n) on the other. A denominator that states enter
    otherwise may be a length, which is never zero.
    """
    quotient = part.args[0].replace(sympy.tan, lambda angle: sympy.sin(angle) / sympy.cos(angle))
    n, d = sympy.fraction(sympy.together(quotient))
    waves = {wave: sympy.Dummy() for wave in d.atoms(sympy.sin, sympy.cos) if wave.free_symbols & moving}
    if not waves or d.xreplace(waves).free_symbols & moving or not _touches(d, n**2, 2, moving, numbers):
        return None
    angle = sympy.sign(d) * n / (sympy.Abs(d) + sympy.sqrt(_shortest(d**2 + n**2)))
    return Fold(part, 2 * sympy.atan(angle), d)


@dataclass(frozen=True)
class _Touched:
    """A base that touches zero from above: where, and what it is the square of but for the rest, if anything."""

    where: Any
    root: Any
    rest: Any
    is_smooth: bool = False
    """Whether the root is that of the power, which has no kink, instead."""


def _touched(base: Any, power: Any, moving: frozenset[Any], numbers: Mapping[Any, Any]) -> _Touched | None:
    """Where a base touches zero from above so that its power is not smooth; None if nowhere."""
    found = _decomposed(base)
    if found is None:
        return None
    constant, factors = found
    root, rest, folds, smooth = sympy.Integer(1), constant, False, sympy.Integer(1)
    for factor, times in factors.items():
        others = constant * sympy.Mul(*(f**m for f, m in factors.items() if f != factor))
        alone = times % 2 and not others.free_symbols & moving
        touches = not alone and _touches(factor, others, times, moving, numbers)
        if touches and times % 2:
            return _Touched(factor, None, None)
        if touches:
            root *= factor ** (times // 2)
            smooth *= factor ** (times * power)
            folds = folds or (times * power) % 2 != 0
        else:
            rest *= factor**times
    if not folds:
        # the run could not pass the zero of the base although nothing happens there
        return _Touched(None, _shortest(smooth), _shortest(rest), True) if smooth != 1 else None
    short = _shortest(root)
    _, where = _content(short)
    return _Touched(where, short, _shortest(rest))


def is_long(expression: Any, most: int = TUNING.decomposed_parts) -> bool:
    """Whether an expression has more parts than a number, without looking at all of them."""
    return next(islice(sympy.preorder_traversal(expression), most, None), None) is not None


def exact(expression: Any) -> Any:
    """An expression whose doubles are the decimal numbers that they are written as."""
    numbers = {number: sympy.Rational(repr(float(number))) for number in expression.atoms(sympy.Float)}
    return expression.xreplace(numbers)


def _shortest(expression: Any) -> Any:
    """A form of an expression that is short enough to be read."""
    if is_long(expression):
        return expression
    units = _units(expression, _CIRCULAR)
    names: dict[Any, Any] = {}
    waves = {}
    for wave in expression.atoms(*_CIRCULAR):
        content, direction = _content(wave.args[0])
        unit = units.get(direction, abs(content))
        # sympy would expand large multiples of an angle in powers
        name = names.setdefault(unit * direction, sympy.Dummy(real=True))
        waves[wave] = wave.func(name * (content / unit))
    back = {name: angle for angle, name in names.items()}
    expanded = sympy.expand(expression.xreplace(waves))
    forms = (e.xreplace(back) for e in (expanded, TR8(expanded), sympy.trigsimp(expanded)))
    return min(expression, *forms, key=lambda e: (len(e.atoms(*_CIRCULAR)), sympy.count_ops(e)))


def _units(expression: Any, kinds: tuple[Any, ...]) -> dict[Any, Any]:
    """By the direction of angles, or exponents: of what all are small whole multiples, where there is such a thing."""
    found: dict[Any, list[Any]] = {}
    for wave in expression.atoms(*kinds):
        content, direction = _content(wave.args[0])
        found.setdefault(direction, []).append(abs(content))
    units = {direction: reduce(sympy.gcd, contents) for direction, contents in found.items()}
    return {direction: unit for direction, unit in units.items() if max(found[direction]) <= TUNING.turns * unit}


@dataclass
class _Variables:
    """Of what polynomials are made."""

    meant: dict[Any, Any] = field(default_factory=dict)  # what each variable stands for
    halves: dict[Any, tuple[Any, Any]] = field(default_factory=dict)
    """Variables that stand for the tangent of half an angle, with its sine and its cosine."""
    radical: Any = None  # a root of a number, which is kept; others are variables
    _of: dict[Any, Any] = field(default_factory=dict)
    _units: dict[tuple[Any, ...], dict[Any, Any]] = field(default_factory=dict)

    @property
    def listed(self) -> list[Any]:
        """The variables in the order of their first use."""
        return list(self._of.values())

    def read_angles(self, expression: Any) -> None:
        """Find of what the angles, and the exponents, are multiples."""
        for kinds in (_CIRCULAR, _HYPERBOLIC):
            self._units[kinds] = _units(expression, kinds)

    def put(self, e: Any) -> Any:
        """An expression in variables; raises `BasePolynomialError` if it has powers that are too high."""
        if e.is_Rational:
            return e
        if e.is_Add or e.is_Mul:
            return e.func(*map(self.put, e.args))
        if e.is_Pow and e.exp.is_Integer:
            if abs(e.exp) > 2 * TUNING.turns:
                raise BasePolynomialError
            return self.put(e.base) ** e.exp
        if e.is_Pow and e.exp.is_Rational:
            if e.is_number and e.is_algebraic and e.is_real and (self.radical or e) == e:
                self.radical = e
                return e
            return self.variable(e.base ** sympy.Rational(1, e.exp.q)) ** e.exp.p
        if isinstance(e, _CIRCULAR):
            return self._circular(e)
        if isinstance(e, _HYPERBOLIC):
            return self._hyperbolic(e)
        return self.variable(e)

    def variable(self, meaning: Any) -> Any:
        """The variable that stands for an expression."""
        if meaning not in self._of:
            self._of[meaning] = one = sympy.Dummy(real=True)
            self.meant[one] = meaning
        return self._of[meaning]

    def _multiple(self, kinds: tuple[Any, ...], angle: Any) -> tuple[Any, int]:
        """The unit of an angle, and how many of them it is."""
        content, direction = _content(angle)
        unit = self._units[kinds].get(direction, abs(content))
        return unit * direction, int(content / unit)

    def _circular(self, wave: Any) -> Any:
        unit, turns = self._multiple(_CIRCULAR, wave.args[0])
        half = self.variable(sympy.tan(unit / 2))
        self.halves[half] = sympy.sin(unit / 2), sympy.cos(unit / 2)
        # cos + i sin of the angle is (1 + i T)^(2 turns) by its modulus
        turned = [math.comb(2 * abs(turns), k) * half**k for k in range(2 * abs(turns) + 1)]
        cosine = sum((one * (-1) ** (k // 2) for k, one in enumerate(turned) if k % 2 == 0), sympy.Integer(0))
        sine = sum((one * (-1) ** (k // 2) for k, one in enumerate(turned) if k % 2 == 1), sympy.Integer(0))
        sine = sine if turns > 0 else -sine
        if isinstance(wave, sympy.tan):
            return sine / cosine
        return (sine if isinstance(wave, sympy.sin) else cosine) / (1 + half**2) ** abs(turns)

    def _hyperbolic(self, wave: Any) -> Any:
        unit, turns = self._multiple(_HYPERBOLIC, wave.args[0])
        grown = self.variable(sympy.exp(unit)) ** turns
        if isinstance(wave, sympy.exp):
            return grown
        if isinstance(wave, sympy.tanh):
            return (grown**2 - 1) / (grown**2 + 1)
        return (grown + (1 if isinstance(wave, sympy.cosh) else -1) / grown) / 2


def _content(angle: Any) -> tuple[Any, Any]:
    """A number, and what an angle is a multiple of by it."""
    count = len(angle.atoms(sympy.Symbol, sympy.Function))
    if math.comb(degree_bound(angle) + count, count) > TUNING.terms:
        return sympy.Integer(1), angle
    content, direction = sympy.expand(angle).as_content_primitive()
    return (-content, -direction) if direction.could_extract_minus_sign() else (content, direction)


def _decomposed(expression: Any) -> tuple[Any, dict[Any, int]] | None:
    """The constant of an expression, and its square-free factors with their powers; None if it is too large.

    Sines and cosines of half the angles take the place of their tangents, so that no factor has a pole.
    """
    if is_long(expression):
        return None
    decimal, variables = exact(expression), _Variables()
    variables.read_angles(decimal)
    try:
        top, bottom = sympy.fraction(sympy.together(variables.put(decimal)))
        names = variables.listed
        if not names or any(math.comb(degree_bound(e) + len(names), len(names)) > TUNING.terms for e in (top, bottom)):
            return None
        roots = None if variables.radical is None else [variables.radical]
        lists = [(_factors(sympy.Poly(e, *names, extension=roots)), way) for e, way in ((top, 1), (bottom, -1))]
    except (BasePolynomialError, NotImplementedError):
        return None
    constant: Any = sympy.Integer(1)
    factors: dict[Any, int] = {}
    for (number, found), way in lists:
        constant *= number**way
        for factor, times in found:
            whole = factor.as_expr()
            for half, (sine, cosine) in variables.halves.items():
                whole, degree = _homogeneous(whole, half, sine, cosine)
                factors[cosine] = factors.get(cosine, 0) - way * times * degree
            whole = whole.xreplace(variables.meant)
            factors[whole] = factors.get(whole, 0) + way * times
    constant *= sympy.Mul(*(f**times for f, times in factors.items() if not f.free_symbols))
    return constant, {f: times for f, times in factors.items() if times and f.free_symbols}


def _factors(poly: Any) -> tuple[Any, list[tuple[Any, int]]]:
    """The constant of a polynomial and its factors with their powers: irreducible ones, if it is small."""
    constant, squares = poly.sqf_list()
    found: list[tuple[Any, int]] = []
    for one, times in squares:
        if one.total_degree() > TUNING.degree:
            found.append((one, times))
            continue
        number, parts = one.factor_list()
        constant *= number**times
        found += [(part, times * again) for part, again in parts]
    return constant, found


def _homogeneous(factor: Any, half: Any, sine: Any, cosine: Any) -> tuple[Any, int]:
    """A polynomial in the tangent of half an angle times a power of its cosine, and that power."""
    poly = sympy.Poly(factor, half)
    degree, one = poly.degree(), sympy.Poly(1 + half**2, half)
    while poly.degree() >= 2 and poly.rem(one).is_zero:
        poly = poly.quo(one)
    highest = poly.degree()
    terms = (a * sine**k * cosine ** (highest - k) for (k,), a in poly.terms())
    return sympy.Add(*terms), int(degree)


def degree_bound(e: Any) -> int:
    """A bound of the degree of a polynomial that is not multiplied out, and of those inside of its functions."""
    if e.is_Mul:
        return sum(map(degree_bound, e.args))
    if e.is_Pow and e.exp.is_Integer:
        return abs(int(e.exp)) * degree_bound(e.base)
    return max(map(degree_bound, e.args), default=int(e.is_Symbol))


def _touches(factor: Any, others: Any, times: int, moving: frozenset[Any], numbers: Mapping[Any, Any]) -> bool:
    """Whether a factor changes its sign somewhere where factor**times * others is above zero on both sides."""
    import numpy as np

    unknown = {call: sympy.Dummy(real=True) for call in opaque(factor) | opaque(others)}
    both = [e.xreplace(unknown) for e in (factor, others)]
    names = sorted(set().union(*(e.free_symbols for e in both)), key=lambda s: (s in moving, s.name))
    function = sympy.lambdify(names, both, modules="numpy", dummify=True)
    rng = np.random.default_rng(20260301)
    shape, most = (TUNING.draws, 1), TUNING.drawn_decades
    drawn = {s: rng.choice([-1.0, 1.0], shape) * 10.0 ** rng.uniform(-most, most, shape) for s in names}
    for s in drawn.keys() & moving:
        drawn[s][0] = 0.0
    drawn |= {s: np.full(shape, value) for s, value in numbers.items() if value is not None}
    # no round number, at which a factor might be zero
    count = TUNING.decades * TUNING.each_decade
    ways = TUNING.off_round * 10.0 ** (np.arange(-count, count + 1) / TUNING.each_decade)
    line = np.broadcast_to(np.concatenate([-ways[::-1], ways]), (TUNING.draws, 2 * len(ways)))
    for x in sorted(both[0].free_symbols & moving, key=lambda s: s.name):

        def at(places: Any, fixed: dict[Any, Any], x: Any = x) -> Any:
            given = [places if name == x else fixed[name] for name in names]
            with np.errstate(all="ignore"):
                rows = [np.broadcast_to(np.asarray(row, dtype=complex), places.shape) for row in function(*given)]
            return np.array([np.where(row.imag == 0, row.real, np.nan) for row in rows])

        changes = [(i, *change) for i, height in enumerate(at(line, drawn)[0]) for change in _changes(height)]
        if not changes:
            continue
        rows, begin, end, sign = np.array(changes).T
        fixed = {s: np.broadcast_to(value, shape)[rows, 0] for s, value in drawn.items()}
        left, right = line[rows, begin], line[rows, end]
        for _ in range(TUNING.halvings):
            middle = (left + right) / 2
            stays = np.sign(at(middle, fixed)[0]) == sign
            left, right = np.where(stays, middle, left), np.where(stays, right, middle)
        if times % 2 == 0:
            touches = [at(end, fixed)[1] > 0 for end in (left, right)]
        else:
            touches = _together(partial(at, fixed=fixed), left, right)
        if np.all(touches, axis=0).any():
            return True
    return False


def _together(at: Callable[[Any], Any], left: Any, right: Any) -> Any:
    """Whether others change their sign where a factor does, to one that agrees with it on the left and on the right.

    ``at``: values of the factor and of the others, shape (2, N), at N places. ``left``, ``right``: places next to where
    the factor changes its sign, shape (N,), as both answers have it.
    """
    import numpy as np

    size = np.maximum(np.abs(left), np.abs(right))
    # from a zero at zero there is no unit, so that all are tried; rounding hides what is next to it
    at_zero = np.sign(left) * np.sign(right) <= 0
    steps = [np.where(at_zero, near, TUNING.zeros_together * size) for near in TUNING.zeros_at_zero]
    found = []
    for place, way in ((left, -1), (right, 1)):
        agrees, differs = np.zeros(len(left), dtype=bool), np.zeros(len(left), dtype=bool)
        for step in steps:
            heights, beside = np.array([at(place + way * step * part) for part in TUNING.straight_parts]).swapaxes(0, 1)
            # only where the factor is a straight line are the two known to have one zero there
            with np.errstate(all="ignore"):
                slopes = heights / (heights[0] * np.array(TUNING.straight_parts)[:, np.newaxis])
            straight = (np.abs(slopes - 1) < TUNING.straight).all(axis=0)
            product = np.sign(heights * beside)
            differs |= straight & (product < 0).any(axis=0)
            agrees |= straight & (product > 0).all(axis=0) & ~differs
        found.append(agrees & ~differs)
    return found


def _changes(height: Any) -> Iterator[tuple[int, int, int]]:
    """Between which places the numbers of a row change their sign, and the sign before; zeros between them count as
    none, and no change is seen beyond what is no number.
    """
    before = None
    for k, value in enumerate(height.tolist()):
        if not math.isfinite(value):
            before = None
        elif value != 0:
            sign = 1 if value > 0 else -1
            if before is not None and before[1] != sign:
                yield before[0], k, before[1]
            before = k, sign

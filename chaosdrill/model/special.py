"""Special functions of contact laws and of gates, as sympy functions that know their derivatives.

With G(v) = v/lam - ln(1 + lam v)/lam^2 a Hunt-Crossley contact d'' = -k d^n (1 + lam d') keeps G(d') + k d^(n+1)/(n+1),
so G(exit) = G(entry) whatever k, n and the masses are. Source: Hunt and Crossley 1975, doi:10.1115/1.3423596.

Gates, softplus functions and the rates of ion channels are finite where the exponentials that they are written with are
not, or at a place where both sides of a quotient are zero; their derivatives are made of such functions again.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import sympy
from sympy.core.function import ArgumentIndexError

FLOW, RESET, CONDITION = range(3)
"""What may hold a function: rates, guards and quadratures need a Taylor series, resets a derivative, conditions a
value; each may hold all that those before it may."""


class WithSlopes(sympy.Function):
    """A function that knows its derivatives, by the first of its arguments or by all."""

    def slopes(self) -> tuple[Any, ...]:
        """The derivatives, in the order of the arguments."""
        raise NotImplementedError

    def fdiff(self, argindex: int = 1) -> Any:
        """Derivative by an argument, counted from 1."""
        known = self.slopes()
        if not 1 <= argindex <= len(known):
            raise ArgumentIndexError(self, argindex)
        return known[argindex - 1]


class hunt_crossley_exit(WithSlopes):
    """Exit speed s(v, lam) > 0 of a contact entered at speed v, with damping constant lam (1/speed).

    s = [1 + W0(-(1 + lam v) exp(-(1 + lam v)))] / lam, with W0 the principal Lambert branch.
    """

    nargs = 2

    def slopes(self) -> tuple[Any, ...]:
        """By v (closed form in s itself) and by lam (the similarity s(v, lam) = S(lam v)/lam)."""
        v, lam = self.args
        return v / (1 + lam * v) * (1 - lam * self) / self, hunt_crossley_exit_lam(v, lam)


class hunt_crossley_exit_lam(sympy.Function):
    """Derivative of the exit speed by lam: (v ds/dv - s)/lam, about -(2/3) v^2 where lam v is small."""

    nargs = 2


class hunt_crossley_peak(sympy.Function):
    """Peak of k d^n (1 + lam d') over a contact entered at speed v; for conditions only, it has no derivative.

    A force per unit of relative mass where k is a stiffness per unit of relative mass. It is reached where
    n d' = lam (n + 1) (G(v) - G(d')), before the greatest depth.
    """

    nargs = 4


class hunt_crossley_duration(WithSlopes):
    """Duration of the contact d'' = -k d^n (1 + lam d') entered at speed v: arguments v, lam, n, k.

    A time where k is a stiffness per unit of relative mass. It is k^(-1/(n + 1)) v^((1 - n)/(1 + n)) f(lam v, n), so
    that its derivative by v consists of the function itself and of that by lam. The derivative changes its sign;
    written like this, the bound of its rounding sees the two cancel.
    """

    nargs = 4

    def slopes(self) -> tuple[Any, ...]:
        """By v, lam, n (integrals of their own) and k (the power -1/(n + 1))."""
        return _by_all(self, 0, hunt_crossley_duration_lam, hunt_crossley_duration_n)


class hunt_crossley_duration_lam(WithSlopes):
    """Derivative of the duration by the damping constant."""

    nargs = 4

    def slopes(self) -> tuple[Any, ...]:
        """By v, lam, n and k."""
        return _by_all(self, 1, hunt_crossley_duration_lam_lam, hunt_crossley_duration_lam_n)


class hunt_crossley_duration_n(sympy.Function):
    """Derivative of the duration by the exponent."""

    nargs = 4


class hunt_crossley_duration_lam_lam(sympy.Function):
    """Second derivative of the duration by the damping constant."""

    nargs = 4


class hunt_crossley_duration_lam_n(sympy.Function):
    """Derivative of the duration by the damping constant and the exponent."""

    nargs = 4


def _by_all(function: Any, order: int, of_lam: Any, of_n: Any) -> tuple[Any, ...]:
    """Derivatives of the duration's derivative of this order by lam, by its similarity."""
    v, lam, n, k = function.args
    by_lam = of_lam(v, lam, n, k)
    by_v = (((1 - n) / (1 + n) + order) * function + lam * by_lam) / v
    return by_v, by_lam, of_n(v, lam, n, k), -function / ((n + 1) * k)


class positive_power(WithSlopes):
    """max(d, 0)^n, a force that pushes and never pulls, with its derivative n max(d, 0)^(n - 1).

    It is for modes that hold while d >= 0: with a whole number n >= 0, written 2 or 2.0, it is the polynomial d^n,
    which is analytic through d = 0. A parameter whose value is whole counts as one in compiled code.
    """

    nargs = 2

    @classmethod
    def eval(cls, d: Any, n: Any) -> Any:
        """d^n for whole n >= 0."""
        whole = sympy.Integer(int(n)) if n.is_Float and float(n).is_integer() else n
        return d**whole if whole.is_Integer and whole >= 0 else None

    def slopes(self) -> tuple[Any, ...]:
        """By d and by n; the logarithm in the latter wants d > 0."""
        d, n = self.args
        return n * positive_power(d, n - 1), self * sympy.log(d)


class WithFormula(WithSlopes):
    """A function of `gates`, with its value in many digits and in numpy by a formula of other functions."""

    def formula(self) -> Any:
        """What it is, written so that exponentials overflow in divisors alone."""
        raise NotImplementedError

    def _eval_evalf(self, prec: int) -> Any:
        value = self.formula()
        # some digits cancel where it is small
        return value if value.has(sympy.nan, sympy.zoo) else value.evalf(2 * prec // 3)

    def _numpycode(self, printer: Any) -> Any:
        # whatever stands around it takes it for one function
        return f"({printer._print(self.formula())})"


class gate(WithFormula):
    """exp(e)/(m + n exp(u)): arguments m, n, u, e. It has a pole where m + n exp(u) is zero."""

    nargs = 4

    def formula(self) -> Any:
        """One over a sum."""
        m, n, u, e = self.args
        return 1 / (m * sympy.exp(-e) + n * sympy.exp(u - e))

    @classmethod
    def eval(cls, m: Any, n: Any, u: Any, e: Any) -> Any:
        """What it is at a pole, where one term is zero, or as a logistic function; exp(u) above goes below."""
        if u.is_zero and (m + n).is_zero:
            return sympy.zoo
        if m.is_zero:
            return sympy.exp(e - u) / n
        if n.is_zero:
            return sympy.exp(e) / m
        if e == u != 0:
            # of two slopes, by u and by e, nearly nothing would be left far out
            return gate(n, m, -u, sympy.S.Zero)
        if m.is_positive and n.is_positive and m.is_number and n.is_number and e == 0:
            return 1 / (m * (1 + sympy.exp(u + exact_logarithm(n, m))))
        return None

    def slopes(self) -> tuple[Any, ...]:
        """By m, n, u and e."""
        m, n, u, _ = self.args
        return -self * gate(m, n, u, sympy.S.Zero), -self * gate(m, n, u, u), -n * self * gate(m, n, u, u), self


class log_sum(WithFormula):
    """log(m + n exp(u)): arguments m, n, u. With m = n = 1 it is softplus."""

    nargs = 3

    def formula(self) -> Any:
        """The larger of both exponents, and the rest."""
        m, n, u = self.args
        most = sympy.Max(u, 0)
        return most + sympy.log(m * sympy.exp(-most) + n * sympy.exp(u - most))

    @classmethod
    def eval(cls, m: Any, n: Any, u: Any) -> Any:
        """What it is where one term is zero."""
        if m.is_zero:
            return sympy.log(n) + u
        return sympy.log(m) if n.is_zero else None

    def slopes(self) -> tuple[Any, ...]:
        """By m, n and u."""
        m, n, u = self.args
        return gate(m, n, u, sympy.S.Zero), gate(m, n, u, u), n * gate(m, n, u, u)


class log_cosh(WithFormula):
    """log(cosh(u)), which is finite where cosh is not."""

    nargs = 1
    is_nonnegative = True

    @classmethod
    def eval(cls, u: Any) -> Any:
        """0 at 0."""
        return sympy.S.Zero if u.is_zero else None

    def formula(self) -> Any:
        """The size of u, and the rest."""
        size = sympy.Abs(self.args[0])
        return size + sympy.log(1 + sympy.exp(-2 * size)) - sympy.log(2)

    def slopes(self) -> tuple[Any, ...]:
        """tanh(u)."""
        return (sympy.tanh(self.args[0]),)


class bernoulli_ratio(WithFormula):
    """Derivative of an order of u exp(s u)/(exp(u) - 1) by u: arguments u, s (0, 1/2 or 1), order.

    It is analytic at 0, where the quotient is 1, and generates the Bernoulli polynomials of s (Abramowitz and Stegun,
    23.1.1). With s = 0 it is the rate of an ion channel, u/(exp(u) - 1); with s = 1 that of -u; with s = 1/2 it is
    (u/2)/sinh(u/2).
    """

    nargs = 3

    def formula(self) -> Any:
        """The quotient's derivative, no number at 0."""
        u, s, order = self.args
        v = sympy.Dummy(real=True)
        return sympy.diff(v * sympy.exp(s * v) / (sympy.exp(v) - 1), v, order).subs(v, u)

    @classmethod
    def eval(cls, u: Any, s: Any, order: Any) -> Any:
        """A number of Bernoulli's at 0."""
        return sympy.bernoulli(order, s) if u.is_zero and s.is_Number and order.is_Integer else None

    def slopes(self) -> tuple[Any, ...]:
        """By u."""
        u, s, order = self.args
        return (bernoulli_ratio(u, s, order + 1),)


_U = sympy.Dummy("u", real=True)


def log1p(u: Any) -> Any:
    """log(1 + u)."""
    return sympy.log(1 + u)


RESTS: tuple[Any, ...] = (
    *(sympy.exp, sympy.sin, sympy.cos, sympy.sinh, sympy.cosh, log1p),
    *(sympy.asin, sympy.atan, sympy.asinh, sympy.atanh, sympy.tanh, log_cosh),
)
"""Functions of `taylor_rest`, by their numbers."""


class _Rest(WithFormula):
    """What the first terms of its Taylor series leave of a function, over a power: (g(u) - sum of c_p u^p, p < m)/u^m.

    Arguments u, what tells g, m from 1 to 4, and the order of a derivative by u.
    """

    nargs = 4

    @classmethod
    def of(cls, told: Any, u: Any) -> Any:
        """g(u)."""
        raise NotImplementedError

    @classmethod
    def term(cls, told: Any, p: int) -> Any:
        """Coefficient c_p."""
        raise NotImplementedError

    def whole(self) -> Any:
        """g at its argument."""
        return self.of(self.args[1], self.args[0])

    def formula(self) -> Any:
        """The quotient's derivative, no number at 0."""
        u, told, m, order = self.args
        first = sympy.Add(*(self.term(told, p) * _U**p for p in range(int(m))))
        return sympy.diff((self.of(told, _U) - first) / _U**m, _U, order).subs(_U, u)

    @classmethod
    def eval(cls, u: Any, told: Any, m: Any, order: Any) -> Any:
        """A term of the series at 0."""
        if u.is_zero and m.is_Integer and order.is_Integer:
            return cls.term(told, int(m + order)) * sympy.factorial(order)
        return None

    def slopes(self) -> tuple[Any, ...]:
        """By u."""
        u, told, m, order = self.args
        return (self.func(u, told, m, order + 1),)


class taylor_rest(_Rest):
    """What the first m terms of its Taylor series leave of a function, over u^m, or a derivative of that.

    Arguments u, the number of the function in `RESTS`, m from 1 to 4, and the order of the derivative. It is analytic
    at 0; with the number 1, of sin, and m = 1 it is sin(u)/u.
    """

    @classmethod
    def of(cls, told: Any, u: Any) -> Any:
        """g(u)."""
        return RESTS[int(told)](u)

    @classmethod
    @cache
    def term(cls, told: Any, p: int) -> Any:
        """Coefficient c_p."""
        if RESTS[int(told)] is log_cosh:
            return cls.term(RESTS.index(sympy.tanh), p - 1) / p if p else sympy.S.Zero
        return cls.of(told, _U).diff(_U, p).subs(_U, 0) / sympy.factorial(p)


class power_rest(_Rest):
    """The same for (1 + u)^a: arguments u, a, m from 1 to 4, and the order of a derivative by u."""

    @classmethod
    def of(cls, told: Any, u: Any) -> Any:
        """(1 + u)^a."""
        return (1 + u) ** told

    @classmethod
    def term(cls, told: Any, p: int) -> Any:
        """Coefficient c_p."""
        return sympy.ff(told, p) / sympy.factorial(p)


class even_rest(_Rest):
    """The same for a `taylor_rest` that is even in u, with the square s of u as argument.

    Arguments s >= 0, the number of the function, m from 0 to 4 such that the terms that are left are even, and the
    order of a derivative by s. With the number 1, of sin, and m = 1 it is sin(r)/r for s = x^2 + y^2, r its root:
    analytic at s = 0, where r is not.
    """

    @classmethod
    def of(cls, told: Any, u: Any) -> Any:
        """g(u) of the root u."""
        return taylor_rest.of(told, u)

    @classmethod
    def term(cls, told: Any, p: int) -> Any:
        """Coefficient c_p."""
        return taylor_rest.term(told, p)

    def whole(self) -> Any:
        """g at the root of its argument."""
        return self.of(self.args[1], sympy.sqrt(self.args[0]))

    def formula(self) -> Any:
        """The quotient's derivative, no number at 0."""
        s, told, m, order = self.args
        v = sympy.Dummy("v", positive=True)
        return sympy.diff(taylor_rest(sympy.sqrt(v), told, m, 0).formula(), v, order).subs(v, s)

    @classmethod
    def eval(cls, s: Any, told: Any, m: Any, order: Any) -> Any:
        """A term of the series at 0."""
        if s.is_zero and m.is_Integer and order.is_Integer:
            return cls.term(told, int(m + 2 * order)) * sympy.factorial(order)
        return None


def exact_logarithm(above: Any, below: Any) -> Any:
    """Logarithm of the quotient of two positive numbers as the rational number that is a double.

    Other numbers are taken out of an exponential by sympy.
    """
    return sympy.S.Zero if above == below else sympy.Rational(float(sympy.log(above) - sympy.log(below)))


class random_uniform(sympy.Function):
    """A number between 0 and 1, both excluded, drawn for a seed and a place in its sequence, two whole numbers.

    The same arguments give the same number everywhere: it is output ``index`` of the generator SplitMix64 at this seed
    (Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195), of which the leading 52 bits count. What is drawn depends
    on no state, so that its derivatives are zero.
    """

    nargs = 2
    is_positive = True

    def fdiff(self, argindex: int = 1) -> Any:
        """Zero."""
        return sympy.Integer(0)


@dataclass(frozen=True)
class Special:
    """Properties of one special function: how it is made, and the largest relative error of its code.

    ``moving``: arguments, from 0, that may move in rates, guards and quadratures, as the function has a Taylor series
    in them; the others may be parameters there. ``expanded``: whether its code gives its Taylor coefficients at a
    point, which are composed with the series of its first argument; otherwise the derivatives by what moves are
    operations on the arguments and on the function itself. ``relative``: whether these are coefficients by powers of
    the argument's relative change; otherwise by those of its change.
    """

    make: Any
    error: float
    moving: tuple[int, ...] = ()
    expanded: bool = False
    relative: bool = True

    @property
    def level(self) -> int:
        """Where it may stand if its arguments hold states or time."""
        known = {"slopes", "fdiff"} & vars(self.make).keys()
        return FLOW if self.moving else RESET if known else CONDITION


SPECIAL: dict[str, Special] = {
    special.make.__name__: special
    for special in (
        Special(hunt_crossley_exit, 5e-16, moving=(0,)),
        Special(hunt_crossley_exit_lam, 1e-14),
        Special(hunt_crossley_peak, 1e-14),
        Special(hunt_crossley_duration, 1e-12, moving=(0,), expanded=True),
        Special(hunt_crossley_duration_lam, 1e-11),
        Special(hunt_crossley_duration_n, 1e-11),
        Special(hunt_crossley_duration_lam_lam, 1e-11),
        Special(hunt_crossley_duration_lam_n, 1e-11),
        Special(positive_power, 2e-16, moving=(0,)),
        Special(gate, 2e-15, moving=(0, 1, 2, 3)),
        Special(log_sum, 5e-16, moving=(0, 1, 2)),
        Special(log_cosh, 5e-16, moving=(0,)),
        Special(bernoulli_ratio, 2e-15, moving=(0,), expanded=True, relative=False),
        Special(taylor_rest, 4e-15, moving=(0,), expanded=True, relative=False),
        Special(power_rest, 4e-15, moving=(0,), expanded=True, relative=False),
        Special(even_rest, 4e-15, moving=(0,), expanded=True, relative=False),
        Special(random_uniform, 0.0),
    )
}
"""The special functions by name; their code is `chaosdrill.codegen.special`."""

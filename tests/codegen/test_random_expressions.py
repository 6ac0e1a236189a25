"""Property: the series of any expression that can be written solves its differential equation.

Random expressions in the grammar of operations and functions.
"""

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.model.crossings import crossings, stripped

X, Y, T, P, W = SYMBOLS = sympy.symbols("x y t p w", real=True)
NUMBERS = {"p": 0.8, "w": 1.9}
ORDER = 11

ATOMS = st.sampled_from([X, Y, T, P, W, X, Y, sympy.Rational(1, 3), sympy.Integer(2), sympy.cos(W * T), X / 2])
# arguments are kept where the functions are analytic at unit distance
UNARY = [
    *(sympy.sin, sympy.cos, sympy.tanh, sympy.atan, sympy.asinh),
    *(lambda a: sympy.exp(-(a**2)), lambda a: sympy.log(2 + a**2), lambda a: sympy.sqrt(1 + a**2)),
    *(lambda a: 1 / (2 + sympy.sin(a)), lambda a: sympy.asin(sympy.sin(a) / 2), lambda a: (3 + sympy.cos(a)) ** P),
    *(
        lambda a: a**2,
        lambda a: a**3,
        lambda a: -a,
        lambda a: sympy.tan(sympy.sin(a)),
        lambda a: sympy.sinh(sympy.cos(a)),
    ),
]


def grow(children):
    pair = st.tuples(children, children)
    return st.one_of(
        pair.map(lambda ab: ab[0] + ab[1]),
        pair.map(lambda ab: ab[0] * ab[1]),
        pair.map(lambda ab: ab[0] - 2 * ab[1]),
        pair.map(lambda ab: ab[0] / (2 + ab[1] ** 2)),
        st.tuples(st.sampled_from(UNARY), children).map(lambda fa: fa[0](fa[1])),
    )


EXPRESSIONS = st.recursive(ATOMS, grow, max_leaves=6)
PLACES = st.tuples(*[st.floats(-1.5, 1.5).map(lambda v: round(v, 3)) for _ in range(2)])


# no shrinking: every example builds a system, and the failing one is printed anyway
@settings(
    max_examples=20,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(f=EXPRESSIONS, g=EXPRESSIONS, place=PLACES, t=st.floats(0, 3).map(lambda v: round(v, 3)))
def test_the_series_solves_the_equation(f, g, place, t, numeric, coefficients, polynomial, agree):
    f, g = sympy.sympify(f), sympy.sympify(g)
    assume(not f.has(sympy.Abs, sympy.sign) and not g.has(sympy.Abs, sympy.sign))
    assume(g.free_symbols & {X, Y, T})
    system = cd.HybridSystem(
        name="random",
        states=(X, Y),
        time=T,
        parameters=NUMBERS,
        modes={"on": {X: f, Y: X * Y - f}},
        transitions=[cd.Transition("event", "on", "on", guard=g, direction=+1)],
    )
    # a guard that is read in another writing may have another surface, with the same zeros
    assume(crossings(system.transitions)[0].surface == stripped(g)[0])
    kernels = kernels_of(system)
    jet, jacobian_jet, tangent = kernels.functions[:3]
    c = kernels.constants(NUMBERS)
    ws = np.full((kernels.layout.rows + 4, COLUMNS), np.nan)
    jet(0, ORDER, t, c, np.array(place), ws)
    assume(np.abs(ws[:3, : ORDER + 1]).max() < 1e12)
    jacobian_jet(0, ORDER, c, ws)
    tangent(0, ORDER, c, np.array([1.0, 0.5]), np.array([-0.3, 1.0]), ws, kernels.layout.rows)

    x, y = (polynomial(ws[i, : ORDER + 1]) for i in (0, 1))
    dx, dy = (polynomial(ws[kernels.layout.rows + i, : ORDER + 1]) for i in (0, 1))
    rate, guard = (numeric(SYMBOLS, e) for e in (f, stripped(g)[0]))
    p, w = (mpmath.mpf(v) for v in NUMBERS.values())
    tiny = mpmath.mpf("1e-40")

    def at(function, s, shift=0):
        return function(x(s) + shift * dx(s), y(s) + shift * dy(s), mpmath.mpf(t) + s, p, w)

    derivative = coefficients(lambda s: at(rate, s), ORDER)
    states = ws[:2, : ORDER + 1]
    agree(ws[0, : ORDER + 1], [place[0], *(derivative[k] / (k + 1) for k in range(ORDER))], 1e-13, beside=states)
    agree(ws[2, : ORDER + 1], coefficients(lambda s: at(guard, s), ORDER), 1e-12, beside=states)
    along = coefficients(lambda s: (at(rate, s, tiny) - at(rate, s, -tiny)) / (2 * tiny), ORDER)
    vector = ws[kernels.layout.rows : kernels.layout.rows + 2, : ORDER + 1]
    agree(vector[0], [1.0, *(along[k] / (k + 1) for k in range(ORDER))], 1e-12, beside=[*states, *vector])


def test_the_property_can_fail(numeric, coefficients, polynomial, agree):
    """A series with one coefficient off by a part in 1e10 does not pass."""
    kernels = kernels_of(cd.HybridSystem(name="e", states=(X,), parameters={}, modes={"on": {X: X}}))
    ws = np.zeros((kernels.layout.rows, COLUMNS))
    kernels.functions.jet(0, ORDER, 0.0, np.zeros(1), np.array([1.0]), ws)
    row = ws[0, : ORDER + 1]
    solution = coefficients(mpmath.exp, ORDER)
    agree(row, solution, 1e-15)
    row[5] *= 1 + 1e-10
    with pytest.raises(AssertionError):
        agree(row, solution, 1e-13)

"""A kink or a jump inside of a flow would be stepped over in silence: it is refused before anything is compiled."""

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of

X, T = sympy.symbols("x t", real=True)

KINKS = {
    "Abs": sympy.Abs(X),
    "sign": -sympy.sign(X),
    "Max": sympy.Max(X, 0),
    "Min": 1 + sympy.Min(X, 2),
    "Heaviside": sympy.Heaviside(X),
    "Mod": sympy.Mod(X, 1),
    "Mod of time": sympy.Mod(T, 1),
    "Piecewise": sympy.Piecewise((X, X > 0), (2 * X, True)),
    "inside of a function": sympy.sin(sympy.Abs(X)),
}


def flow(rate, **more):
    return cd.HybridSystem(name="kink", states=(X,), time=T, parameters={}, modes={"on": {X: rate}}, **more)


@pytest.mark.parametrize("kink", KINKS)
def test_a_kink_in_a_rate_is_refused_with_the_remedy(kink):
    with pytest.raises(cd.ModelError, match=r"kink: mode 'on', dx/dt = .*write its branches as modes with a guard"):
        _ = kernels_of(flow(KINKS[kink]))


@pytest.mark.parametrize("jump", [sympy.floor(X), sympy.ceiling(T), sympy.frac(X)])
def test_a_jump_in_a_rate_is_refused(jump):
    with pytest.raises(cd.ModelError, match="modes"):
        _ = kernels_of(flow(1 + jump))


@pytest.mark.parametrize("function", [sympy.gamma(X + 2), sympy.besselj(0, X), sympy.Function("mine")(X)])
def test_a_function_without_a_series_is_refused_and_what_there_is_is_told(function):
    with pytest.raises(cd.ModelError, match=r"has no Taylor series here.*acos, .*exp, log and powers"):
        _ = kernels_of(flow(-X + function))


def test_a_kink_in_a_guard_is_refused():
    ring = cd.Transition("ring", "on", "on", guard=sympy.Abs(X) - 1, direction=+1, reset={X: 0})
    with pytest.raises(cd.ModelError, match="Abs"):
        _ = kernels_of(flow(1, transitions=[ring]))


def test_a_kink_in_a_quadrature_is_refused():
    with pytest.raises(cd.ModelError, match="Abs"):
        _ = kernels_of(flow(1, quadratures={"path": sympy.Abs(X)}))


def test_a_reset_without_a_derivative_is_refused_by_the_name_of_its_transition():
    fold = cd.Transition("fold", "on", "on", guard=X - 1, direction=+1, reset={X: sympy.Max(X - 2, T)})
    with pytest.raises(cd.ModelError, match="fold"):
        _ = kernels_of(flow(1, transitions=[fold]))

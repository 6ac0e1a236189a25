"""Special functions of what moves: their series, their tangents and their rounding, in line and in tables."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.analysis.precision.reference import EXACT
from chaosdrill.codegen import kernels_of, mode
from chaosdrill.codegen.layout import UNIT
from chaosdrill.codegen.rounding import rounding_bound
from chaosdrill.codegen.signatures import LANES
from chaosdrill.codegen.special import CODE
from chaosdrill.engine.lanes import aligned
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.errors import ModelError
from chaosdrill.model.special import SPECIAL, hunt_crossley_exit

X, Y, Q = sympy.symbols("x y q", real=True)
ORDER, CHECKED = 23, 10
PLACE, DAMPING = (0.7, 0.6), 0.45


def system(rate, title):
    hit = cd.Transition("hit", "on", "on", guard=hunt_crossley_exit(X + Y, Q) - 2, direction=1, reset={X: 0})
    return cd.HybridSystem(
        name=title, states=(X, Y), parameters={"q": DAMPING}, modes={"on": {X: rate, Y: X - Y}}, transitions=[hit]
    )


@pytest.fixture(scope="module", params=["in line", "in tables"])
def kernels(request):
    with pytest.MonkeyPatch.context() as patched:
        if request.param == "in tables":
            patched.setattr(mode, "TUNING", replace(mode.TUNING, products_in_line=-1))
        return kernels_of(system(hunt_crossley_exit(X * Y, Q), request.param))


@pytest.fixture
def workspace(kernels):
    ws, c = np.zeros((kernels.layout.rows + 4, COLUMNS)), kernels.constants({"q": DAMPING})
    jet, jacobian_jet, tangent = kernels.functions[:3]
    jet(0, ORDER, 0.0, c, np.array(PLACE), ws)
    jacobian_jet(0, ORDER, c, ws)
    tangent(0, ORDER, c, np.array([1.0, -0.4]), np.array([0.3, 2.0]), ws, kernels.layout.rows)
    return ws


def taylor(f):
    with mpmath.workdps(60):
        return [float(a) for a in mpmath.taylor(f, 0, CHECKED)]


def exact(v):
    return EXACT["hunt_crossley_exit"](v, mpmath.mpf(DAMPING))


def polynomial(row):
    return lambda s: mpmath.polyval([mpmath.mpf(a) for a in row[ORDER::-1]], s)


def test_series_of_the_exit_speed(workspace):
    x, y = map(polynomial, workspace[:2])
    rate = taylor(lambda s: exact(x(s) * y(s)))
    np.testing.assert_allclose(workspace[0, 1 : CHECKED + 2], np.array(rate) / np.arange(1, CHECKED + 2), rtol=1e-11)
    guard = taylor(lambda s: exact(x(s) + y(s)) - 2)
    np.testing.assert_allclose(workspace[2, : CHECKED + 1], guard, rtol=1e-11, atol=1e-13)


def test_tangents_of_the_exit_speed(workspace, kernels):
    x, y = map(polynomial, workspace[:2])
    for half in range(2):
        first, second = workspace[kernels.layout.rows + 2 * half :][:2]
        dx, dy = polynomial(first), polynomial(second)

        def along(s, dx=dx, dy=dy):
            tiny = mpmath.mpf("1e-25")
            ahead = exact((x(s) + tiny * dx(s)) * (y(s) + tiny * dy(s)))
            return (ahead - exact(x(s) * y(s))) / tiny

        with mpmath.workdps(90):
            expected = [float(a) for a in mpmath.taylor(along, 0, 5)]
        np.testing.assert_allclose(first[1:7], np.array(expected) / np.arange(1, 7), rtol=1e-9, atol=1e-12)


def test_lanes_have_the_same_series(workspace, kernels):
    def lanes(numbers):
        filled = aligned(*np.shape(numbers), LANES)
        filled[:] = np.asarray(numbers)[..., np.newaxis]
        return filled

    ws = aligned(kernels.layout.rows + 4, COLUMNS, LANES)
    ws[:] = 0.0
    kernels.lanes[0](0, ORDER, lanes(0.0), lanes(kernels.constants({"q": DAMPING})), lanes(PLACE), ws)
    np.testing.assert_allclose(ws[:3, : ORDER + 1, 3], workspace[:3, : ORDER + 1], rtol=1e-12, atol=1e-12)


def test_what_has_no_series_is_refused():
    with pytest.raises(ModelError, match=r"hunt_crossley_exit\(.*\) has no Taylor series in its argument 2"):
        assert kernels_of(system(hunt_crossley_exit(1 + X**2, Y), "a damping that moves"))


@pytest.mark.parametrize("name", EXACT)
def test_the_error_of_the_code_is_within_its_bound(name):
    special = SPECIAL[name]
    (count,) = special.make.nargs
    symbols = sympy.symbols(f"a0:{count}", real=True)
    rng = np.random.default_rng(7)
    for _ in range(8):
        values = [0.1 + float(a) for a in rng.uniform(0, 3, int(count))]
        values[2:3] = [1 + v for v in values[2:3]]
        if name == "bernoulli_ratio":
            # a part of the exponent, and an order
            values[1:] = [rng.integers(3) / 2, float(rng.integers(3))]
        if name.endswith("_rest"):
            # which function of those that are analytic there, or an exponent; terms, and no derivative
            values[1:] = [
                float(rng.integers(6)) if name == "taylor_rest" else values[1],
                float(rng.integers(1, 5)),
                0.0,
            ]
        if name == "even_rest":
            # a sine or cosine, circular or hyperbolic
            values[1:] = [float(told := rng.integers(1, 5)), float(rng.integers(2) * 2 + told % 2), 0.0]
        with mpmath.workdps(30):
            truth = EXACT[name](*map(mpmath.mpf, values))
            error = abs(mpmath.mpf(CODE[name](*values)) - truth)
        size = abs(truth)
        if name.endswith("_rest"):
            # far from 0 as exact as the function itself over the power
            v, told, m, _ = values
            v, told = v**0.5 if name == "even_rest" else v, told if name == "power_rest" else int(told)
            size += abs(float(special.make.of(told, sympy.Float(v)))) / (v**m + 0.5**m)
        assert error <= special.error * size
    bound = rounding_bound(special.make(*symbols)).coeff(sympy.Abs(special.make(*symbols)))
    # what an exponent is off by, its value is off by as well
    assert bound.xreplace({symbols[-1]: sympy.S.Zero}) == math.ceil(special.error / UNIT)

"""Taylor coefficients of every operation and function against Cauchy's integral in 160 digits.

One mode an expression: x' = f(x, y, t), y' = x - y/3, a guard g = f + x y - 1/8 in the same mode. If X(s) is the
computed polynomial of the state, the coefficients of f(X(s), t + s) up to the order below must be (k + 1) times the
next ones of X itself: that is the differential equation, and it has one solution.
"""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of, mode
from chaosdrill.codegen.signatures import LANES
from chaosdrill.engine.lanes import aligned
from chaosdrill.engine.layout import COLUMNS

X, Y, T, P, Q, W = sympy.symbols("x y t p q w", real=True)

EXPRESSIONS = {
    "exp": sympy.exp(-X * Y),
    "log": sympy.log(2 + X * Y),
    "sin": sympy.sin(3 * X),
    "cos": sympy.cos(X + Y),
    "sin and cos": sympy.sin(X) * sympy.cos(X),
    "tan": sympy.tan(X / 2),
    "sinh": sympy.sinh(X - Y),
    "cosh": sympy.cosh(2 * Y),
    "tanh": sympy.tanh(3 * X),
    "asin": sympy.asin(X * Y),
    "acos": sympy.acos(X / 2),
    "atan": sympy.atan(2 * X),
    "asinh": sympy.asinh(3 * X * Y),
    "atanh": sympy.atanh(X / 3),
    "square": X**2 - 1,
    "cube": X**3,
    "power 7": X**7 - X**5,
    "inverse": 1 / X,
    "inverse cube": 1 / (1 + Y) ** 3,
    "root": sympy.sqrt(X),
    "rational power": X ** sympy.Rational(5, 3),
    "negative rational power": (X + Y) ** -sympy.Rational(3, 2),
    "symbolic power": X**P,
    "power of a state": X**Y,
    "power of a parameter": P**X,
    "product": X * Y,
    "product of three": X * Y * sympy.sin(X),
    "quotient": X / (1 + Y**2),
    "quotient of functions": sympy.sin(X) / sympy.cosh(Y),
    "quotient by a product": sympy.exp(X) / (X * (2 + Y)),
    "nested": sympy.exp(sympy.sin(sympy.sqrt(1 + X**2))),
    "deeply nested": sympy.tanh(sympy.log(1 + sympy.exp(X * sympy.cos(Y)))),
    "affine sine of time": P * sympy.sin(W * T + Q),
    "sine and cosine of time": sympy.sin(W * T) + X * sympy.cos(W * T),
    "affine with a parameter in the phase": sympy.cos(W * T + P * Q) * X,
    "two frequencies": sympy.sin(W * T) * sympy.sin(2 * W * T + 1),
    "sine of time squared": sympy.sin(T**2),
    "sine of time and state": sympy.sin(W * T + X),
    "affine and not of one argument": sympy.cos(W * T) + sympy.atan(W * T),
    "time alone": T,
    "polynomial of time": (1 + T) ** 3 * X,
    "decay in time": sympy.exp(-Q * T) * sympy.cos(W * T),
    "parameters alone": P * sympy.exp(Q) - W,
    "linear": P * X - Q * Y + W,
    "number": sympy.Rational(3, 7),
    "pi": sympy.pi * X - sympy.sqrt(2) * Y,
    "float exponent": X**1.5,
    "zero": sympy.Integer(0),
}
NAMES = list(EXPRESSIONS)
BESIDE = " (side by side)"
SIDE_BY_SIDE = ["exp", "log", "sin", "tan", "cube", "symbolic power", "quotient by a product", "sine of time squared"]
NUMBERS = {"p": 1.3, "q": 0.45, "w": 2.1}
PLACE = (0.7, 0.6)
TIME = 0.85
ORDER = 23


def system(names, title):
    return cd.HybridSystem(
        name=title,
        states=(X, Y),
        time=T,
        parameters=NUMBERS,
        modes={name: {X: EXPRESSIONS[name], Y: X - Y / 3} for name in names},
        transitions=[
            cd.Transition(
                name, name, name, guard=EXPRESSIONS[name] + X * Y - sympy.Rational(1, 8), direction=+1, reset={X: 0}
            )
            for name in names
        ],
        quadratures={"area": sympy.sin(Y) * X},
    )


@pytest.fixture(scope="module", params=["in line", "in tables"])
def kernels(request):
    """Small systems have their products of series in line; those of large ones stand in tables."""
    with pytest.MonkeyPatch.context() as patched:
        if request.param == "in tables":
            patched.setattr(mode, "TUNING", replace(mode.TUNING, products_in_line=-1))
        whole, few = (kernels_of(system(names, f"operations {request.param}")) for names in (NAMES, SIDE_BY_SIDE))
        # lanes are compiled when they are first asked for
        assert few.lanes
        return whole, few


def side_by_side(kernels, mode):
    """The same in two of eight lanes, whose neighbours start elsewhere: to the bit, wherever the lane is."""

    def lanes(numbers, spread=0.0):
        filled = aligned(*np.shape(numbers), LANES)
        filled[:] = np.asarray(numbers)[..., np.newaxis] * (1 - spread * np.array([0, 1, 2, 3, 4, 5, 0, 7]))
        return filled

    c, rows = kernels.constants(NUMBERS), kernels.layout.rows
    ws = aligned(rows + 4, COLUMNS, LANES)
    ws[:] = np.nan
    jet, jacobian_jet, tangent = kernels.lanes
    jet(mode, ORDER, lanes(TIME), lanes(c), lanes(PLACE, 0.01), ws)
    jacobian_jet(mode, ORDER, lanes(c), ws)
    tangent(mode, ORDER, lanes(c), lanes([1.0, -0.4]), lanes([0.3, 2.0]), ws, rows)
    first, other = (np.ascontiguousarray(ws[..., lane]) for lane in (0, 6))
    assert first.tobytes() == other.tobytes()
    return first


@pytest.fixture(scope="module")
def expand(kernels):
    whole, few = kernels

    def one(mode, c, rows):
        ws = np.full((rows + 4, COLUMNS), np.nan)
        jet, jacobian_jet, tangent = whole.functions[:3]
        jet(mode, ORDER, TIME, c, np.array(PLACE), ws)
        jacobian_jet(mode, ORDER, c, ws)
        tangent(mode, ORDER, c, np.array([1.0, -0.4]), np.array([0.3, 2.0]), ws, rows)
        return ws

    def run(name):
        plain = name.removesuffix(BESIDE)
        if plain != name:
            return side_by_side(few, SIDE_BY_SIDE.index(plain)), few.layout.rows
        return one(NAMES.index(name), whole.constants(NUMBERS), whole.layout.rows), whole.layout.rows

    return run


def exact(values):
    return [mpmath.mpf(v) for v in values]


@pytest.fixture(scope="module")
def around(kernels):
    """Where what these kernels gave for one name is kept for the three tests of it."""
    return {}


@pytest.fixture
def evaluated(expand, numeric, circle, polynomial, around):
    """Numbers of the kernels, f as a function, and x, y and f of the computed series at the places of a circle."""

    def make(name):
        if name not in around:
            ws, row = expand(name)
            x, y = polynomial(ws[0, : ORDER + 1]), polynomial(ws[1, : ORDER + 1])
            f = numeric((X, Y, T, P, Q, W), EXPRESSIONS[name.removesuffix(BESIDE)])
            time, numbers = mpmath.mpf(TIME), exact(NUMBERS.values())
            places = [(s, x(s), y(s)) for s in circle(ORDER)]

            def rate(x, y, s):
                return f(x, y, time + s, *numbers)

            around[name] = ws, row, rate, places, [rate(x, y, s) for s, x, y in places]
        return around[name]

    return make


@pytest.mark.parametrize("name", [*NAMES, *(name + BESIDE for name in SIDE_BY_SIDE)])
def test_states_are_their_taylor_series(name, evaluated, from_circle, agree):
    ws, _, _, _, values = evaluated(name)
    derivative = from_circle(values, ORDER)
    expected = [PLACE[0], *(derivative[k] / (k + 1) for k in range(ORDER))]
    agree(ws[0, : ORDER + 1], expected, 2e-14)


@pytest.mark.parametrize("name", [*NAMES, *(name + BESIDE for name in SIDE_BY_SIDE)])
def test_guards_are_their_taylor_series(name, evaluated, from_circle, agree):
    ws, _, _, places, values = evaluated(name)
    guard = [f + x * y - mpmath.mpf("0.125") for f, (_, x, y) in zip(values, places, strict=True)]
    agree(ws[3, : ORDER + 1], from_circle(guard, ORDER), 2e-14)


@pytest.mark.parametrize("name", [*NAMES, *(name + BESIDE for name in SIDE_BY_SIDE)])
def test_tangents_are_differences_of_the_field(name, evaluated, from_circle, polynomial, agree):
    """d' = J d, with J d as a difference of the field along the tangent in 160 digits.

    What the difference leaves out is itself a series, of the size of ``tiny``: one side is enough.
    """
    ws, row, rate, places, values = evaluated(name)
    tiny = mpmath.mpf("1e-40")
    for half in range(2):
        vector = ws[row + 2 * half : row + 2 * half + 2, : ORDER + 1]
        dx, dy = (polynomial(series) for series in vector)
        along = [
            (rate(x + tiny * dx(s), y + tiny * dy(s), s) - f) / tiny
            for f, (s, x, y) in zip(values, places, strict=True)
        ]
        derivative = from_circle(along, ORDER)
        expected = [vector[0, 0], *(derivative[k] / (k + 1) for k in range(ORDER))]
        agree(vector[0], expected, 5e-14, beside=ws[:2, : ORDER + 1])
        second = vector[1]
        linear = [(vector[0, k] - second[k] / 3) / (k + 1) for k in range(ORDER)]
        agree(second, [second[0], *linear], 1e-14, beside=ws[:2, : ORDER + 1])


def test_registers_of_either_width(monkeypatch):
    """Whether a register holds all lanes or half of them, the series are the same, up to rounding."""
    found = []
    for width in (LANES, LANES // 2):
        monkeypatch.setattr("chaosdrill.codegen.kernels.register_width", lambda width=width: width)
        kernels = kernels_of(system(SIDE_BY_SIDE, "registers"))
        found.append([np.nan_to_num(side_by_side(kernels, mode)) for mode in range(len(SIDE_BY_SIDE))])
    for name, whole, half in zip(SIDE_BY_SIDE, *found, strict=True):
        size = np.abs(whole).max(axis=1, keepdims=True)
        assert (np.abs(half - whole) <= 1e-13 * size).all(), name


@pytest.mark.parametrize("name", ["sin", "product", "time alone"])
def test_quadratures_are_integrals_of_their_series(name, expand, coefficients, polynomial, agree):
    ws, _ = expand(name)
    x, y = polynomial(ws[0, : ORDER + 1]), polynomial(ws[1, : ORDER + 1])
    integrand = coefficients(lambda s: mpmath.sin(y(s)) * x(s), ORDER)
    expected = [0, *(integrand[k] / (k + 1) for k in range(ORDER))]
    agree(ws[2, : ORDER + 1], expected, 2e-14)

"""Which guards are one surface, as the expressions tell."""

import math
import time

import mpmath
import numpy as np
import pytest
import sympy

from chaosdrill.model.crossings import Crossing, crossings, stripped

NAMES = {name: sympy.Symbol(name, real=True) for name in ("x", "v", "t", "k", "d")}


class Written:
    def __init__(self, guard, direction=1):
        self.guard, self.direction = sympy.sympify(guard, locals=NAMES), direction


@pytest.mark.parametrize(
    ("guard", "way"),
    [
        ("2*x", 1),
        ("-3*x", -1),
        ("x*(1 + v**2)", 1),
        ("-x*exp(v)", -1),
        ("x*(2 + sin(t))", 1),
        ("x + x**3", 1),
        ("-2*x - x**5", -1),
        ("sinh(x)", 1),
        ("atan(-2*x)", -1),
        ("tanh(x)**3", 1),
        ("exp(x) - 1", 1),
        ("1 - exp(x)", -1),
        ("exp(x - log(2)) - 1/2", 1),
        ("3*exp(x + v) - 3*exp(v)", 1),
        ("(1 - x)**3 - 1", -1),
        ("x + x*v**2", 1),
        ("1e-9*x", 1),
        ("-2*tanh(x)*(1 + v**2)/3", -1),
    ],
)
def test_it_is_the_surface_of_x(guard, way):
    assert crossings([Written("x"), Written(guard)]) == (Crossing(NAMES["x"], 1), Crossing(NAMES["x"], way))
    assert crossings([Written(guard, 0), Written("x")])[0] == Crossing(NAMES["x"], 0)


@pytest.mark.parametrize("guard", ["exp(x**2 - x) - 3", "3*exp(x) - exp(x**2)"])
def test_what_may_overflow_on_both_sides_of_its_roots_is_bounded(guard):
    core, way = stripped(Written(guard).guard)
    root = (1 + math.sqrt(1 + 4 * math.log(3))) / 2
    for x, sign in ((-40, 1), (1 - root - 1e-9, 1), (0, -1), (root - 1e-9, -1), (root + 1e-9, 1), (40, 1)):
        value = float(core.subs(NAMES["x"], x))
        assert abs(value) <= 1.0
        assert value * way * sign * (1 if guard.startswith("e") else -1) > 0


@pytest.mark.parametrize(
    "guard",
    [
        "exp(-x**2) - exp(-v**2)",
        "exp(x**2 - v**2) - 2",
        "exp(v**2 - x) - 3",
        "3 - exp(x**2 + v)",
        "exp(-x**2) - 2*exp(-(x - 1)**2)",
        "exp(-(x + v)**2) - exp(-(x - v - 3)**2)",
        "exp(x**2 - 30*x - v**2) - 1",
        "exp(x**2 - 60*x) - 1",
        "exp(x**2 + v**2 - v) - 3",
    ],
)
def test_none_overflows_where_its_guard_has_a_value(guard):
    guard = Written(guard).guard
    core, way = stripped(guard)
    places = [-400.0, -30.0, -1.1, 0.1, 2.3, 30.0, 800.0]
    told, has = (sympy.lambdify([NAMES["x"], NAMES["v"]], e, "numpy") for e in (core, guard))
    exact = sympy.lambdify([NAMES["x"], NAMES["v"]], guard, "mpmath")
    x, v = np.meshgrid(places, places)
    with np.errstate(over="ignore", under="ignore"):
        there, here = told(x, v), has(x, v)
    # in numbers without bounds: as doubles both exponentials may be zero where they differ
    signs = [[float(mpmath.sign(exact(mpmath.mpf(a), mpmath.mpf(b)))) for a in places] for b in places]
    np.testing.assert_array_equal(np.sign(there), way * np.array(signs))
    assert np.isfinite(there[np.isfinite(here)]).all()


@pytest.mark.parametrize("inner", ["((x - k)/d)**2", "((x - 20)/1e-8)**2"])
@pytest.mark.parametrize(
    "gate", ["1/(1 + exp(u)) - 1/3", "1/2 - exp(-u)/(1/2 + exp(-u))", "2/(3 + exp(-u)) - 4/7", "tanh(u/2) - 1/3"]
)
def test_a_gate_of_a_pulse_opens_where_its_exponential_has_a_value(gate, inner):
    """All are zero at u = log(2), where the exponential is met as fast as the gate, and from a value of its own."""
    x, guard = NAMES["x"], Written(gate).guard.subs("u", Written(inner).guard)
    core, way = stripped(guard)
    assert way == 1
    assert core != guard
    for u, part in ((0.69, 1e-2), (math.log(2), 1e-9), (0.7, 1e-2), (1e12, 1.5)):
        place = {NAMES["k"]: 20, NAMES["d"]: 1e-8, x: 20 + sympy.Float(1e-8, 40) * sympy.sqrt(u)}
        here, there = (float((e if u != math.log(2) else e.diff(x)).subs(place).evalf(30)) for e in (guard, core))
        assert abs(math.log(there / here)) < part


@pytest.mark.parametrize("guard", ["2*(x - 0.3)", "-3*(x - 0.3)", "0.3 - x", "(x - 0.3)**3 + x - 0.3", "sinh(x - 0.3)"])
def test_a_threshold_may_be_written_in_many_ways(guard):
    plain, other = crossings([Written("x - 0.3"), Written(guard)])
    assert other.surface == plain.surface == Written("x - 0.3").guard


@pytest.mark.parametrize(
    "guard",
    [
        "k*x",
        "x*v",
        "x**2 - 1",
        "x*(1 + v)",
        "x - x**3",
        "sin(x)",
        "x*(1 + sin(t))",
        "x - v",
        "(1 + x)**2 - 1",
        "log(1 + x)",
    ],
)
def test_what_may_vanish_elsewhere_is_another_surface(guard):
    assert crossings([Written("x"), Written(guard)])[1].surface == Written(guard).guard


def test_each_factor_that_may_vanish_is_what_it_vanishes_with():
    assert stripped(Written("(1 - v/40)*(x - 1)**3*exp(t)").guard) == (Written("(1 - v/40)*(x - 1)").guard, 1)


def test_a_lone_guard_stays_as_it_is_written():
    for guard in ("-x", "0.3 - x", "1e6*x - 3", "k*x - d", "sin(2*pi*t)"):
        assert stripped(Written(guard).guard) == (Written(guard).guard, 1)


def test_sums_of_many_terms_that_vanish_apart_take_no_time():
    """The time grew with the factorial of the number of terms: nine cubes took more than a minute."""
    begun = time.process_time()
    cubes = sum(state**3 for state in sympy.symbols("x0:20"))
    assert stripped(cubes) == (cubes, 1)
    assert time.process_time() - begun < 5

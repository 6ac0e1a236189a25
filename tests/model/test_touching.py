"""Kinks by what functions do: refused with the modes to write, or taken apart; what has none is accepted."""

from math import pi
from time import process_time

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.model.parts import read_expression
from chaosdrill.model.touching import find_fold, unfolded, without_smooth_zeros

X, Y, T, A, N = sympy.symbols("x y t a n", real=True)
MOVING = (X, Y, T)
NUMBERS = {"a": 0.5, "n": 1.5, "eps": 1e-9}

SINGLE = {
    "asin(sin(t))": "Abs(cos(t))",
    "acos(cos(t))": "Abs(sin(t))",
    "asin(cos(3*t))": "Abs(sin(3*t))",
    "atan(tan(t))": "Abs(cos(t))",
    "atan(sin(t)/cos(t))": "Abs(cos(t))",
    "atan(1/tan(t))": "Abs(sin(t))",
    "sqrt(1 - cos(t)**2)": "Abs(sin(t))",
    "sqrt(1 + cos(t))": "Abs(cos(t/2))",
    "sqrt((1 - cos(2*x))/2 + sin(x)**2)": "Abs(sin(x))",
    "sqrt(2 - 2*cos(x)*cos(y) - 2*sin(x)*sin(y))": "Abs(sin(x/2 - y/2))",
    "sqrt(x**2 - 2*x + 1)": "Abs(x - 1)",
    "sqrt(x**2 - 0.2*x + 0.01)": "Abs(10*x - 1)",
    "(x**2 - 2*a*x + a**2)**1.5": "Abs(a - x)",
    "(x**2 + 2*x*y + y**2)**0.25": "Abs(x + y)",
    "(x**4 - 2*x**2 + 1)**n": "Abs(x**2 - 1)",
    "positive_power(x**2 - 2*x + 1, n)": "Abs(x - 1)",
    "exp(log(x**2 - 2*x + 1)/2)": "Abs(x - 1)",
    "sqrt(x**3 - 2*x**2 + x)": "Abs(x - 1)",
    "sqrt(cosh(x) - 1)": "Abs(exp(x) - 1)",
    "sqrt(exp(2*x) - 2*exp(x) + 1)": "Abs(exp(x) - 1)",
    "asin(2*x/(1 + x**2))": "Abs(x**2 - 1)",
    "acos(x/sqrt(x**2 + y**2))": "Abs(y)",
    "1/sqrt(x**2 - 2*x + 1)": "Abs(x - 1)",
    "sqrt(x**2 - 2*sqrt(2)*x + 2)": "Abs(x - sqrt(2))",
}
"""Expressions, and what has the kink in them."""

TOGETHER = ("sqrt(x*tanh(x))", "sqrt(x*sin(x))", "sqrt((x - 1)*log(x))", "sqrt(3*x**2 + x*sin(x))")
"""Bases of which two factors change their signs together, so that nothing can be taken out."""

SMOOTH = (
    *("sqrt(x)", "x**(3/4)", "sqrt(1 - x**2)", "asin(x)", "acos(y)", "sqrt(x*(x - 1))", "sqrt(x**2 - 1)"),
    *("sqrt(1 + x**2)", "sqrt(x**2 + eps**2)", "sqrt(x**2 + y**2)", "(x**2 + y**2)**1.5", "sqrt((x - a)**2 + y**2)"),
    *("sqrt(x**4 + 2*x**2*y**2 + y**4)", "sqrt(x**4 - 4*x**3*y + 6*x**2*y**2 - 4*x*y**3 + y**4)", "asin(a*sin(t))"),
    *("sqrt(1 - a**2*sin(t)**2)", "atan(x/y)", "atan(sin(t)/(1 + cos(t)))", "atan(a*sin(t)/(2 + cos(t)))"),
    *("sqrt(1 - tanh(x)**2)", "x/sqrt(x**2 + y**2)", "sqrt((x**2 - 1)**2*(x**4 + 1))*0 + x", "log(cosh(20*sin(t)))/20"),
    *("positive_power(x - a, n)", "sqrt(2*sin(x) - sin(2*x))", "exp(-x**2)**0.5", "sqrt(-x*log(x))"),
)
"""Without a kink: what crosses its branch point, what stays away from it, what touches it at points alone."""


def read(text):
    return read_expression("rate", text)


def flow(rate, **more):
    given = {"states": "x y", "parameters": NUMBERS, "modes": {"on": {"x": rate, "y": "-y"}}}
    return cd.HybridSystem(name="fold", **{**given, **more})


def agree(one, other, places=100):
    """Whether two expressions are the same where the first is a number."""
    known = {sympy.Symbol(name, real=True): value for name, value in NUMBERS.items()}
    rng = np.random.default_rng(7)
    found = 0
    functions = [sympy.lambdify(MOVING, e.xreplace(known), modules="scipy") for e in (one, other)]
    for place in rng.uniform(-3, 3, (places, 3)):
        with np.errstate(all="ignore"):
            here, there = (complex(function(*(place + 0j))) for function in functions)
        if np.isfinite(here) and abs(here.imag) < 1e-12:
            assert there == pytest.approx(here, rel=1e-7, abs=1e-7)
            found += 1
    assert found >= 5


@pytest.mark.parametrize("text", SINGLE)
def test_a_kink_is_refused_with_the_modes_to_write(text):
    with pytest.raises(cd.ModelError, match=r"modes\.on\.x: .* (kink|jump) where .* is zero") as caught:
        flow(text)
    assert f"For {SINGLE[text]} write a mode with " in str(caught.value)
    assert str(caught.value).endswith("between them; chaosdrill.in_modes does so")


@pytest.mark.parametrize("text", [one for one in SINGLE if "positive" not in one])
def test_what_is_to_be_written_instead_is_the_same_function(text):
    expression = read(text)
    instead = unfolded(expression, MOVING, NUMBERS)
    assert instead.has(sympy.Abs)
    assert find_fold(instead, MOVING, NUMBERS) is None
    agree(expression, instead)


@pytest.mark.parametrize("text", TOGETHER)
def test_factors_that_touch_together_are_refused(text):
    with pytest.raises(cd.ModelError, match=r"has a kink where .* is zero; write Abs\(.* a mode for each side"):
        flow(text)


@pytest.mark.parametrize("text", SMOOTH)
def test_what_has_no_kink_is_accepted(text):
    assert find_fold(read(text), MOVING, NUMBERS) is None


AWAY = "sqrt(x**2 - 2*x + 1) - 1"
PLACES = {
    "guard": lambda: flow("y", transitions=[cd.Transition("ring", "on", "on", AWAY, 1, {"x": 0})]),
    "quadrature": lambda: flow("y", quadratures={"way": AWAY}),
    "section": lambda: cd.poincare_section(flow("y"), at=f"{AWAY} > 0", periods=2),
}


@pytest.mark.parametrize("make", PLACES.values(), ids=PLACES)
def test_kinks_elsewhere_in_a_flow_are_refused(make):
    with pytest.raises(cd.ChaosdrillError, match="has a kink where x - 1 is zero"):
        make()


def test_resets_and_conditions_may_have_kinks():
    reset = cd.Transition("back", "on", "on", "x - 1", 1, {"x": "sqrt(y**2 - 2*y + 1) - 3"}, "acos(cos(t)) > 1")
    assert flow("y", transitions=[reset]).transitions[0].reset


TAKEN_OUT = {
    "sqrt(x**4)": "x**2",
    "(x**2)**3": "x**6",
    "sqrt((x - 1)**4*(1 + y**2))": "(x - 1)**2*sqrt(1 + y**2)",
    "(x**4 - 4*x**3 + 6*x**2 - 4*x + 1)**1.5": "(x - 1)**6",
    "sqrt(1 - 2*cos(t)**2 + cos(t)**4)": "sin(t)**2",
    "sqrt(1 - 2*sin(t) + sin(t)**2)": "1 - sin(t)",
    "abs(1 - cos(x))": "1 - cos(x)",
}
"""Roots of what touches zero so that they are smooth there, and the same without a root."""


@pytest.mark.parametrize("text", TAKEN_OUT)
def test_smooth_zeros_are_taken_out_of_roots(text):
    found, plain = without_smooth_zeros(read(text), MOVING, NUMBERS), read(TAKEN_OUT[text])
    assert find_fold(found, MOVING, NUMBERS) is None
    assert not found.has(sympy.Abs)
    rng = np.random.default_rng(1)
    for values in rng.uniform(-3, 3, (20, 3)):
        put = dict(zip(MOVING, values, strict=True))
        assert float(found.subs(put)) == pytest.approx(float(plain.subs(put)), rel=1e-11, abs=1e-13)
    # the slopes are those of the smooth expression where the base is zero as well
    for zero in ({X: 1.0, Y: 0.3, T: np.pi / 2}, {X: 0.0, Y: 0.3, T: 0.0}):
        for x in MOVING:
            slopes = [complex(sympy.diff(e, x).subs(zero)) for e in (found, plain)]
            assert slopes[0] == pytest.approx(slopes[1], abs=1e-7)


LARGE = (
    "sqrt(1 - cos((x + y + t + 1)**300)**2)",
    "sqrt((x + y + t)**200 + 1 - x)",
    "asin(sin(1000000007*t) + cos((x + y)**40)*x**40)",
    "sqrt(1 - cos(" + " + ".join(f"sin({k}*t)" for k in range(1, 40)) + ")**2)",
    "sqrt(((((x + y)**9 + t)**9 + x)**9 + y)**9 + 1)",
    "atan(tan((x + y + t)**90) + " + " + ".join(f"tan({k}*t)" for k in range(1, 20)) + ")",
    "sqrt(1 - " + "*".join(f"cos({k}*t + y)" for k in range(1, 12)) + ")",
)


@pytest.mark.parametrize("text", LARGE, ids=range(len(LARGE)))
def test_large_expressions_take_bounded_time(text):
    begin = process_time()
    find_fold(read(text), MOVING, NUMBERS)
    assert process_time() - begin < 20


@pytest.mark.parametrize("name", ["t", "cos", "sin", "lambda", "numpy", "exp"])
def test_names_have_no_say(name):
    given = {"states": (name,), "parameters": {"sqrt": 2.0}}
    with pytest.raises(cd.ModelError, match="has a kink where"):
        cd.HybridSystem(**given, modes={"on": {name: f"sqrt(1 - cos(sqrt*`{name}`)**2)"}})
    assert cd.HybridSystem(**given, modes={"on": {name: f"sqrt(2 - cos(sqrt*`{name}`)**2)"}}).autonomous


@st.composite
def squares(draw):
    """The square of what changes its sign on a line, in one of its writings, in any unit of length."""
    unit = draw(st.sampled_from([1, sympy.Rational(1, 10**12), 10**9]))
    along, across = draw(st.sampled_from([X, T])), draw(st.sampled_from([0, Y]))
    line = draw(st.integers(1, 3)) * along + across - draw(st.integers(-3, 3))
    line = sympy.expand(line.xreplace({x: x / unit for x in MOVING}))
    waves = (1 - sympy.cos(line) ** 2, (1 - sympy.cos(2 * line)) / 2)
    grown = sympy.exp(2 * line) - 2 * sympy.exp(line) + 1
    return sympy.expand(draw(st.sampled_from([line**2, line**2 * (1 + Y**2 / unit**2), *waves, grown])))


@settings(max_examples=30)
@given(base=squares(), power=st.sampled_from([sympy.Rational(1, 2), sympy.Rational(3, 2), sympy.Float(0.4)]))
def test_any_root_of_a_square_has_a_kink_and_none_above_zero(base, power):
    root = sympy.Pow(base, power)
    assert root.has(sympy.Abs) or find_fold(root, MOVING, NUMBERS) is not None
    assert find_fold(sympy.Pow(base + sympy.Rational(1, 100), power), MOVING, NUMBERS) is None


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize(
    ("rate", "mean"),
    [("asin(sin(t))", 0.0), ("acos(cos(t))", pi / 2), ("atan(tan(t))", 0.0), ("sqrt(1 - cos(t)**2)", 2 / pi)],
)
def test_a_drive_with_hidden_kinks_has_its_mean_in_modes(rate, mean, method):
    system = cd.in_modes(name="drive", states="x", parameters={}, field={"x": rate}, period="2*pi")
    run = cd.trajectory(system, periods=10, samples=8, method=method)
    assert int(run["outcome"]) == cd.Outcome.OK
    assert run["states"].values[-1, 0] == pytest.approx(20 * pi * mean, rel=1e-11, abs=1e-10)


def test_a_triangle_wave_in_multiples_of_pi():
    """The number is no name that a quotient could be filled in, as of asin(sin(pi*t))/pi where pi is zero."""
    system = cd.in_modes(states="x", field={"x": "asin(sin(pi*t))/pi"})
    run = cd.trajectory(system, duration=6.4, samples=1)
    assert run["event_time"].values == pytest.approx(np.arange(6) + 0.5, rel=1e-13)
    assert run["states"].values[-1, 0] == pytest.approx(0.08, abs=1e-11)


def test_a_kink_beside_a_limit_is_seen():
    with pytest.raises(cd.ModelError, match=r"asin\(sin\(t\)\) has a kink where cos\(t\) is zero"):
        cd.HybridSystem(states="x", modes={"on": {"x": "asin(sin(t))/t"}})


@pytest.mark.parametrize("distance", ["sqrt(x**2 - 2*x + 1)", "(x**2 - 2*x + 1)**0.5", "exp(log(x**2 - 2*x + 1)/2)"])
def test_a_hidden_kink_of_a_state_in_modes(distance):
    """z'' = -|z| + 0.3 about z = x - 1 from 0.9: 0.3 + 0.6 cos(t) down to zero at 2 pi/3, then in hyperbolas."""
    field = {"x": "v", "v": f"0.3 - {distance}"}
    system = cd.in_modes(name="mass", states="x v", parameters={}, field=field, initial={"x": 1.9})
    run = cd.trajectory(system, duration=3.0, samples=1)
    after, speed = 3 - 2 * pi / 3, -0.6 * np.sin(2 * pi / 3)
    assert run["event_time"].values == pytest.approx([2 * pi / 3], rel=1e-13)
    expected = 1 + 0.3 * (np.cosh(after) - 1) + speed * np.sinh(after)
    assert run["states"].values[-1, 0] == pytest.approx(expected, rel=1e-12)

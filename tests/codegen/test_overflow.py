"""Rates whose exponentials are no doubles, or whose quotients are 0/0 at one place, have one value in any writing.

Each state has another writing for its rate; the last one is what these are functions of, and moves evenly. So a state
moves by the integral of its function, and by the function's difference if the last one starts elsewhere.
"""

import math
from functools import cache

import mpmath
import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from support.laws import check_survival, values_and_slopes

import chaosdrill as cd
from chaosdrill.engine.batch import Batch
from chaosdrill.engine.numerics import Numerics
from chaosdrill.model.special import bernoulli_ratio, gate, log_cosh, log_sum

K, A, B = 0.3, 1.7, 0.6
NUMBERS = {"k": K, "a": A, "b": B}
U = sympy.Symbol("u", real=True)


def channel(u):
    return u / mpmath.expm1(u) if u else mpmath.mpf(1)


def over_one(f):
    """Divided so that its integral is not that of its asymptotes alone."""
    return lambda u: f(u) / (1 + u * u)


def in_full(f):
    """Of what loses digits near 0, with enough of them; 0 at 0."""

    def value(u):
        with mpmath.workdps(200):
            return f(u) if u else mpmath.mpf(0)

    return value


LAWS = {
    lambda u: 1 / (1 + K * mpmath.exp(-u)): (
        "exp(u)/(k + exp(u))",
        "1/(1 + k*exp(-u))",
        "1 - k/(k + exp(u))",
        "exp(u/2)/(k*exp(-u/2) + exp(u/2))",
        "a*exp(u)/(a*k + a*exp(u))",
    ),
    lambda u: K * mpmath.exp(u) / (K + mpmath.exp(u)) ** 2: (
        "k*exp(u)/(k + exp(u))**2",
        "k/(k*exp(-u/2) + exp(u/2))**2",
        "exp(u)/(k + exp(u)) - exp(2*u)/(k + exp(u))**2",
    ),
    over_one(lambda u: mpmath.log1p(mpmath.exp(u))): (
        "log(1 + exp(u))/(1 + u**2)",
        "(u + log(1 + exp(-u)))/(1 + u**2)",
        "-log(1/(1 + exp(u)))/(1 + u**2)",
    ),
    over_one(lambda u: mpmath.log(A * mpmath.exp(u) + B * mpmath.exp(-2 * u))): (
        "log(a*exp(u) + b*exp(-2*u))/(1 + u**2)",
        "(u + log(a + b*exp(-3*u)))/(1 + u**2)",
        "log(exp(u)*(a + b*exp(-3*u)))/(1 + u**2)",
    ),
    over_one(lambda u: mpmath.log1p(2 * mpmath.sinh(u / 2) ** 2)): (
        "log(cosh(u))/(1 + u**2)",
        "(log(exp(u) + exp(-u)) - log(2))/(1 + u**2)",
        "-log(1/cosh(u))/(1 + u**2)",
    ),
    lambda u: 2 * mpmath.sinh(u) / (mpmath.exp(u) + K * mpmath.exp(-u)): (
        "(exp(u) - exp(-u))/(exp(u) + k*exp(-u))",
        "2*sinh(u)/(exp(u) + k*exp(-u))",
        "(exp(2*u) - 1)/(k + exp(2*u))",
    ),
    lambda u: 1 / (K + mpmath.cosh(u)): (
        "1/(k + cosh(u))",
        "2/(2*k + exp(u) + exp(-u))",
        "2*exp(u)/(1 + 2*k*exp(u) + exp(2*u))",
    ),
    lambda u: 1 / (mpmath.exp(u / 5) + K * mpmath.exp(-u / 3)): (
        "1/(exp(u/5) + k*exp(-u/3))",
        "exp(u/3)/(k + exp(8*u/15))",
    ),
    lambda u: 1 - mpmath.tanh(mpmath.exp(-u)): ("1 - tanh(exp(-u))",),
    over_one(lambda u: mpmath.asinh(mpmath.exp(u))): ("asinh(exp(u))/(1 + u**2)",),
    lambda u: 1 / mpmath.sqrt(1 + mpmath.exp(-2 * u)): ("exp(u)/sqrt(1 + exp(2*u))", "1/sqrt(1 + exp(-2*u))"),
    over_one(channel): (
        "u/(exp(u) - 1)/(1 + u**2)",
        "u*exp(-u)/(1 - exp(-u))/(1 + u**2)",
        "0.5*u*exp(-u/2)/sinh(u/2)/(1 + u**2)",
        "-u/(1 - exp(u))/(1 + u**2)",
    ),
    over_one(lambda u: A * channel(-u) - B * channel(u)): (
        "u*(a - b*exp(-u))/(1 - exp(-u))/(1 + u**2)",
        "u*(a*exp(u) - b)/(exp(u) - 1)/(1 + u**2)",
    ),
    over_one(lambda u: channel((u - A) / B)): (
        "(u - a)/b/(exp((u - a)/b) - 1)/(1 + u**2)",
        "(a - u)/(b - b*exp((u - a)/b))/(1 + u**2)",
    ),
    lambda u: u / mpmath.sinh(u) if u else mpmath.mpf(1): ("u/sinh(u)", "2*u/(exp(u) - exp(-u))"),
    lambda u: mpmath.mpf(2): ("sinh(2*u)/(sinh(u)*cosh(u))", "sinh(4*u)/(2*sinh(u)*cosh(u)*cosh(2*u))"),
    lambda u: 2 + 1 / mpmath.cosh(2 * u): ("sinh(3*u)/(sinh(u)*cosh(2*u))",),
    lambda u: mpmath.sinh(K * u) / mpmath.sinh(u) if u else mpmath.mpf(K): ("sinh(k*u)/sinh(u)",),
    lambda u: (channel(2 * u) + channel(-2 * u)) ** 4 / (16 + 16 * u**4): ("cosh(u)**4/sinh(u)**4*u**4/(1 + u**4)",),
    lambda u: channel(u) * channel(-u): ("u**2*exp(u)/(exp(u) - 1)**2", "(u/2/sinh(u/2))**2"),
    lambda u: mpmath.tanh(u) / u if u else mpmath.mpf(1): ("tanh(u)/u", "sinh(u)/(u*cosh(u))"),
    lambda u: (u / 2 / mpmath.sinh(u / 2)) ** 2 if u else mpmath.mpf(1): ("u**2/(2*cosh(u) - 2)",),
    lambda u: mpmath.sinc(u): ("sin(u)/u",),
    lambda u: mpmath.sinc(u / 2) ** 2 / 2: ("(1 - cos(u))/u**2",),
    lambda u: mpmath.atan(u) / u if u else mpmath.mpf(1): ("atan(u)/u",),
    in_full(lambda u: mpmath.coth(u) - 1 / u): ("1/tanh(u) - 1/u",),
    lambda u: mpmath.log1p(u * u) / u**2 if u else mpmath.mpf(1): ("log(1 + u**2)/u**2",),
    lambda u: 1 / (1 + mpmath.sqrt(1 + u * u)): ("(sqrt(1 + u**2) - 1)/u**2",),
    in_full(lambda u: (mpmath.sin(u) - u * mpmath.cos(u)) / u**2): ("(sin(u) - u*cos(u))/u**2",),
}
"""Some of them, such as u/sin(u), have poles elsewhere and are in `test_removable`."""
WRITINGS = [(law, text) for law, texts in LAWS.items() for text in texts]
STATES = [f"y{i}" for i in range(len(WRITINGS))]


@pytest.fixture(autouse=True)
def digits():
    with mpmath.workdps(40):
        yield


@pytest.fixture(scope="module")
def system():
    rates = {y: text for y, (_, text) in zip(STATES, WRITINGS, strict=True)}
    return cd.HybridSystem(
        states=[*STATES, "u"], parameters=NUMBERS, modes={"on": {**rates, "u": "1"}}, initial={"u": -60.0}
    )


@cache
def integral(law, low, high):
    places = sorted({low, high, *(p for p in (-20, -8, -3, -1, 0, 1, 2, 3, 8, 20) if low < p < high)})
    return mpmath.quad(law, places)


@pytest.mark.parametrize("u", [0.0, 1e-9, -1e-9, 0.3, -2.0, 3.2, 17.0, -17.0, 300.0, -300.0, 900.0, -900.0, 1e6, -1e6])
def test_values_and_slopes(system, u):
    for (law, text), rate, slope in zip(WRITINGS, *values_and_slopes(system, u), strict=True):
        value, by_u = law(mpmath.mpf(u)), mpmath.diff(law, mpmath.mpf(u))
        # what the exponent is rounded by counts as often as it is large
        assert rate == pytest.approx(float(value), rel=1e-14 * (10 + abs(u)), abs=1e-300), text
        size = abs(by_u) + abs(value) / (1 + abs(u))
        assert slope == pytest.approx(float(by_u), abs=1e-13 * (10 + abs(u)) * float(size) + 1e-300), text


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_runs_from_far_to_far(system, method):
    found = cd.trajectory(system, duration=120.0, samples=2, method=method)
    assert found["outcome"] == cd.Outcome.OK
    for (law, text), end in zip(WRITINGS, found["states"].values[-1], strict=False):
        assert end == pytest.approx(float(integral(law, -60.0, 60.0)), rel=1e-10, abs=1e-10), text


def test_lanes_through_and_from_zero(system):
    """Side by side, with tangents: by where the last state starts, a state changes by its function's difference."""
    starts = np.zeros((8, len(STATES) + 1))
    starts[:, -1] = [0.0, 1e-9, -1e-9, -1.0, -3.0, 2.0, -800.0, -1e5]
    runs = Batch(system, {}, starts, np.zeros(8, int), Numerics("taylor", 1e-12), unit=2.0)
    runs.run(0, np.array([0, 1]))
    assert (runs.outcome == cd.Outcome.OK).all()
    for (law, text), ends in zip(WRITINGS, runs.x.T, strict=False):
        for start, end in zip(starts[:, -1], ends, strict=True):
            expected = float(integral(law, float(start), float(start) + 2.0))
            assert end == pytest.approx(expected, rel=1e-10, abs=1e-12), (text, start)


@pytest.mark.parametrize("text", [text for _, text in WRITINGS])
def test_writings_survive(text):
    check_survival(text, {name: sympy.Symbol(name, real=True) for name in ("u", *NUMBERS)})


@pytest.mark.parametrize("u", ["0.7", "-1.3", "4.5"])
@pytest.mark.parametrize(
    "made", [gate(-K, A, U, U / 3), log_sum(K, A, U), log_cosh(U), bernoulli_ratio(U, sympy.S.Half, 1)], ids=str
)
def test_derivatives_are_central_differences(made, u):
    """Against central differences in many digits."""
    tiny = sympy.Float("1e-15", 40)
    place = sympy.Float(u, 40)
    ahead, behind = ((made.xreplace({U: place + step})).evalf(40) for step in (tiny, -tiny))
    slope = sympy.diff(made, U).xreplace({U: place}).evalf(40)
    assert float((ahead - behind) / (2 * tiny)) == pytest.approx(float(slope), rel=1e-13)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_guards_and_resets(method):
    """A guard that is flat at both ends, a condition, and a reset whose exponentials are infinite at the event."""
    passed = cd.HybridSystem(
        states="y u",
        parameters={"k": K, "n": 1e3},
        modes={"on": {"y": "0", "u": "1"}},
        transitions=[
            cd.Transition("half", "on", "on", "exp(n*u)/(k + exp(n*u)) - 1/2", 1),
            cd.Transition(
                "soft", "on", "on", "u - 1", 1, reset={"y": "log(k + exp(n*u)) + u/(exp(n*u) - 1)"},
                condition="k + exp(n*u) > 2*exp(n*u - 1)",
            ),
        ],
        initial={"y": 0.0, "u": -2.0},
    )  # fmt: skip
    found = cd.trajectory(passed, duration=4.0, samples=2, method=method)
    assert found["outcome"] == cd.Outcome.OK
    assert found["event_time"].values == pytest.approx([2 + math.log(K) / 1e3, 3.0], abs=1e-12)
    assert found["states"].values[-1] == pytest.approx([1e3, 2.0], rel=1e-12)


def test_a_pole_is_one_still():
    """Beside the pole the motion is right, and does not pass it."""
    beside = cd.HybridSystem(
        states="y u",
        parameters={"k": -2.0},
        modes={"on": {"y": "exp(u)/(k + exp(u))", "u": "1"}},
        initial={"u": -40.0},
    )
    near = cd.trajectory(beside, duration=40.0, samples=2)
    assert near["states"].values[-1, 0] == pytest.approx(float(np.log(1 / (2 - np.exp(-40.0)))), rel=1e-11)
    assert cd.trajectory(beside, duration=50.0, samples=2)["outcome"] == cd.Outcome.SINGULAR


def test_hodgkin_and_huxley():
    """A spike of the membrane, which passes both 0/0 of its rates, and a start in each of them.

    Hodgkin and Huxley 1952, doi:10.1113/jphysiol.1952.sp004764; the reference is scipy's, with expm1.
    """

    def field(t, y):
        v, m, h, n = y
        to_m, to_n = (w / -math.expm1(-w) if w else 1.0 for w in ((v + 40) / 10, (v + 55) / 10))
        return [
            10 - 120 * m**3 * h * (v - 50) - 36 * n**4 * (v + 77) - 0.3 * (v + 54.387),
            to_m * (1 - m) - 4 * math.exp(-(v + 65) / 18) * m,
            0.07 * math.exp(-(v + 65) / 20) * (1 - h) - h / (1 + math.exp(-(v + 35) / 10)),
            0.1 * to_n * (1 - n) - 0.125 * math.exp(-(v + 65) / 80) * n,
        ]

    membrane = hodgkin_huxley()
    for start in (-65.0, -40.0, -40.0 + 1e-9, -55.0):
        first = [start, 0.05, 0.6, 0.32]
        expected = solve_ivp(field, (0, 4), first, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        begun = membrane.with_initial(V=start)
        for method in ("taylor", "dop853", "radau") if start != -55.0 else ("taylor",):
            found = cd.trajectory(begun, duration=4.0, samples=2, method=method)
            assert found["outcome"] == cd.Outcome.OK
            np.testing.assert_allclose(found["states"].values[-1], expected, rtol=1e-9)


def hodgkin_huxley():
    rates = {
        "m": ("0.1*(V + 40)/(1 - exp(-(V + 40)/10))", "4*exp(-(V + 65)/18)"),
        "h": ("0.07*exp(-(V + 65)/20)", "1/(1 + exp(-(V + 35)/10))"),
        "n": ("0.01*(V + 55)/(1 - exp(-(V + 55)/10))", "0.125*exp(-(V + 65)/80)"),
    }
    field = {x: f"({up})*(1 - {x}) - ({down})*{x}" for x, (up, down) in rates.items()}
    field["V"] = "I - 120*m**3*h*(V - 50) - 36*n**4*(V + 77) - 0.3*(V + 54.387)"
    return cd.HybridSystem(
        states="V m h n", parameters={"I": 10.0}, modes={"on": field},
        initial={"V": -65.0, "m": 0.05, "h": 0.6, "n": 0.32},
    )  # fmt: skip

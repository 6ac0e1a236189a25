"""Quotients that are 0/0 at one place have their limit there, and all digits beside it, in any writing."""

import mpmath
import numpy as np
import pytest
import sympy
from support.laws import check_survival, values_and_slopes

import chaosdrill as cd
from chaosdrill.codegen.formulas import function_of
from chaosdrill.model.gates import without_overflow
from chaosdrill.model.text import read_text

U, K = sympy.symbols("u k", real=True)
SIZE = 1.75
LIMITS = {0: 2 * mpmath.pi, 0.5: mpmath.pi}

LAWS = {
    "u/sin(u)": lambda u: 1 / mpmath.sinc(u),
    "tan(k*u)/u": lambda u: SIZE * mpmath.sinc(SIZE * u) / mpmath.cos(SIZE * u),
    "asin(u/4)/u": lambda u: mpmath.asin(u / 4) / u if u else mpmath.mpf(1) / 4,
    "log(1.5 + u)/(0.5 + u)": lambda u: mpmath.log1p(u + 0.5) / (u + 0.5) if u != -0.5 else mpmath.mpf(1),
    "u**2/(1 - cos(u))": lambda u: 2 / mpmath.sinc(u / 2) ** 2,
    "sin(3.5*u)/sin(u)": lambda u: 3.5 * mpmath.sinc(3.5 * u) / mpmath.sinc(u),
    "(tan(u) - u)/u**3": lambda u: (mpmath.tan(u) - u) / u**3 if u else mpmath.mpf(1) / 3,
    "1/sin(u) - 1/u": lambda u: 1 / mpmath.sin(u) - 1 / u if u else mpmath.mpf(0),
    "1/(exp(u) - 1) - 1/u": lambda u: 1 / mpmath.expm1(u) - 1 / u if u else -mpmath.mpf(1) / 2,
    "sin(sin(u))/u": lambda u: mpmath.sinc(mpmath.sin(u)) * mpmath.sinc(u),
    "(exp(k*u) - exp(-u))/u": lambda u: (mpmath.exp(SIZE * u) - mpmath.exp(-u)) / u if u else mpmath.mpf(1 + SIZE),
    "(1/sqrt(1 - u**2) - 1)/u**2": lambda u: (1 / mpmath.sqrt(1 - u * u) - 1) / u**2 if u else mpmath.mpf(1) / 2,
    "log(cosh(u))/u**2": lambda u: mpmath.log(mpmath.cosh(u)) / u**2 if u else mpmath.mpf(1) / 2,
    "sin(2*pi*u)/(u - 4*u**3)": lambda u: mpmath.sinpi(2 * u) / (u - 4 * u**3) if u - 4 * u**3 else LIMITS[abs(u)],
    "log(k*u + 2)*exp(k*u)/(k*u + 1)": lambda u: mpmath.log1p(SIZE * u + 1) * mpmath.exp(SIZE * u) / (SIZE * u + 1),
    "cos(pi*k*u)/(1 - 4*k**2*u**2)": lambda u: mpmath.cospi(SIZE * u) / (1 - 4 * (SIZE * u) ** 2),
    "-log(1/(u + 1.5))/(2*u + 1)": lambda u: mpmath.log1p(u + 0.5) / (2 * u + 1) if u != -0.5 else mpmath.mpf(1) / 2,
    "cos(pi*u)*(1/(1 - 2*u) + 1/(1 + 2*u))": lambda u: (
        2 * mpmath.cospi(u) / (1 - 4 * u * u) if abs(u) != 0.5 else mpmath.pi / 2
    ),
    "sin(2*pi*u)*(1/(1 - 2*u) + 1/(1 + 2*u))": lambda u: (
        2 * mpmath.sinpi(2 * u) / (1 - 4 * u * u) if abs(u) != 0.5 else 2 * u * mpmath.pi
    ),
    "sin(sin(2*pi*u))**2/(1 - 4*u**2)**2": lambda u: (
        (mpmath.sin(mpmath.sinpi(2 * u)) / (1 - 4 * u * u)) ** 2 if abs(u) != 0.5 else mpmath.pi**2 / 4
    ),
    "2*atan(u/(1 + sqrt(1 + u**2)))/u": lambda u: mpmath.atan(u) / u if u else mpmath.mpf(1),
    "(u**2 - k**2*u**4)/(k*u**2 - u)": lambda u: -u * (1 + SIZE * u),
    "u*sinh(k*u)/sinh(u)": lambda u: u * mpmath.sinh(SIZE * u) / mpmath.sinh(u) if u else mpmath.mpf(0),
    "u*sinh(u)/sinh(k*u)": lambda u: u * mpmath.sinh(u) / mpmath.sinh(SIZE * u) if u else mpmath.mpf(0),
    "(sqrt(k + u) - sqrt(k))/u": lambda u: 1 / (mpmath.sqrt(SIZE + u) + mpmath.sqrt(SIZE)),
    "u/(sqrt(4 + u) - 2)": lambda u: mpmath.sqrt(4 + u) + 2,
    "u/(sqrt(4 + k*u) - 2)": lambda u: (mpmath.sqrt(4 + SIZE * u) + 2) / SIZE,
    "(sqrt(1 + u) - 1)/(sqrt(4 + u) - 2)": lambda u: (mpmath.sqrt(4 + u) + 2) / (mpmath.sqrt(1 + u) + 1),
    "(sqrt(k**2 + u) - k)/u": lambda u: 1 / (mpmath.sqrt(SIZE**2 + u) + SIZE),
    "u/(sqrt(k**2 + u) + k)": lambda u: u / (mpmath.sqrt(SIZE**2 + u) + SIZE),
    "u/sin(k*u)": lambda u: 1 / (SIZE * mpmath.sinc(SIZE * u)),
    "sqrt(k + u)/u - sqrt(k - u)/u": lambda u: 2 / (mpmath.sqrt(SIZE + u) + mpmath.sqrt(SIZE - u)),
    "exp(-exp(-1000*u))": lambda u: mpmath.exp(-mpmath.exp(-1000 * u)),
    "atan(k*exp(1000*u))": lambda u: mpmath.atan(SIZE * mpmath.exp(1000 * u)),
}
STATES = [f"y{i}" for i in range(len(LAWS))]


@pytest.fixture(autouse=True)
def digits():
    with mpmath.workdps(60):
        yield


@pytest.fixture(scope="module")
def system():
    rates = dict(zip(STATES, LAWS, strict=True))
    return cd.HybridSystem(
        states=[*STATES, "u"], parameters={"k": SIZE}, modes={"on": {**rates, "u": "1"}}, initial={"u": -0.8}
    )


@pytest.mark.parametrize("u", [0.0, 1e-12, -1e-7, 1e-3, -0.5, 0.51, -0.6, -0.8, 0.79])
def test_values_and_slopes(system, u):
    for (text, law), rate, slope in zip(LAWS.items(), *values_and_slopes(system, u), strict=True):
        place, step = mpmath.mpf(u), mpmath.mpf("1e-18")
        by_u = (law(place + step) - law(place - step)) / (2 * step)
        far = 2000 if "1000" in text else 10
        assert rate == pytest.approx(float(law(place)), rel=1e-15 * far, abs=1e-300), text
        assert slope == pytest.approx(float(by_u), rel=1e-14 * far, abs=1e-14 * far), text


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_runs_pass_the_place(system, method):
    found = cd.trajectory(system, duration=1.6, samples=2, method=method)
    assert found["outcome"] == cd.Outcome.OK
    for (text, law), end in zip(LAWS.items(), found["states"].values[-1], strict=False):
        with mpmath.workdps(25):
            expected = float(mpmath.quad(law, [-0.8, -0.5, -0.01, 0, 0.01, 0.5, 0.8]))
        assert end == pytest.approx(expected, rel=2e-11, abs=1e-12), text


@pytest.mark.parametrize("text", LAWS)
def test_they_survive_being_written_and_derived(text):
    check_survival(text, {"u": U, "k": K})


@pytest.mark.parametrize("u", [1, -1])
def test_places_of_two_states(u):
    expression = read_text("sin(pi*u)*log(k)/((1 - u**2)*(k - 1))", {"u": U, "k": K})
    assert float(without_overflow(expression).subs({U: u, K: 1})) == pytest.approx(u * np.pi / 2, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["sin(u)/u**2", "exp(u)/u", "sin(u)/(1 + u)", "sin(u)/(1 - u**2)", "1/sin(u) + 1/u", "log(u)/u"]
)
def test_a_pole_stays(text):
    expression = read_text(text, {"u": U})
    assert without_overflow(expression) == expression


@pytest.mark.parametrize("guard", ["(x + 7)**2 - 49", "(x + 0.7)**2 - 0.49", "(x + k)**2 - k**2"])
def test_a_guard_is_as_exact_as_its_state(guard):
    """Rebounds down to a height of 1e-25, each half as fast as the one before; the flights are a geometric series."""
    ball = cd.HybridSystem(
        states="x v",
        parameters={"k": 3.0, "e": 0.5},
        modes={"fly": {"x": "v", "v": "-1"}},
        transitions=[cd.Transition("hit", "fly", "fly", guard, -1, reset={"v": "-e*v"})],
        initial={"x": 1e-10, "v": 0.0},
    )
    times = cd.trajectory(ball, duration=4.2e-5, samples=2, method="dop853")["event_time"].values
    expected = np.sqrt(2e-10) * np.concatenate([[1.0], 1 + 2 * np.cumsum(0.5 ** np.arange(1, 20))])
    count = int(np.sum(expected < 4.2e-5))
    np.testing.assert_allclose(times, expected[:count], rtol=1e-12)


def test_a_formula_of_special_functions_is_kept(system):
    """As text, which a process reads that has neither sympy nor numba."""
    values = [0.0] * (len(STATES) + 2) + [SIZE]
    values[-2] = -0.3
    function = function_of(system, "rates", lambda placed: [placed.modes["on"][x] for x in placed.states])
    assert "taylor_rest" in system.shared["formulas"]["rates"]
    system.shared["functions"].clear()
    read = function_of(system, "rates", lambda placed: pytest.fail("it is kept"))
    assert read(*values) == function(*values)
    for law, rate in zip(LAWS.values(), read(*values), strict=False):
        assert rate == pytest.approx(float(law(mpmath.mpf(-0.3))), rel=1e-12)

"""What is even in the root of a sum of squares is analytic where all of them are zero, in any writing."""

import re
from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy
from support.laws import check_survival, values_and_slopes

import chaosdrill as cd
from chaosdrill.codegen import kernels_of, mode
from chaosdrill.codegen.signatures import LANES
from chaosdrill.engine.lanes import aligned
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.model.gates import without_overflow
from chaosdrill.model.special import even_rest
from chaosdrill.model.text import read_text

SIZE, ORDER = 1.5, 23
NAMES = {name: sympy.Symbol(name, real=True) for name in "uyk"}

# of the root r of u**2 + y**2
LAWS = {
    "sin(r)/r": mpmath.sinc,
    "tanh(k*r)/r": lambda r: mpmath.tanh(SIZE * r) / r if r else mpmath.mpf(SIZE),
    "(1 - cos(k*r))/(2*u**2 + 2*y**2)": lambda r: (mpmath.sinc(SIZE * r / 2) * SIZE / 2) ** 2,
    "(tan(r/9) - r/9)/r**3": lambda r: (mpmath.tan(r / 9) - r / 9) / r**3 if r else mpmath.mpf(1) / 2187,
    "cos(r)*exp(-r**2)": lambda r: mpmath.cos(r) * mpmath.exp(-r * r),
    "r*atan(r)": lambda r: r * mpmath.atan(r),
    "log(cosh(k*r))": lambda r: mpmath.log(mpmath.cosh(SIZE * r)),
    "r/asinh(k*r)": lambda r: r / mpmath.asinh(SIZE * r) if r else 1 / mpmath.mpf(SIZE),
    "sinh(r)/r": lambda r: mpmath.sinh(r) / r if r else mpmath.mpf(1),
}
TEXTS = [re.sub(r"\br\b", "sqrt(u**2 + y**2)", text) for text in LAWS]
STATES = [f"z{i}" for i in range(len(LAWS))]


@pytest.fixture(autouse=True)
def digits():
    with mpmath.workdps(60):
        yield


def through_the_place():
    rates = dict(zip(STATES, TEXTS, strict=True))
    modes = {"on": {**rates, "y": "0", "u": "1"}}
    return cd.HybridSystem(states=[*STATES, "y", "u"], parameters={"k": SIZE}, modes=modes, initial={"u": -6.0})


@pytest.fixture(scope="module")
def system():
    return through_the_place()


@pytest.mark.parametrize("u", [0.0, 1e-12, -1e-7, 1e-3, -0.7, 0.9, -1.4, 3.1, -5.0, 6.0])
def test_values_and_slopes(system, u):
    for (text, law), rate, slope in zip(LAWS.items(), *values_and_slopes(system, u), strict=False):
        place, step = mpmath.mpf(u), mpmath.mpf("1e-18")
        by_u = (law(abs(place + step)) - law(abs(place - step))) / (2 * step)
        assert rate == pytest.approx(float(law(abs(place))), rel=1e-13, abs=1e-300), text
        assert slope == pytest.approx(float(by_u), rel=1e-12, abs=1e-13), text


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("beside", [0.0, 1e-3])
def test_runs_pass_the_place(system, method, beside):
    start = system.with_initial(y=beside)
    found = cd.trajectory(start, duration=12.0, samples=2, method=method)
    assert found["outcome"] == cd.Outcome.OK
    for (text, law), end in zip(LAWS.items(), found["states"].values[-1], strict=False):
        with mpmath.workdps(20):
            parts = [-6, -3, -1, -0.1, 0, 0.1, 1, 3, 6]
            expected = float(mpmath.quad(lambda u, f=law: f(mpmath.hypot(u, beside)), parts))
        assert end == pytest.approx(expected, rel=2e-12), text


@pytest.fixture(scope="module", params=["in line", "in tables"])
def kernels(request, system):
    with pytest.MonkeyPatch.context() as patched:
        if request.param == "in tables":
            patched.setattr(mode, "TUNING", replace(mode.TUNING, products_in_line=-1))
            return kernels_of(through_the_place())
        return kernels_of(system)


@pytest.mark.parametrize("u", [0.0, 0.3, 2.5, 7.0])
def test_series_of_runs_and_lanes(kernels, u):
    def lanes(numbers):
        filled = aligned(*np.shape(numbers), LANES)
        filled[:] = np.asarray(numbers)[..., np.newaxis]
        return filled

    c, place = kernels.constants({"k": SIZE}), np.zeros(len(STATES) + 2)
    place[-1] = u
    alone = np.zeros((kernels.layout.rows + 4, COLUMNS))
    beside = aligned(kernels.layout.rows + 4, COLUMNS, LANES)
    beside[:] = 0.0
    kernels.functions.jet(0, ORDER, 0.0, c, place, alone)
    kernels.lanes[0](0, ORDER, lanes(0.0), lanes(c), lanes(place), beside)
    for i, (text, law) in enumerate(LAWS.items()):
        series = mpmath.taylor(lambda h, f=law: f(abs(u + h)), 0, 8)
        expected = [float(a) / (j + 1) for j, a in enumerate(series)]
        np.testing.assert_allclose(alone[i, 1:10], expected, 1e-11, 1e-14, err_msg=text)
        np.testing.assert_allclose(beside[i, : ORDER + 1, 3], alone[i, : ORDER + 1], 1e-12, 1e-14, err_msg=text)


@pytest.mark.parametrize("text", TEXTS)
def test_they_survive_being_written_and_derived(text):
    check_survival(text, NAMES)


@pytest.mark.parametrize(
    "text",
    ["sin(r)/r**2", "exp(r)/r", "r/sinh(r)", "exp(-r)*sinh(r)", "sin(r)", "u/r**3", "acos(u)*sin(u*r)"],
)
def test_what_is_not_even_or_overflows_stays(text):
    expression = read_text(re.sub(r"\br\b", "sqrt(u**2 + y**2)", text), NAMES)
    assert not without_overflow(expression).has(even_rest)


def test_shares_of_factors_and_places_of_their_own():
    """Beside what is not even, and around a place that is not zero, with all digits there."""
    text = "exp(-sqrt(u**2 + y**2))*sin(sqrt(u**2 + y**2))/sqrt(u**2 + y**2) + sin(d)/d"
    made = without_overflow(read_text(text.replace("d", "sqrt((u - 1)**2 + y**2)"), NAMES))
    squares = {f.args[0] for f in made.atoms(even_rest)}
    assert squares == {NAMES["u"] ** 2 + NAMES["y"] ** 2, (NAMES["u"] - 1) ** 2 + NAMES["y"] ** 2}

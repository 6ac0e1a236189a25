"""Gates and pulses have one value however they are written, also where an exponential of theirs is no double."""

import math

import numpy as np
import pytest
import sympy
from hypothesis import example, given
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill.model.gates import without_overflow
from chaosdrill.model.text import read_text, write_text

U, K = sympy.symbols("u k", real=True)

LOGISTIC = (
    "1/(1 + exp(-u))",
    "exp(u)/(1 + exp(u))",
    "exp(u)/(exp(u) + 1.0)",
    "exp(u/2)/(exp(u/2) + exp(-u/2))",
    "exp(u/2)/cosh(u/2)/2",
    "(1 + tanh(u/2))/2",
    "1 - 1/(1 + exp(u))",
    "1 - exp(-u)/(1 + exp(-u))",
    "1/(1 + 1/exp(u))",
    "exp(2*u)/(exp(u) + exp(2*u))",
    "3*exp(u)/(3 + 3*exp(u))",
    "exp(u - 2)/(exp(-2) + exp(u - 2))",
    "(cosh(u/2) + sinh(u/2))/cosh(u/2)/2",
    "sqrt(1/(1 + 2*exp(-u) + exp(-2*u)))",
)
TANH = (
    "tanh(u)",
    "sinh(u)/cosh(u)",
    "(exp(u) - exp(-u))/(exp(u) + exp(-u))",
    "(exp(2*u) - 1)/(exp(2*u) + 1)",
    "sin(atan(sinh(u)))",
    "sinh(2*u)/(1 + cosh(2*u))",
    "(cosh(2*u) - 1)/sinh(2*u)",
)
PULSE = (
    "1/cosh(u)**2",
    "1 - tanh(u)**2",
    "4/(exp(u) + exp(-u))**2",
    "4*exp(2*u)/(1 + exp(2*u))**2",
    "4*exp(-2*u)/(1 + exp(-2*u))**2",
    "2/(1 + cosh(2*u))",
    "1/(1 + sinh(u)**2)",
)
OF_A_GATE = (
    "exp(u)/((1 + exp(u))*(1 + exp(1/(2 + exp(u)))))",
    "(1 + tanh(u/2))/(2 + 2*exp(exp(-u)/(1 + 2*exp(-u))))",
)


def logistic(u):
    return 1 / (1 + math.exp(-u)) if u > -700 else 0.0


VALUES = {
    LOGISTIC: logistic,
    TANH: math.tanh,
    PULSE: lambda u: 4 * logistic(2 * u) * logistic(-2 * u),
    OF_A_GATE: lambda u: logistic(u) / (1 + math.exp(logistic(math.log(2) - u) / 2)),
}
WRITINGS = [(text, value) for texts, value in VALUES.items() for text in texts]


@given(
    writing=st.sampled_from(WRITINGS),
    inner=st.sampled_from(["u", "-u", "50*(u - 1)", "(u - 0.3)/0.06", "k*u", "u**3"]),
    place=st.floats(-40, 40),
    far=st.sampled_from([1.0, 1e3]),
)
@example(writing=("1 - exp(-u)/(1 + exp(-u))", logistic), inner="(u - 0.3)/0.06", place=-1.0, far=1.0)
def test_all_writings_have_the_value_of_the_gate(writing, inner, place, far):
    text, value = writing
    argument = read_text(inner, {"u": U, "k": K})
    made = without_overflow(read_text(text, {"u": U}).xreplace({U: argument}))
    assert without_overflow(made) == made
    at = {U: place * far, K: 7.5}
    w = float(argument.subs(at))
    with np.errstate(over="ignore"):
        found = float(sympy.lambdify((U, K), made, "numpy")(np.float64(at[U]), np.float64(at[K])))
    # what is applied to has rounding of its own, which its tails multiply
    assert found == pytest.approx(value(w), rel=1e-14 * (10 + abs(w)), abs=1e-300)


@pytest.mark.parametrize("text", [*LOGISTIC, *PULSE, "exp(k*u)/(1 + exp(k*u))", "exp(u)/(2 + exp(u))"])
def test_a_gate_survives_being_written(text):
    made = without_overflow(read_text(text, {"u": U, "k": K}))
    assert without_overflow(read_text(write_text(made), {"u": U, "k": K})) == made


@pytest.mark.parametrize(
    "text",
    [
        *("exp(k)/(1 + exp(u))", "1/(1 + exp(-u))", "cosh(u)**(-3)", "sin(u) - k*u**2", "1 - u"),
        "u + sqrt(1 + exp(asinh(exp(cosh(3)))))",  # nobody waits for the digits of this number
    ],
)
def test_what_is_no_such_quotient_stays(text):
    expression = read_text(text, {"u": U, "k": K})
    assert without_overflow(expression) is expression


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("text", ["exp(n*u)/(1 + exp(n*u))", "exp(n*u/2)/(exp(n*u/2) + exp(-n*u/2))"])
def test_a_gate_is_passed_from_far_to_far(text, method):
    """From where the exponential is zero to where it would be infinite; the guard's slope is zero at both ends."""
    passed = cd.HybridSystem(
        states="y u",
        parameters={"n": 1e4},
        modes={"on": {"y": text, "u": "1"}},
        transitions=[cd.Transition("half", "on", "on", f"{text} - 1/2", 1)],
        initial={"y": 0.0, "u": -2.0},
    )
    found = cd.trajectory(passed, duration=5.0, samples=2, method=method)
    assert found["outcome"] == cd.Outcome.OK
    assert found["states"].values[-1] == pytest.approx([3.0, 3.0], rel=1e-11)
    assert found["event_time"].values == pytest.approx([2.0], abs=1e-11)


@pytest.mark.parametrize("above", ["1", "sinh(x)"])
def test_many_factors_are_not_multiplied_out(above):
    """Each hyperbolic function is two exponentials: of thirty factors there would be a billion of them."""
    many = "*".join(f"cosh({k}*x)" for k in range(1, 31))
    written = sympy.sympify(f"({above} + {many})/(1 + exp(x) + {many})")
    assert without_overflow(written) == written


@pytest.mark.parametrize(
    "gate", ["1/(1 + exp(a))", "exp(-a)/(1 + exp(-a))", "(1 - tanh(a/2))/2", "1/(exp(a/2)*cosh(a/2))/2"]
)
def test_an_exponent_keeps_its_digits(gate):
    """The terms of (u/k - 1)**2 are 1 where it is 1e-12: their sum has lost all its digits."""
    made = without_overflow(read_text(gate, {"a": U}).xreplace({U: read_text("1e12*(u/k - 1)**2", {"u": U, "k": K})}))
    u = 20.0 + 2e-5
    value = float(sympy.lambdify((U, K), made, "math")(u, 20.0))
    np.testing.assert_allclose(value, 1 / (1 + math.exp(1e12 * (u / 20.0 - 1) ** 2)), rtol=1e-13)

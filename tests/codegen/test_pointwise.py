"""Field, variation, guards and resets of the compiled kernels against mpmath, derivatives against differences."""

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd

X, Y, Z, T, P = sympy.symbols("x y z t p", real=True)
FIELD = {X: Y * sympy.exp(-P * Z), Y: sympy.sin(X) - sympy.sqrt(1 + Z**2) * sympy.cos(P * T), Z: X**3 / (2 + Y**2)}
GUARD = X * Y - sympy.sin(P * T) + Z**2
RESET = {X: sympy.Mod(3 * X + T, 1), Z: sympy.Abs(Y) * sympy.sqrt(X**2 + P * T), Y: sympy.floor(4 * Y) + X}
STATES = (X, Y, Z)
PLACES = [(0.31, -0.72, 1.4, 0.9), (-1.15, 0.44, -0.27, 5.3), (2.3, 1.9, 0.8, 0.05)]
NUMBER = 0.7


@pytest.fixture(scope="module")
def kernels():
    system = cd.HybridSystem(
        name="pointwise",
        states=STATES,
        time=T,
        parameters={"p": NUMBER},
        modes={"idle": dict.fromkeys(STATES, 0), "on": FIELD},
        transitions=[
            cd.Transition("go", "idle", "on", guard=X - 1, direction=+1),
            cd.Transition("jump", "on", "idle", guard=GUARD, direction=+1, reset=RESET),
        ],
        quadratures={"work": X * Y},
    )
    return system.kernels, system.kernels.constants(system.parameters)


def value(expression, place, t):
    numbers = [mpmath.mpf(v) for v in (*place, t, NUMBER)]
    f = sympy.lambdify((*STATES, T, P), expression, [{"floor": mpmath.floor, "Abs": abs}, "mpmath"])
    return f(*numbers)


def gradient(expression, place, t):
    """Central differences in 40 digits."""
    tiny = mpmath.mpf("1e-12")
    point = [mpmath.mpf(v) for v in (*place, t)]
    found = []
    for j in range(4):
        ahead, behind = ([v + s * tiny * (i == j) for i, v in enumerate(point)] for s in (1, -1))
        difference = value(expression, ahead[:3], ahead[3]) - value(expression, behind[:3], behind[3])
        found.append(float(difference / (2 * tiny)))
    return found


@pytest.fixture(autouse=True)
def digits():
    with mpmath.workdps(40):
        yield


@pytest.mark.parametrize("place", PLACES)
def test_field_and_quadrature(kernels, place):
    functions, c = kernels[0].functions, kernels[1]
    out = np.empty(4)
    functions[3](1, place[3], c, np.array(place[:3]), out)
    expected = [float(value(e, place[:3], place[3])) for e in (*FIELD.values(), X * Y)]
    np.testing.assert_allclose(out, expected, rtol=5e-15)


@pytest.mark.parametrize("place", PLACES)
def test_variation(kernels, place):
    functions, c = kernels[0].functions, kernels[1]
    jacobian = np.array([gradient(e, place[:3], place[3])[:3] for e in FIELD.values()])
    out = np.empty(3)
    for direction in ([1.0, 0, 0], [0.3, -2.0, 0.7]):
        functions[4](1, place[3], c, np.array(place[:3]), np.array(direction), out)
        np.testing.assert_allclose(out, jacobian @ direction, rtol=1e-13)


@pytest.mark.parametrize("place", PLACES)
def test_guard(kernels, place):
    functions, c = kernels[0].functions, kernels[1]
    found = np.empty(4)
    at = functions[5](1, 0, place[3], c, np.array(place[:3]), found)
    assert at == pytest.approx(float(value(GUARD, place[:3], place[3])), rel=1e-14)
    np.testing.assert_allclose(found, gradient(GUARD, place[:3], place[3]), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("place", PLACES)
def test_reset(kernels, place):
    functions, c = kernels[0].functions, kernels[1]
    out, jacobian = np.empty(3), np.empty((3, 4))
    functions[7](1, place[3], c, np.array(place[:3]), out, jacobian)
    np.testing.assert_allclose(out, [float(value(RESET[s], place[:3], place[3])) for s in STATES], rtol=1e-14)
    expected = [gradient(RESET[s], place[:3], place[3]) for s in STATES]
    np.testing.assert_allclose(jacobian, expected, rtol=1e-13, atol=1e-13)


def test_a_mode_or_guard_that_is_not_there_chooses_nothing(kernels):
    functions, c = kernels[0].functions, kernels[1]
    x = np.zeros(3)
    assert functions[6](1, 1, 0.0, c, x, 0.0, np.empty(1)) == -1
    assert functions[6](7, 0, 0.0, c, x, 0.0, np.empty(1)) == -1


def test_constants_are_parameters_first(kernels):
    assert kernels[1][0] == NUMBER

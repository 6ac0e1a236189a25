"""Field, variation, guards and resets of the compiled kernels against mpmath, derivatives against differences."""

import ctypes
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.emitter import DOUBLE, Function, Module
from chaosdrill.codegen.expression import Expressions
from chaosdrill.codegen.machine import compile_object, load
from chaosdrill.codegen.signatures import event_places
from chaosdrill.model.special import positive_power

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
    return kernels_of(system), kernels_of(system).constants(system.parameters)


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
    functions.field(1, place[3], c, np.array(place[:3]), out)
    expected = [float(value(e, place[:3], place[3])) for e in (*FIELD.values(), X * Y)]
    np.testing.assert_allclose(out, expected, rtol=5e-15)


@pytest.mark.parametrize("place", PLACES)
def test_variation_is_jacobian_times_direction(kernels, place):
    functions, c = kernels[0].functions, kernels[1]
    jacobian = np.array([gradient(e, place[:3], place[3])[:3] for e in FIELD.values()])
    out = np.empty(3)
    for direction in ([1.0, 0, 0], [0.3, -2.0, 0.7]):
        functions.variation(1, place[3], c, np.array(place[:3]), np.array(direction), out)
        np.testing.assert_allclose(out, jacobian @ direction, rtol=1e-13)


@pytest.mark.parametrize("place", PLACES)
def test_guard_has_its_value_and_gradient(kernels, place):
    functions, c = kernels[0].functions, kernels[1]
    found = np.empty(4)
    at = functions.guard(1, 0, place[3], c, np.array(place[:3]), found)
    assert at == pytest.approx(float(value(GUARD, place[:3], place[3])), rel=1e-14)
    np.testing.assert_allclose(found, gradient(GUARD, place[:3], place[3]), rtol=1e-13, atol=1e-13)


def crossed(kernels, place, tangents=1):
    """The event of the guard near a place: transition, state on the guard, and the parts of the event by name."""
    functions, c = kernels[0].functions, kernels[1]
    x, places = np.array(place[:3]), event_places(3)
    event = np.full(places.size, np.nan)
    transition = functions.event_map(1, 0, place[3], c, x, tangents, np.ones(3), 1.0, event)
    first = places._asdict()
    order = sorted(first, key=first.get)
    ends = {name: first[later] for name, later in pairwise(order)}
    return transition, x, {name: event[first[name] : ends[name]] for name in order[:-1]}


@pytest.mark.parametrize("place", PLACES)
def test_an_event_puts_the_state_closer_to_the_guard_along_its_gradient(kernels, place):
    _, x, _ = crossed(kernels, place)
    way = np.array(gradient(GUARD, place[:3], place[3])[:3])
    height = float(value(GUARD, place[:3], place[3]))
    np.testing.assert_allclose(x, np.array(place[:3]) - height * way / (way @ way), rtol=1e-13)


@pytest.mark.parametrize("place", PLACES)
def test_parts_of_an_event(kernels, place):
    transition, x, event = crossed(kernels, place)
    t = place[3]
    assert transition == 1
    np.testing.assert_allclose(event["gradient"], gradient(GUARD, x, t), rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(event["before"], [float(value(e, x, t)) for e in FIELD.values()], rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(event["image"], [float(value(RESET[s], x, t)) for s in STATES], rtol=1e-14)
    np.testing.assert_array_equal(event["after"], [0.0, 0.0, 0.0])
    expected = [gradient(RESET[s], x, t) for s in STATES]
    np.testing.assert_allclose(event["jacobian"].reshape(3, 4), expected, rtol=1e-13, atol=1e-13)


def test_the_rate_after_an_event_is_that_of_the_mode_reached(kernels):
    functions, c = kernels[0].functions, kernels[1]
    x, places = np.array([1.0, 0.4, -0.3]), event_places(3)
    event = np.empty(places.size)
    assert functions.event_map(0, 0, 0.9, c, x, 1, np.ones(x.size), 0.0, event) == 0
    expected = [float(value(e, x, 0.9)) for e in FIELD.values()]
    np.testing.assert_allclose(event[places.after : places.image], expected, rtol=1e-14, atol=1e-15)


def test_a_mode_or_guard_that_is_not_there_chooses_nothing(kernels):
    functions, c = kernels[0].functions, kernels[1]
    event = np.empty(event_places(3).size)
    assert functions.event_map(1, 1, 0.0, c, np.zeros(3), 0, np.ones(3), 0.0, event) == -1
    assert functions.event_map(7, 0, 0.0, c, np.zeros(3), 0, np.ones(3), 0.0, event) == -1


def test_constants_are_parameters_first(kernels):
    assert kernels[1][0] == NUMBER


FUNCTIONS = {
    **{name: getattr(sympy, name) for name in ("sin", "cos", "tan", "asin", "atan", "sinh", "cosh", "tanh", "asinh")},
    **{name: getattr(sympy, name) for name in ("exp", "log", "sqrt", "erf", "erfc", "gamma", "ceiling", "floor")},
    "acos": sympy.acos,
    "atanh": sympy.atanh,
    "acosh": lambda x: sympy.acosh(1 + x),
    "loggamma": lambda x: sympy.loggamma(3 + x),
    "atan2": lambda x: sympy.atan2(x, -1),
    "larger": lambda x: sympy.Max(x, Y, P),
    "smaller": lambda x: sympy.Min(x, Y, P),
    "branches": lambda x: sympy.Piecewise((x, (x < Y) | (Y > 3)), (-x, x < 2), (Y, True)),
    "sign": lambda x: sympy.sign(Y - x),
    "remainder of a negative number": lambda x: sympy.Mod(-x, P),
    "remainder by a negative number": lambda x: sympy.Mod(x, -P),
    "negative power": lambda x: 3 * Y / (x**2 * (1 + x) ** sympy.Rational(3, 2)),
    "parameter's power": lambda x: x**P - P**x,
}


def test_every_function_of_resets_and_conditions():
    module, row = Module(), DOUBLE.as_pointer()
    f = Function(module, "every", {"x": row, "out": row})
    x, out = (f.row(argument) for argument in f.arguments)
    made = [function(X) for function in FUNCTIONS.values()]
    values = Expressions(f, {symbol: x[i] for i, symbol in enumerate((X, Y, P))}, made)
    for i, e in enumerate(made):
        out[i] = values[e]
    f.end()
    library = load(compile_object(str(module)), {})
    call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(library.address("every"))
    for place in ((0.37, 0.81, NUMBER), (0.62, 0.15, NUMBER)):
        given, found = np.array(place), np.empty(len(made))
        call(given.ctypes.data, found.ctypes.data)
        for name, e, value in zip(FUNCTIONS, made, found, strict=True):
            expected = float(sympy.N(e.subs(dict(zip((X, Y, P), place, strict=True))), 30))
            assert value == pytest.approx(expected, rel=4e-15), name


def test_the_force_of_a_contact_that_has_just_begun():
    """At depths of a rounding below zero the force and its derivative are zero, not what is no number."""
    d, k, n = sympy.symbols("d k n", real=True)
    system = cd.HybridSystem(
        name="contact",
        states=(d, X),
        parameters={"k": 3.0, "n": 1.5},
        modes={"touch": {d: X, X: -k * positive_power(d, n)}},
    )
    kernels, c = kernels_of(system), kernels_of(system).constants(system.parameters)
    out = np.empty(2)
    for depth, slope in ((-1e-300, 0.0), (0.0, 0.0), (0.25, -3.0 * 1.5 * 0.5)):
        kernels.functions.variation(0, 0.0, c, np.array([depth, 1.0]), np.array([1.0, 2.0]), out)
        np.testing.assert_allclose(out, [2.0, slope], rtol=1e-15)

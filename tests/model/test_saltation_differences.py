"""The saltation matrix against finite differences of an exact flow, solved by hand with 50 digits.

A ball under gravity meets a floor that moves: both flights are parabolas and the time of contact is a root that mpmath
finds, so nothing of the package is in the reference.
"""

import mpmath
import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.model.derive import saltation

X, V, T, G, A, OMEGA, E = sympy.symbols("x v t g a omega e", real=True)
NUMBERS = {"g": 1.3, "a": 0.4, "omega": 1.7, "e": 0.6}
FLOOR = A * sympy.sin(OMEGA * T)
SPEED = sympy.diff(FLOOR, T)


@pytest.fixture(scope="module")
def ball():
    return cd.HybridSystem(
        name="ball",
        states=(X, V),
        time=T,
        parameters=NUMBERS,
        modes={"flight": {X: V, V: -G}},
        transitions=[
            cd.Transition("hit", "flight", "flight", guard=X - FLOOR, direction=-1, reset={V: SPEED - E * (V - SPEED)})
        ],
    )


def exact_map(start, numbers, before, after):
    """State at time ``after`` from the one at ``before``, one hit in between, and the state and time of the hit."""
    g, a, omega, e = (mpmath.mpf(numbers[key]) for key in ("g", "a", "omega", "e"))
    x, v = start

    def gap(s):
        return x + v * s - g * s * s / 2 - a * mpmath.sin(omega * (before + s))

    s = mpmath.findroot(gap, after - before - mpmath.mpf("0.1"))
    speed = a * omega * mpmath.cos(omega * (before + s))
    place, meet = a * mpmath.sin(omega * (before + s)), v - g * s
    leave = speed - e * (meet - speed)
    rest = after - before - s
    return (place + leave * rest - g * rest * rest / 2, leave - g * rest), (place, meet, before + s)


@pytest.fixture(scope="module")
def meeting():
    """Start a while before a hit, and the time after it."""
    mpmath.mp.dps = 50
    yield (mpmath.mpf("0.9"), mpmath.mpf("-0.4")), mpmath.mpf("0.3"), mpmath.mpf("1.2")
    mpmath.mp.dps = 15


def numeric(matrix, system, place):
    values = {**system.parameters, "x": place[0], "v": place[1], "t": place[2]}
    return np.array(matrix.subs({s: values[s.name] for s in matrix.free_symbols}).evalf(30), dtype=float)


def flight(duration):
    return np.array([[1.0, float(duration)], [0.0, 1.0]])


def differences(function, count):
    step = mpmath.mpf("1e-15")
    columns = []
    for j in range(count):
        ahead, behind = function(j, step), function(j, -step)
        columns.append([float((p - m) / (2 * step)) for p, m in zip(ahead, behind, strict=True)])
    return np.array(columns).T


def test_columns_of_states_are_differences(ball, meeting):
    start, before, after = meeting
    _, place = exact_map(start, NUMBERS, before, after)

    def shifted(j, step):
        moved = [value + (step if i == j else 0) for i, value in enumerate(start)]
        return exact_map(moved, NUMBERS, before, after)[0]

    jump = numeric(saltation(ball, ball.transitions[0]), ball, place)
    product = flight(after - place[2]) @ jump @ flight(place[2] - before)
    np.testing.assert_allclose(product, differences(shifted, 2), rtol=1e-12)


@pytest.mark.parametrize("name", ["a", "e", "omega"])
def test_columns_of_parameters_are_differences(ball, meeting, name):
    """The column of a parameter that only the event knows: flow after the hit times that column."""
    start, before, after = meeting
    _, place = exact_map(start, NUMBERS, before, after)

    def shifted(_, step):
        return exact_map(start, {**NUMBERS, name: mpmath.mpf(NUMBERS[name]) + step}, before, after)[0]

    wide = ball.augmented(time=True, parameters=[name])
    values = {**NUMBERS, "x": place[0], "v": place[1], "t": place[2]}
    matrix = saltation(wide, wide.transitions[0])
    jump = np.array(matrix.subs({s: values[s.name] for s in matrix.free_symbols}).evalf(30), dtype=float)
    column = flight(after - place[2]) @ jump[:2, 3]
    np.testing.assert_allclose(column, differences(shifted, 1)[:, 0], rtol=1e-12)


def test_column_of_time_is_a_difference(ball, meeting):
    """The column of time: starting later with the same state."""
    start, before, after = meeting
    _, place = exact_map(start, NUMBERS, before, after)

    def shifted(_, step):
        return exact_map(start, NUMBERS, before + step, after + step)[0]

    wide = ball.augmented(time=True)
    matrix = saltation(wide, wide.transitions[0])
    values = {**NUMBERS, "x": place[0], "v": place[1], "t": place[2]}
    jump = np.array(matrix.subs({s: values[s.name] for s in matrix.free_symbols}).evalf(30), dtype=float)
    column = flight(after - place[2]) @ jump[:2, 2]
    np.testing.assert_allclose(column, differences(shifted, 1)[:, 0], rtol=1e-12)

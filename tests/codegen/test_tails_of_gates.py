"""Pulses and gates far from where they act, zero or one there, though their cosh or exponential is no double."""

import math

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.model.definition import build_defined, write_definition

T = sympy.Symbol("t", real=True)


def flow(rate, **words):
    return cd.HybridSystem(
        name="tail", states="x", parameters={}, modes={"on": {"x": rate}}, initial={"x": 0.0}, **words
    )


def rate_of(system):
    (rate,) = system.modes["on"].values()
    return rate


def end(rate, duration=10.0, **words):
    found = cd.trajectory(flow(rate), duration=duration, samples=2, **words)
    assert found["outcome"] == cd.Outcome.OK
    return float(found["states"][-1, 0])


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize(
    ("rate", "integral"),
    [
        ("1/cosh((t - 5)/1e-3)", 1e-3 * math.pi),
        ("1/cosh((t - 5)/1e-3)**2", 2e-3),
        ("1/(1 + exp(-(t - 2)/1e-4))", 8.0),
        ("1/(1.0 + exp((t - 2)/1e-4))**2", 2.0 - 1e-4),
        ("exp((t - 9.9)/0.012)", 0.012 * math.exp(0.1 / 0.012)),
    ],
)
def test_tails_are_followed(rate, integral, method):
    assert end(rate, method=method) == pytest.approx(integral, rel=1e-11)


@pytest.mark.parametrize("sign", [1, -1])
def test_an_exponential_that_sympy_has_divided_is_one_again(sign):
    far = sign * 900.25
    divided = sympy.exp(-T + far) if sign < 0 else sympy.exp(T - far)
    assert divided.is_Mul
    assert float(rate_of(flow(divided)).subs(T, far)) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("rate", ["3*exp((t - 800.1)/0.7)", "exp(t/3 - 1/3)", "exp(0.5 - t)"])
def test_numbers_of_exponents_survive_being_written(rate):
    made = flow(rate)
    again = build_defined(write_definition(made), made.parameters, made.initial)
    assert repr(rate_of(again)) == repr(rate_of(made))
    assert float(rate_of(made).subs(T, 1.0)) == pytest.approx(eval(rate, {"exp": math.exp, "t": 1.0}), rel=1e-12)


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize(("force", "outcome"), [("-x", cd.Outcome.OK), ("x", cd.Outcome.ESCAPED)])
def test_a_unit_in_which_states_are_large_ends_no_run(force, outcome, unit):
    moves = cd.HybridSystem(
        name="moves",
        states="x v",
        parameters={},
        modes={"on": {"x": "v", "v": force}},
        initial={"x": unit, "v": 0.0},
    )
    found = cd.trajectory(moves, duration=16 * math.pi, samples=2)
    assert found["outcome"] == outcome
    assert outcome != cd.Outcome.OK or found["states"][-1].values == pytest.approx([unit, 0.0], abs=1e-10 * unit)

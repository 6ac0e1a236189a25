"""A parameter in an exponent is the whole number that it holds; other systems' code does not change for it."""

import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kernels import write
from chaosdrill.codegen.special import hunt_crossley_duration
from chaosdrill.codegen.special import positive_power as numeric_power
from chaosdrill.model.exponents import exponent_parameters, specialise
from chaosdrill.model.special import positive_power

D, V, K, N = sympy.symbols("d v k n", real=True)


def contact(n, force=D**N):
    """An elastic contact that begins at d = 0, where a power that is not whole has no series."""
    return cd.HybridSystem(
        name="contact",
        states=(D, V),
        parameters={"k": 1e6, "n": n},
        modes={"touch": {D: V, V: -K * force}, "apart": {D: V, V: 0}},
        transitions=[cd.Transition("part", "touch", "apart", guard=D, direction=-1)],
        initial={"mode": "touch", V: 1.0},
    )


@pytest.mark.parametrize("force", [D**N, positive_power(D, N)], ids=str)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_contact_of_whole_exponent_starts_at_no_depth(n, force):
    run = cd.trajectory(contact(n, force), duration=1.0, tolerance=1e-13)
    assert run["event_time"].values == pytest.approx([hunt_crossley_duration(1.0, 0.0, float(n), 1e6)], rel=1e-12)
    assert run["event_state_before"].values[0, 1] == pytest.approx(-1.0, rel=1e-12)


@pytest.mark.parametrize("force", [D**N, positive_power(D, N)], ids=str)
def test_another_exponent_ends_the_taylor_method_with_advice(force):
    run = cd.trajectory(contact(1.5, force), duration=1.0)
    assert cd.Outcome(int(run["outcome"])) is cd.Outcome.NONFINITE
    assert "dop853" in cd.Outcome.NONFINITE.advice


def test_where_it_is_analytic_any_exponent_has_a_series():
    system = contact(1.5, positive_power(D, N)).with_initial(d=1e-3, v=0.0)
    run = cd.trajectory(system, duration=1e-3)
    speed, depth = run["state"].values[-1, 1], run["state"].values[-1, 0]
    assert speed**2 / 2 == pytest.approx(1e6 * (1e-3**2.5 - depth**2.5) / 2.5, rel=1e-12)


def test_copies_with_another_whole_exponent_have_kernels_of_their_own():
    linear = contact(1.0)
    square = linear.with_parameters(n=2.0)
    assert kernels_of(linear.with_parameters(k=3.0)) is kernels_of(linear)
    assert kernels_of(square) is not kernels_of(linear)
    assert kernels_of(square.with_parameters(n=1)) is kernels_of(linear)
    assert kernels_of(linear.with_parameters(n=1.5)) is kernels_of(linear.with_parameters(n=1.25))


def test_exponents_are_found_where_they_stand_alone_or_in_a_sum():
    assert exponent_parameters(contact(1.0, D ** (2 * N - 1))) == ("n",)
    assert exponent_parameters(contact(1.0, positive_power(D, N))) == ("n",)
    assert exponent_parameters(contact(1.0, D * sympy.exp(-N * D) * 2**N)) == ()


def test_only_the_exponent_becomes_a_number():
    system = specialise(contact(1.0, N * D**N), {"n": 3})
    assert system.modes["touch"][V] == -K * N * D**3


def test_the_code_of_a_linear_contact_is_that_of_a_spring():
    special = write(specialise(contact(1.0, positive_power(D, N)), {"n": 1}))
    assert special.single == write(contact(1.0, D)).single


def test_the_power_of_what_is_not_positive_is_zero():
    assert numeric_power(-0.5, 1.5) == 0.0
    assert numeric_power(0.25, 1.5) == pytest.approx(0.125, rel=1e-15)
    slope = sympy.lambdify((D, N), sympy.diff(positive_power(D, N), D), [{"positive_power": numeric_power}])
    assert slope(0.25, 1.5) == pytest.approx(0.75, rel=1e-15)
    assert slope(0.0, 1.5) == 0.0
    assert sympy.diff(positive_power(D, N), N) == positive_power(D, N) * sympy.log(D)

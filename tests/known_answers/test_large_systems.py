"""Systems of many states: Lorenz's ring of 1996, rotors in a mean field, a chain of masses with a stop."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd

K = sympy.Symbol("k", real=True)
MASSES = 64


def chain(masses=MASSES):
    t = sympy.Symbol("t", real=True)
    x, v = (sympy.symbols(f"{letter}0:{masses}", real=True) for letter in "xv")
    rates = dict(zip(x, v, strict=True))
    for i in range(masses):
        pull = -(x[i] ** 3) - v[i] / 10 - (x[i] - (x[i - 1] if i else 0))
        rates[v[i]] = pull + (x[i + 1] - x[i] if i < masses - 1 else K * sympy.cos(6 * t / 5))
    hit = cd.Transition("hit", "on", "on", guard=x[-1] - 1, direction=1, reset={v[-1]: -0.7 * v[-1]})
    period = 5 * sympy.pi / 3
    return cd.HybridSystem(
        name="chain",
        states=(*x, *v),
        time=t,
        parameters={"k": 3.0},
        modes={"on": rates},
        transitions=[hit],
        period=period,
    )


def test_all_exponents_of_the_ring():
    """Their sum is the divergence, -40; the largest 1.68(2) and the dimension 27.1(3) are those of the literature."""
    found = cd.lyapunov_spectrum(cd.build("lorenz-96"), duration=150, transient=20, blocks=64, tolerance=1e-10)
    exponents, errors = found["lyapunov_exponent"].values, found["lyapunov_error"].values
    assert exponents.sum() == pytest.approx(-40, abs=1e-9)
    assert exponents[0] == pytest.approx(1.68, abs=0.02 + 3 * errors[0])
    assert float(found["kaplan_yorke_dimension"]) == pytest.approx(27.1, abs=0.3)
    assert int(found["outcome"]) == cd.Outcome.CHAOTIC


@pytest.mark.parametrize("count", [1, 6])
def test_few_exponents_of_the_ring_are_the_first(count):
    found = cd.lyapunov_spectrum(
        cd.build("lorenz-96"), duration=150, transient=20, exponents=count, blocks=64, tolerance=1e-10
    )
    assert found.sizes["exponent"] == count
    assert float(found["lyapunov_exponent"][0]) == pytest.approx(1.68, abs=0.02 + 3 * float(found["lyapunov_error"][0]))
    assert int(found["outcome"]) == cd.Outcome.CHAOTIC
    assert int(found["rank"]) == 40


def test_rotors_that_their_mean_field_locks():
    """Strongly coupled they turn as one: a shift of all angles neither grows nor decays, everything else does.

    The sum of all exponents is the mean divergence, k (1 - n r^2) with the order parameter r, which rests.
    """
    found = cd.lyapunov_spectrum(cd.build("kuramoto"), duration=60, transient=60, blocks=16, tolerance=1e-11)
    exponents = found["lyapunov_exponent"].values
    assert exponents[0] == pytest.approx(0, abs=1e-9)
    assert exponents[1] < -0.1
    angles = cd.trajectory(cd.build("kuramoto"), duration=120, samples=1, tolerance=1e-11)["state"].values[-1]
    order = abs(np.exp(1j * angles).mean())
    assert exponents.sum() == pytest.approx(3.0 * (1 - 50 * order**2), abs=1e-6)
    assert int(found["outcome"]) == cd.Outcome.PERIODIC


def test_a_chain_of_many_masses_with_a_stop():
    """The sum of all exponents is the damping and what every hit adds; fewer are the first of all."""
    run = {"periods": 30, "transient": 30, "blocks": 30, "tolerance": 1e-10}
    whole, part = cd.lyapunov_spectrum(chain(), **run), cd.lyapunov_spectrum(chain(), exponents=4, **run)
    hits = int(whole["event_count"].sum())
    time = 30 * 5 * np.pi / 3
    assert hits > 0
    total = float(whole["lyapunov_exponent"].sum())
    assert total == pytest.approx(-MASSES / 10 + 2 * np.log(0.7) * hits / time, abs=1e-8)
    assert int(part["rank"]) == int(whole["rank"]) == 2 * MASSES
    assert part["outcome"] == whole["outcome"]
    gap = np.abs(part["lyapunov_exponent"] - whole["lyapunov_exponent"][:4]).values
    assert (gap <= 5 * np.hypot(part["lyapunov_error"], whole["lyapunov_error"][:4]).values).all()

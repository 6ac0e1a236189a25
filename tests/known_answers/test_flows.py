"""Flows, piecewise flows, and large ones: exponents in closed form and published."""

from math import log, sqrt

import numpy as np
import pytest
import sympy

import chaosdrill as cd

K = sympy.Symbol("k", real=True)


# Lorenz and Rössler: smooth flows, the first of them with a constant divergence.


CASES = [
    ("lorenz", [0.9056, 0.0, -14.572], [2e-4, 1e-4, 5e-4], 10_000),
    ("roessler", [0.0718, 0.0, -5.3945], [3e-4, 1e-4, 3e-3], 20_000),
]


@pytest.mark.parametrize(("name", "known", "errors", "duration"), CASES)
def test_exponents(name, known, errors, duration, agrees):
    spectrum = cd.lyapunov_spectrum(cd.build(name), duration=duration, transient=200)
    assert agrees(spectrum, known, errors)
    assert abs(float(spectrum["lyapunov_exponent"][1])) < 1e-3
    assert float(spectrum["lyapunov_error"][0]) < 5e-3


def test_sum_is_the_divergence_of_the_lorenz_flow():
    spectrum = cd.lyapunov_spectrum(cd.build("lorenz"), duration=200, transient=20)
    assert float(spectrum["lyapunov_exponent"].sum()) == pytest.approx(-(10 + 1 + 8 / 3), abs=1e-9)


def test_dimension_of_the_lorenz_attractor():
    spectrum = cd.lyapunov_spectrum(cd.build("lorenz"), duration=5000, transient=200)
    assert float(spectrum["kaplan_yorke_dimension"]) == pytest.approx(2.0621, abs=2e-3)


# Chua's circuit, piecewise linear: its field is continuous, so the breaks add nothing.


@pytest.mark.parametrize(
    ("alpha", "beta", "known", "errors"),
    [
        (9.0, 100 / 7, [0.3268, 0.0, -2.523], [9e-4, 1e-3, 3e-3]),
        (15.6, 28.0, [0.4313, 0.0, -4.222], [1.2e-3, 1e-3, 2e-3]),
    ],
)
def test_exponents_of_chua(alpha, beta, known, errors, agrees):
    system = cd.build("chua", {"alpha": alpha, "beta": beta})
    spectrum = cd.lyapunov_spectrum(system, duration=20_000, transient=500)
    assert agrees(spectrum, known, errors)
    assert float(spectrum["lyapunov_error"][0]) < 1e-2
    assert abs(float(spectrum["lyapunov_exponent"][1])) < 1e-3
    assert int(spectrum["outcome"]) == cd.Outcome.CHAOTIC


# Saddle with a tripling reset: the spectrum is ln 3, 0 and -0.7 per unit time.


@pytest.fixture(scope="module")
def spectrum():
    return cd.lyapunov_spectrum(cd.build("saddle-reset"), duration=200_000, transient=100)


def test_stretching_is_ln_3_within_its_error_bar(spectrum):
    value, error = (float(spectrum[name][0]) for name in ("lyapunov_exponent", "lyapunov_error"))
    assert abs(value - log(3)) < 3 * error
    # times between returns are -ln x, of mean 1; their variances and covariances under x := 3x mod 1 add up to 2.42
    right = log(3) * sqrt(2.42 / 200_000)
    assert right / 2 < error < 2 * right


def test_flow_direction_neither_grows_nor_decays(spectrum):
    # what is left is the change of |F| over the whole run, divided by its length
    assert abs(float(spectrum["lyapunov_exponent"][1])) < 1e-4


def test_driven_coordinate_decays_at_its_rate(spectrum):
    assert float(spectrum["lyapunov_exponent"][2]) == pytest.approx(-0.7, abs=1e-12)


def test_the_return_map_triples_in_time_minus_ln_x():
    run = cd.trajectory(cd.build("saddle-reset"), duration=2000, samples=2)
    x, times = run["event_state_after"].values[:, 0], run["event_time"].values
    assert len(x) > 1500
    np.testing.assert_allclose((x[1:] - 3 * x[:-1] + 0.5) % 1, 0.5, atol=1e-11)
    np.testing.assert_allclose(np.diff(times), -np.log(x[:-1]), atol=1e-11)


# Tilted switch: all stretching is saltation, ln(3)/5 exactly; a code without it prints 0.


def test_spectrum_is_exact():
    spectrum = cd.lyapunov_spectrum(cd.build("tilted-switch"), duration=5 * 2000, transient=5 * 20)
    exponents = spectrum["lyapunov_exponent"].values
    np.testing.assert_allclose(exponents, [log(3) / 5, 0.0], atol=1e-10)
    assert abs(exponents[0] - 0.21972245773362) < 1e-10


def test_every_return_takes_five_and_triples():
    run = cd.trajectory(cd.build("tilted-switch"), duration=5 * 60, samples=2)
    back = run.cd.words("event_kind").values == "return"
    np.testing.assert_allclose(np.diff(run["event_time"].values[back]), 5, atol=1e-12)
    x = run["event_state_after"].values[back, 0]
    np.testing.assert_allclose((x[1:] - 3 * x[:-1] + 0.5) % 1, 0.5, atol=1e-12)


# Systems of many states: Lorenz's ring of 1996, rotors in a mean field, a chain of masses with a stop.


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
    found = cd.lyapunov_spectrum(cd.build("lorenz-96"), duration=800, transient=20, blocks=64, tolerance=1e-8)
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
    angles = cd.trajectory(cd.build("kuramoto"), duration=120, samples=1, tolerance=1e-11)["states"].values[-1]
    order = abs(np.exp(1j * angles).mean())
    assert exponents.sum() == pytest.approx(3.0 * (1 - 50 * order**2), abs=1e-6)
    # their own rates have the mean zero: locked, they rest
    assert int(found["outcome"]) == cd.Outcome.EQUILIBRIUM


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

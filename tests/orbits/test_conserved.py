"""Orbits that are one of a family because a quantity is conserved, here in closed form."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

from chaosdrill import HybridSystem, ModelError, Outcome, Transition, build, continue_orbit, on_level, periodic_orbit


def pendulum(unit=1.0, order="x v"):
    return HybridSystem(
        name="pendulum", states=order, parameters={"k": 1.0}, modes={"f": {"x": "v", "v": f"-k*{unit}*sin(x/{unit})"}},
        transitions=[], initial={"x": 1.0 * unit, "v": 0.0},
    )  # fmt: skip


def walled(guard="x - 0.5", **reset):
    """An oscillator that hardens, with an elastic wall."""
    return HybridSystem(
        name="walled", states="x v", parameters={"k": 1.0}, modes={"f": {"x": "v", "v": "-k*x - x**3"}},
        transitions=[Transition("hit", "f", "f", guard, direction=1, reset={"v": "-v", **reset})],
        initial={"x": -1.0, "v": 0.0},
    )  # fmt: skip


def walled_period(k, speed):
    """Time from the wall back to it, by quadrature of the energy."""
    energy = speed**2 / 2 + k / 8 + 1 / 64
    # x = -a is where k x^2/2 + x^4/4 is the energy; x = -a cos(s) takes the root at the turning point away
    a = np.sqrt(-k + np.sqrt(k * k + 4 * energy))
    end = np.pi - np.arccos(0.5 / a)
    return 2 * quad(lambda s: 1 / np.sqrt(k + a * a * (1 + np.cos(s) ** 2) / 2), 0, end, epsabs=1e-13)[0]


def test_the_pendulum_through_its_start():
    # of the other members Newton's method knows no reason to prefer one
    for unit, order in ((1.0, "x v"), (1e4, "v x")):
        found = periodic_orbit(pendulum(unit, order), start="guess")
        assert int(found["outcome"]) == Outcome.PERIODIC
        assert float(found["period_time"]) == pytest.approx(4 * ellipk(np.sin(0.5) ** 2), rel=1e-10)
        assert int(found["neutral"]) == 2
        assert "conserved" in found.attrs["message"]


def test_a_branch_of_the_pendulum():
    # x at the start is kept, so that the period goes with the root of k
    branch = continue_orbit(pendulum(), {"k": (0.8, 1.2)}, start="guess")
    assert branch.sizes["special"] == 0
    assert np.diff(branch["k"]).min() > 0
    np.testing.assert_allclose(branch["period_time"], 4 * ellipk(np.sin(0.5) ** 2) / np.sqrt(branch["k"]), rtol=1e-9)


def test_a_branch_with_an_elastic_wall():
    branch = continue_orbit(walled(), {"k": (0.8, 1.2)}, at="hit")
    k = branch["k"].values
    assert branch.sizes["special"] == 0
    assert np.diff(k).min() > 0
    np.testing.assert_allclose(k[[0, -1]], [0.8, 1.2], atol=1e-12)
    # on the wall x is what it is, and with it v is kept
    speeds = branch["section"].values.reshape(len(k), -1, 2)[:, 0, 1]
    np.testing.assert_allclose(speeds, speeds[0], rtol=1e-7)
    expected = [walled_period(a, v) for a, v in zip(k[::20], speeds[::20], strict=True)]
    np.testing.assert_allclose(branch["period_time"][::20], expected, rtol=1e-9)


def test_what_is_conserved_is_the_differential_of_the_energy():
    found = periodic_orbit(walled(), at="hit", start="guess")
    assert found["section"].values[0, 1] == pytest.approx(np.sqrt(2 * (1 / 2 + 1 / 4 - 1 / 8 - 1 / 64)), rel=1e-10)
    # behind the wall it is (k x + x^3, v) = (0.625, -1.10397)
    message = found.attrs["message"]
    words = message.split("; ")[1].split(",")[0].split()
    slope, speed = float(words[0]), float("".join(words[2:4]))
    assert slope / speed == pytest.approx(-0.625 / found["section"].values[0, 1], rel=5e-3)


def test_a_cycle_that_attracts_is_no_family():
    lossy = walled(v="-0.9*v - 0.1")
    for system, at in ((lossy, "hit"), (van_der_pol(), None)):
        found = periodic_orbit(system, **({"at": at} if at else {}))
        assert int(found["outcome"]) == Outcome.PERIODIC
        assert int(found["neutral"]) == 1
        assert "conserved" not in found.attrs["message"]


def test_a_family_of_the_pendulum_is_a_branch_over_its_energy():
    system = on_level(pendulum(), "v**2/2 - k*cos(x)", name="energy", rate=0.2)
    assert system.parameters["energy"] == pytest.approx(-np.cos(1), rel=1e-15)
    branch = continue_orbit(system, {"energy": (-0.8, 0.5)}, start="guess", step=0.1)
    assert branch.sizes["special"] == 0
    assert (branch["energy"].values.min(), branch["energy"].values.max()) == (-0.8, 0.5)
    period = 4 * ellipk((1 + branch["energy"].values) / 2)
    np.testing.assert_allclose(branch["period_time"], period, rtol=1e-11)
    found = np.sort(branch["multiplier_real"].values, axis=1)
    np.testing.assert_allclose(found, np.stack([np.exp(-0.2 * period), np.ones(len(period))], axis=1), rtol=1e-9)


ENERGY = "v**2/2 + k*x**2/2 + x**4/4"


@pytest.mark.parametrize(
    ("system", "conserved", "told"),
    [
        (walled(), ENERGY.replace("k", "2"), "mode 'f' changes it"),
        (walled(v="-0.9*v"), ENERGY, "transition 'hit' changes it"),
        (walled("(x - 0.5)**3", v="-0.9*v"), ENERGY, "transition 'hit' changes it"),
        (walled("exp(-x**2) - 2"), ENERGY, "no state on the guard of 'hit' was found"),
        (walled(), f"log({ENERGY} - 1)", "in the initial state it is .*, not a number"),
        (walled(), {"g": ENERGY}, "unknown mode 'g'"),
        (walled(), "v**2/2 + w", "holds 'w'"),
        (walled(), "k", "holds no state"),
        (build("impact-oscillator"), "v**2", "depends on time"),
        (build("lorenz"), "x**2", "mode 'flow' changes it"),
    ],
)
def test_what_is_not_conserved_has_no_level(system, conserved, told):
    with pytest.raises(ModelError, match=told):
        on_level(system, conserved)


def test_a_parameter_pi_is_no_number():
    system = HybridSystem(
        name="spring", states="x v", parameters={"pi": 2.0}, modes={"f": {"x": "v", "v": "-pi*x"}}, initial={"x": 1.0}
    )  # fmt: skip
    assert on_level(system, "v**2/2 + pi*x**2/2").parameters["level"] == pytest.approx(1.0, rel=1e-15)


def test_an_elastic_wall_keeps_the_energy():
    system = on_level(walled(), ENERGY)
    found = periodic_orbit(system, at="hit", start="guess")
    assert float(found["period_time"]) == pytest.approx(walled_period(1.0, found["section"].values[0, 1]), rel=1e-9)
    assert found["section"].values[0, 1] == pytest.approx(np.sqrt(2 * (3 / 4 - 1 / 8 - 1 / 64)), rel=1e-11)


def van_der_pol():
    return HybridSystem(
        name="vdp", states="x v", parameters={}, modes={"f": {"x": "v", "v": "(1 - x**2)*v - x"}}, transitions=[],
        initial={"x": 2.0, "v": 0.0},
    )  # fmt: skip

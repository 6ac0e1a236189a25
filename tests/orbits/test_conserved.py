"""Orbits that are one of a family because a quantity is conserved, here in closed form."""

import math
import re

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


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_a_coarse_tolerance_finds_the_same_member(tolerance, method):
    # steps keep the energy to their tolerance only, and no equation is solved for it
    found = periodic_orbit(pendulum(), start="guess", tolerance=tolerance, method=method)
    assert int(found["neutral"]) == 2
    assert found["orbit_state"].values == pytest.approx([1, 0], abs=10 * tolerance)
    assert float(found["period_time"]) == pytest.approx(4 * ellipk(np.sin(0.5) ** 2), rel=10 * tolerance)


def test_a_weak_attraction_is_no_conserved_quantity():
    # van der Pol's cycle has the radius 2 and the multiplier 1 - tau mu, to first order in mu
    for mu, tolerance in ((1e-5, 1e-6), (1e-6, 1e-8), (1e-7, 1e-10)):
        weak = HybridSystem(
            states="x v", parameters={}, modes={"f": {"x": "v", "v": f"{mu}*(1 - x**2)*v - x"}}, initial={"x": 2.02}
        )
        found = periodic_orbit(weak, start="guess", tolerance=tolerance)
        assert int(found["neutral"]) == 1
        assert found["multiplier_real"].values[1] == pytest.approx(1 - math.tau * mu, abs=0.01 * mu)


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


@pytest.mark.parametrize("back", ["0", "p - 1"])
def test_a_branch_keeps_the_phase_of_a_clock(back):
    """x' = -x + b cos(2 pi t), with a push when a clock p strikes: half a period after each strobe, at every a."""
    push = Transition("push", "run", "run", "p - 1", +1, reset={"x": "x + a", "p": back})
    pushed = HybridSystem(
        states="x p",
        parameters={"a": 0.5, "b": 1.0},
        modes={"run": {"x": "-x + b*cos(2*pi*t)", "p": "1"}},
        transitions=[push],
        period="1",
        initial={"x": 0.2, "p": 0.5},
    )
    branch = continue_orbit(pushed, {"a": (0.1, 2.0)})
    a = branch["a"].values
    assert (a.min(), a.max()) == pytest.approx((0.1, 2.0))
    x, p = branch["orbit_state"].values.reshape(-1, 2).T
    np.testing.assert_allclose(p, 0.5, rtol=1e-12)
    swing = 1 / (1 + 4 * np.pi**2)
    np.testing.assert_allclose(x, swing + a * np.exp(-0.5) / (1 - np.exp(-1)), rtol=1e-11)


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


def ending(branch):
    """The value in the words of the end at the lower level, its error, and the words."""
    words = branch["branch_end_text"].item().split("; at its start: ")[-1]
    value, error = re.search(r"= (\S+) \(error (\S+)\)$", words).groups()
    return float(value), float(error), words


@pytest.mark.parametrize(("unit", "pace", "order"), [(1.0, 1.0, "x v"), (1e-6, 1e6, "v x")])
def test_a_family_ends_at_its_centre_in_any_unit(unit, pace, order):
    swing = HybridSystem(
        name="swing", states=order, parameters={"w": pace, "u": unit}, initial={"x": unit, "v": 0.0},
        modes={"f": {"x": "v", "v": "-w**2*u*sin(x/u)"}},
    )  # fmt: skip
    system, energy = on_level(swing, "v**2/2 - w**2*u**2*cos(x/u)", rate=pace), (unit * pace) ** 2
    branch = continue_orbit(system, {"level": (-2 * energy, 0.5 * energy)}, start="guess", max_return=20 / pace)
    value, error, words = ending(branch)
    assert "it shrinks onto the equilibrium" in words
    assert "a centre of mode 'f'" in words
    assert abs(value + energy) <= error <= 1e-14 * energy
    assert branch.sizes["special"] == 0
    assert -energy < branch["level"].values.min() < -0.99 * energy
    period = 4 * ellipk((1 + branch["level"].values / energy) / 2) / pace
    np.testing.assert_allclose(branch["period_time"], period, rtol=1e-10)


def test_the_upright_family_of_henon_and_heiles_ends_at_its_centre():
    henon = HybridSystem(
        name="henon", states="x y u v", parameters={}, initial={"y": 0.3},
        modes={"f": {"x": "u", "y": "v", "u": "-x - 2*x*y", "v": "-y - x**2 + y**2"}},
    )  # fmt: skip
    system = on_level(henon, "(u**2 + v**2 + x**2 + y**2)/2 + x**2*y - y**3/3")
    branch = continue_orbit(system, {"level": (-0.1, 0.1)}, start="guess", max_return=10)
    value, error, words = ending(branch)
    assert "a centre" in words
    assert abs(value) <= error + 1e-15
    # on x = 0 it is y'' = -y + y^2
    cubic = [np.sort(np.roots([-1 / 3, 1 / 2, 0, -level]).real) for level in branch["level"].values[::20]]
    period = [4 * np.sqrt(1.5 / (c - a)) * ellipk((b - a) / (c - a)) for a, b, c in cubic]
    np.testing.assert_allclose(branch["period_time"].values[::20], period, rtol=1e-9)


@pytest.mark.parametrize(("unit", "least"), [(1e-6, 0.01), (1.0, 0.125)])
def test_bounces_end_where_they_have_no_height(unit, least):
    # pressed against its wall by the spring
    pressed = HybridSystem(
        name="pressed", states="x v", parameters={"w": 0.5 * unit}, modes={"f": {"x": "v", "v": "-x"}},
        transitions=[Transition("hit", "f", "f", "x + w", direction=1, reset={"v": "-v"})], initial={"x": -unit},
    )  # fmt: skip
    system = on_level(pressed, "(x**2 + v**2)/2")
    branch = continue_orbit(system, {"level": (least * unit**2, 2 * unit**2)}, start="guess")
    value, error, words = ending(branch)
    assert "hit has no speed" in words
    assert abs(value - 0.125 * unit**2) <= error <= 1e-11 * unit**2
    assert branch.sizes["special"] == 0
    assert (np.diff(branch["level"]) > 0).all()
    level = 0.125 * unit**2 / np.cos(branch["period_time"].values / 2) ** 2
    np.testing.assert_allclose(branch["level"], level, rtol=1e-11)


def test_bounces_reach_a_limit_above_no_height():
    ball = HybridSystem(
        name="ball", states="y v", parameters={}, modes={"f": {"y": "v", "v": "-1"}}, initial={"y": 1.0},
        transitions=[Transition("hit", "f", "f", "y", direction=-1, reset={"v": "-v"})],
    )  # fmt: skip
    branch = continue_orbit(on_level(ball, "v**2/2 + y"), {"level": (1e-9, 2.0)}, start="guess")
    assert branch["level"].values.min() == 1e-9
    assert branch["branch_end_text"].item() == "the parameter reached its limit"


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


FAR = [("sqrt(-a)", -2.0), ("sqrt(a - 100)", 400.0), ("log(1 - a)", -2.0)]


@pytest.mark.parametrize(("stiffness", "a"), FAR)
def test_parameters_are_tried_about_their_values(stiffness, a):
    spring = HybridSystem(
        name="spring", states="x v", parameters={"a": a}, modes={"f": {"x": "v", "v": f"-{stiffness}*x"}},
        transitions=[], initial={"x": 0.5},
    )  # fmt: skip
    assert on_level(spring, f"v**2/2 + {stiffness}*x**2/2").parameters["a"] == a
    with pytest.raises(ModelError, match="mode 'f' changes it"):
        on_level(spring, f"v**2/2 + {stiffness}*x**2")


def test_a_quantity_that_has_no_values_is_not_said_to_change():
    far = HybridSystem(
        name="far", states="x v", parameters={}, modes={"f": {"x": "v", "v": "-x*acos(x**2 + v**2 - 1e60)"}},
        transitions=[], initial={"x": 1e30},
    )  # fmt: skip
    with pytest.raises(ModelError, match="mode 'f' has no value at states"):
        on_level(far, "v**2/2 + x**2/2")


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize(("speed", "tolerance"), [(0.9, 1e-12), (1.2, 1e-12), (1.2, 1e-9), (1.2, 1e-8), (1.2, 1e-6)])
def test_an_ellipse_is_its_own_start(speed, tolerance, method):
    # all orbits of one energy have one period: of the family that of the start is meant
    pull = "/sqrt(x**2 + y**2)**3"
    kepler = HybridSystem(
        name="kepler",
        states="x y u v",
        parameters={},
        modes={"only": {"x": "u", "y": "v", "u": f"-x{pull}", "v": f"-y{pull}"}},
        transitions=[],
        initial={"x": 1.0, "v": speed},
    )
    found = periodic_orbit(kepler, start="guess", tolerance=tolerance, method=method)
    assert found["orbit_state"].values == pytest.approx([1, 0, 0, speed], abs=10 * tolerance)
    assert float(found["period_time"]) == pytest.approx(math.tau * (2 - speed**2) ** -1.5, rel=10 * tolerance)
    assert int(found["neutral"]) == 4
    # of energy, angular momentum and the axis; told in the same way whatever round-off makes of them
    told = re.search(r"3 quantities are conserved; 1 x and (\S+) y \+ (\S+) u and (\S+) v, ", found.attrs["message"])
    assert float(told[2]) / float(told[1]) == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize(("order", "start"), [("r p l", "guess"), ("l p r", "attractor")])
def test_an_ellipse_whose_angular_momentum_is_a_state(order, start):
    # its rate of 0 tells one conserved quantity, and nothing of the energy
    kepler = HybridSystem(
        name="radial", states=order, parameters={"mu": 1.0}, transitions=[], initial={"r": 0.8, "l": 0.96},
        modes={"f": {"r": "p", "p": "l**2/r**3 - mu/r**2", "l": "0"}},
    )  # fmt: skip
    found = periodic_orbit(kepler, start=start)
    axis = 1 / (2 / 0.8 - 1.2**2)
    assert float(found["period_time"]) == pytest.approx(2 * np.pi * axis**1.5, rel=1e-10)
    assert int(found["neutral"]) == 3
    assert bool(found["stable"])
    assert "a quantity is conserved" in found.attrs["message"]

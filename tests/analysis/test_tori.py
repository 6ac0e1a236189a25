"""Quasiperiodic motion is neither periodic nor chaotic, and weak chaos is no torus."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.analysis.judgement.tori import agreement


def test_a_circle_is_shed_by_the_fixed_point(delayed_logistic):
    """Multipliers of modulus sqrt(r - 1); above r = 2 a circle, the fixed point being left."""
    r = 2 + np.array([-0.1, -1e-2, -1e-3, -1e-4, 1e-3, 5e-3, 2e-2, 5e-2, 0.1])
    found = cd.bifurcation_diagram(delayed_logistic, {"r": r}, transient=500, periods=256).isel(seed=0)
    np.testing.assert_array_equal(found["period"].values, [1] * 4 + [0] * 5)
    outcome = cd.Outcome.PERIODIC, cd.Outcome.QUASIPERIODIC
    np.testing.assert_array_equal(found["outcome"].values, [outcome[0]] * 4 + [outcome[1]] * 5)
    # that of the clock is zero
    exponents = found["lyapunov_exponent"].values[:4]
    np.testing.assert_allclose(exponents.sum(axis=1), np.log(r[:4] - 1), rtol=1e-6)


@pytest.mark.parametrize("length", [600, 1024, 2048])
def test_a_torus_is_known_from_off_it(length):
    """An angle, which neither grows nor decays, drives a state that comes closer from far away, by a clock as well."""
    images = {"x": "b*x + cos(angle)", "angle": f"angle + {np.pi * (np.sqrt(5) - 1)}"}
    driven = cd.Map("x angle", {"b": 0.5}, images, name="driven", initial={"x": 9.0})
    assert cd.lyapunov_spectrum(driven, periods=length).cd.outcome == "quasiperiodic"
    found = cd.bifurcation_diagram(driven, {"b": np.array([-0.3, 0.5])}, transient=0, periods=length, max_extension=0)
    assert (found["outcome"].values == cd.Outcome.QUASIPERIODIC).all()
    if length < 2048:  # all events are known
        assert clocked("x angle", images | {"x": "x/2 + cos(angle)"}, {"x": 9.0}, length) == "quasiperiodic"


@pytest.mark.parametrize("length", [4096, 16384])
def test_more_points_tell_a_torus_of_many_curves(length):
    """An angle moves the logistic map's cycle of 16 points a little; 2,048 points of 16 curves are too few."""
    turned = {"u": "cos(w)*u - sin(w)*v", "v": "sin(w)*u + cos(w)*v"}
    images = {"x": "3.5668*x*(1 - x)*(1 + u/1e5)", **turned}
    many = cd.Map("x u v", {"w": np.pi * (np.sqrt(5) - 1)}, images, name="many-curves", initial={"x": 0.4, "u": 1.0})
    assert cd.lyapunov_spectrum(many, periods=length, transient=20_000).cd.outcome == "quasiperiodic"
    given = {"transient": 20_000, "periods": length, "max_extension": 0}
    found = cd.bifurcation_diagram(many, {"w": [np.pi * (np.sqrt(5) - 1)]}, **given)
    assert found["outcome"].values.ravel().tolist() == [cd.Outcome.QUASIPERIODIC]


@pytest.mark.parametrize("length", [600, 1024])
def test_a_clock_turns_two_angles_on_a_torus(length):
    turns = {"a": "sqrt(2) + sin(b)/20", "b": "sqrt(3) + sin(a)/20"}
    assert clocked("a b", {name: f"{name} + {turn}" for name, turn in turns.items()}, {}, length) == "quasiperiodic"


def test_a_cycle_longer_than_what_is_looked_at_is_no_torus():
    """A clock turns an angle by 1147 parts of 2503, round after round of a record of 9,000."""
    images = {"angle": "Mod(angle + 1147/2503, 1)", "x": "x/2 + cos(2*pi*angle)"}
    assert clocked("angle x", images, {}, 9_000) in ("periodic", "undecided")


def clocked(states, images, initial, length):
    """The word for a map that a clock without forcing works."""
    strike = cd.Transition("strike", "wait", "wait", "clock - 1", 1, {**images, "clock": "0"})
    field = {**dict.fromkeys(images, "0"), "clock": "1"}
    system = cd.HybridSystem(
        name="clocked", states=f"{states} clock",
        modes={"wait": field}, transitions=[strike], initial={**initial, "clock": 0.5},
    )  # fmt: skip
    return cd.lyapunov_spectrum(system, duration=length).cd.outcome


def test_a_rotation_has_the_period_of_its_angle_or_none(circle):
    angles = 2 * np.pi * np.array([1 / 5, 3 / 7, (np.sqrt(5) - 1) / 2, np.sqrt(2) - 1])
    found = cd.bifurcation_diagram(circle, {"angle": angles}, transient=50, periods=128).isel(seed=0)
    np.testing.assert_array_equal(found["period"].values, [5, 7, 0, 0])
    periodic, torus = cd.Outcome.PERIODIC, cd.Outcome.QUASIPERIODIC
    np.testing.assert_array_equal(found["outcome"].values, [periodic, periodic, torus, torus])


def test_smooth_averages_tell_a_torus_from_a_cloud():
    k = np.arange(2048)
    golden = 2 * np.pi * (np.sqrt(5) - 1) / 2
    torus = np.stack([np.cos(golden * k), np.exp(np.sin(golden * k)) + 0.3 * np.cos(np.sqrt(3) * k)], axis=1)
    x = np.empty(2048)
    x[0] = 0.3
    for i in range(2047):
        x[i + 1] = 3.7 * x[i] * (1 - x[i])
    cloud = np.stack([x, np.roll(x, 1)], axis=1)
    smooth, converging, *_ = agreement(np.stack([torus, cloud]), np.ones((2, 2)))
    assert smooth.tolist() == converging.tolist() == [True, False]


def test_chaos_on_narrow_bands_is_no_torus():
    """The logistic map has 64 to 2 bands at these values; averages over them are close in parts of the whole extent."""
    r = np.repeat([3.5702, 3.571, 3.573, 3.58, 3.6, 3.67], 50)
    x = np.random.default_rng(5).uniform(0.1, 0.9, len(r))
    points = np.empty((len(r), 2048, 1))
    for i in range(-20_000, 2048):
        x = r * x * (1 - x)
        points[:, max(i, 0), 0] = x
    smooth, converging, *_ = agreement(points, np.ones(points[:, 0].shape))
    assert (smooth & converging).mean() < 0.05


def test_tori_that_are_not_near_critical_are_known():
    """Lifts of the circle map on which no motion is locked: rotations, seen through a smooth change of the angle."""
    turns = np.random.default_rng(6).uniform(0.05, 0.95, 300)[:, np.newaxis]
    angle = 2 * np.pi * turns * np.arange(2048)
    angle = angle + 0.4 * np.sin(angle) + 0.1 * np.cos(2 * angle)
    points = np.stack([np.cos(angle), np.sin(angle) + 0.3 * np.cos(2 * angle)], axis=2)
    smooth, converging, *_ = agreement(points, np.ones(points[:, 0].shape))
    assert (smooth & converging).mean() > 0.9

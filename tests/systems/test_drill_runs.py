"""Drills with other effects than the paper's, against systems that they must coincide with."""

import numpy as np
import pytest

import chaosdrill as cd


def path(system, **span):
    return cd.trajectory(system, samples=20, **span)


def test_six_lobes_drill_as_their_frequency_does():
    lobes = path(cd.drill(drive="lobes", lobes=6, spin=0.1), periods=40)
    harmonic = path(cd.drill(eta=0.6), periods=40)
    np.testing.assert_allclose(lobes["states"].values, harmonic["states"].values, rtol=0, atol=1e-9)
    assert lobes.sizes["event"] == harmonic.sizes["event"] > 50


def test_a_bit_on_a_fixed_rock_is_an_impact_oscillator():
    bit = cd.drill(
        rock="fixed", friction="none", contact="newton", b=0.0, a=1.0, eta=2.5, phi=0.0, xi=0.05, r=0.3, e=0.8,
        initial={"u": 0.3},
    )  # fmt: skip
    ours, theirs = path(bit, periods=10), path(cd.build("impact-oscillator"), periods=10)
    np.testing.assert_allclose(ours["states"].values, theirs["states"].values, rtol=0, atol=1e-10)
    assert ours.sizes["event"] == theirs.sizes["event"] > 5


def test_a_bit_on_a_fixed_rock_without_drive_or_stop_settles_at_the_static_stretch():
    run = path(cd.drill(drive="none", contact="none", rock="fixed", friction="none", b=0.7, xi=0.1), duration=10.0)
    t, damped = run["time"].values, np.sqrt(1 - 0.1**2)
    y = 0.7 * (1 - np.exp(-0.1 * t) * (np.cos(damped * t) + 0.1 / damped * np.sin(damped * t)))
    np.testing.assert_allclose(run["states"].values[:, 0], y, rtol=0, atol=1e-12)


# the gap keeps the spring below friction, and the load below the spring: the bit is never pressed on the rock it hits
HITTING = {"r": 0.8, "b": 0.4, "a": 0.4, "eta": 0.9}


def test_soft_hits_never_move_the_rock():
    run = path(cd.drill(k=1e-3, **HITTING), periods=30)
    assert set(run.cd.words("event_kind").values) == {"weak-hit"}
    held = path(cd.drill(rock="fixed", friction="none", **HITTING), periods=30)
    np.testing.assert_allclose(run["states"].values[:, :2], held["states"].values, rtol=0, atol=1e-9)
    assert np.all(run["penetration"].values == 0)


def test_hard_hits_drive_the_rock_though_the_spring_could_not():
    run = path(cd.drill(**HITTING), periods=30)
    assert {"strong-hit", "stick"} <= set(run.cd.words("event_kind").values)
    assert float(run["penetration"][-1]) > 0.1
    assert np.all(np.diff(run["penetration"].values) >= 0)


def test_free_masses_keep_their_momentum_through_hits():
    run = path(
        cd.drill(friction="none", drive="none", b=0.0, xi=0.0, eps=2.0, r=0.2, initial={"u": 1.0}), duration=50.0
    )
    assert run.sizes["event"] > 3
    momentum = 2.0 * run["states"].values[:, 1] + run["states"].values[:, 2]
    np.testing.assert_allclose(momentum, 2.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("friction", ["stribeck", "coulomb"])
def test_a_rock_that_is_held_for_ever_has_no_exponent_of_its_own(friction):
    # spring and damper stay below friction: of three tangents one is lost, and the bit alone remains
    spectrum = cd.lyapunov_spectrum(cd.drill(friction=friction, b=0.3, a=0.1), periods=400, transient=50)
    found = spectrum["lyapunov_exponent"].values
    assert int(spectrum["event_count"].sum()) == 0
    assert found[:2].mean() == pytest.approx(-0.06, abs=1e-9)
    assert found[2] == -np.inf
    assert int(spectrum["outcome"]) == cd.Outcome.PERIODIC

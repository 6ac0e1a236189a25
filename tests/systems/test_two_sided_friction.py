"""Friction against sliding either way: odd in the speed, sticking as long as it can, undecided nowhere."""

import numpy as np
import pytest

import chaosdrill as cd

STILL = {"drive": "none", "contact": "none", "b": 0.0}


def events(run):
    return run.cd.words("event_kind").values.tolist()


@pytest.mark.parametrize("friction", ["coulomb-two-sided", "stribeck-two-sided"])
def test_what_happens_forward_happens_backward(friction):
    mirror = {"slip": "slip-back", "slip-back": "slip", "stick": "stick"}
    runs = [
        cd.trajectory(
            cd.drill(friction=friction, eps=3.0, initial={"y": 6.0 * way, "mode": mode}, **STILL),
            duration=30.0,
            samples=40,
        )
        for way, mode in ((1, "slip"), (-1, "slip-back"))
    ]
    forward, backward = runs
    np.testing.assert_allclose(forward["states"].values, -backward["states"].values, rtol=0, atol=1e-12)
    assert [mirror[mode] for mode in forward.cd.words("mode").values] == backward.cd.words("mode").values.tolist()
    assert {"turn-back", "turn-forward", "stick"} <= set(events(forward)) | set(events(backward))


def test_sliding_masses_lose_momentum_to_friction_alone():
    # coulomb: the momentum eps u + w changes at the rate -eps mu against the motion of the rock
    run = cd.trajectory(
        cd.drill(friction="coulomb-two-sided", eps=3.0, mu=0.4, initial={"y": 6.0, "mode": "slip"}, **STILL),
        duration=4.0, samples=400,
    )  # fmt: skip
    _, bit, rock = run["states"].values.T
    t, momentum = run["time"].values, 3.0 * bit + rock
    modes = run.cd.words("mode").values
    for mode, way in (("slip", 1), ("slip-back", -1)):
        inside = (modes[:-1] == mode) & (modes[1:] == mode)
        assert inside.sum() > 20
        rate = np.diff(momentum)[inside] / np.diff(t)[inside]
        happened = np.searchsorted(run["event_time"].values, t)
        calm = (np.diff(happened) == 0)[inside]
        np.testing.assert_allclose(rate[calm], -way * 3.0 * 0.4, rtol=0, atol=1e-10)


def test_a_rock_sticks_only_while_friction_can_hold_it():
    run = cd.trajectory(
        cd.drill(friction="stribeck-two-sided", a=1.2, b=0.0, eta=0.7, eps=2.0, contact="none"), periods=60, samples=50
    )
    modes = run.cd.words("mode").values
    y, u, w = run["states"].values.T
    stuck = modes == "stick"
    assert 0 < stuck.mean() < 1
    assert np.all(np.abs(y + 2 * 0.06 * u)[stuck] <= 1 + 1e-12)
    assert np.all(w[stuck] == 0)
    assert np.all(w[modes == "slip"] >= -1e-13)
    assert np.all(w[modes == "slip-back"] <= 1e-13)
    assert {"release", "release-back"} <= set(events(run))


@pytest.mark.parametrize("mode", ["stick", "slip", "slip-back"])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_at_the_threshold_itself_nothing_flickers(mode, way):
    system = cd.drill(drive="none", contact="none", friction="stribeck-two-sided", b=way)
    rest = cd.trajectory(system.with_initial(mode=mode, y=way), duration=50.0, samples=5)
    assert len(events(rest)) <= 1
    np.testing.assert_allclose(rest["states"].values[-1, 1:], 0, atol=1e-14)


@pytest.mark.parametrize(("speed", "name"), [(1e-3, "release"), (2.0**-30, "release")])
def test_a_rising_demand_lets_go_at_once_and_once(speed, name):
    system = cd.drill(
        drive="none", contact="none", friction="stribeck-two-sided", b=1.0, xi=0.0, initial={"y": 1.0, "u": speed}
    )
    run = cd.trajectory(system, duration=1.0, samples=5)
    assert events(run) == [name]
    assert float(run["event_time"][0]) == 0.0
    assert events(cd.trajectory(system.with_initial(y=-1.0, u=-speed).with_parameters(b=-1.0), duration=1.0)) == [
        "release-back"
    ]

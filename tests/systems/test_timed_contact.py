"""A hit whose duration passes: the law of the jump, later by the time that the contact takes."""

import numpy as np
import pytest

import chaosdrill as cd


def events(run, name):
    chosen = run.cd.words("event_kind") == name
    return tuple(run[f"event_{part}"].values[chosen] for part in ("time", "state_before", "state_after"))


@pytest.fixture(scope="module")
def run():
    # elastic and linear, so that the contact of free masses lasts pi/sqrt((1 + eps) k)
    return cd.trajectory(
        cd.drill(contact="hunt-crossley-timed", lam=0.0, k=1e4, eps=0.5, eta=0.6), periods=40, samples=10
    )


def test_the_new_speeds_hold_after_the_duration(run):
    start, before, hit = events(run, "hit")
    end, _, after = events(run, "rebound")
    strong, *_ = events(run, "strong-hit")
    assert len(start) > 10
    assert len(start) + len(strong) == len(end)
    np.testing.assert_allclose(hit[:, 3], np.pi / np.sqrt(1.5e4), rtol=1e-12)
    np.testing.assert_array_equal(hit[:, :3], before[:, :3])
    after = after[np.isin(end, end[np.searchsorted(end, start)])]
    end = end[np.searchsorted(end, start)]
    np.testing.assert_allclose(end - start, np.pi / np.sqrt(1.5e4), rtol=1e-10)
    # elastic: the relative speed turns round, the momentum stays
    np.testing.assert_allclose(after[:, 1] - after[:, 2], before[:, 2] - before[:, 1], rtol=0, atol=1e-14)
    np.testing.assert_allclose(0.5 * after[:, 1] + after[:, 2], 0.5 * before[:, 1] + before[:, 2], rtol=0, atol=1e-14)
    assert np.all(after[:, 3] == 0)


def test_against_a_rock_that_friction_holds_the_bits_own_mass_counts():
    gap = {"r": 0.8, "b": 0.4, "a": 0.4, "eta": 0.9}
    run = cd.trajectory(cd.drill(contact="hunt-crossley-timed", lam=0.0, k=1e-3, **gap), periods=3, samples=1)
    _, _, hit = events(run, "weak-hit")
    assert len(hit) > 0
    np.testing.assert_allclose(hit[:, 3], np.pi / np.sqrt(1e-3), rtol=1e-12)


def test_tangents_are_differences_of_the_flow():
    def run_from(x, **more):
        start = dict(zip(("y", "u", "w", "timer"), x, strict=True))
        system = cd.drill(eta=0.8, contact="hunt-crossley-timed", n=1.5, k=1e3, initial={**start, "mode": "slip"})
        return cd.trajectory(system, periods=1, samples=1, tolerance=1e-15, **more)

    def end(x):
        return run_from(x)["states"].values[-1]

    start = np.array([0.51, 0.26, 0.37, 0.0])
    run = run_from(start, tangents=True)
    kinds = run.cd.words("event_kind").values.tolist()
    assert kinds.count("hit") == kinds.count("rebound") == 1
    for unit, found in zip(np.eye(4)[:3], run["final_tangent"].values, strict=False):
        coarse, fine = ((end(start + h * unit) - end(start - h * unit)) / (2 * h) for h in (2e-4, 1e-4))
        np.testing.assert_allclose(found, (4 * fine - coarse) / 3, rtol=0, atol=1e-8)


def test_the_timer_is_pinned():
    spectrum = cd.lyapunov_spectrum(
        cd.drill(eta=0.8, contact="hunt-crossley-timed", k=1e12), periods=400, transient=200
    )
    found = spectrum["lyapunov_exponent"].values
    # as stiff as this the cycle is that of the jump, but for a part in 1e6
    rate = np.log(np.abs(0.11672896840556 + 0.65713468420972j)) * 0.8 / (2 * np.pi)
    np.testing.assert_allclose(found[:2].mean(), rate, atol=1e-6)
    assert np.all(found[2:] == -np.inf)

"""Every hit and every stop of the rock in a chaotic run: momentum, energy and position."""

import numpy as np
import pytest

import chaosdrill as cd

PERIODS = 300


@pytest.fixture(scope="module", params=[1.0, 0.4], ids="eps={}".format)
def run(request):
    return cd.trajectory(cd.drill(eta=0.448, eps=request.param), periods=PERIODS, samples=10), request.param


def states(run, *kinds):
    """States before and after the events of these names."""
    chosen = np.isin(run.cd.words("event_kind"), kinds)
    return run["event_state_before"].values[chosen], run["event_state_after"].values[chosen]


def test_hits_keep_momentum_to_round_off_and_lose_energy(run):
    data, eps = run
    before, after = states(data, "hit", "strong-hit")
    assert len(before) > PERIODS // 4
    momentum = eps * (after[:, 1] - before[:, 1]) + after[:, 2] - before[:, 2]
    np.testing.assert_allclose(momentum, 0, atol=1e-15)
    energy = eps * (after[:, 1] ** 2 - before[:, 1] ** 2) + after[:, 2] ** 2 - before[:, 2] ** 2
    assert energy.max() < 0


def test_hits_happen_at_the_stop_and_nowhere_beyond(run):
    data, _ = run
    before, after = states(data, "hit", "strong-hit", "weak-hit")
    np.testing.assert_allclose(before[:, 0], 1.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(after[:, 0], 1.0, rtol=0, atol=1e-15)
    assert np.all(before[:, 1] > before[:, 2])
    assert np.all(after[:, 1] < after[:, 2])
    assert data["states"].values[:, 0].max() <= 1 + 1e-12


def test_a_rock_that_sticks_is_at_rest_and_never_goes_back(run):
    data, _ = run
    _, after = states(data, "stick")
    assert len(after) > PERIODS // 4
    assert np.all(after[:, 2] == 0)
    assert np.all(data["states"].values[:, 2] >= -1e-15)
    assert np.all(np.diff(data["penetration"].values) >= -1e-15)


def test_a_release_changes_no_state(run):
    data, _ = run
    before, after = states(data, "release")
    assert np.array_equal(before, after)
    np.testing.assert_allclose(before[:, 0] + 2 * 0.06 * before[:, 1], 1.0, rtol=0, atol=1e-14)

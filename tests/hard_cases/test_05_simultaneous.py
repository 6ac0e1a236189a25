"""Case 5: of two guards that are reached together the one with the larger priority acts first, and ties are counted."""

import numpy as np
import pytest

import chaosdrill as cd

ORDERS = [((1, 0), ["p-first", "q-last"], [[1, 0], [0.5, 0.5]]), ((0, 1), ["q-first", "p-last"], [[0.5, 0.5], [0, 1]])]


@pytest.mark.parametrize(("priorities", "order", "matrix"), ORDERS)
def test_priority_decides_the_order(priorities, order, matrix, case):
    run = cd.trajectory(case(5).corner(*priorities), duration=2.0, samples=4)
    names = run["event_kind"].attrs["flag_meanings"].split()
    assert [names[k] for k in run["event_kind"].values] == order
    np.testing.assert_allclose(run["event_time"].values, 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(run["state"].values[-1], [1.0, 1.0], atol=1e-13)


@pytest.mark.parametrize(("priorities", "order", "matrix"), ORDERS)
def test_the_order_decides_the_tangent(priorities, order, matrix, tangent_entries, case):
    probe = np.array([[0.3, 0.2], [0.1, 0.4]])
    found = tangent_entries(case(5).corner(*priorities), 2.0, (1.0, 1.0), probe.tolist())
    np.testing.assert_allclose(np.sort(found), np.sort(np.linalg.eigvals(probe @ matrix)), atol=1e-9)


def test_ties_are_counted(case):
    spectrum = cd.lyapunov_spectrum(case(5).corner(1, 0), duration=2.0)
    assert int(spectrum["tie_count"]) == 1


def test_a_drill_whose_release_and_hit_coincide_hits_first():
    # r = 1 and xi = 0: friction gives way where the stop is
    system = cd.drill(eta=0.8, xi=0.0, r=1.0)
    run = cd.trajectory(system, periods=50)
    names = run["event_kind"].attrs["flag_meanings"].split()
    happened = [names[k] for k in run["event_kind"].values]
    assert "strong-hit" in happened
    assert "release" not in happened
    assert run["state"].values[:, 0].max() <= 1 + 1e-12


def test_the_drill_counts_those_ties():
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.8, xi=0.0, r=1.0), periods=50)
    counts = dict(zip(spectrum["transition_name"].values, spectrum["event_count"].values, strict=True))
    assert counts["strong-hit"] > 0
    assert int(spectrum["tie_count"]) == counts["strong-hit"]

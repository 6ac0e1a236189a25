"""Recurrence matrices, against those that are known in closed form and another program's distances."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

import chaosdrill as cd

GOLDEN = (np.sqrt(5) - 1) / 2


def test_on_a_cycle_diagonals_are_a_period_apart(logistic):
    section = cd.poincare_section(logistic.with_parameters(r=3.5), transient=500, periods=40)
    close = cd.recurrences(section, rate=0.01)
    k = np.arange(40)
    np.testing.assert_array_equal(close.toarray(), (k[:, np.newaxis] - k) % 4 == 0)


def test_a_rotation_comes_back_after_times_that_its_number_tells(circle):
    """On a circle the distance of two points is a function of the turns between them."""
    section = cd.poincare_section(circle.with_parameters(angle=2 * np.pi * GOLDEN), periods=89)
    close = cd.recurrences(section, rate=0.1).toarray()
    k = np.arange(89)
    turned = np.abs(((k[:, np.newaxis] - k) * GOLDEN + 0.5) % 1 - 0.5)
    within = np.sort(turned[np.triu_indices(89, 1)])[round(0.1 * 89 * 44) - 1]
    # both states have nearly the same spread, and the ties of equal times all count
    assert np.mean(close == (turned <= within * (1 + 1e-9))) > 0.98


def test_units_are_of_no_account_and_as_many_are_close_as_asked_for():
    section = cd.poincare_section(cd.build("duffing"), transient=100, periods=200)
    close = cd.recurrences(section, rate=0.07)
    other = section.assign(section=section["section"] * [1e-9, 1e9])
    assert (cd.recurrences(other, rate=0.07) != close).nnz == 0
    assert (close != close.T).nnz == 0
    assert close.nnz == 200 + 2 * round(0.07 * 199 * 100)
    scaled = section["section"].values / section["section"].values.std(axis=0)
    distance = cdist(scaled, scaled)
    inside = close.toarray()
    assert distance[inside].max() <= distance[~inside].min()


def test_modes_are_apart():
    run = cd.trajectory(cd.build("belt-stick-slip"), duration=60.0, samples=300)
    close = cd.recurrences(run).tocoo()
    mode = run["mode"].values
    assert len(set(mode.tolist())) > 1
    assert (mode[close.coords[0]] == mode[close.coords[1]]).all()


def test_what_has_no_recurrences(logistic):
    section = cd.poincare_section(logistic.with_parameters(r=3.5), periods=8)
    for wrong in (0.0, 1.5, np.nan):
        with pytest.raises(cd.SettingsError, match="rate is"):
            cd.recurrences(section, wrong)
    with pytest.raises(cd.SettingsError, match="ds is regularity; it must be a poincare-section"):
        cd.recurrences(cd.regularity(logistic, periods=50))
    with pytest.raises(cd.SettingsError, match="holds 1 points of a run with the outcome"):
        cd.recurrences(cd.poincare_section(logistic, periods=1))

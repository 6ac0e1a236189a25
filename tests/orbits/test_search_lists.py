"""What a search lists: every orbit once, in order, each of them verified."""

import numpy as np
import pytest

from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.search import search


@pytest.fixture(scope="module")
def listed(drill):
    calls = []
    chaos = drill.with_parameters(eta=0.448)
    found = search(
        chaos, 3, np.zeros((0, 3)), np.zeros(0, dtype=np.int64), Numerics(), lambda *call: calls.append(call)
    )
    return found, calls


def test_orbits_that_repel_are_found(listed):
    # counted by another program: Newton's method on the strobe map of the engine, from 2500 random states a period
    leading = {1: [2.32488107, 8.70474597], 2: [3.79860266, 8.04872666, 30.21090569], 3: [10.50992, 66.2424589]}
    found, _ = listed
    for period, known in leading.items():
        np.testing.assert_allclose([abs(o.multipliers[0]) for o in found if o.period == period], known, rtol=1e-5)


def test_each_once_and_in_order(listed):
    found, _ = listed
    keys = [(o.period, abs(o.multipliers[0])) for o in found]
    assert keys == sorted(keys)
    for i, a in enumerate(found):
        for b in found[:i]:
            if a.period == b.period:
                assert np.abs(b.states - a.states[0]).max(axis=1).min() > 1e-6
            elif a.period % b.period == 0:
                assert np.abs(a.states - b.states[0]).max(axis=1).min() > 1e-6


def test_each_returns_and_agrees_with_itself(listed):
    for orbit in listed[0]:
        assert orbit.outcome == Outcome.PERIODIC
        assert orbit.residual < 1e-10
        assert orbit.checks.consistent, orbit.checks.disagreements


def test_progress_is_told(listed):
    found, calls = listed
    assert [call[:2] for call in calls] == [(1, 3), (2, 3), (3, 3)]
    assert calls[-1][2] == {"periodic": len(found)}


def test_a_start_that_runs_away_is_no_error(drill):
    away = np.array([[-1.0, 2.0, 0.0]])
    assert search(drill.with_parameters(xi=0.0, b=2.0), 1, away, np.zeros(1, dtype=np.int64), Numerics()) == []

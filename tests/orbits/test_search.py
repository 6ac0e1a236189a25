"""A search finds as many orbits as there are, and lists each once."""

from collections import Counter

import numpy as np
import pytest
from support.closed_bouncing_ball import bounces
from support.closed_impact import one_impact

from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.search import search
from chaosdrill.systems import build

# A search finds as many orbits of every period as there are.


FINE = Numerics(tolerance=1e-13)


def found_in(system, longest):
    n = len(system.states)
    return search(system, longest, np.zeros((0, n)), np.zeros(0, dtype=np.int64), FINE)


def rounds(orbits):
    """How many orbits meet their most frequent event how often."""
    return Counter(max(Counter(o.event_transitions.tolist()).values()) for o in orbits)


def test_all_cycles_of_the_tripling_map_as_a_switch():
    # x -> 3x mod 1 has 3^k - 1 points of period k, so 2, (8 - 2)/2 cycles
    orbits = found_in(build("tilted-switch"), 2)
    assert rounds(orbits) == {1: 2, 2: 3}
    for orbit in orbits:
        turns = len(orbit.event_times) // 2
        assert orbit.duration == pytest.approx(5 * turns, abs=1e-12)
        assert orbit.multipliers[0].real == pytest.approx(3.0**turns, rel=1e-11)


def test_all_cycles_of_the_tripling_map_as_a_saddle():
    # here x = 0 is the saddle itself, and takes for ever
    orbits = found_in(build("saddle-reset"), 3)
    assert rounds(orbits) == {1: 1, 2: 3, 3: 8}
    points = np.sort(np.concatenate([o.event_states_after[:, 0] for o in orbits if len(o.event_times) == 3]))
    known = np.array([k for k in range(1, 26) if k != 13]) / 26
    np.testing.assert_allclose(points, known, atol=1e-12)
    for orbit in orbits:
        assert orbit.duration == pytest.approx(-np.log(orbit.event_states_after[:, 0]).sum(), abs=1e-11)


def test_all_words_of_the_lorenz_attractor():
    # two letters, one a turn about either wing: cyclic words that are no powers, without the wings' own centres
    orbits = found_in(build("lorenz"), 3)
    assert Counter(round(o.duration / 0.76) for o in orbits) == {2: 1, 3: 2}
    assert orbits[0].duration == pytest.approx(1.558652210716, abs=1e-11)


def test_all_orbits_of_the_impact_oscillator_that_newton_finds_from_a_grid():
    # counted up to period 6 by another program: Newton's method on the exact flow from 40000 starts
    orbits = found_in(build("impact-oscillator"), 4)
    assert [(o.period, len(o.event_times)) for o in orbits] == [(1, 0), (2, 1), (2, 1), (4, 3)]
    slow, fast = sorted(orbits[1:3], key=lambda o: o.event_speeds[0])
    for orbit, closed in zip((slow, fast), one_impact(2.5, 0.3, 0.05, 0.8, 2), strict=True):
        assert orbit.event_speeds[0] == pytest.approx(closed.speed, abs=1e-12)
        assert orbit.multipliers.sum().real == pytest.approx(closed.trace, rel=1e-10)
    np.testing.assert_allclose(orbits[3].multipliers, [-5.15731758, -0.01860011], atol=1e-7)


def test_all_single_bounces_stable_or_not():
    orbits = found_in(build("bouncing-ball"), 2)
    for n in (1, 2):
        mine = [o for o in orbits if o.period == n and o.event_transitions.tolist() == [0]]
        closed = bounces(0.9, 1.0, 0.8, n=n)
        assert len(mine) == len(closed) == 2
        traces = sorted(o.multipliers.sum().real for o in mine)
        np.testing.assert_allclose(traces, sorted(b.trace for b in closed), atol=1e-11)
    # amplitude times frequency squared is less than gravity: the ball may ride
    riding = [o for o in orbits if not len(o.event_times)]
    assert [o.rank for o in riding] == [0]
    assert not riding[0].multipliers.any()


# What a search lists: every orbit once, in order, each of them verified.


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

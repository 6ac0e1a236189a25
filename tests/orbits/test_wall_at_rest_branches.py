"""Branches of the impact oscillator with its wall at rest, against its closed forms and its cascade in 45 digits."""

import numpy as np
import pytest
from mpmath import mp
from support import wall_at_rest as wall
from support.wall_at_rest_cascade import DOUBLINGS, RATIOS

from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.systems import build

R = 0.8


@pytest.fixture(scope="module")
def system():
    """Started beside the orbit with one impact a period, away from the other attractors there."""
    return build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": 2.64, "e": R}, {}).with_initial(
        x=-0.615, v=0.0178
    )


@pytest.fixture(scope="module")
def cascade(system):
    return branches(system, "omega", (2.55, 2.76), 1, "attractor", 300, 5, 0.0015, 150, Numerics(), None)


def test_trace_and_determinant_follow_their_closed_forms(cascade, digits):
    digits(30)
    first = np.flatnonzero(cascade.branch == 0)
    assert len(first) > 100
    for k in first[:: len(first) // 40]:
        known = wall.period_one(cascade.values[k, 0], R)
        product, total = cascade.multipliers[k].prod(), cascade.multipliers[k].sum()
        assert abs(total - float(known.trace)) < 1e-11
        assert abs(product - float(known.determinant)) < 1e-11
        assert abs(cascade.smallest_speed[k] - float(known.speed)) < 1e-11


def test_the_first_doubling_is_where_the_closed_form_has_it(cascade, digits):
    digits(30)
    assert abs(cascade.cascade.values[0] - float(wall.doubling(mp.mpf("0.8"), 2.65))) < 1e-12


def test_five_further_doublings_are_those_of_the_exact_flow(cascade):
    assert cascade.cascade.periods.tolist() == [1, 2, 4, 8, 16, 32]
    assert np.abs(cascade.cascade.values - [float(w) for w in DOUBLINGS[:6]]).max() < 1e-10
    found = cascade.cascade.ratios[2:]
    # the gap between two doublings, as exact as they are, divides
    errors = 1e-10 * np.array(RATIOS[:4]) / np.diff(cascade.cascade.values)[1:]
    assert (np.abs(found - RATIOS[:4]) < errors + 1e-8).all()
    assert abs(found[-1] - 4.669201609) < 0.02


def test_the_limit_is_as_exact_as_it_says(cascade):
    beyond = float(DOUBLINGS[-1])
    limit = beyond + (beyond - float(DOUBLINGS[-2])) / (4.669201609 - 1)
    assert abs(cascade.cascade.limit - limit) < cascade.cascade.limit_error < 1e-5


def test_each_doubling_has_the_multiplier_minus_one(cascade):
    for event in cascade.events:
        if event.code == Special.PERIOD_DOUBLING:
            assert np.abs(cascade.multipliers[event.point] + 1).min() < 1e-8


def test_orbits_are_stable_up_to_their_doubling_and_unstable_beyond(cascade):
    first = cascade.branch == 0
    values = cascade.values[first, 0]
    regular = cascade.special[first] == Special.REGULAR
    assert (cascade.stable[first] == (values < float(DOUBLINGS[0])))[regular].all()


def test_multipliers_of_an_orbit_multiply_to_what_its_impacts_leave(cascade):
    # the product is known to the round-off of the matrix, which is as large as a multiplier is on the way
    for period in np.unique(cascade.period):
        multipliers = cascade.multipliers[cascade.period == period]
        largest = max(1.0, np.abs(multipliers).max())
        assert np.abs(multipliers.prod(axis=1) - R ** (2.0 * period)).max() < 4e-15 * period * largest**2


def test_both_ends_are_the_limits(cascade):
    ends = cascade.values[cascade.branch == 0, 0][[0, -1]]
    assert cascade.branches[0].end_code == BranchEnd.LIMIT
    assert ends.tolist() == [2.55, 2.76]


def test_no_doubling_is_jumped_over_where_the_range_is_narrow(system):
    start = system.with_parameters(omega=2.7285)
    found = branches(start, "omega", (2.728, 2.732), 4, "attractor", 600, 3, 2e-5, 300, Numerics(), None)
    assert found.cascade.periods.tolist() == [4, 8, 16, 32]
    assert np.abs(found.cascade.values - [float(w) for w in DOUBLINGS[2:6]]).max() < 1e-10

"""Orbits of systems in which almost every motion escapes."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from support.pinball import ROUNDS, itineraries, least, on_triangle, pinball

from chaosdrill import HybridSystem, Outcome, Transition, periodic_orbit
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import least_period, starting_orbit
from chaosdrill.orbits.tuning import TUNING

# Newton's method from beside an orbit, though the motion from there escapes.


@pytest.mark.parametrize("bounds", [{}, {"x": (-20, 20), "y": (-20, 20)}])
@pytest.mark.parametrize("beside", [0.0, 1e-6])
def test_the_cycle_next_to_the_start(bounds, beside):
    system = pinball(bounds=bounds)
    across = system.with_initial(x=2.0, y=beside, p=0.0)
    for length, start in ((2, across), (3, system.with_initial(**_moved(on_triangle(0, 1), beside)))):
        found = periodic_orbit(start, at="bounce", period=length, start="guess")
        time, multiplier = ROUNDS[length]
        assert int(found["outcome"]) == Outcome.PERIODIC, found.attrs["message"]
        assert int(found["period"]) == length
        assert float(found["period_time"]) == pytest.approx(time, rel=1e-11)
        assert float(found["multiplier_real"][0]) == pytest.approx(multiplier, rel=2e-8)


def _moved(start, by):
    return {**start, "y": start["y"] + by}


@pytest.mark.parametrize("disks", [(0, 1), (2, 0), (1, 0)])
@pytest.mark.parametrize("beside", [1e-5, -1e-5])
def test_the_first_round_counts_where_deviations_grow_a_thousandfold_a_round(disks, beside):
    start = pinball().with_initial(**_moved(on_triangle(*disks), beside))
    found = periodic_orbit(start, at="bounce", period=3, start="guess")
    assert int(found["outcome"]) == Outcome.PERIODIC, found.attrs["message"]
    assert float(found["period_time"]) == pytest.approx(ROUNDS[3][0], rel=1e-11)
    assert float(found["multiplier_real"][0]) == pytest.approx(ROUNDS[3][1], rel=2e-8)


def test_without_a_section_too():
    start = pinball().with_initial(**_moved(on_triangle(1, 2), 1e-5))
    found = periodic_orbit(start, start="guess")
    assert float(found["period_time"]) == pytest.approx(ROUNDS[3][0], rel=1e-11)


def test_what_never_returned_has_escaped():
    found = periodic_orbit(pinball().with_initial(x=2.0, y=0.7, p=0.9), at="bounce", start="guess")
    assert int(found["outcome"]) == Outcome.ESCAPED


def test_two_turns_that_differ_by_a_residual_are_one():
    """The height y is zero on the cycle between two disks."""
    across = pinball().with_initial(x=2.0, y=0.0, p=0.0)
    problem, once, _, _, _ = starting_orbit(across, (), 1, "guess", 0.0, Numerics())
    twice = {name: np.concatenate([getattr(once, name)] * 2) for name in ("segments", "starts", "durations")}
    twice["starts"][2:, 1] += TUNING.residual * problem.sizes[1]
    assert len(least_period(problem, replace(once, **twice))[0]) == len(once) == 2


# A search, though hardly a motion returns.


def _itineraries(found, names):
    kinds = found["event_kind"].values
    return Counter(least([names[k] for k in row if k >= 0]) for row in kinds)


@pytest.mark.parametrize(
    ("most", "order", "options", "given"),
    [
        (1, (0, 1, 2), {"away": 1000.0}, {}),
        (2, (2, 0, 1), {"states": "p y x", "unit": 1000.0}, {"seeds": [{"x": 2000.0, "y": 100.0, "p": 0.1}]}),
    ],
)
def test_all_cycles_of_the_pinball(most, order, options, given):
    # no sequence of disks is pruned at this distance
    found = periodic_orbit(pinball(order, **options), start="search", max_period=most, **given)
    assert _itineraries(found, order) == dict.fromkeys(itineraries(most), 1)
    for length, (time, multiplier) in ROUNDS.items():
        mine = found.isel(orbit=np.flatnonzero(found["event_count"] == length))
        np.testing.assert_allclose(mine["period_time"], time, rtol=1e-11)
        np.testing.assert_allclose(mine["multiplier_real"][:, 0], multiplier, rtol=2e-8)


def test_all_cycles_of_a_map_whose_points_escape():
    # x -> 5 x (1 - x): every word of two letters is an orbit, so 2, 1, 2, 3, 6 cycles of periods 1 to 5
    map_ = HybridSystem(
        name="escape", states="x", parameters={}, period=1, modes={"m": {"x": "0"}}, initial={"x": 0.3},
        transitions=[Transition("next", "m", "m", "sin(2*pi*(t - 0.5))", 1, reset={"x": "5*x*(1 - x)"})],
        bounds={"x": (-1, 2)},
    )  # fmt: skip
    found = periodic_orbit(map_, start="search", max_period=5)
    assert Counter(found["period"].values.tolist()) == {1: 2, 2: 1, 3: 2, 4: 3, 5: 6}
    # where the slope is 5 (1 - 2x), and 5x (1 - x) = x at 0 and 4/5
    fixed = found.isel(orbit=np.flatnonzero(found["period"] == 1))
    np.testing.assert_allclose(sorted(fixed["multiplier_real"][:, 0]), [-3.0, 5.0], rtol=1e-10)

"""Branches of the drill at xi = 0.06 against special points that another program located in 30 digits."""

import numpy as np
import pytest
from support.drill_orbits import ALL, CASCADES

from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches

KINDS = {
    "fold": Special.FOLD,
    "period doubling": Special.PERIOD_DOUBLING,
    "grazing": Special.GRAZING,
    "neimark-sacker": Special.NEIMARK_SACKER,
}


@pytest.fixture(scope="module")
def found(drill):
    """The branches of the orbits known at 0.8 and at 0.6, the latter's doubled ones included."""
    results = []
    for eta, period, doublings in ((0.8, 1, 1), (0.6, 2, 1)):
        system = drill.with_parameters(eta=eta)
        results.append(
            branches(system, "eta", (0.4, 0.9), period, "attractor", 300, doublings, 0.0025, 2000, Numerics(), None)
        )
    return results


FOLLOWED = ("p1", "p2", "p4 born at 0.6200", "p4 born at 0.6705", "p4 born at 0.7245")
KNOWN = [p for p in ALL if p.branch.startswith(FOLLOWED)]


@pytest.mark.parametrize("known", KNOWN, ids=lambda p: f"{p.branch}-{p.kind}-{p.eta[:8]}")
def test_a_special_point_is_where_the_other_program_has_it(found, known):
    events = [
        (result, e)
        for result in found
        for e in result.events
        if e.code == KINDS[known.kind] and result.period[e.point] == known.periods
    ]
    result, nearest = min(events, key=lambda pair: abs(pair[1].values[0] - float(known.eta)))
    assert abs(nearest.values[0] - float(known.eta)) < 1e-11
    strobes = result.section[nearest.point, : known.periods]
    there = np.array([float(s) for s in known.state])
    assert np.abs(strobes - there).max(axis=1).min() < 1e-8
    if known.kind != "grazing":
        multipliers = result.multipliers[nearest.point]
        for one in known.multipliers:
            assert np.abs(multipliers - one).min() < 1e-6
        assert (multipliers == 0).sum() == 1


def test_no_orbit_of_period_1_doubles_between_060_and_064(found):
    """Its multipliers stay far from -1 there, so the diagram's doublings are those of other orbits."""
    result = found[0]
    inside = (result.branch == 0) & (result.values[:, 0] > 0.6) & (result.values[:, 0] < 0.64)
    assert inside.sum() > 5
    assert (np.abs(result.multipliers[inside, 0]) > 2.5).all()
    assert not any(
        e.code == Special.PERIOD_DOUBLING and 0.6 < e.values[0] < 0.64
        for e in result.events
        if result.branch[e.point] == 0
    )


def test_errors_that_are_told_are_those_there_are(found):
    for known in KNOWN:
        for result in found:
            for e in result.events:
                if e.code == KINDS[known.kind] and abs(e.values[0] - float(known.eta)) < 1e-9:
                    assert abs(e.values[0] - float(known.eta)) < 30 * e.error


def test_a_whole_cascade_is_that_of_the_other_program(drill):
    """From the period-2 orbit that doubles at 0.6705, downward to period 32."""
    birth = next(p for p in ALL if p.branch == "p2" and p.eta.startswith("0.6705"))
    y, u, w = (float(value) for value in birth.state)
    system = drill.with_parameters(eta=0.672).with_initial(y=y, u=u, w=w, mode="slip")
    result = branches(system, "eta", (0.655, 0.69), 2, "guess", 0, 4, 0.0005, 150, Numerics(), None)
    assert result.cascade.periods.tolist() == [2, 4, 8, 16, 32]
    assert np.abs(result.cascade.values - CASCADES["E"]).max() < 2e-11

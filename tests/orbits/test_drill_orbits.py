"""The drill's special points return, are what they are called, and are found again from eight digits."""

import numpy as np
import pytest
from mpmath import mp
from support.drill_in_series import SLIP, Drill
from support.drill_orbits import ALL, CASCADES, TESTS, located, named
from support.strobe_orbits import Branch, touches

FEIGENBAUM = 4.669201609102991


def name(special):
    return f"{special.kind}-{special.periods}-{special.eta[:7]}"


@pytest.mark.parametrize("special", ALL, ids=name)
def test_it_returns_and_meets_nothing_else(digits, special):
    digits(18)
    start = [mp.mpf(value) for value in special.state]
    run = Drill(special.eta).run(start, SLIP, special.periods, overlook=1e-2)
    assert run.mode == SLIP
    assert max(abs(a - b) for a, b in zip(run.state, start, strict=True)) < 1e-13
    assert min(event.speed for event in run.events) > 0.03
    values = [value for _, _, value in run.misses]
    if special.kind == "grazing":
        touched = touches(special.touched, mp.mpf(special.time))([*start, mp.mpf(special.eta)], run)
        assert abs(touched) < 1e-14
        values.remove(touched)
    assert max(values) < -1e-4


@pytest.mark.parametrize("special", [s for s in ALL if s.periods <= 2 and s.kind != "grazing"], ids=name)
def test_it_has_its_multipliers(digits, special):
    digits(18)
    held = mp.mpf(special.state[0])
    found = Branch(special.periods, SLIP).find([*special.state, special.eta], lambda z, run: z[0] - held)
    np.testing.assert_allclose(found.multipliers, special.multipliers, atol=1e-7)


@pytest.mark.parametrize(
    "special",
    [named("p1", "period doubling", 0.76), named("p1", "grazing", 0.45)],
    ids=name,
)
def test_it_is_found_again(digits, special):
    digits(20)
    found = located(special)
    assert abs(found.eta - mp.mpf(special.eta)) < 1e-10
    if special.kind != "grazing":
        assert abs(TESTS[special.kind](found)) < 1e-8


def test_period_1_does_not_double_near_the_known_period_2(digits):
    """Between 0.60 and 0.64 the period-1 orbit has no multiplier near -1."""
    digits(18)
    for eta, state in (("0.6", (0.8988, 0.2804, 0.2487)), ("0.64", (0.8627, 0.3444, 0.2370))):
        found = Branch(1, SLIP).at(eta, state)
        assert found.multipliers[0].real < -2.5
        assert abs(found.multipliers[1]) < 0.1


@pytest.mark.parametrize(("cascade", "count"), [("E", 5), ("A", 5)])
def test_a_cascade_tends_to_feigenbaums_ratio(cascade, count):
    steps = np.diff(CASCADES[cascade])
    assert len(CASCADES[cascade]) == count
    assert abs(steps[-2] / steps[-1] - FEIGENBAUM) < 0.01


def test_cascades_hold_the_special_points():
    known = np.array([float(s.eta) for s in ALL if s.kind == "period doubling"])
    for doublings in CASCADES.values():
        for eta in doublings[:3]:
            assert np.abs(known - eta).min() < 1e-12

"""Beyond a grazing: where the orbit with the new event exists, and what it does to the doubled orbit."""

import pytest
from mpmath import mp
from support.drill_in_series import SLIP
from support.drill_orbits import named
from support.grazing_sides import with_event
from support.strobe_orbits import Branch, doubled


@pytest.mark.parametrize(
    "special", [named("p1", "grazing", 0.45), named("p2 born at 0.5510", "grazing", 0.56)], ids=lambda s: s.beyond
)
def test_on_which_side_the_event_exists(digits, special):
    digits(20)
    speed = mp.mpf("1e-4")
    grazing, found = with_event(special, speed)
    side = 1 if found.eta > grazing.eta else -1
    assert side == (special.without if special.beyond == "turns back" else -special.without)
    assert len(found.run.events) == len(grazing.run.events) + 1
    assert abs(found.multipliers[0]) > 0.1 / speed


def test_the_doubled_orbit_is_born_stable_and_above(digits):
    digits(16)
    special = named("p2", "period doubling", 0.62)
    old = Branch(2, SLIP).at(special.eta, special.state)
    new = doubled(old, SLIP, 4, mp.mpf("5e-4"))
    assert 0 < new.eta - old.eta < 1e-4
    assert abs(new.multipliers[0]) < 1

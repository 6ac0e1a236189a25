"""Every hit keeps momentum to round-off and never gains energy."""

import math

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import chaosdrill as cd
from chaosdrill import systems

SYSTEMS = {
    "hunt-crossley": cd.drill(),
    "newton": cd.drill(contact="newton"),
    "free rock": cd.drill(friction="none"),
    "lobes and coulomb": cd.drill(drive="lobes", friction="coulomb"),
    "timed": cd.drill(contact="hunt-crossley-timed"),
    "two-sided": cd.drill(friction="coulomb-two-sided", contact="newton"),
    "two-sided timed": cd.drill(friction="stribeck-two-sided", contact="hunt-crossley-timed"),
    "autonomous": systems.build("percussive-drill-5d"),
}
BIT = {name: "x2" if name == "autonomous" else "u" for name in SYSTEMS}
HITS = [
    (name, t)
    for name, system in SYSTEMS.items()
    for t in system.transitions
    if t.kind in ("impact", "rebound", "hold") and sympy.Symbol(BIT[name], real=True) in t.reset
]
HELD = ("weak-hit", "rebound-from-rest", "hold-stick")
"""Hits of a rock that friction holds, which takes momentum up."""

approaches = st.floats(1e-9, 5.0)
contact = {
    "eps": st.floats(1e-2, 1e2),
    "lam": st.floats(1e-9, 10.0),
    "e": st.floats(0.0, 1.0),
}
WAY = {"stick": 0.0, "stick-contact": 0.0, "slip": 1.0, "slip-contact": 1.0, "slip-back": -1.0}
"""Direction in which the rock moves before the hit."""


def label(pair):
    return f"{pair[0]}: {pair[1].name}"


def rebound(number, name, transition, bit, rock, values):
    """Speeds of bit and rock after the hit."""
    system = SYSTEMS[name]
    u, w = (sympy.Symbol(s, real=True) for s in (BIT[name], "x4" if name == "autonomous" else "w"))
    here = {**system.parameters, **values, u.name: bit, w.name: rock}
    return tuple(number(transition.reset.get(s, s), here) for s in (u, w))


@pytest.mark.parametrize("pair", HITS, ids=label)
@given(approach=approaches, rock=st.floats(0.0, 5.0), values=st.fixed_dictionaries(contact))
def test_no_hit_gains_energy_and_free_masses_keep_momentum_and_part_no_faster_than_they_met(
    number, pair, approach, rock, values
):
    """Three laws of one hit, as its speeds afterwards take longer than all that is asked of them."""
    name, transition = pair
    rock *= WAY[transition.source[0]]
    bit = rock + approach
    eps = values["eps"]
    after = rebound(number, name, transition, bit, rock, values)
    before = eps * bit**2 + rock**2
    assert eps * after[0] ** 2 + after[1] ** 2 <= before * (1 + 1e-14)
    if transition.name in HELD:
        return
    terms = (eps * after[0], after[1], -eps * bit, -rock)
    assert abs(math.fsum(terms)) <= 8 * 2.0**-53 * sum(map(abs, terms))
    slack = 1e-15 * (1 + abs(bit) + abs(rock)) * (1 + eps)
    assert -slack <= after[1] - after[0] <= bit - rock + slack


@pytest.mark.parametrize("name", ["hunt-crossley", "autonomous"])
@given(bit=st.floats(1e-9, 5.0), values=st.fixed_dictionaries(contact))
def test_a_weak_hit_leaves_the_rock_at_rest_and_throws_the_bit_back(number, name, bit, values):
    transition = next(t for t in SYSTEMS[name].transitions if t.name == "weak-hit")
    after = rebound(number, name, transition, bit, 0.0, values)
    assert after[1] == 0
    assert -bit <= after[0] < 0


@pytest.mark.parametrize("name", ["hunt-crossley", "autonomous"])
def test_friction_holds_the_rock_below_a_certain_speed_only(number, name):
    # elastic and linear: the relative mass 1/(1 + eps) on a spring k has the peak force v sqrt(k/(1 + eps))
    transition = next(t for t in SYSTEMS[name].transitions if t.name == "weak-hit")
    u = "x2" if name == "autonomous" else "u"
    values = {"lam": 0.0, "n": 1.0, "k": 2e4, "eps": 1.0}
    assert number(transition.condition, {**values, u: 0.99e-2})
    assert not number(transition.condition, {**values, u: 1.01e-2})


def test_nothing_holds_the_rock_against_an_infinite_force():
    assert [t.name for t in SYSTEMS["newton"].transitions if t.kind == "impact"] == ["strong-hit", "hit"]
    assert "weak-hit" not in [t.name for t in SYSTEMS["two-sided"].transitions]


@given(bit=st.floats(1e-9, 5.0), lam=contact["lam"])
def test_a_fixed_rock_throws_the_bit_back(number, bit, lam):
    system = cd.drill(rock="fixed", friction="none")
    (hit,) = (t for t in system.transitions if t.kind == "impact")
    after = number(hit.reset[system.states[1]], {"u": bit, "lam": lam})
    assert -bit <= after < 0

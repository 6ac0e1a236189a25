"""The flow direction survives every event of every system: S F- = F+."""

import random
from functools import cache

import numpy as np
import pytest

from chaosdrill import drill, systems
from chaosdrill.model.derive import saltation

DRILLS = [
    *({"friction": "stribeck", "contact": contact} for contact in ("newton", "hunt-crossley-timed", "compliant")),
    *({"friction": "coulomb-two-sided", "contact": contact} for contact in systems.EFFECTS["contact"]),
    {"rock": "fixed", "friction": "none", "contact": "compliant"},
]
"""Choices of effects that among them have every transition of the drill, beside the one that is built by default."""

SYSTEMS = {name: systems.build(name) for name in sorted(systems.REGISTRY)}
SYSTEMS |= {" ".join(effects.values()): drill(**effects) for effects in DRILLS}
EVENTS = [
    pytest.param(name, transition.name, source, id=f"{name}: {transition.name}")
    for name, system in SYSTEMS.items()
    for transition in system.transitions
    for source in transition.source
]


@cache
def with_time(name):
    return SYSTEMS[name].augmented(time=True)


@pytest.mark.parametrize(("name", "event", "source"), EVENTS)
def test_flow_direction_survives(number, name, event, source):
    system = with_time(name)
    transition = next(t for t in system.transitions if t.name == event)
    rng = random.Random(f"{name} {event}")
    there = {"": np.nan}
    # what an event does is a number only where it can happen: bodies that part have no contact to last
    while not np.isfinite(list(there.values())).all():
        here = {**system.parameters, **{s: rng.uniform(0.2, 0.9) for s in system.state_names}}
        there = here | {s.name: number(transition.reset.get(s, s), here) for s in system.states}
    before = np.array([number(system.modes[source][s], here) for s in system.states], dtype=float)
    after = np.array([number(system.modes[transition.target][s], there) for s in system.states], dtype=float)
    jump = np.array(saltation(system, transition, source).applyfunc(lambda entry: number(entry, here)), dtype=float)
    scale = max(1.0, np.abs(jump).max(), np.abs(after).max())
    np.testing.assert_allclose(jump @ before, after, rtol=0, atol=1e-12 * scale)

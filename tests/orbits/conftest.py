"""A working precision, and the orbit of the drill that several tests begin with."""

import pytest
from mpmath import mp


@pytest.fixture
def digits():
    """Set the working precision of mpmath for one test."""
    before = mp.dps

    def work_with(count):
        mp.dps = count

    yield work_with
    mp.dps = before


@pytest.fixture(scope="session")
def drill():
    """The drill of the paper, as reproduced."""
    from chaosdrill.systems.drill import drill

    return drill(friction="stribeck", contact="hunt-crossley", eta=0.8, xi=0.06)


@pytest.fixture(scope="session")
def drill_period_one(drill):
    """Shooting problem over eta, orbit and shot of the drill's period-1 orbit at eta = 0.8."""
    from chaosdrill.engine.numerics import Numerics
    from chaosdrill.orbits.find import starting_orbit

    problem, orbit, shot, _, _ = starting_orbit(drill, ("eta",), 1, "attractor", 300, Numerics())
    return problem, orbit, shot

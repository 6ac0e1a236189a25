"""Where the equations close but the system goes otherwise, no orbit is reported."""

from math import pi

import numpy as np
import pytest
from support.closed_impact import one_impact

from chaosdrill.dataset import Outcome
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.find import admissible, inadmissible_words
from chaosdrill.orbits.orbit import Orbit
from chaosdrill.orbits.problem import Problem
from chaosdrill.orbits.verification import describe
from chaosdrill.systems import build

FINE = Numerics(tolerance=1e-13)


def closed(w, d, n, which):
    """The orbit of a closed form, the system it belongs to, and whether it stays below the wall."""
    impact = one_impact(w, d, 0.05, 0.8, n)[which]
    problem = Problem(build("impact-oscillator", {"omega": w, "wall": d}), (), FINE)
    segments, starts = np.array([[0, 0, 0]]), np.array([[d, -0.8 * impact.speed]])
    guess = Orbit(segments, n, starts, impact.phase / w, np.array([n * 2 * pi / w]))
    code, orbit, shot, residuals = problem.newton(guess)
    assert code == 0
    assert residuals[-1] < 1e-12
    assert np.trace(shot.monodromy) == pytest.approx(impact.trace, rel=1e-9)
    return problem, orbit, shot, residuals, impact.highest < d


@pytest.mark.parametrize(
    ("w", "d", "n", "which"), [(2.0, 0.3, 2, 0), (2.0, 0.3, 3, 0), (2.5, 0.3, 4, 0), (1.8, 0.5, 3, 1)]
)
def test_an_orbit_through_the_wall(w, d, n, which):
    problem, orbit, shot, residuals, below = closed(w, d, n, which)
    assert not below
    assert not admissible(orbit, shot)
    assert inadmissible_words(problem, orbit, shot) == "in mode 'free' the guard of 'impact' is crossed on the way"
    found = describe(problem, orbit, shot, residuals)
    assert found.outcome == Outcome.INADMISSIBLE
    assert "the equations close, but" in found.message
    assert len(found.states) == 0


@pytest.mark.parametrize(("w", "d", "n", "which"), [(2.0, 0.3, 1, 0), (2.5, 0.3, 2, 0), (1.8, 0.5, 3, 0)])
def test_an_orbit_below_the_wall(w, d, n, which):
    problem, orbit, shot, residuals, below = closed(w, d, n, which)
    assert below
    assert admissible(orbit, shot)
    found = describe(problem, orbit, shot, residuals)
    assert found.outcome == Outcome.PERIODIC
    assert found.residual < 1e-12
    assert found.checks.consistent

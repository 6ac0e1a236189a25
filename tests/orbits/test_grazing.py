"""Where a wall is just touched: closed forms of the non-impacting orbit, and what becomes of its branch."""

import math

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.systems import build

ZETA = 0.05


def frequency(wall):
    """Forcing frequency above resonance at which the amplitude of the free response is that of the wall."""
    h = 1 - 2 * ZETA**2
    return math.sqrt(h + math.sqrt(h * h - 1 + 1 / wall**2))


def branch(wall, start, limits, points=400):
    system = build("impact-oscillator", {"wall": wall, "zeta": ZETA, "omega": start}, {}).with_initial(x=-0.1, v=0.0)
    step = (limits[1] - limits[0]) / 200
    return system, branches(system, "omega", limits, 1, "attractor", 300, 0, step, points, Numerics(), None)


@pytest.mark.parametrize(("wall", "becomes"), [(0.3, "continues"), (0.5, "folds back")])
def test_grazing_is_where_the_amplitude_reaches_the_wall(wall, becomes):
    _, result = branch(wall, 3.6, (frequency(wall) - 0.05, 4.0))
    grazing = [e for e in result.events if e.code == Special.GRAZING]
    assert abs(grazing[0].values[0] - frequency(wall)) < 1e-11
    assert grazing[0].text == f"impact appears; the branch {becomes}"
    before, after = sorted({int(s) for s in result.sequence[result.branch == 0]})[:2]
    assert {result.sequences[before], result.sequences[after]} == {"", "impact"}


@pytest.mark.parametrize("wall", [0.3, 0.5])
def test_simulation_hits_the_wall_on_one_side_of_grazing_only(wall):
    exact = frequency(wall)
    for off, hits in ((1e-6, 0), (-1e-6, 1)):
        omega = exact + off
        system = build("impact-oscillator", {"wall": wall, "zeta": ZETA, "omega": omega}, {})
        square = (1 - omega**2) ** 2 + (2 * ZETA * omega) ** 2
        # the response of the oscillator without the wall, at phase zero
        state = {"x": (1 - omega**2) / square, "v": 2 * ZETA * omega**2 / square}
        ds = cd.trajectory(system.with_initial(**state), periods=1)
        assert ds.sizes["event"] == hits


def test_a_branch_that_grazing_ends_says_so():
    """Behind the wall of this ball everything is lost: no orbit with the hit exists, and the branch ends there."""
    import sympy

    x, v, t, omega = sympy.symbols("x v t omega", real=True)
    system = cd.HybridSystem(
        name="trapdoor", states=(x, v), time=t, parameters={"omega": 3.6},
        modes={"held": {x: v, v: -x - 0.1 * v + sympy.cos(omega * t)}, "falling": {x: v, v: 1}},
        transitions=[cd.Transition("open", "held", "falling", guard=x - 0.3, direction=1, reset={})],
        period=2 * sympy.pi / omega, initial={"mode": "held", x: -0.1},
    )  # fmt: skip
    result = branches(system, "omega", (1.9, 4.0), 1, "attractor", 300, 0, 0.01, 500, Numerics(), None)
    assert result.branches[0].end_code in (BranchEnd.LIMIT, BranchEnd.GRAZING)
    grazing = [e for e in result.events if e.code == Special.GRAZING]
    assert [e.text for e in grazing] == ["open appears; the branch ends"]
    assert abs(grazing[0].values[0] - frequency(0.3)) < 1e-11
    assert np.abs(result.values[:, 0].min() - frequency(0.3)) < 1e-11
    assert "open appears; the branch ends" in result.branches[0].end

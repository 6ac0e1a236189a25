"""Where the sequence of events changes: grazing, corner and border collision, and what lies beyond."""

import math

import numpy as np
import pytest
import sympy
from scipy.linalg import expm

import chaosdrill as cd
from chaosdrill.dataset.branches import BranchEnd, Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches
from chaosdrill.systems import build

# Where a wall is just touched: closed forms of the non-impacting orbit, and what becomes of its branch.


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


# Border collision of a converter: events appear and vanish at full speed, and the branch goes on near by or ends.


VIN, INDUCTANCE, CAPACITANCE, LOAD, CLOCK = 10.0, 1e-3, 12e-6, 20.0, 1e-4


@pytest.fixture(scope="module")
def converter():
    """Current-mode controlled boost converter: a clock closes the switch, the current opens it at a reference.

    Banerjee and Verghese (eds.), Nonlinear Phenomena in Power Electronics, IEEE Press 2001;
    di Bernardo, Budd, Champneys and Kowalczyk 2008, doi:10.1007/978-1-84628-708-4.
    """
    i, v, s, reference = sympy.symbols("i v s reference", real=True)
    vin, ind, cap, load, clock = sympy.symbols("vin ind cap load clock", real=True)
    return cd.HybridSystem(
        name="boost", states=(i, v, s),
        parameters={"reference": 1.7, "vin": VIN, "ind": INDUCTANCE, "cap": CAPACITANCE, "load": LOAD, "clock": CLOCK},
        modes={
            "on": {i: vin / ind, v: -v / (load * cap), s: 1 / clock},
            "off": {i: (vin - v) / ind, v: i / cap - v / (load * cap), s: 1 / clock},
        },
        transitions=[
            cd.Transition("switch_off", "on", "off", guard=i - reference, direction=1),
            cd.Transition("clock", "off", "on", guard=s - 1, direction=1, reset={s: 0}),
            cd.Transition("skip", "on", "on", guard=s - 1, direction=1, reset={s: 0}),
        ],
        initial={"mode": "on", i: 0.9, v: 15.0, s: 0.0},
    )  # fmt: skip


def collision():
    """The reference at which a current that rises through a whole period ends it at the reference, exactly.

    From the clock on, v0 decays for a period while i rises by VIN CLOCK/L to the reference; then the switch is open
    for a period, after which both are as before: two linear equations for v0 and the reference.
    """
    off = np.array([[0, -1 / INDUCTANCE, VIN / INDUCTANCE], [1 / CAPACITANCE, -1 / (LOAD * CAPACITANCE), 0], [0, 0, 0]])
    over = expm(off * CLOCK)
    decay = np.exp(-CLOCK / (LOAD * CAPACITANCE))
    # i1 = reference, v1 = decay v0: over @ (i1, v1, 1) = (reference - rise, v0)
    matrix = np.array([[over[0, 1] * decay, over[0, 0] - 1], [over[1, 1] * decay - 1, over[1, 0]]])
    return float(np.linalg.solve(matrix, [-VIN * CLOCK / INDUCTANCE - over[0, 2], -over[1, 2]])[1])


@pytest.mark.parametrize("limits", [(1.4, 2.6), (1.0, 3.0)])
def test_the_doubled_branch_goes_on_behind_the_collision(converter, limits):
    step = (limits[1] - limits[0]) / 200
    result = branches(converter, "reference", limits, 1, "attractor", 1, 1, step, 2000, Numerics(tolerance=1e-13), None)
    doubling, border = result.events
    assert doubling.code == Special.PERIOD_DOUBLING
    assert border.code == Special.BORDER_COLLISION
    assert border.text == "skip appears, switch_off and clock vanish; the branch continues"
    assert border.values[0] == pytest.approx(collision(), rel=1e-10)
    assert [b.period for b in result.branches] == [1, 2]
    beyond = (result.branch == 1) & (result.values[:, 0] > border.values[0])
    assert beyond.sum() > 5
    assert {result.sequences[k] for k in result.sequence[beyond]} == {"clock skip switch_off"}
    assert (result.smallest_speed > 9e3).all()

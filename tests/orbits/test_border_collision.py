"""Border collision of a converter: events appear and vanish at full speed, and the branch goes on near by or ends."""

import numpy as np
import pytest
import sympy
from scipy.linalg import expm

import chaosdrill as cd
from chaosdrill.dataset.branches import Special
from chaosdrill.engine.numerics import Numerics
from chaosdrill.orbits.branches import branches

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

"""Where an event that moves the state however slow it is vanishes: the curve against the exact flow."""

import numpy as np
import pytest
import sympy
from scipy.linalg import expm
from scipy.optimize import fsolve
from support.following import followed

import chaosdrill as cd
from chaosdrill.dataset.branches import Special

KICK, DAMPING = 0.5, 0.2


@pytest.fixture(scope="module")
def kicked():
    x, v, t, omega, wall = sympy.symbols("x v t omega wall", real=True)
    system = cd.HybridSystem(
        name="kicked-oscillator",
        states=(x, v),
        time=t,
        parameters={"omega": 1.9, "wall": 0.2},
        modes={"free": {x: v, v: -x - sympy.Rational(1, 5) * v + sympy.cos(omega * t)}},
        transitions=[
            cd.Transition(
                "kick", "free", "free", guard=x - wall, direction=+1, reset={v: -v / 2 - sympy.Rational(1, 2)}
            )
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "free", x: 0.0, v: 0.0},
    )
    return followed(system, {"omega": (1.2, 6.0), "wall": (-1.0, 1.0)}, "grazing", 0.05)


def touching_walls(omega, guess):
    """Walls that the flight which leaves them with the kick alone just touches a period later, by the exact flow."""
    flow = expm(np.array([[0, 1], [-1, -DAMPING]]) * 2 * np.pi / omega)

    def gap(unknown):
        phase, wall = unknown
        force = np.exp(1j * phase) / (1 - omega**2 + 1j * DAMPING * omega)
        forced = np.array([force.real, (1j * omega * force).real])
        return flow @ (np.array([wall, -KICK]) - forced) + forced - np.array([wall, 0.0])

    found = [fsolve(gap, (phase, guess), full_output=True, xtol=1e-13) for phase in (0.0, 2.0, 3.0, 4.0)]
    return np.array([one[0][1] for one in found if np.abs(one[1]["fvec"]).max() < 1e-14])


def test_the_kick_vanishes_where_the_exact_flow_says(kicked):
    points = kicked.values[:: len(kicked.values) // 8]
    for omega, wall in points:
        assert np.abs(touching_walls(omega, wall) - wall).min() < 1e-11
    assert np.ptp(points[:, 0]) > 1.0


def test_it_is_met_at_no_speed(kicked):
    assert (kicked.special == Special.GRAZING).all()
    assert kicked.sequences == ("kick",)
    assert kicked.smallest_speed.max() < 1e-11
    # the tangent map has no bound there
    assert np.isnan(kicked.multipliers).all()
    assert not kicked.stable.any()

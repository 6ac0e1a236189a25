"""Systems that several analyses are tried on."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd


@pytest.fixture(scope="session")
def duffing():
    """A smooth forced oscillator: no event, chaotic at these parameters."""
    x, v, t, delta, gamma, omega = sympy.symbols("x v t delta gamma omega", real=True)
    return cd.HybridSystem(
        name="duffing",
        states=(x, v),
        time=t,
        parameters={"delta": 0.25, "gamma": 0.4, "omega": 1.0},
        modes={"well": {x: v, v: x - x**3 - delta * v + gamma * sympy.cos(omega * t)}},
        period=2 * sympy.pi / omega,
        quadratures={"work": v**2, "penetration": v},
        initial={x: 0.5, v: -0.2},
    )


@pytest.fixture(scope="session")
def circle():
    """A rotation by ``angle`` about the origin between two strobes, with a growth: the map is known in closed form."""
    x, y, angle, growth = sympy.symbols("x y angle growth", real=True)
    return cd.HybridSystem(
        name="circle",
        states=(x, y),
        parameters={"angle": 2 * np.pi / 5, "growth": 0.0},
        modes={"turn": {x: growth * x - angle * y, y: angle * x + growth * y}},
        transitions=[cd.Transition("axis", "turn", "turn", guard=y, direction=+1)],
        period=sympy.Integer(1),
        initial={x: 1.0, y: 0.0},
        bounds={x: (-100, 100), y: (-100, 100)},
    )


@pytest.fixture(scope="session")
def bouncer():
    """A ball on a floor at rest."""
    x, v, g, e = sympy.symbols("x v g e", real=True)
    return cd.HybridSystem(
        name="ball",
        states=(x, v),
        parameters={"g": 2.0, "e": 0.75},
        modes={"flight": {x: v, v: -g}},
        transitions=[
            cd.Transition("apex", "flight", "flight", guard=v, direction=-1),
            cd.Transition("hit", "flight", "flight", guard=x, direction=-1, reset={v: -e * v}, kind="impact"),
        ],
        initial={x: 1.0, v: 3.0},
    )

"""Systems that several analyses are tried on."""

import numpy as np
import pytest
import sympy
from support.discrete import clocked

import chaosdrill as cd


@pytest.fixture(scope="session")
def duffing():
    """A smooth forced oscillator: no event, chaotic at these parameters."""
    return cd.HybridSystem(
        name="duffing",
        states="x v",
        parameters={"delta": 0.25, "gamma": 0.4, "omega": 1.0},
        modes={"well": {"x": "v", "v": "x - x**3 - delta*v + gamma*cos(omega*t)"}},
        period="2*pi/omega",
        quadratures={"work": "v**2", "penetration": "v"},
        initial={"x": 0.5, "v": -0.2},
    )


@pytest.fixture(scope="session")
def circle():
    """A rotation by ``angle`` about the origin between two strobes, with a growth: the map is known in closed form."""
    return cd.HybridSystem(
        name="circle",
        states="x y",
        parameters={"angle": 2 * np.pi / 5, "growth": 0.0},
        modes={"turn": {"x": "growth*x - angle*y", "y": "angle*x + growth*y"}},
        transitions=[cd.Transition("axis", "turn", "turn", guard="y", direction=+1)],
        period=1,
        initial={"x": 1.0},
        bounds={"x": (-100, 100), "y": (-100, 100)},
    )


@pytest.fixture(scope="session")
def bouncer():
    """A ball on a floor at rest."""
    return cd.HybridSystem(
        name="ball",
        states="x v",
        parameters={"g": 2.0, "e": 0.75},
        modes={"flight": {"x": "v", "v": "-g"}},
        transitions=[
            cd.Transition("apex", "flight", "flight", guard="v", direction=-1),
            cd.Transition("hit", "flight", "flight", guard="x", direction=-1, reset={"v": "-e*v"}, kind="impact"),
        ],
        initial={"x": 1.0, "v": 3.0},
    )


@pytest.fixture(scope="session")
def logistic():
    """x -> r x (1 - x)."""
    x, r = sympy.symbols("x r", real=True)
    return clocked("logistic", (x,), {"r": 3.2}, {x: r * x * (1 - x)}, {x: 0.3})


@pytest.fixture(scope="session")
def delayed_logistic():
    """x -> r x (1 - y), y -> x: the fixed point sheds an invariant circle at r = 2."""
    x, y, r = sympy.symbols("x y r", real=True)
    return clocked("delayed", (x, y), {"r": 2.1}, {x: r * x * (1 - y), y: x}, {x: 0.4, y: 0.5})


@pytest.fixture(scope="session")
def bistable():
    """x' = a + x - x**3, y' = -y/2: two equilibria between the folds at a = -+2/sqrt(27)."""
    return cd.HybridSystem(
        name="bistable",
        states="x y",
        parameters={"a": 0.0, "c": 1.0},
        modes={"only": {"x": "a + x - x**3", "y": "-y*c/2"}},
        period=1,
        initial={"x": -1.0, "y": 0.1},
    )


@pytest.fixture(scope="session")
def equilibria():
    """Stable equilibria of that by a, lowest and highest."""

    def roots(a):
        found = np.roots([-1.0, 0.0, 1.0, a])
        real = np.sort(found[np.abs(found.imag) < 1e-9].real)
        return real[0], real[-1]

    return roots

"""Tangents through a stiff contact

A body pressed by a load bounces off a stiff spring. Two dozen Runge-Kutta steps through the contact give its speed
to five digits; the derivative of the speed by the place is off by a number that grows with the square root of the
stiffness, for a phase error of 1e-5 is multiplied by it. An exponent computed from such tangents is invented. The
error control must see the tangents, and the flow direction must come through the contact: M F− = F+.
"""

import math

import numpy as np
import sympy
from tools import Finding, show, tangent_map

import chaosdrill as cd

LOAD, SPEED, STEPS, LATER = 0.45, 1.0, 24, 1e-3
X, V = sympy.symbols("x v", real=True)


def pressed(k: float) -> "cd.HybridSystem":
    """A body under a constant load that meets a spring of stiffness ``k`` at x = 0 with speed 1."""
    load, stiffness = sympy.symbols("f k", real=True)
    return cd.HybridSystem(
        name="pressed body",
        states=(X, V),
        parameters={"f": LOAD, "k": k},
        modes={"free": {X: V, V: load}, "contact": {X: V, V: load - stiffness * X}},
        transitions=[
            cd.Transition("touch", "free", "contact", guard=X, direction=+1),
            cd.Transition("part", "contact", "free", guard=X, direction=-1),
        ],
        initial={"mode": "contact", X: 0.0, V: SPEED},
    )


def entry(k: float) -> float:
    """Derivative of the exit speed by the place, closed form (at one instant of free time)."""
    return 2 * LOAD / SPEED / (1 + LOAD**2 / (SPEED**2 * k))


def contact_time(k: float) -> float:
    """Duration of the contact, closed form."""
    return (math.pi + 2 * math.atan(LOAD / (SPEED * math.sqrt(k)))) / math.sqrt(k)


def runge_kutta(k: float) -> tuple[float, float]:
    """Return exit speed and the same derivative by the classical method, 24 steps over the exact duration."""
    matrix = np.array([[0.0, 1.0], [-k, 0.0]])
    h = contact_time(k) / STEPS
    state, tangent = np.array([0.0, SPEED]), np.array([1.0, 0.0])
    for _ in range(STEPS):
        for load, vector in ((LOAD, state), (0.0, tangent)):
            force = np.array([0.0, load])
            k1 = matrix @ vector + force
            k2 = matrix @ (vector + h / 2 * k1) + force
            k3 = matrix @ (vector + h / 2 * k2) + force
            k4 = matrix @ (vector + h * k3) + force
            vector += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return float(state[1]), float(tangent[1])


def findings() -> list[Finding]:
    """Speed and derivative at three stiffnesses, and the flow direction through the contact."""
    rows = []
    for k, within in ((1e8, 1e-7), (1e10, 1e-6), (1e12, 1e-5)):
        later = LATER * math.sqrt(1e8 / k)
        state, map_, _ = tangent_map(pressed(k), later)
        speed, derivative = runge_kutta(k)
        leaving = float(state[1]) - LOAD * (later - contact_time(k))
        by = f"{{}} (Runge-Kutta, {STEPS} steps through the contact)"
        rows.append(Finding(f"exit speed, k = {k:.0e}", -SPEED, leaving, 1e-11, by.format(show(speed, 7))))
        rows.append(
            Finding(
                f"its derivative by the place, k = {k:.0e}",
                entry(k),
                float(map_[1, 0]),
                within,
                by.format(show(derivative, 4)),
            )
        )
        flow = map_ @ [SPEED, LOAD] - [state[1], LOAD]
        rows.append(Finding(f"M F− − F+, k = {k:.0e}", 0.0, float(np.abs(flow).max()), within))
    return rows

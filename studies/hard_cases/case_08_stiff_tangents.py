"""Tangents through a stiff contact

A body pressed by a load bounces off a stiff spring. Two dozen Runge-Kutta steps through the contact give its speed
to six digits; the derivative of the speed by the place may not have the right sign, for an error of the phase is
multiplied by the square root of the stiffness. An exponent computed from such tangents is invented. The error
control must see the tangents, and the flow direction must come through the contact: M F− = F+.
"""

import math

import numpy as np
import sympy
from tools import Finding, show, tangent_map

import chaosdrill as cd
from chaosdrill.model.special import positive_power

LOAD, SPEED, STEPS, AFTER = 0.45, 1.0, 24, 1e-5
METHODS = {1.0: "taylor", 1.5: "dop853"}
"""Exponent -> method: a force of exponent 1.5 has no series where the contact begins."""

X, V, F, K, N = sympy.symbols("x v f k n", real=True)


def pressed(k: float, n: float = 1.0) -> "cd.HybridSystem":
    """A body under a constant load that meets the spring force k xⁿ at x = 0 with speed 1."""
    return cd.HybridSystem(
        name="pressed body",
        states=(X, V),
        parameters={"f": LOAD, "k": k, "n": n},
        modes={"free": {X: V, V: F}, "contact": {X: V, V: F - K * positive_power(X, N)}},
        transitions=[
            cd.Transition("touch", "free", "contact", guard=X, direction=+1),
            cd.Transition("part", "contact", "free", guard=X, direction=-1),
        ],
        initial={"mode": "contact", X: 0.0, V: SPEED},
    )


def entry(k: float, n: float = 1.0) -> float:
    """Derivative of the exit speed by the place: 2 f/v + f² T'(v), exact for n = 1, else to first order in T."""
    if n == 1:
        return 2 * LOAD / SPEED / (1 + LOAD**2 / (SPEED**2 * k))
    return 2 * LOAD / SPEED + LOAD**2 * (1 - n) / (1 + n) * contact_time(k, n) / SPEED


def contact_time(k: float, n: float = 1.0) -> float:
    """Duration T of the contact, exact for n = 1, else without the load."""
    if n == 1:
        return (math.pi + 2 * math.atan(LOAD / (SPEED * math.sqrt(k)))) / math.sqrt(k)
    share = 1 / (n + 1)
    depth = ((n + 1) * SPEED**2 / (2 * k)) ** share
    return 2 * depth / SPEED * math.sqrt(math.pi) * math.gamma(1 + share) / math.gamma(0.5 + share)


def runge_kutta(k: float, n: float = 1.0) -> tuple[float, float]:
    """Return exit speed and the same derivative by the classical method, 24 steps over the duration."""

    def rates(s: np.ndarray) -> np.ndarray:
        depth = max(s[0], 0.0)
        return np.array([s[1], LOAD - k * depth**n, s[3], -k * n * depth ** (n - 1) * s[2]])

    h = contact_time(k, n) / STEPS
    state = np.array([0.0, SPEED, 1.0, 0.0])
    for _ in range(STEPS):
        k1 = rates(state)
        k2 = rates(state + h / 2 * k1)
        k3 = rates(state + h / 2 * k2)
        k4 = rates(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return float(state[1]), float(state[3])


def findings() -> list[Finding]:
    """Speed and derivative at several stiffnesses and exponents, and the flow direction through the contact."""
    rows = []
    for k, n, within in ((1e8, 1.0, 1e-8), (1e12, 1.0, 1e-6), (1e8, 1.5, 1e-6)):
        later = contact_time(k, n) + AFTER
        state, map_, _ = tangent_map(pressed(k, n), later, method=METHODS[n])
        speed, derivative = runge_kutta(k, n)
        # the body is free again: its speed at x = 0 follows from the energy
        leaving = -math.sqrt(float(state[1]) ** 2 - 2 * LOAD * float(state[0]))
        where = f"k = {k:.0e}, n = {n:g}"
        by = f"{{}} (Runge-Kutta, {STEPS} steps through the contact)"
        rows.append(Finding(f"exit speed, {where}", -SPEED, leaving, 1e-10, by.format(show(speed, 7))))
        rows.append(
            Finding(
                f"its derivative by the place, {where}",
                entry(k, n),
                float(map_[1, 0]),
                within,
                by.format(show(derivative, 4)),
            )
        )
        flow = map_ @ [SPEED, LOAD] - [state[1], LOAD]
        rows.append(Finding(f"M F− − F+, {where}", 0.0, float(np.abs(flow).max()), 1e-8))
    return rows

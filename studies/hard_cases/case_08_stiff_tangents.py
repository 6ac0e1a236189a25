"""Tangents through a stiff contact

A loaded body bounces off a stiff spring. With two dozen Runge-Kutta steps through the contact, whose end is located to
less than a thousandth of its duration, the exit speed is right to five digits, but its derivative with respect to the
position may have any error: the delay of the end enters multiplied by the stiffness, and a force with exponent 1.5 is
not smooth where it begins. Exponents from such tangents are artefacts. The error control must include the tangents, and
the contact must map the flow direction to the flow direction: M F− = F+.
"""

import math
from functools import cache

import mpmath
import numpy as np
import sympy
from tools import Finding, show, tangent_map

import chaosdrill as cd
from chaosdrill.model.special import positive_power

LOAD, SPEED, STEPS, AFTER = 0.45, 1.0, 24, 1e-6
TOLERANCE = 1e-12
"""That of the package, unless another is given."""

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


@cache
def entry(k: float, n: float = 1.0) -> float:
    """Derivative of the exit speed by the place, 2 f/v + f² T'(v)/v, with energy kept and the duration T."""
    if n == 1:
        return 2 * LOAD / SPEED / (1 + LOAD**2 / (SPEED**2 * k))
    with mpmath.workdps(20):
        return float(2 * LOAD / SPEED + LOAD**2 / SPEED * mpmath.diff(lambda v: _duration(v, k, n), SPEED))


@cache
def contact_time(k: float, n: float = 1.0) -> float:
    """Duration T of the contact."""
    if n == 1:
        return (math.pi + 2 * math.atan(LOAD / (SPEED * math.sqrt(k)))) / math.sqrt(k)
    with mpmath.workdps(20):
        return float(_duration(SPEED, k, n))


def _duration(v: "mpmath.mpf", k: float, n: float) -> "mpmath.mpf":
    """Twice the time to the greatest depth, by quadrature of dx/|v(x)| with x = depth (1 - s²)."""

    def square(x: "mpmath.mpf") -> "mpmath.mpf":
        return v**2 + 2 * LOAD * x - 2 * k * x ** (n + 1) / (n + 1)

    depth = mpmath.findroot(square, ((n + 1) * v**2 / (2 * k)) ** (1 / mpmath.mpf(n + 1)))
    return (
        4 * depth * mpmath.quad(lambda s: s / mpmath.sqrt(square(depth * (1 - s**2))), [0, 1], method="gauss-legendre")
    )


def runge_kutta(k: float, n: float = 1.0) -> tuple[float, float]:
    """Return exit speed and the same derivative by the method of the paper, 24 steps through the contact."""
    duration = contact_time(k, n)
    later = duration + AFTER
    steps = {"method": "rk4", "steps": round(STEPS * later / duration), "tolerance": 1e-2}
    state, map_, _ = tangent_map(pressed(k, n), later, **steps)
    return leaving(state), float(map_[1, 0])


def leaving(state: np.ndarray) -> float:
    """Return the speed with which the body has left the spring, from its energy later on."""
    return -math.sqrt(float(state[1]) ** 2 - 2 * LOAD * float(state[0]))


def frequency(k: float, n: float) -> float:
    """Angular frequency of the spring where it is deepest: on the way tangents are so many times as long as states."""
    deepest = ((n + 1) * SPEED**2 / (2 * k)) ** (1 / (n + 1))
    return math.sqrt(n * k * deepest ** (n - 1))


def findings() -> list[Finding]:
    """Speed and derivative at several stiffnesses and exponents, and the flow direction through the contact."""
    rows = []
    for k, n in ((1e8, 1.0), (1e12, 1.0), (1e8, 1.5)):
        later = contact_time(k, n) + AFTER
        state, map_, _ = tangent_map(pressed(k, n), later, method=METHODS[n])
        speed, derivative = runge_kutta(k, n)
        where = f"k = {k:.0e}, n = {n:g}"
        by = f"{{}} (Runge-Kutta, {STEPS} steps through the contact)"
        rows.append(Finding(f"exit speed, {where}", -SPEED, leaving(state), 1e-10, by.format(show(speed, 7))))
        rows.append(
            Finding(
                f"its derivative by the place, {where}",
                entry(k, n),
                float(map_[1, 0]),
                TOLERANCE * frequency(k, n),
                by.format(show(derivative, 4)),
            )
        )
        flow = map_ @ [SPEED, LOAD] - [state[1], LOAD]
        rows.append(Finding(f"M F− − F+, {where}", 0.0, float(np.abs(flow).max()), 1e-8))
    return rows

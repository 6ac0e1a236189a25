"""Mapped and resolved contact

A stop either maps the speed, and a hit takes no time, or it is a stiff spring that is integrated. Most programs have
one of the two. For the Hunt-Crossley force k dⁿ (1 + λ d') both have the same exit speed, but the duration of the
integrated hit decreases only like k^(−1/(n+1)), and so does the difference between the traces of the multipliers. With
n = 1.5 it is still 0.0016 at a stiffness of 10¹⁰, and a soft stop has another attractor.
"""

import math

import numpy as np
import sympy
from tools import Finding, show

import chaosdrill as cd
from chaosdrill.model.special import hunt_crossley_exit, positive_power

X, V, T = sympy.symbols("x v t", real=True)
LAM, OMEGA, K, N = sympy.symbols("lam omega k n", real=True)
FORCE = -X + sympy.cos(OMEGA * T)
LAMBDA, FREQUENCY = 0.6, 2.6
METHODS = {1.0: "taylor", 1.5: "dop853"}
"""Exponent -> method: a force of exponent 1.5 has no series where the contact begins."""


def mapped() -> "cd.HybridSystem":
    """An oscillator with a stop at rest, whose hits take no time."""
    return cd.HybridSystem(
        name="mapped stop",
        states=(X, V),
        time=T,
        parameters={"lam": LAMBDA, "omega": FREQUENCY},
        modes={"free": {X: V, V: FORCE}},
        transitions=[
            cd.Transition("hit", "free", "free", guard=X, direction=+1, reset={V: -hunt_crossley_exit(V, LAM)})
        ],
        period=2 * sympy.pi / OMEGA,
        initial={"mode": "free", X: -0.1},
    )


def resolved(k: float, n: float) -> "cd.HybridSystem":
    """The same, whose hits are integrated."""
    return cd.HybridSystem(
        name="resolved stop",
        states=(X, V),
        time=T,
        parameters={"lam": LAMBDA, "omega": FREQUENCY, "k": k, "n": n},
        modes={"free": {X: V, V: FORCE}, "contact": {X: V, V: FORCE - K * positive_power(X, N) * (1 + LAM * V)}},
        transitions=[
            cd.Transition("touch", "free", "contact", guard=X, direction=+1),
            cd.Transition("part", "contact", "free", guard=X, direction=-1),
        ],
        period=2 * sympy.pi / OMEGA,
        initial={"mode": "free", X: -0.1},
    )


def cycle(system: "cd.HybridSystem", method: str = "taylor") -> tuple[int, np.ndarray]:
    """Return the period of the attractor and the multipliers of the cycle, shape (2,)."""
    section = cd.poincare_section(system, periods=24, transient=600, method=method)
    return int(section["period"]), section["multiplier_real"].values + 1j * section["multiplier_imag"].values


def traces(n: float, stiffnesses: tuple[float, ...]) -> dict[float, float]:
    """Return by stiffness how far the trace of the multipliers is from that of the mapped stop."""
    _, limit = cycle(mapped())
    return {k: float((cycle(resolved(k, n), METHODS[n])[1].sum() - limit.sum()).real) for k in stiffnesses}


def findings() -> list[Finding]:
    """The slope of the difference over the stiffness, and what a soft stop does."""
    rows = []
    for n in METHODS:
        off = traces(n, (1e6, 1e8, 1e10))
        slope = math.log(off[1e10] / off[1e8]) / math.log(100)
        shown = ", ".join(f"{show(value, 3)} at k = {k:.0e}" for k, value in off.items())
        rows.append(
            Finding(
                f"slope of log difference over log k, n = {n:g}", -1 / (n + 1), slope, 1e-3, f"{shown} (mapped stop)"
            )
        )
    one, _ = cycle(mapped())
    soft, _ = cycle(resolved(1e4, 1.0))
    rows.append(Finding("period of the attractor, k = 1e4, n = 1", "3", str(soft), 0.0, f"{one} (mapped stop)"))
    other, ours = cycle(resolved(1e8, 1.0), "dop853")[1], cycle(resolved(1e8, 1.0))[1]
    gap = float(np.abs(np.sort_complex(other) - np.sort_complex(ours)).max())
    rows.append(Finding("multipliers by two methods, k = 1e8, n = 1: largest difference", 0.0, gap, 1e-7))
    return rows

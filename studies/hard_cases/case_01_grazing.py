"""Grazing

A ball thrown at a ceiling only just reaches it. The lower its speed there, the more its later motion depends on the
initial height: the tangent grows like 1/v, without bound. Some programs clip it. Others take a finite difference, one
of whose neighbours misses the ceiling. It must not be clipped: ln(1/v) is integrable, so that the exponents stay right.
Every archive contains the smallest normal speed of its run.
"""

import math

import sympy
from tools import Finding, show, tangent_map

import chaosdrill as cd

E = 0.8
X, V = sympy.symbols("x v", real=True)


def thrown(depth: float) -> "cd.HybridSystem":
    """A ball that would overshoot the ceiling by ``depth`` at time 1."""
    return cd.HybridSystem(
        name="thrown ball",
        states=(X, V),
        parameters={"e": E},
        modes={"flight": {X: V, V: -1}},
        transitions=[
            cd.Transition("impact", "flight", "flight", guard=X, direction=+1, reset={V: -sympy.Symbol("e") * V})
        ],
        initial={"mode": "flight", X: -0.5 + depth, V: 1.0},
    )


def height(start: float) -> float:
    """Return the ball's height at time 2 by the formulas of free fall."""
    top = start + 0.5
    if top <= 0:
        return start
    hit = math.sqrt(2 * top)
    fall = 1 + hit
    return -E * hit * fall - fall**2 / 2


def exact(depth: float) -> float:
    """Derivative of the height at time 2 by the start, for the start that is -0.5 + depth in floating point."""
    kept = (-0.5 + depth) + 0.5
    return -(1 + E) / math.sqrt(2 * kept) - (1 + 2 * E)


def findings() -> list[Finding]:
    """Sensitivities for three depths, and the smallest normal speed."""
    rows = []
    for depth, within in ((1e-4, 1e-10), (1e-6, 1e-9), (1e-8, 1e-7)):
        _, map_, _ = tangent_map(thrown(depth), 2.0)
        step = 1e-6
        difference = (height(-0.5 + depth + step) - height(-0.5 + depth - step)) / (2 * step)
        by_difference = f"{show(difference)} (finite difference, step 1e-6)"
        rows.append(Finding(f"dx(2)/dx(0), depth {depth:g}", exact(depth), float(map_[0, 0]), within, by_difference))
    spectrum = cd.lyapunov_spectrum(thrown(1e-8), duration=2.0)
    speed = math.sqrt(2 * ((-0.5 + 1e-8) + 0.5))
    rows.append(Finding("smallest normal speed, depth 1e−08", speed, float(spectrum["closest_grazing"]), 1e-12))
    return rows

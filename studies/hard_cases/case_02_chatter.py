"""Infinitely many impacts in finite time

A ball with restitution e, thrown up at speed 1 under gravity 1, bounces for the last time at t = 2/(1 − e). A program
that computes bounce after bounce never gets beyond this time, falls through the floor, or goes on with tangents that
every bounce has multiplied: its exponents then grow with the number of bounces, although their sum obeys the sum rule
to the last digit. (The rule is necessary, not sufficient.) This package completes the chatter with its limit time and
limit state. The ball then rests until the force changes its sign, on a moving table where sin(ωt) = 1/Γ. A held contact
reduces the rank.
"""

import math

import numpy as np
import sympy
from tools import Finding, event_names, listed, scipy_ball

import chaosdrill as cd

X, V, E = sympy.symbols("x v e", real=True)


def ball(e: float) -> "cd.HybridSystem":
    """A ball on a floor at height 0 that holds it when the bounces end."""
    landing = {"guard": X, "direction": -1}
    return cd.HybridSystem(
        name="ball",
        states=(X, V),
        parameters={"e": e},
        modes={"flight": {X: V, V: -1}, "contact": {X: 0, V: 0}},
        transitions=[
            cd.Transition("impact", "flight", "flight", reset={V: -E * V}, **landing),
            cd.Transition("rest", "flight", "contact", reset={X: 0, V: 0}, completes="impact", **landing),
        ],
        initial={"mode": "flight", X: 0.0, V: 1.0},
    )


def one_by_one(e: float, bounces: int) -> tuple[float, float]:
    """Return both exponents after a number of bounces with saltation: growth of a length, and of an area less that."""
    tangent, length, area, speed, time = np.array([1.0, 0.0]), 0.0, 0.0, 1.0, 0.0
    for _ in range(bounces):
        flight = np.array([[1.0, 2 * speed], [0.0, 1.0]])
        hit = np.array([[-e, 0.0], [-(1 + e) / speed, -e]])
        tangent = hit @ (flight @ tangent)
        length += math.log(math.hypot(*tangent))
        area += math.log(np.linalg.det(hit))
        tangent /= math.hypot(*tangent)
        time += 2 * speed
        speed *= e
    return length / time, (area - length) / time


def findings() -> list[Finding]:
    """The end of the bounces, the rest after it, and lift-off from a moving table."""
    times, _ = scipy_ball(0.5, 1000)
    left_alone = "; ".join(f"{listed(one_by_one(0.5, n))} after {n} bounces" for n in (100, 1000)) + " (one by one)"
    rows = []
    for e in (0.5, 0.9, 0.99):
        run = cd.trajectory(ball(e), duration=2 / (1 - e) + 1, samples=10)
        rest = np.array(event_names(run)) == "rest"
        elsewhere = f"none: falls through after bounce {len(times)} (scipy's DOP853)" if e == 0.5 else ""
        rows.append(
            Finding(
                f"end of the bounces, e = {e}", 2 / (1 - e), float(run["event_time"].values[rest][0]), 1e-9, elsewhere
            )
        )
    spectrum = cd.lyapunov_spectrum(ball(0.5), duration=10.0)
    for i, value in enumerate(spectrum["lyapunov_exponent"].values):
        rows.append(
            Finding(f"λ{i + 1} over the bounces and the rest", -math.inf, float(value), 0.0, "" if i else left_alone)
        )
    for gamma in (1.05, 1.6):
        table = cd.build("bouncing-ball", {"amplitude": gamma, "e": 0.1}, initial={"x": gamma + 1.0, "v": 0.0})
        run = cd.trajectory(table, periods=12, samples=4)
        left = run["event_time"].values[np.array(event_names(run)) == "lift-off"]
        off = float(np.abs(np.sin(left) - 1 / gamma).max())
        rows.append(Finding(f"lift-off, Γ = {gamma}: largest error of sin(ωt) of {left.size}", 0.0, off, 1e-12))
        spectrum = cd.lyapunov_spectrum(table, periods=100, transient=10)
        minus = int(np.isneginf(spectrum["lyapunov_exponent"].values).sum())
        rows.append(Finding("its exponents −∞, of two", 2.0, float(minus)))
    return rows

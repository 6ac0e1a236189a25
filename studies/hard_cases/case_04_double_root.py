"""Two crossings inside one step

The parabola x'' = −2 from −1 + 10⁻⁶ with speed 2 is above zero only between 0.999 and 1.001. A solver that compares the
signs at the ends of a step finds no crossing at any tolerance: each step is exact for a parabola, so that the step
never shrinks. The polynomial of the guard itself must be searched, with its extrema.
"""

import math

import sympy
from scipy.integrate import solve_ivp
from tools import Finding, event_names

import chaosdrill as cd

X, V = sympy.symbols("x v", real=True)
METHODS = ("RK45", "DOP853", "LSODA", "Radau")


def parabola(gap: float, direction: int = 0) -> "cd.HybridSystem":
    """A parabola that reaches ``gap`` above zero at time 1, and what sees it cross."""
    return cd.HybridSystem(
        name="parabola",
        states=(X, V),
        parameters={},
        modes={"flight": {X: V, V: -2}},
        transitions=[cd.Transition("cross", "flight", "flight", guard=X, direction=direction)],
        initial={"mode": "flight", X: -1 + gap, V: 2.0},
    )


def missed(gap: float) -> dict[str, int]:
    """Return how many of the two crossings each method of scipy finds at its best tolerance."""
    found = {}
    for method in METHODS:
        solution = solve_ivp(
            lambda t, s: [s[1], -2.0],
            (0.0, 2.0),
            [-1 + gap, 2.0],
            method=method,
            rtol=1e-12,
            atol=1e-14,
            events=lambda t, s: s[0],
        )
        found[method] = len(solution.t_events[0])
    return found


def findings() -> list[Finding]:
    """How many crossings are found, and when."""
    rows = []
    for gap in (1e-6, 1e-10):
        run = cd.trajectory(parabola(gap), duration=2.0, samples=2)
        kept = (-1 + gap) + 1
        counts = ", ".join(f"{method} {count}" for method, count in missed(gap).items())
        rows.append(Finding(f"crossings, gap {gap:g}", 2.0, float(len(event_names(run))), 0.0, f"{counts} (scipy)"))
        first, second = 1 - math.sqrt(kept), 1 + math.sqrt(kept)
        times = run["event_time"].values
        slack = 1e-15 / math.sqrt(gap)
        rows.append(Finding(f"first crossing, gap {gap:g}", first, float(times[0]), slack))
        rows.append(Finding(f"second crossing, gap {gap:g}", second, float(times[1]), slack))
    below = cd.trajectory(parabola(-1e-10), duration=2.0, samples=2)
    return [*rows, Finding("crossings, gap −1e-10", 0.0, float(below.sizes["event"]))]

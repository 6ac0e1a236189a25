"""Runaway

Kinetic friction below the static load cannot hold a bit that is fast enough, which then accelerates for ever. A program
that only integrates prints a progression rate that grows with the length of the run. Here such a run has an outcome of
its own, and its averages are missing instead of large.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from tools import Finding, show

import chaosdrill as cd

XI, MU, G, A, B, ETA = 0.06, 0.6, 3.0, 0.25, 0.7, 0.448


def rate(periods: int) -> float:
    """Return the mean speed of the rock over this number of periods, from a bit at full speed, without any bound."""

    def field(t: float, s: np.ndarray) -> list[float]:
        y, u, w, _ = s
        force = y + 2 * XI * (u - w)
        return [u - w, B - A * math.sin(ETA * t) - force, force - MU - (1 - MU) * math.exp(-G * w), w]

    end = periods * 2 * math.pi / ETA
    solution = solve_ivp(field, (0, end), [0.6, 2.0, 2.0, 0.0], method="DOP853", rtol=1e-9, atol=1e-9)
    return float(solution.y[3, -1] / end)


def findings() -> list[Finding]:
    """What the drill says of a run that escapes, and of its neighbours that do not."""
    fast = cd.drill(eta=ETA, initial={"y": -1.0, "u": 2.0, "mode": "stick"})
    spectrum = cd.lyapunov_spectrum(fast, periods=500, transient=100)
    diagram = cd.bifurcation_diagram(cd.drill(), {"eta": np.array([0.448, 0.48, 0.49, 0.6])}, transient=300, periods=32)
    escaped = (diagram["outcome"].values[:, 0] == cd.Outcome.ESCAPED).astype(int)
    numbers = np.isfinite(diagram["progression_rate"].values[:, 0]).astype(int)
    return [
        Finding(
            "progression rate of a runaway, eta 0.448",
            "escaped, no number",
            f"{cd.Outcome(int(spectrum['outcome'])).name.lower()}, "
            + ("no number" if np.isnan(spectrum["progression_rate"]) else show(float(spectrum["progression_rate"]))),
            0.0,
            f"{show(rate(50), 3)} after 50 periods, {show(rate(500), 3)} after 500 (scipy's DOP853)",
        ),
        Finding("escaped from rest at eta 0.448, 0.48, 0.49, 0.6", "0 1 1 0", " ".join(map(str, escaped))),
        Finding("progression rate given", "1 0 0 1", " ".join(map(str, numbers))),
    ]

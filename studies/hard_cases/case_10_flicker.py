"""Chattering at the friction threshold

The spring force equals the friction limit exactly (b = 1, a = 0, y + 2 xi u = 1). The values alone permit sticking and
slipping, and a program that goes by signs switches between them at one instant for ever. The friction demand and its
derivatives decide: if the demand rises, the rock slips at once; if it falls, the rock sticks; if all derivatives are
zero, the drill is at rest, and nothing happens.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from tools import Finding, event_names

import chaosdrill as cd

XI = 0.0625
MOST = 1000


def drill(u: float, mode: str) -> "cd.HybridSystem":
    """The drill without load, friction constant and exactly met by the spring; numbers that are exact in binary."""
    start = {"y": 1 - 2 * XI * u, "u": u, "mode": mode}
    return cd.drill(drive="none", contact="none", b=1.0, mu=1.0, xi=XI, initial=start)


def flicker() -> tuple[int, float]:
    """Return events and time reached by scipy's terminal events at the drill's rest on the threshold."""

    def demand(t: float, s: np.ndarray) -> float:
        return s[0] + 2 * XI * s[1] - 1

    def speed(t: float, s: np.ndarray) -> float:
        return s[2]

    demand.terminal = speed.terminal = True
    demand.direction, speed.direction = +1, -1
    time, state, slips, events = 0.0, np.array([1.0, 0.0, 0.0]), False, 0
    while time < 50 and events < MOST:

        def field(t: float, s: np.ndarray, slips: bool = slips) -> list[float]:
            force = s[0] + 2 * XI * (s[1] - s[2])
            return [s[1] - s[2], 1 - force, force - 1 if slips else 0.0]

        leg = solve_ivp(
            field, (time, 50.0), state, method="DOP853", rtol=1e-12, atol=1e-12, events=speed if slips else demand
        )
        time, state = float(leg.t[-1]), leg.y[:, -1]
        if leg.status == 1:
            slips, events = not slips, events + 1
    return events, time


def findings() -> list[Finding]:
    """Which way the drill goes from the threshold, and the exponents there."""
    events, time = flicker()
    release = math.pi / math.sqrt(1 - XI**2)
    rows = []
    for u, mode, names, times in (
        (0.0, "stick", [], []),
        (0.25, "stick", ["release"], [0.0]),
        (0.25, "slip", [], []),
        (-0.25, "stick", ["release"], [release]),
        (-0.25, "slip", ["stick", "release"], [0.0, release]),
        (2.0**-20, "stick", ["release"], [0.0]),
        (-(2.0**-20), "slip", ["stick", "release"], [0.0, release]),
    ):
        run = cd.trajectory(drill(u, mode), duration=50.0, samples=2)
        found = event_names(run)
        elsewhere = f"{events} events without leaving t = {time:g} (scipy's DOP853)" if u == 0 else ""
        rows.append(
            Finding(
                f"events, u = {u:.3g}, from {mode}",
                " ".join(names) or "none",
                " ".join(found) or "none",
                0.0,
                elsewhere,
            )
        )
        if found == names and times:
            rows.append(Finding("time of the last", times[-1], float(run["event_time"].values[-1]), 1e-9))
    known = 0
    for mode in ("stick", "slip"):
        for u in (0.0, 0.25, -0.25):
            spectrum = cd.lyapunov_spectrum(drill(u, mode), duration=200.0, transient=100)
            known += int(np.isnan(spectrum["lyapunov_exponent"].values).sum())
    return [*rows, Finding("exponents that are NaN, six starts", 0.0, float(known))]

"""Falling through after a reset

A ball with restitution 0.5 bounces ever faster. A solver that restarts from an event one rounding error below the floor
finds no further crossing: after some fifty bounces the ball falls through the floor, without a warning. A dead time
after each event only moves the problem. This package puts the state onto the guard; the sign of the guard's derivative
after the event says from which side the next crossing comes.
"""

import numpy as np
import sympy
from tools import Finding, scipy_ball, show

import chaosdrill as cd

X, V = sympy.symbols("x v", real=True)


def ball(e: float) -> "cd.HybridSystem":
    """A ball on a floor at height 0, gravity 1, thrown up at speed 1; nothing holds it when the bounces end."""
    return cd.HybridSystem(
        name="ball",
        states=(X, V),
        parameters={"e": e},
        modes={"flight": {X: V, V: -1}},
        transitions=[
            cd.Transition("impact", "flight", "flight", guard=X, direction=-1, reset={V: -sympy.Symbol("e") * V})
        ],
        initial={"mode": "flight", X: 0.0, V: 1.0},
    )


def findings() -> list[Finding]:
    """The lowest point, the times of bounces, and a ball that bounces a thousand times."""
    times, lowest = scipy_ball(0.5, 1000)
    run = cd.trajectory(ball(0.5), duration=5.0, samples=1000)
    found = run["event_time"].values[:30]
    slow = cd.trajectory(ball(0.999), duration=1260.0, samples=10)
    speeds = -slow["event_speed"].values
    return [
        Finding(
            "lowest point until t = 5, e = 0.5",
            0.0,
            float(np.nanmin(run["states"].values[:, 0])),
            0.0,
            f"{show(lowest, 3)} at t = 5 (scipy's DOP853: falls after {len(times)} bounces)",
        ),
        Finding("time of bounce 30", 4 * (1 - 0.5**30), float(found[29]), 1e-14),
        Finding("speed at bounce 900, e = 0.999", 0.999**899, float(speeds[899]), 1e-11),
    ]

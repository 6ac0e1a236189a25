"""No event location

On a period-1 orbit of the impact oscillator every impact has the same speed. A program that resets the state at the
first step beyond the wall meets the wall at another depth each time, and shows hundreds of impact speeds at any step
size. A smaller step only narrows their scatter.
"""

import math

import numpy as np
from tools import Finding

import chaosdrill as cd

OMEGA, E, HITS = 2.6, 0.8, 400
STEPS = (1e-2, 1e-3)


def without_location(step: float, time: float, speed: float) -> np.ndarray:
    """Return impact speeds if the reset acts at the end of the step in which the wall is passed.

    It starts on the orbit, after the impact at ``time`` with ``speed``. The flow between impacts is exact (the
    oscillator is linear), so that the late reset is the only error.
    """
    c, s = math.cos(step), math.sin(step)
    gain = 1 / (1 - OMEGA**2)
    x, v, speeds, k = 0.0, -E * speed, [], 0
    phase = OMEGA * time
    now, now_v = gain * math.cos(phase), -gain * OMEGA * math.sin(phase)
    while len(speeds) < HITS:
        k += 1
        phase = OMEGA * (time + k * step)
        then, then_v = gain * math.cos(phase), -gain * OMEGA * math.sin(phase)
        p, q = x - now, v - now_v
        x, v = c * p + s * q + then, c * q - s * p + then_v
        now, now_v = then, then_v
        if x >= 0 and v > 0:
            speeds.append(v)
            x, v = 0.0, -E * v
    return np.array(speeds)


def speed() -> float:
    """Return the impact speed of the period-1 orbit in closed form."""
    period = 2 * math.pi / OMEGA
    turn = (1 + E) / math.tan(period / 2) / 2
    return 1 / abs(1 - OMEGA**2) / math.hypot(turn, (1 - E) / (2 * OMEGA))


def _different(speeds: np.ndarray) -> int:
    return len(np.unique(np.round(speeds, 8)))


def findings() -> list[Finding]:
    """The impact speed, and how many different ones 400 impacts show."""
    system = cd.build("impact-oscillator", {"wall": 0.0, "zeta": 0.0, "omega": OMEGA, "e": E})
    run = cd.trajectory(system, periods=HITS, transient=2000, samples=2)
    speeds = run["event_speed"].values
    fuzz = {step: without_location(step, float(run["event_time"].values[-1]), speeds[-1]) for step in STEPS}
    counts = ", ".join(f"{_different(v)} at a step of {step:g}" for step, v in fuzz.items())
    spreads = ", ".join(f"{np.ptp(v):.0e}" for v in fuzz.values())
    return [
        Finding("different speeds of 400 impacts", 1.0, float(_different(speeds)), 0.0, counts),
        Finding("impact speed", speed(), float(speeds.mean()), 1e-12),
        Finding("spread of the speeds", 0.0, float(np.ptp(speeds)), 1e-11, spreads),
    ]

"""Rank loss

An event that removes a direction (a stick, a plastic hit) makes an exponent minus infinity. A factorisation that
divides by the lost pivot returns NaN throughout; one that bounds the pivot from below prints a number that follows from
the bound alone. The number of such exponents follows from the rank of the product of all maps, not from the number of
sticks: a direction that is lost a thousand times counts once, two directions that are lost in two steps count twice.
"""

import math
import warnings

import numpy as np
import sympy
from tools import Finding, listed

import chaosdrill as cd

X, Y, Z, S = sympy.symbols("x y z s", real=True)
ANGLE = 0.7


def every_unit(states: tuple, reset: dict) -> "cd.HybridSystem":
    """A map that is applied once a unit of time, with a clock beside it (whose exponent is 0)."""
    return cd.HybridSystem(
        name="map",
        states=(*states, S),
        parameters={},
        modes={"hold": {**dict.fromkeys(states, 0), S: 1}},
        transitions=[cd.Transition("map", "hold", "hold", guard=S - 1, direction=+1, reset={**reset, S: 0})],
        initial={"mode": "hold", S: 0.5},
    )


def textbook(floor: float, count: int = 200) -> np.ndarray:
    """Return the exponents of diag(1, 0) and a rotation by the QR of textbooks, no pivot smaller than ``floor``."""
    turn = np.array([[math.cos(ANGLE), -math.sin(ANGLE)], [math.sin(ANGLE), math.cos(ANGLE)]])
    frame, logs = turn.copy(), np.zeros(2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        for _ in range(count):
            image = turn @ np.diag([1.0, 0.0]) @ frame
            for i in range(2):
                for j in range(i):
                    image[:, i] -= (frame[:, j] @ image[:, i]) * frame[:, j]
                length = max(np.sqrt(image[:, i] @ image[:, i]), floor)
                logs[i] += np.log(length)
                frame[:, i] = image[:, i] / length
    return logs / count


def findings() -> list[Finding]:
    """Exponents of three maps, and of the drill."""
    c, s = math.cos(ANGLE), math.sin(ANGLE)
    maps = {
        "projection and rotation by 0.7": ((X, Y), {X: c * X, Y: s * X}, [0.0, math.log(c), -math.inf]),
        "one direction lost again and again": (
            (X, Y, Z),
            {X: X / 2, Y: Y / 3, Z: 0},
            [0.0, -math.log(2), -math.log(3), -math.inf],
        ),
        "rank 2 a step, rank 1 in two steps": (
            (X, Y, Z),
            {X: X / 2, Y: Z, Z: 0},
            [0.0, -math.log(2), -math.inf, -math.inf],
        ),
    }
    others = {
        "projection and rotation by 0.7": f"{listed(textbook(0.0))} as it is; "
        f"{listed(textbook(1e-17))} with 1e-17 for a lost pivot (textbook QR)"
    }
    rows = []
    for name, (states, reset, right) in maps.items():
        found = cd.lyapunov_spectrum(every_unit(states, reset), duration=1000, transient=10)
        for i, (value, ours) in enumerate(zip(right, found["lyapunov_exponent"].values, strict=True)):
            if i:  # the first is the clock's
                rows.append(Finding(f"{name}: λ{i}", value, float(ours), 1e-10, others.pop(name, "")))
    spectrum = cd.lyapunov_spectrum(cd.drill(eta=0.448), periods=2000, transient=100)
    minus = float(np.isneginf(spectrum["lyapunov_exponent"].values).sum())
    rows.append(Finding("drill, 2000 periods with a stick in each: exponents −∞", 1.0, minus))
    return rows

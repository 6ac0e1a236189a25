"""Lorenz's ring of weather stations, 40 of them.

    x_k' = (x_(k+1) - x_(k-2)) x_(k-1) - x_k + F

At F = 8 the exponents sum to -40, the largest is 1.68, and the Kaplan-Yorke dimension is 27.1. Source: Lorenz
and Emanuel 1998, doi:10.1175/1520-0469(1998)055<0399:OSFSWO>2.0.CO;2.
"""

from math import sin

NAME = "lorenz-96"
SUMMARY = "Lorenz's ring of 40 weather stations"
GROUP = "smooth flows"
N = 40
STATES = {f"x{k}": f"station {k}" for k in range(N)}
PARAMETERS = {"F": (8.0, "forcing")}
x = tuple(STATES)
EQUATIONS = {
    "modes": {"flow": {x[k]: f"({x[(k + 1) % N]} - {x[k - 2]})*{x[k - 1]} - {x[k]} + F" for k in range(N)}},
    "initial": {"mode": "flow", **{x[k]: 8.0 + 0.1 * sin(k) for k in range(N)}},
}
"""The ring with default parameters; chaotic."""

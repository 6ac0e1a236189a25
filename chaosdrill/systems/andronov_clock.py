"""Andronov's clock: a damped balance that receives the same energy from its escapement in every period.

    x'' = -x - 2 h x';   at x = 0 upward: x' := sqrt(x'^2 + p^2)

The cycle has the period T = 2 pi/sqrt(1 - h^2), the speed p/sqrt(1 - exp(-2 h T)) after the kick, and the multipliers
1 and exp(-2 h T). Source: Andronov, Vitt and Khaikin 1966, Theory of Oscillators.
"""

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE

NAME = "andronov-clock"
SUMMARY = "clock with an escapement"
GROUP = "machines"
STATES = {"x": "angle of the balance", "v": "angular velocity"}
PARAMETERS = {
    "h": (0.1, "damping ratio"),
    "p": (1.0, "speed that a kick gives from rest"),
}
LIMITS = {"h": NOT_NEGATIVE, "p": NOT_NEGATIVE}
EQUATIONS = {
    "modes": {"free": {"x": "v", "v": "-x - 2*h*v"}},
    "transitions": [event("kick", "free", "free", guard="x", direction=+1, reset={"v": "sqrt(v**2 + p**2)"})],
    "initial": {"mode": "free", "x": -1.0, "v": 0.0},
}
"""The clock with default parameters, wound up a little."""

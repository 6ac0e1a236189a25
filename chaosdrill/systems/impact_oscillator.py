"""Forced linear oscillator with a wall on one side.

    x'' = -x - 2 zeta x' + amplitude cos(omega t),  x <= wall;   at the wall: x' := -e x'

The fruit fly of impacting systems: period doubling, grazing and chaos. Source: Shaw and Holmes 1983,
doi:10.1016/0022-460X(83)90407-8; grazing: Nordmark 1991, doi:10.1016/0022-460X(91)90592-8.
"""

from chaosdrill.declared import event
from chaosdrill.limits import POSITIVE, RESTITUTION

NAME = "impact-oscillator"
SUMMARY = "forced oscillator that hits a wall"
GROUP = "impacts"
CITES = ("shaw1983",)
STATES = {"x": "displacement", "v": "velocity"}
PARAMETERS = {
    "wall": (0.3, "position of the wall"),
    "zeta": (0.05, "damping ratio"),
    "amplitude": (1.0, "amplitude of the force over the stiffness"),
    "omega": (2.5, "forcing frequency over natural frequency"),
    "e": (0.8, "coefficient of restitution"),
}
LIMITS = {"omega": POSITIVE, "e": RESTITUTION}
BODIES = {"mass": "x", "wall": "wall"}
EQUATIONS = {
    "time": "t",
    "modes": {"free": {"x": "v", "v": "-x - 2*zeta*v + amplitude*cos(omega*t)"}},
    "transitions": [event("impact", "free", "free", guard="x - wall", direction=+1, reset={"v": "-e*v"})],
    "period": "2*pi/omega",
    "initial": {"mode": "free", "x": 0.0, "v": 0.3},
}
"""The impact oscillator with default parameters; chaotic, exponents about 0.091 and -0.319."""

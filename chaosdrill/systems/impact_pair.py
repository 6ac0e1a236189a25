"""Ball between the walls of a box that is shaken.

    x'' = amplitude cos(omega t),  -gap/2 <= x <= gap/2;   at a wall: x' := -e x'

The motion with one hit on each wall a period is known in closed form. Source: Bapat, Popplewell and McLachlan 1983,
Journal of Sound and Vibration 87, 19-40.
"""

from chaosdrill.declared import event
from chaosdrill.limits import POSITIVE, RESTITUTION

NAME = "impact-pair"
SUMMARY = "ball between the walls of a shaken box"
GROUP = "impacts"
STATES = {"x": "displacement in the box", "v": "velocity in the box"}
PARAMETERS = {
    "gap": (1.0, "clearance"),
    "amplitude": (1.0, "acceleration of the box"),
    "omega": (1.0, "frequency of the box"),
    "e": (0.6, "coefficient of restitution"),
}
LIMITS = {"gap": POSITIVE, "omega": POSITIVE, "e": RESTITUTION}
BODIES = {"ball": "x", "right wall": "gap/2", "left wall": "-gap/2"}
EQUATIONS = {
    "time": "t",
    "modes": {"free": {"x": "v", "v": "amplitude*cos(omega*t)"}},
    "transitions": [
        event("right", "free", "free", guard="x - gap/2", direction=+1, reset={"v": "-e*v"}, kind="impact"),
        event("left", "free", "free", guard="x + gap/2", direction=-1, reset={"v": "-e*v"}, kind="impact"),
    ],
    "period": "2*pi/omega",
    "initial": {"mode": "free", "x": 0.0, "v": 0.5},
}

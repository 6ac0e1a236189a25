"""Ball on a floor that is at rest (amplitude 0) or moves sinusoidally.

    x'' = -gravity,  x >= amplitude sin(omega t);   at the floor, with its speed V = amplitude omega cos(omega t):
    v := V - e (v - V)

The rebound law is exact: the floor's own motion is kept, not replaced by the high-bounce approximation. A ball that
bounces with e < 1 ever lower makes infinitely many impacts in finite time; then it rests on the floor, in the mode
``contact``, until the floor falls away faster than the ball can follow: lift-off at x'' = -gravity, where
amplitude omega^2 sin(omega t) = gravity. Source: Luck and Mehta 1993, doi:10.1103/PhysRevE.48.3988.
"""

from math import pi

from chaosdrill.declared import event
from chaosdrill.limits import POSITIVE, RESTITUTION

NAME = "bouncing-ball"
SUMMARY = "ball on a fixed or sinusoidally moving floor"
GROUP = "impacts"
CITES = ("luck1993",)
STATES = {"x": "height", "v": "velocity"}
PARAMETERS = {
    "gravity": (1.0, "acceleration of gravity"),
    "amplitude": (0.9, "amplitude of the floor's motion"),
    "omega": (1.0, "frequency of the floor's motion"),
    "e": (0.8, "coefficient of restitution"),
}
LIMITS = {"gravity": POSITIVE, "omega": POSITIVE, "e": RESTITUTION}
BODIES = {"ball": "x", "floor": "amplitude*sin(omega*t)"}
floor, speed = "amplitude*sin(omega*t)", "amplitude*omega*cos(omega*t)"
acceleration = "-amplitude*omega**2*sin(omega*t)"
landing = {"guard": f"x - {floor}", "direction": -1}
# round-off along the contact must not leave the ball below the floor when it lets go
on_floor = {"reset": {"x": floor, "v": speed}}
EQUATIONS = {
    "time": "t",
    "modes": {"flight": {"x": "v", "v": "-gravity"}, "contact": {"x": speed, "v": acceleration}},
    "transitions": [
        event("impact", "flight", "flight", reset={"v": f"{speed} - e*(v - {speed})"}, **landing),
        event("rest", "flight", "contact", completes="impact", **on_floor, **landing),
        event("lift-off", "contact", "flight", f"{acceleration} + gravity", direction=-1, **on_floor),
    ],
    "period": "2*pi/omega",
    "initial": {"mode": "flight", "x": 1.0, "v": pi},
}
"""The bouncing ball with default parameters: one stable bounce per period of the floor."""

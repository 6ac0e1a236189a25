"""Ball on a floor that is at rest (amplitude 0) or moves sinusoidally.

    x'' = -gravity,  x >= amplitude sin(omega t);   at the floor, with its speed V = amplitude omega cos(omega t):
    v := V - e (v - V)

The rebound law is exact: the floor's own motion is kept, not replaced by the high-bounce approximation. A ball that
bounces with e < 1 ever lower makes infinitely many impacts in finite time; then it rests on the floor, in the mode
``contact``, until the floor falls away faster than the ball can follow: lift-off at x'' = -gravity, where
amplitude omega^2 sin(omega t) = gravity. Source: Luck and Mehta 1993, doi:10.1103/PhysRevE.48.3988.
"""

from math import pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "bouncing-ball"
SUMMARY = "ball on a fixed or sinusoidally moving floor"
GROUP = "impacts"
CITES = ("luck1993",)
STATES = ("x", "v")
PARAMETERS = {"gravity": 1.0, "amplitude": 0.9, "omega": 1.0, "e": 0.8}
LABELS = {
    "x": "height",
    "v": "velocity",
    "gravity": "acceleration of gravity",
    "amplitude": "amplitude of the floor's motion",
    "omega": "frequency of the floor's motion",
    "e": "coefficient of restitution",
}


def system() -> "HybridSystem":
    """The bouncing ball with default parameters: one stable bounce per period of the floor."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    x, v, t, gravity, amplitude, omega, e = sympy.symbols("x v t gravity amplitude omega e", real=True)
    floor = amplitude * sympy.sin(omega * t)
    speed, acceleration = sympy.diff(floor, t), sympy.diff(floor, t, 2)
    landing = {"guard": x - floor, "direction": -1}
    return HybridSystem(
        name=NAME,
        states=(x, v),
        time=t,
        parameters=PARAMETERS,
        modes={"flight": {x: v, v: -gravity}, "contact": {x: speed, v: acceleration}},
        transitions=[
            Transition("impact", "flight", "flight", reset={v: speed - e * (v - speed)}, **landing),
            Transition("rest", "flight", "contact", reset={x: floor, v: speed}, completes="impact", **landing),
            # round-off along the contact must not leave the ball below the floor when it lets go
            Transition(
                "lift-off", "contact", "flight", guard=acceleration + gravity, direction=-1, reset={x: floor, v: speed}
            ),
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "flight", x: 1.0, v: pi},
        description=SUMMARY,
        labels=LABELS,
    )

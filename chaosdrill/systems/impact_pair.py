"""Ball between the walls of a box that is shaken.

    x'' = amplitude cos(omega t),  -gap/2 <= x <= gap/2;   at a wall: x' := -e x'

The motion with one hit on each wall a period is known in closed form. Source: Bapat, Popplewell and McLachlan 1983,
Journal of Sound and Vibration 87, 19-40.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "impact-pair"
SUMMARY = "ball between the walls of a shaken box"
GROUP = "impacts"
STATES = ("x", "v")
PARAMETERS = {"gap": 1.0, "amplitude": 1.0, "omega": 1.0, "e": 0.6}
LABELS = {
    "x": "displacement in the box",
    "v": "velocity in the box",
    "gap": "clearance",
    "amplitude": "acceleration of the box",
    "omega": "frequency of the box",
    "e": "coefficient of restitution",
}


def system() -> "HybridSystem":
    """The impact pair with default parameters."""
    from chaosdrill.model import HybridSystem, Transition

    return HybridSystem(
        name=NAME,
        states=STATES,
        time="t",
        parameters=PARAMETERS,
        modes={"free": {"x": "v", "v": "amplitude*cos(omega*t)"}},
        transitions=[
            Transition("right", "free", "free", guard="x - gap/2", direction=+1, reset={"v": "-e*v"}, kind="impact"),
            Transition("left", "free", "free", guard="x + gap/2", direction=-1, reset={"v": "-e*v"}, kind="impact"),
        ],
        period="2*pi/omega",
        initial={"mode": "free", "x": 0.0, "v": 0.5},
        description=SUMMARY,
        labels=LABELS,
    )

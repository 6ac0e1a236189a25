"""Idler gear that rattles in the backlash of an unevenly rotating gear.

    s'' = -beta s' - drag + amplitude cos(omega t),  0 <= s <= backlash;   at a flank: s' := -e s'

The exponents sum to -beta and 2 ln e for each hit, over the time between hits. Source: Karagiannis and Pfeiffer 1991,
doi:10.1007/BF00045670.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "gear-rattle"
SUMMARY = "idler gear that rattles in its backlash"
GROUP = "machines"
STATES = ("s", "v")
PARAMETERS = {"backlash": 1.0, "beta": 0.1, "drag": 0.1, "amplitude": 1.0, "omega": 1.0, "e": 0.9}
LABELS = {
    "s": "distance from the driving flank",
    "v": "relative velocity",
    "backlash": "clearance between the flanks",
    "beta": "oil drag over inertia",
    "drag": "torque of drag over inertia",
    "amplitude": "acceleration of the driving gear",
    "omega": "frequency of its unevenness",
    "e": "coefficient of restitution",
}


def system() -> "HybridSystem":
    """The rattling gear with default parameters."""
    from chaosdrill.model import HybridSystem, Transition

    return HybridSystem(
        name=NAME,
        states=STATES,
        time="t",
        parameters=PARAMETERS,
        modes={"free": {"s": "v", "v": "-beta*v - drag + amplitude*cos(omega*t)"}},
        transitions=[
            Transition("driving", "free", "free", guard="s", direction=-1, reset={"v": "-e*v"}, kind="impact"),
            Transition("coast", "free", "free", guard="s - backlash", direction=+1, reset={"v": "-e*v"}, kind="impact"),
        ],
        period="2*pi/omega",
        initial={"mode": "free", "s": 0.5, "v": 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

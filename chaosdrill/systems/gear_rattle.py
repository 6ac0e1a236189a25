"""Idler gear that rattles in the backlash of an unevenly rotating gear.

    s'' = -beta s' - drag + amplitude cos(omega t),  0 <= s <= backlash;   at a flank: s' := -e s'

The exponents sum to -beta and 2 ln e for each hit, over the time between hits. Source: Karagiannis and Pfeiffer 1991,
doi:10.1007/BF00045670.
"""

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE, RESTITUTION

NAME = "gear-rattle"
SUMMARY = "idler gear that rattles in its backlash"
GROUP = "machines"
STATES = {"s": "distance from the driving flank", "v": "relative velocity"}
PARAMETERS = {
    "backlash": (1.0, "clearance between the flanks"),
    "beta": (0.1, "oil drag over inertia"),
    "drag": (0.1, "torque of drag over inertia"),
    "amplitude": (1.0, "acceleration of the driving gear"),
    "omega": (1.0, "frequency of the unevenness"),
    "e": (0.9, "coefficient of restitution"),
}
LIMITS = {"backlash": POSITIVE, "beta": NOT_NEGATIVE, "omega": POSITIVE, "e": RESTITUTION}
BODIES = {"idler gear": "s", "driving flank": "0", "coast flank": "backlash"}
EQUATIONS = {
    "time": "t",
    "modes": {"free": {"s": "v", "v": "-beta*v - drag + amplitude*cos(omega*t)"}},
    "transitions": [
        event("driving", "free", "free", guard="s", direction=-1, reset={"v": "-e*v"}, kind="impact"),
        event("coast", "free", "free", guard="s - backlash", direction=+1, reset={"v": "-e*v"}, kind="impact"),
    ],
    "period": "2*pi/omega",
    "initial": {"mode": "free", "s": 0.5, "v": 0.0},
}

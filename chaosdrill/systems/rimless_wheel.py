"""Spoked wheel without a rim that rolls down a slope, an inverted pendulum from spoke to spoke.

    th'' = sin th;   at th = gamma + alpha: th := gamma - alpha, om := cos(2 alpha) om, and the mirror image uphill

Half the angle between spokes is alpha, the slope gamma; lengths and gravity are 1. The rolling gait has the multipliers
1 and cos^2(2 alpha) exactly. Source: McGeer 1990, doi:10.1177/027836499000900206.
"""

from chaosdrill.declared import Event, event
from chaosdrill.limits import POSITIVE

NAME = "rimless-wheel"
SUMMARY = "spoked wheel that rolls down a slope"
GROUP = "walkers"
CITES = ("mcgeer1990",)
STATES = {"th": "angle of the stance spoke from the vertical", "om": "angular velocity"}
PARAMETERS = {
    "alpha": (0.3, "half the angle between spokes"),
    "gamma": (0.15, "slope"),
}
LIMITS = {"alpha": POSITIVE}


def step(name: str, sign: str, direction: int) -> Event:
    """Onto the next spoke, downhill or back."""
    reset = {"th": f"gamma - {sign}alpha", "om": "cos(2*alpha)*om"}
    guard = f"th - gamma - {sign}alpha"
    return event(name, "stance", "stance", guard, direction, reset=reset, kind="impact")


EQUATIONS = {
    "modes": {"stance": {"th": "om", "om": "sin(th)"}},
    "transitions": [step("step", "+", +1), step("step-back", "-", -1)],
    "initial": {"mode": "stance", "th": 0.0, "om": 0.5},
}
"""The rimless wheel with default parameters, started on its rolling gait's side."""

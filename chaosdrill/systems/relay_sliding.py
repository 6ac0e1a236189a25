"""Disturbed mass under relay control, which ends in sliding motion.

    x'' = -U + d cos(omega t)   where s = x + tau x' > 0,   +U + d cos(omega t)   where s < 0
    s = 0, x' = -x/tau          while abs(d cos(omega t) - x/tau^2) <= U (Filippov)

Where it slides it forgets the disturbance: x decays like exp(-t/tau), and one exponent is -inf. Source: Utkin 1977,
doi:10.1109/TAC.1977.1101446; di Bernardo, Johansson and Vasca 2001, doi:10.1142/S0218127401002584.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "relay-sliding"
SUMMARY = "mass under relay control, with sliding"
GROUP = "friction and sliding"
STATES = ("x", "s")
PARAMETERS = {"U": 1.0, "tau": 1.0, "d": 0.5, "omega": 2.0}
LABELS = {
    "x": "displacement",
    "s": "distance from the switching surface",
    "U": "force of the relay over the mass",
    "tau": "time constant of sliding",
    "d": "disturbance over the mass",
    "omega": "frequency of the disturbance",
}


def system() -> "HybridSystem":
    """The relay with default parameters, started above the surface."""
    from chaosdrill.model import HybridSystem, Transition

    force, speed = "d*cos(omega*t)", "(s - x)/tau"
    needed = f"{force} - x/tau**2"
    down: dict[str, Any] = {"guard": "s", "direction": -1, "kind": "surface"}
    up: dict[str, Any] = {"guard": "s", "direction": +1, "kind": "surface"}
    return HybridSystem(
        name=NAME,
        states=STATES,
        time="t",
        parameters=PARAMETERS,
        modes={
            "above": {"x": speed, "s": f"{speed} + tau*(-U + {force})"},
            "below": {"x": speed, "s": f"{speed} + tau*(U + {force})"},
            "sliding": {"x": speed, "s": "0"},
        },
        transitions=[
            Transition("slide-down", "above", "sliding", reset={"s": "0"}, condition=f"{needed} >= -U", **down),
            Transition("cross-down", "above", "below", **down),
            Transition("slide-up", "below", "sliding", reset={"s": "0"}, condition=f"{needed} <= U", **up),
            Transition("cross-up", "below", "above", **up),
            Transition("leave-up", "sliding", "above", guard=f"{needed} - U", direction=+1, kind="leave"),
            Transition("leave-down", "sliding", "below", guard=f"{needed} + U", direction=-1, kind="leave"),
        ],
        period="2*pi/omega",
        initial={"mode": "above", "x": 2.0, "s": 2.0},
        description=SUMMARY,
        labels=LABELS,
    )

"""Leaky integrate-and-fire neuron.

    tau v' = -v + drive;   at v = threshold: v := 0

It spikes every tau ln(drive/(drive - threshold)). Source: Abbott 1999, doi:10.1016/S0361-9230(99)00161-6.
"""

from typing import Any

from chaosdrill.limits import POSITIVE

NAME = "integrate-and-fire"
SUMMARY = "leaky integrate-and-fire neuron"
GROUP = "neurons"
STATES = {"v": "membrane potential above rest"}
PARAMETERS = {
    "tau": (1.0, "time constant of the membrane"),
    "drive": (1.5, "current times resistance"),
    "threshold": (1.0, "potential at which it fires"),
}
LIMITS = {"tau": POSITIVE}


def equations() -> dict[str, Any]:
    """The neuron with default parameters: it spikes every ln 3."""
    from chaosdrill.model import Transition

    return {
        "modes": {"rest": {"v": "(drive - v)/tau"}},
        "transitions": [Transition("spike", "rest", "rest", guard="v - threshold", direction=+1, reset={"v": "0"})],
        "initial": {"mode": "rest", "v": 0.0},
    }

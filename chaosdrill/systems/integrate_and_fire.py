"""Leaky integrate-and-fire neuron.

    tau v' = -v + drive;   at v = threshold: v := 0

It spikes every tau ln(drive/(drive - threshold)). Source: Abbott 1999, doi:10.1016/S0361-9230(99)00161-6.
"""

from chaosdrill.declared import event
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
EQUATIONS = {
    "modes": {"rest": {"v": "(drive - v)/tau"}},
    "transitions": [event("spike", "rest", "rest", guard="v - threshold", direction=+1, reset={"v": "0"})],
    "initial": {"mode": "rest", "v": 0.0},
}
"""The neuron with default parameters: it spikes every ln 3."""

"""Leaky integrate-and-fire neuron.

    tau v' = -v + drive;   at v = threshold: v := 0

It spikes every tau ln(drive/(drive - threshold)). Source: Abbott 1999, doi:10.1016/S0361-9230(99)00161-6.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "integrate-and-fire"
SUMMARY = "leaky integrate-and-fire neuron"
GROUP = "neurons"
STATES = ("v",)
PARAMETERS = {"tau": 1.0, "drive": 1.5, "threshold": 1.0}
LABELS = {
    "v": "membrane potential above rest",
    "tau": "time constant of the membrane",
    "drive": "current times resistance",
    "threshold": "potential at which it fires",
}


def system() -> "HybridSystem":
    """The neuron with default parameters: it spikes every ln 3."""
    from chaosdrill.model import HybridSystem, Transition

    return HybridSystem(
        name=NAME,
        states=STATES,
        parameters=PARAMETERS,
        modes={"rest": {"v": "(drive - v)/tau"}},
        transitions=[Transition("spike", "rest", "rest", guard="v - threshold", direction=+1, reset={"v": "0"})],
        initial={"mode": "rest", "v": 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

"""Izhikevich's simple model of a spiking neuron.

    v' = 0.04 v^2 + 5 v + 140 - u + I,  u' = a (b v - u);   at v = 30: v := c, u := u + d

Times in ms, v in mV. Source: Izhikevich 2003, doi:10.1109/TNN.2003.820440.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "izhikevich"
SUMMARY = "Izhikevich's spiking neuron"
GROUP = "neurons"
STATES = ("v", "u")
PARAMETERS = {"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0, "I": 10.0}
LABELS = {
    "v": "membrane potential",
    "u": "recovery",
    "a": "rate of the recovery",
    "b": "sensitivity of the recovery",
    "c": "potential after a spike",
    "d": "step of the recovery at a spike",
    "I": "current",
}


def system() -> "HybridSystem":
    """The neuron with default parameters: regular spiking."""
    from chaosdrill.model import HybridSystem, Transition

    return HybridSystem(
        name=NAME,
        states=STATES,
        parameters=PARAMETERS,
        modes={"rest": {"v": "0.04*v**2 + 5*v + 140 - u + I", "u": "a*(b*v - u)"}},
        transitions=[Transition("spike", "rest", "rest", guard="v - 30", direction=+1, reset={"v": "c", "u": "u + d"})],
        initial={"mode": "rest", "v": -65.0, "u": -13.0},
        description=SUMMARY,
        labels=LABELS,
    )

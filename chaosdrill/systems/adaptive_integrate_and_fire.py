"""Adaptive exponential integrate-and-fire neuron.

    C V' = -g_L (V - E_L) + g_L slope exp((V - V_T)/slope) - w + I,  tau_w w' = a (V - E_L) - w
    at V = peak: V := V_r, w := w + b

Times in ms, voltages in mV, currents in pA, conductances in nS, C in pF. Source: Brette and Gerstner 2005,
doi:10.1152/jn.00686.2005.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "adaptive-integrate-and-fire"
SUMMARY = "adaptive exponential integrate-and-fire neuron"
GROUP = "neurons"
STATES = ("V", "w")
PARAMETERS = {
    "C": 281.0,
    "g_L": 30.0,
    "E_L": -70.6,
    "V_T": -50.4,
    "slope": 2.0,
    "tau_w": 144.0,
    "a": 4.0,
    "b": 80.5,
    "I": 1000.0,
    "V_r": -70.6,
    "peak": 0.0,
}
LABELS = {
    "V": "membrane potential",
    "w": "adaptation current",
    "C": "capacitance",
    "g_L": "leak conductance",
    "E_L": "leak reversal potential",
    "V_T": "threshold potential",
    "slope": "slope factor",
    "tau_w": "time constant of the adaptation",
    "a": "subthreshold adaptation",
    "b": "spike-triggered adaptation",
    "I": "current",
    "V_r": "potential after a spike",
    "peak": "potential at which a spike is cut",
}


def system() -> "HybridSystem":
    """The neuron with default parameters: it spikes with adaptation."""
    from chaosdrill.model import HybridSystem, Transition

    return HybridSystem(
        name=NAME,
        states=STATES,
        parameters=PARAMETERS,
        modes={
            "rest": {
                "V": "(-g_L*(V - E_L) + g_L*slope*exp((V - V_T)/slope) - w + I)/C",
                "w": "(a*(V - E_L) - w)/tau_w",
            }
        },
        transitions=[
            Transition("spike", "rest", "rest", guard="V - peak", direction=+1, reset={"V": "V_r", "w": "w + b"})
        ],
        initial={"mode": "rest", "V": PARAMETERS["E_L"], "w": 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

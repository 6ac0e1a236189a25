"""Adaptive exponential integrate-and-fire neuron.

    C V' = -g_L (V - E_L) + g_L slope exp((V - V_T)/slope) - w + I,  tau_w w' = a (V - E_L) - w
    at V = peak: V := V_r, w := w + b

Times in ms, voltages in mV, currents in pA, conductances in nS, C in pF. Source: Brette and Gerstner 2005,
doi:10.1152/jn.00686.2005.
"""

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE

NAME = "adaptive-integrate-and-fire"
SUMMARY = "adaptive exponential integrate-and-fire neuron"
GROUP = "neurons"
STATES = {"V": "membrane potential", "w": "adaptation current"}
PARAMETERS = {
    "C": (281.0, "capacitance"),
    "g_L": (30.0, "leak conductance"),
    "E_L": (-70.6, "leak reversal potential"),
    "V_T": (-50.4, "threshold potential"),
    "slope": (2.0, "slope factor"),
    "tau_w": (144.0, "time constant of the adaptation"),
    "a": (4.0, "subthreshold adaptation"),
    "b": (80.5, "spike-triggered adaptation"),
    "I": (1000.0, "current"),
    "V_r": (-70.6, "potential after a spike"),
    "peak": (0.0, "potential at which a spike is cut"),
}
LIMITS = {"C": POSITIVE, "g_L": NOT_NEGATIVE, "slope": POSITIVE, "tau_w": POSITIVE}
EQUATIONS = {
    "modes": {
        "rest": {
            "V": "(-g_L*(V - E_L) + g_L*slope*exp((V - V_T)/slope) - w + I)/C",
            "w": "(a*(V - E_L) - w)/tau_w",
        }
    },
    "transitions": [event("spike", "rest", "rest", guard="V - peak", direction=+1, reset={"V": "V_r", "w": "w + b"})],
    "initial": {"mode": "rest", "V": PARAMETERS["E_L"][0], "w": 0.0},
}
"""The neuron with default parameters: it spikes with adaptation."""

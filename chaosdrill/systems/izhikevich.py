"""Izhikevich's simple model of a spiking neuron.

    v' = 0.04 v^2 + 5 v + 140 - u + I,  u' = a (b v - u);   at v = 30: v := c, u := u + d

Times in ms, v in mV. Source: Izhikevich 2003, doi:10.1109/TNN.2003.820440.
"""

from chaosdrill.declared import event

NAME = "izhikevich"
SUMMARY = "Izhikevich's spiking neuron"
GROUP = "neurons"
STATES = {"v": "membrane potential", "u": "recovery"}
PARAMETERS = {
    "a": (0.02, "rate of the recovery"),
    "b": (0.2, "sensitivity of the recovery"),
    "c": (-65.0, "potential after a spike"),
    "d": (8.0, "step of the recovery at a spike"),
    "I": (10.0, "current"),
}
EQUATIONS = {
    "modes": {"rest": {"v": "0.04*v**2 + 5*v + 140 - u + I", "u": "a*(b*v - u)"}},
    "transitions": [event("spike", "rest", "rest", guard="v - 30", direction=+1, reset={"v": "c", "u": "u + d"})],
    "initial": {"mode": "rest", "v": -65.0, "u": -13.0},
}
"""The neuron with default parameters: regular spiking."""

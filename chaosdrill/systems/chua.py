"""Chua's circuit with its piecewise-linear diode.

    x' = alpha (y - x - h(x)),  y' = x - y + z,  z' = -beta y
    h(x) = m1 x + (m0 - m1)(abs(x + 1) - abs(x - 1))/2

Three modes, linear each; the field is continuous at the breaks, so the saltation matrix is the identity there. Source:
Matsumoto 1984, doi:10.1109/TCS.1984.1085459; Chua, Komuro and Matsumoto 1986, doi:10.1109/TCS.1986.1085869.
"""

from chaosdrill.declared import event

NAME = "chua"
SUMMARY = "Chua's circuit, piecewise linear"
GROUP = "circuits"
CITES = ("matsumoto1984",)
STATES = {"x": "voltage over the diode", "y": "voltage over the second capacitor", "z": "current of the inductor"}
PARAMETERS = {
    "alpha": (9.0, "ratio of the capacitances"),
    "beta": (100 / 7, "inverse of the scaled inductance"),
    "m0": (-8 / 7, "slope of the diode between the breaks"),
    "m1": (-5 / 7, "slope of the diode beyond the breaks"),
}
currents = {"left": "m1*x - (m0 - m1)", "middle": "m0*x", "right": "m1*x + (m0 - m1)"}
EQUATIONS = {
    "modes": {mode: {"x": f"alpha*(y - x - ({h}))", "y": "x - y + z", "z": "-beta*y"} for mode, h in currents.items()},
    "transitions": [
        event("enter-right", "middle", "right", guard="x - 1", direction=+1, kind="break"),
        event("leave-right", "right", "middle", guard="x - 1", direction=-1, kind="break"),
        event("enter-left", "middle", "left", guard="x + 1", direction=-1, kind="break"),
        event("leave-left", "left", "middle", guard="x + 1", direction=+1, kind="break"),
    ],
    "initial": {"mode": "middle", "x": 0.1, "y": 0.0, "z": 0.0},
}
"""Chua's circuit with default parameters: double scroll."""

"""Boost converter under current control: a clock closes the switch, the current opens it.

    closed: L i' = V_in,       C v' = -v/R        until i = I_ref
    open:   L i' = V_in - v,   C v' = i - v/R     until the clock, or until i = 0
    idle:   i' = 0,            C v' = -v/R        until the clock

Times in ms, L in mH, C in mF. Source: Deane 1992, IEEE Transactions on Circuits and
Systems I 39, 680-683.
"""

from chaosdrill.declared import event
from chaosdrill.limits import POSITIVE

NAME = "boost-converter"
SUMMARY = "boost converter under current control"
GROUP = "converters"
STATES = {"v": "output voltage", "i": "current of the inductor", "phase": "phase of the clock"}
PARAMETERS = {
    "V_in": (10.0, "input voltage"),
    "R": (20.0, "load"),
    "L": (1.0, "inductance"),
    "C": (0.012, "capacitance"),
    "I_ref": (1.2, "reference current"),
    "T": (0.1, "period of the clock"),
}
LIMITS = {"R": POSITIVE, "L": POSITIVE, "C": POSITIVE, "T": POSITIVE}
EQUATIONS = {
    "modes": {
        "closed": {"v": "-v/(R*C)", "i": "V_in/L", "phase": "1/T"},
        "open": {"v": "(i - v/R)/C", "i": "(V_in - v)/L", "phase": "1/T"},
        "idle": {"v": "-v/(R*C)", "i": "0", "phase": "1/T"},
    },
    "transitions": [
        event("open", "closed", "open", guard="i - I_ref", direction=+1, kind="switch"),
        event("clock", ("closed", "open", "idle"), "closed", "phase - 1", +1, reset={"phase": "0"}),
        event("run-dry", "open", "idle", guard="i", direction=-1, reset={"i": "0"}),
    ],
    "initial": {"mode": "closed", "v": 15.0, "i": 0.8, "phase": 0.0},
}
"""The boost converter with default parameters: a cycle of one period."""

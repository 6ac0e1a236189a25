"""Boost converter under current control: a clock closes the switch, the current opens it.

    closed: L i' = V_in,       C v' = -v/R        until i = I_ref
    open:   L i' = V_in - v,   C v' = i - v/R     until the clock, or until i = 0
    idle:   i' = 0,            C v' = -v/R        until the clock

Times in ms, L in mH, C in mF. Source: Deane 1992, IEEE Transactions on Circuits and
Systems I 39, 680-683.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "boost-converter"
SUMMARY = "boost converter under current control"
GROUP = "converters"
STATES = ("v", "i", "phase")
PARAMETERS = {"V_in": 10.0, "R": 20.0, "L": 1.0, "C": 0.012, "I_ref": 1.2, "T": 0.1}
LABELS = {
    "v": "output voltage",
    "i": "current of the inductor",
    "phase": "phase of the clock",
    "V_in": "input voltage",
    "R": "load",
    "L": "inductance",
    "C": "capacitance",
    "I_ref": "reference current",
    "T": "period of the clock",
}


def system() -> "HybridSystem":
    """The boost converter with default parameters: a cycle of one period."""
    from chaosdrill.model import HybridSystem, Transition

    return HybridSystem(
        name=NAME,
        states=STATES,
        parameters=PARAMETERS,
        modes={
            "closed": {"v": "-v/(R*C)", "i": "V_in/L", "phase": "1/T"},
            "open": {"v": "(i - v/R)/C", "i": "(V_in - v)/L", "phase": "1/T"},
            "idle": {"v": "-v/(R*C)", "i": "0", "phase": "1/T"},
        },
        transitions=[
            Transition("open", "closed", "open", guard="i - I_ref", direction=+1, kind="switch"),
            Transition("clock", ("closed", "open", "idle"), "closed", "phase - 1", +1, reset={"phase": "0"}),
            Transition("run-dry", "open", "idle", guard="i", direction=-1, reset={"i": "0"}),
        ],
        initial={"mode": "closed", "v": 15.0, "i": 0.8, "phase": 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

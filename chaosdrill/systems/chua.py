"""Chua's circuit with its piecewise-linear diode.

    x' = alpha (y - x - h(x)),  y' = x - y + z,  z' = -beta y
    h(x) = m1 x + (m0 - m1)(abs(x + 1) - abs(x - 1))/2

Three modes, linear each; the field is continuous at the breaks, so the saltation matrix is the identity there. Source:
Matsumoto 1984, doi:10.1109/TCS.1984.1085459; Chua, Komuro and Matsumoto 1986, doi:10.1109/TCS.1986.1085869.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "chua"
SUMMARY = "Chua's circuit, piecewise linear"
GROUP = "circuits"
CITES = ("matsumoto1984",)
STATES = ("x", "y", "z")
PARAMETERS = {"alpha": 9.0, "beta": 100 / 7, "m0": -8 / 7, "m1": -5 / 7}
LABELS = {
    "x": "voltage over the diode",
    "y": "voltage over the second capacitor",
    "z": "current of the inductor",
    "alpha": "ratio of the capacitances",
    "beta": "inverse of the scaled inductance",
    "m0": "slope of the diode between the breaks",
    "m1": "slope of the diode beyond the breaks",
}


def system() -> "HybridSystem":
    """Chua's circuit with default parameters: double scroll."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    x, y, z, alpha, beta, m0, m1 = sympy.symbols("x y z alpha beta m0 m1", real=True)
    currents = {"left": m1 * x - (m0 - m1), "middle": m0 * x, "right": m1 * x + (m0 - m1)}
    return HybridSystem(
        name=NAME,
        states=(x, y, z),
        parameters=PARAMETERS,
        modes={mode: {x: alpha * (y - x - h), y: x - y + z, z: -beta * y} for mode, h in currents.items()},
        transitions=[
            Transition("enter-right", source="middle", target="right", guard=x - 1, direction=+1, kind="break"),
            Transition("leave-right", source="right", target="middle", guard=x - 1, direction=-1, kind="break"),
            Transition("enter-left", source="middle", target="left", guard=x + 1, direction=-1, kind="break"),
            Transition("leave-left", source="left", target="middle", guard=x + 1, direction=+1, kind="break"),
        ],
        initial={"mode": "middle", x: 0.1, y: 0.0, z: 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

"""Forced oscillator with Coulomb friction.

    x'' + x = cos(omega t) - S sgn(x');   at x' = 0 the mass stays as long as abs(cos(omega t) - x) <= S

Force, mass and stiffness are 1. At low friction the motion never stops (Den Hartog's continuous solution); sticking is
a mode of its own. Source: Den Hartog 1931, Trans. ASME 53, APM-53-9, 107.
"""

from chaosdrill.declared import event
from chaosdrill.limits import NOT_NEGATIVE, POSITIVE

NAME = "den-hartog"
SUMMARY = "forced oscillator with Coulomb friction"
GROUP = "friction and sliding"
CITES = ("denhartog1931",)
STATES = {"x": "displacement", "v": "velocity"}
PARAMETERS = {
    "omega": (0.8, "forcing frequency over natural frequency"),
    "S": (0.3, "friction force over the amplitude of the force"),
}
LIMITS = {"omega": POSITIVE, "S": NOT_NEGATIVE}
demand = "cos(omega*t) - x"
held = {"reset": {"v": "0"}, "condition": f"Abs({demand}) <= S", "kind": "stick"}
stop = {"guard": "v", "direction": -1}
turn = {"guard": "v", "direction": +1}
EQUATIONS = {
    "time": "t",
    "modes": {
        "forward": {"x": "v", "v": f"{demand} - S"},
        "backward": {"x": "v", "v": f"{demand} + S"},
        "stick": {"x": "0", "v": "0"},
    },
    "transitions": [
        event("stick-forward", "forward", "stick", **held, **stop),
        event("reverse-forward", "forward", "backward", kind="reverse", **stop),
        event("stick-backward", "backward", "stick", **held, **turn),
        event("reverse-backward", "backward", "forward", kind="reverse", **turn),
        event("release-forward", "stick", "forward", guard=f"{demand} - S", direction=+1, kind="slip"),
        event("release-backward", "stick", "backward", guard=f"{demand} + S", direction=-1, kind="slip"),
    ],
    "period": "2*pi/omega",
    "initial": {"mode": "forward", "x": 0.0, "v": 1.0},
}
"""The Den Hartog oscillator with default parameters: a cycle without sticking."""

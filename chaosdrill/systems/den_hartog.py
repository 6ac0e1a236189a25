"""Forced oscillator with Coulomb friction.

    x'' + x = cos(omega t) - S sgn(x');   at x' = 0 the mass stays as long as abs(cos(omega t) - x) <= S

Force, mass and stiffness are 1. At low friction the motion never stops (Den Hartog's continuous solution); sticking is
a mode of its own. Source: Den Hartog 1931, Trans. ASME 53, APM-53-9, 107.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "den-hartog"
SUMMARY = "forced oscillator with Coulomb friction"
GROUP = "friction and sliding"
CITES = ("denhartog1931",)
STATES = ("x", "v")
PARAMETERS = {"omega": 0.8, "S": 0.3}
LABELS = {
    "x": "displacement",
    "v": "velocity",
    "omega": "forcing frequency over natural frequency",
    "S": "friction force over the amplitude of the force",
}


def system() -> "HybridSystem":
    """The Den Hartog oscillator with default parameters: a cycle without sticking."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    x, v, t, omega, friction = sympy.symbols("x v t omega S", real=True)
    demand = sympy.cos(omega * t) - x
    held = sympy.Abs(demand) <= friction
    stop = {"guard": v, "direction": -1}
    turn = {"guard": v, "direction": +1}
    return HybridSystem(
        name=NAME,
        states=(x, v),
        time=t,
        parameters=PARAMETERS,
        modes={
            "forward": {x: v, v: demand - friction},
            "backward": {x: v, v: demand + friction},
            "stick": {x: 0, v: 0},
        },
        transitions=[
            Transition("stick-forward", "forward", "stick", reset={v: 0}, condition=held, kind="stick", **stop),
            Transition("reverse-forward", "forward", "backward", kind="reverse", **stop),
            Transition("stick-backward", "backward", "stick", reset={v: 0}, condition=held, kind="stick", **turn),
            Transition("reverse-backward", "backward", "forward", kind="reverse", **turn),
            Transition("release-forward", "stick", "forward", guard=demand - friction, direction=+1, kind="slip"),
            Transition("release-backward", "stick", "backward", guard=demand + friction, direction=-1, kind="slip"),
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "forward", x: 0.0, v: 1.0},
        description=SUMMARY,
        labels=LABELS,
    )

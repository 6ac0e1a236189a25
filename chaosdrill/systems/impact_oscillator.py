"""Forced linear oscillator with a wall on one side.

    x'' = -x - 2 zeta x' + amplitude cos(omega t),  x <= wall;   at the wall: x' := -e x'

The fruit fly of impacting systems: period doubling, grazing and chaos. Source: Shaw and Holmes 1983,
doi:10.1016/0022-460X(83)90407-8; grazing: Nordmark 1991, doi:10.1016/0022-460X(91)90592-8.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "impact-oscillator"
SUMMARY = "forced oscillator that hits a wall"
GROUP = "impacts"
CITES = ("shaw1983",)
STATES = ("x", "v")
PARAMETERS = {"wall": 0.3, "zeta": 0.05, "amplitude": 1.0, "omega": 2.5, "e": 0.8}
LABELS = {
    "x": "displacement",
    "v": "velocity",
    "wall": "position of the wall",
    "zeta": "damping ratio",
    "amplitude": "amplitude of the force over the stiffness",
    "omega": "forcing frequency over natural frequency",
    "e": "coefficient of restitution",
}


def system() -> "HybridSystem":
    """The impact oscillator with default parameters; chaotic, exponents about 0.091 and -0.319."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    x, v, t, wall, zeta, amplitude, omega, e = sympy.symbols("x v t wall zeta amplitude omega e", real=True)
    return HybridSystem(
        name=NAME,
        states=(x, v),
        time=t,
        parameters=PARAMETERS,
        modes={"free": {x: v, v: -x - 2 * zeta * v + amplitude * sympy.cos(omega * t)}},
        transitions=[
            Transition("impact", source="free", target="free", guard=x - wall, direction=+1, reset={v: -e * v})
        ],
        period=2 * sympy.pi / omega,
        initial={"mode": "free", x: 0.0, v: 0.3},
        description=SUMMARY,
        labels=LABELS,
    )

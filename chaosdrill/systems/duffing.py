"""Duffing's oscillator with a double well.

    x'' = -delta x' - alpha x - beta x^3 + amplitude cos(omega t)

The exponents sum to -delta. Source: Moon and Holmes 1979, doi:10.1016/0022-460X(79)90520-0.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "duffing"
SUMMARY = "Duffing's forced oscillator"
GROUP = "smooth flows"
STATES = ("x", "v")
PARAMETERS = {"delta": 0.25, "alpha": -1.0, "beta": 1.0, "amplitude": 0.4, "omega": 1.0}
LABELS = {
    "x": "displacement",
    "v": "velocity",
    "delta": "damping",
    "alpha": "linear stiffness",
    "beta": "cubic stiffness",
    "amplitude": "amplitude of the force",
    "omega": "forcing frequency",
}


def system() -> "HybridSystem":
    """Duffing's oscillator with default parameters; chaotic."""
    from chaosdrill.model import HybridSystem

    return HybridSystem(
        name=NAME,
        states=STATES,
        time="t",
        parameters=PARAMETERS,
        modes={"flow": {"x": "v", "v": "-delta*v - alpha*x - beta*x**3 + amplitude*cos(omega*t)"}},
        period="2*pi/omega",
        initial={"mode": "flow", "x": 0.2, "v": 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

"""Rössler's flow, the simplest smooth chaos.

    x' = -y - z,  y' = x + a y,  z' = b + z (x - c)

Source: Rössler 1976, doi:10.1016/0375-9601(76)90101-8.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "roessler"
SUMMARY = "Rössler's single-scroll flow"
GROUP = "smooth flows"
CITES = ("roessler1976",)
STATES = ("x", "y", "z")
PARAMETERS = {"a": 0.2, "b": 0.2, "c": 5.7}
LABELS = {
    "x": "first coordinate of the scroll",
    "y": "second coordinate of the scroll",
    "z": "coordinate across the scroll",
    "a": "growth rate within the scroll",
    "b": "feed across the scroll",
    "c": "position of the fold",
}


def system() -> "HybridSystem":
    """Rössler's flow with its classic parameters; exponents about 0.0718, 0, -5.3945."""
    import sympy

    from chaosdrill.model import HybridSystem

    x, y, z, a, b, c = sympy.symbols("x y z a b c", real=True)
    return HybridSystem(
        name=NAME,
        states=(x, y, z),
        parameters=PARAMETERS,
        modes={"flow": {x: -y - z, y: x + a * y, z: b + z * (x - c)}},
        initial={"mode": "flow", x: 1.0, y: 1.0, z: 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

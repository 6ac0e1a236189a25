"""Saddle flow that is sent back with a tripling.

    x' = x,  y' = -y,  z' = -0.7 z;   at x = 1: x := 3 y mod 1, y := 1, z := z + sin(3 y)/2

Started at y = 1 the return map is x -> 3 x mod 1 in time -ln x, of mean 1: the exponents are ln 3, 0 and -0.7 per unit
time. Three, because doubling collapses in binary floating point. Made for testing.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "saddle-reset"
SUMMARY = "saddle flow with a tripling reset"
GROUP = "maps for tests"
STATES = ("x", "y", "z")
PARAMETERS = {"decay": 0.7}
LABELS = {
    "x": "unstable coordinate",
    "y": "stable coordinate",
    "z": "driven coordinate",
    "decay": "decay rate of the driven coordinate",
}


def system() -> "HybridSystem":
    """The saddle with reset and default parameters."""
    import sympy

    from chaosdrill.model import HybridSystem, Transition

    x, y, z, decay = sympy.symbols("x y z decay", real=True)
    return HybridSystem(
        name=NAME,
        states=(x, y, z),
        parameters=PARAMETERS,
        modes={"saddle": {x: x, y: -y, z: -decay * z}},
        transitions=[
            Transition(
                "return",
                source="saddle",
                target="saddle",
                guard=x - 1,
                direction=+1,
                reset={x: sympy.Mod(3 * y, 1), y: 1, z: z + sympy.sin(3 * y) / 2},
            )
        ],
        initial={"mode": "saddle", x: 0.3141592653589793, y: 1.0, z: 0.0},
        description=SUMMARY,
        labels=LABELS,
    )

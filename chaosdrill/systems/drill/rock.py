"""What the bit presses on: a rock that gives way, or one that never does.

Source: equations (2) and (7) of the paper, the friction force with the sign that opposes motion.
"""

from typing import Any

from chaosdrill.limits import Limit

OPTIONS = {
    "fixed": "the rock never moves: no progression",
    "moving": "the rock-side mass moves forward; the drill progresses",
}

PARAMETERS: dict[str, dict[str, float]] = {
    "fixed": {},
    "moving": {"eps": 1.0},
}

LIMITS = {"eps": Limit(open_below=True, quantity="the mass ratio m1/m2")}

LABELS = {"eps": "bit mass over rock-side mass"}


def acceleration(force: Any, resistance: Any) -> Any:
    """Acceleration of the moving rock under the force of spring and damper against friction."""
    import sympy

    return sympy.Symbol("eps", real=True) * (force - resistance)

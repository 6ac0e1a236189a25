"""Dynamic load on the bit.

Source: equations (1) and (7) of the paper; lobes after its introduction (three or six lobes a turn of the cone).
"""

from math import pi
from typing import Any

from chaosdrill.limits import Limit

OPTIONS = {
    "none": "no dynamic load, only the static load",
    "harmonic": "a cos(eta t + phi), eta = forcing frequency over natural frequency",
    "lobes": "a cos(lobes spin t + phi), spin = rotation speed over natural frequency",
}

PARAMETERS: dict[str, dict[str, float]] = {
    "none": {},
    "harmonic": {"a": 0.25, "eta": 0.8, "phi": pi / 2},
    "lobes": {"a": 0.25, "lobes": 3.0, "spin": 0.8 / 3, "phi": pi / 2},
}

LIMITS = {
    "eta": Limit(open_below=True, quantity="the frequency ratio"),
    "lobes": Limit(open_below=True, quantity="the number of lobes"),
    "spin": Limit(open_below=True, quantity="the rotation speed"),
}

LABELS = {
    "a": "amplitude of the dynamic load over the static friction force",
    "eta": "forcing frequency over natural frequency",
    "phi": "phase of the dynamic load",
    "lobes": "lobes on the rock surface per turn",
    "spin": "rotation speed over natural frequency",
}


def load(option: str, time: Any) -> tuple[Any, Any]:
    """Dynamic load over the static friction force, and its period in units of 1/w0; (0, None) without a drive."""
    import sympy

    if option == "none":
        return sympy.Integer(0), None
    a, phi = sympy.symbols("a phi", real=True)
    if option == "harmonic":
        frequency = sympy.Symbol("eta", real=True)
    else:
        frequency = sympy.Symbol("lobes", real=True) * sympy.Symbol("spin", real=True)
    return a * sympy.cos(frequency * time + phi), 2 * sympy.pi / frequency

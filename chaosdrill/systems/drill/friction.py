"""Dry friction of the rock, in units of the static friction force mu_e F_N.

One-sided friction is the paper's: the rock advances or rests, and nothing pushes it back. Two-sided friction holds
the rock against either direction and opposes sliding either way. Source: equations (3) and (8) of the paper, the latter
read as mu + (1 - mu) exp(-g w), which is 1 at rest.
"""

from typing import Any

from chaosdrill.limits import Limit

OPTIONS = {
    "none": "no friction: the rock moves freely in both directions",
    "coulomb": "static friction 1, kinetic friction mu at any speed; one-sided",
    "stribeck": "friction mu + (1 - mu) exp(-g w), 1 at rest; one-sided",
    "coulomb-two-sided": "static friction 1, kinetic friction mu, against sliding either way",
    "stribeck-two-sided": "friction mu + (1 - mu) exp(-g abs(w)), 1 at rest, against sliding either way",
}

PARAMETERS: dict[str, dict[str, float]] = {
    "none": {},
    "coulomb": {"mu": 0.6},
    "stribeck": {"mu": 0.6, "g": 3.0},
    "coulomb-two-sided": {"mu": 0.6},
    "stribeck-two-sided": {"mu": 0.6, "g": 3.0},
}

LIMITS = {
    "mu": Limit(high=1.0, quantity="the friction ratio mu_d/mu_e"),
    "g": Limit(quantity="the decay rate of friction"),
}

LABELS = {
    "mu": "kinetic over static friction coefficient",
    "g": "decay rate of friction with speed",
}

STATIC = 1
SUFFIX = "-two-sided"


def two_sided(option: str) -> bool:
    """Whether the rock can slide back."""
    return option.endswith(SUFFIX)


def resistance(option: str, speed: Any) -> Any:
    """Friction on the rock that slides at a positive speed, against its motion, over the static friction force."""
    import sympy

    if option == "none":
        return sympy.Integer(0)
    mu, g = sympy.symbols("mu g", real=True)
    if option.removesuffix(SUFFIX) == "coulomb":
        return mu
    return mu + (1 - mu) * sympy.exp(-g * speed)

"""What holds the rock: one-sided dry friction, in units of the static friction force mu_e F_N.

Source: equations (3) and (8) of the paper, the latter read as mu + (1 - mu) exp(-g w), which is 1 at rest.
"""

from typing import Any

OPTIONS = {
    "none": "nothing holds the rock: it moves freely, both ways",
    "coulomb": "static friction 1, kinetic friction mu at any speed; one-sided",
    "stribeck": "friction mu + (1 - mu) exp(-g w), 1 at rest; one-sided",
}

PARAMETERS: dict[str, dict[str, float]] = {
    "none": {},
    "coulomb": {"mu": 0.6},
    "stribeck": {"mu": 0.6, "g": 3.0},
}

LABELS = {
    "mu": "kinetic over static friction coefficient",
    "g": "decay rate of friction with speed",
}

STATIC = 1


def resistance(option: str, speed: Any) -> Any:
    """Friction force on the sliding rock.

    Parameters
    ----------
    option : str
        A name of `OPTIONS`.
    speed : sympy expression
        Speed of the rock, positive forward.

    Returns
    -------
    sympy expression
        Force over the static friction force.
    """
    import sympy

    if option == "none":
        return sympy.Integer(0)
    mu, g = sympy.symbols("mu g", real=True)
    if option == "coulomb":
        return mu
    return mu + (1 - mu) * sympy.exp(-g * speed)

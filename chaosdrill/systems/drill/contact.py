"""What happens at the stop: the bit hits the rock-side mass after closing the gap r.

A contact acts at once. It gives the rebound speed s of the relative motion from the approach speed v; impulse and
momentum balance give the rest. With J = (v + s)/(1 + eps) the bit loses J and the rock gains eps J, so the momentum
eps u + w is kept to round-off whatever s is. Source: equations (5), (9) of the paper; Hunt and Crossley 1975,
doi:10.1115/1.3423596.
"""

from typing import Any

OPTIONS = {
    "none": "no stop: the gap never closes",
    "newton": "instantaneous, constant restitution e",
    "hunt-crossley": "instantaneous, exact exit speed of the force k d^n (1 + lam d')",
}

PARAMETERS: dict[str, dict[str, float]] = {
    "none": {},
    "newton": {"r": 1.0, "e": 0.8},
    "hunt-crossley": {"r": 1.0, "lam": 0.6},
}

# the force of a contact only matters where friction may hold the rock against it
FORCE_PARAMETERS: dict[str, dict[str, float]] = {
    "none": {},
    "newton": {},
    "hunt-crossley": {"n": 1.0, "k": 12e5},
}

LABELS = {
    "r": "gap of the stop",
    "e": "coefficient of restitution",
    "lam": "damping constant of the contact",
    "n": "exponent of the contact force",
    "k": "stiffness of the contact over the static friction force",
}


def exit_speed(option: str, approach: Any) -> Any:
    """Rebound speed of the relative motion, positive, from the approach speed (sympy expressions)."""
    import sympy

    from chaosdrill.model.special import hunt_crossley_exit

    if option == "newton":
        return sympy.Symbol("e", real=True) * approach
    return hunt_crossley_exit(approach, sympy.Symbol("lam", real=True))


def exchange(option: str, bit: Any, rock: Any) -> tuple[Any, Any]:
    """Speeds of bit and rock after a hit of free masses.

    Parameters
    ----------
    option : str
        ``"newton"`` or ``"hunt-crossley"``.
    bit, rock : sympy expressions
        Speeds before the hit; ``bit - rock`` is the approach speed.

    Returns
    -------
    bit, rock : sympy expressions
    """
    import sympy

    eps = sympy.Symbol("eps", real=True)
    approach = bit - rock
    impulse = (approach + exit_speed(option, approach)) / (1 + eps)
    return bit - impulse, rock + eps * impulse


def holds(option: str, approach: Any) -> Any:
    """Whether friction holds a resting rock through the hit; None where nothing can.

    The peak force is that of the relative mass 1/(1 + eps), of stiffness (1 + eps) k per unit mass (equation 4 of the
    paper). A Newtonian hit has an infinite force, which no friction holds.

    Returns
    -------
    sympy relation or None
    """
    import sympy

    from chaosdrill.model.special import hunt_crossley_peak
    from chaosdrill.systems.drill.friction import STATIC

    if option == "newton":
        return None
    lam, n, k, eps = sympy.symbols("lam n k eps", real=True)
    return hunt_crossley_peak(approach, lam, n, (1 + eps) * k) / (1 + eps) <= STATIC

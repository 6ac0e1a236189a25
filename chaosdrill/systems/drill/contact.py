"""What happens at the stop: the bit hits the rock-side mass after closing the gap r.

A hit gives the rebound speed s of the relative motion from the approach speed v; impulse and momentum balance give the
rest. With J = (v + s)/(1 + eps) the bit loses J and the rock gains eps J, so the momentum eps u + w is kept to
round-off whatever s is. Source: equations (4), (5), (9) of the paper; Hunt and Crossley 1975, doi:10.1115/1.3423596.
"""

from typing import Any

from chaosdrill.limits import Limit
from chaosdrill.systems.drill.friction import STATIC

OPTIONS = {
    "none": "no stop: the gap never closes",
    "newton": "instantaneous, constant restitution e",
    "hunt-crossley": "instantaneous, exact exit speed of the force k d^n (1 + lam d')",
    "hunt-crossley-timed": "the same, applied after the duration of the contact",
    "compliant": "integrated: the force k d^n (1 + lam d') acts on both masses",
}

_LAW = {"r": 1.0, "lam": 0.6, "n": 1.0, "k": 12e5}

PARAMETERS: dict[str, dict[str, float]] = {
    "none": {},
    "newton": {"r": 1.0, "e": 0.8},
    "hunt-crossley": _LAW,
    "hunt-crossley-timed": _LAW,
    "compliant": _LAW,
}

LIMITS = {
    "lam": Limit(quantity="the contact's damping"),
    "n": Limit(low=1.0, quantity="the contact's exponent"),
    "k": Limit(open_below=True, quantity="the contact's stiffness"),
    "e": Limit(high=1.0, quantity="the coefficient of restitution"),
}

LABELS = {
    "r": "gap of the stop",
    "e": "coefficient of restitution",
    "lam": "damping constant of the contact",
    "n": "exponent of the contact force",
    "k": "stiffness of the contact over the static friction force",
}


STATES = {"hunt-crossley-timed": "timer", "compliant": "depth"}
"""The state that a contact which takes time adds; it is 0 in free flight."""


def jumps(option: str) -> bool:
    """Whether a hit changes the speeds by a law, not by a force."""
    return option in ("newton", "hunt-crossley", "hunt-crossley-timed")


def exit_speed(option: str, approach: Any) -> Any:
    """Rebound speed of the relative motion, positive, from the approach speed (sympy expressions)."""
    import sympy

    from chaosdrill.model.special import hunt_crossley_exit

    if option == "newton":
        return sympy.Symbol("e", real=True) * approach
    return hunt_crossley_exit(approach, sympy.Symbol("lam", real=True))


def exchange(option: str, bit: Any, rock: Any) -> tuple[Any, Any]:
    """Speeds of bit and rock after a hit of free masses, by those before it; ``bit - rock`` is the approach speed."""
    import sympy

    eps = sympy.Symbol("eps", real=True)
    approach = bit - rock
    impulse = (approach + exit_speed(option, approach)) / (1 + eps)
    return bit - impulse, rock + eps * impulse


def peak(approach: Any, *, free: bool) -> Any:
    """Largest force of a Hunt-Crossley hit at an approach speed, over the static friction force.

    ``free``: whether the rock gives way. The relative mass is then 1/(1 + eps) and the stiffness per unit of it (1 +
    eps) k (equation 4 of the paper); against a rock at rest the bit's own mass 1 counts.
    """
    import sympy

    from chaosdrill.model.special import hunt_crossley_peak

    lam, n, k, eps = sympy.symbols("lam n k eps", real=True)
    if free:
        return hunt_crossley_peak(approach, lam, n, (1 + eps) * k) / (1 + eps)
    return hunt_crossley_peak(approach, lam, n, k)


def holds(option: str, approach: Any) -> Any:
    """Whether friction holds a resting rock through the hit; None where nothing can.

    The paper uses the peak force of free masses. A Newtonian hit has an infinite force, which no friction holds.
    """
    return None if option == "newton" else peak(approach, free=True) <= STATIC


def duration(approach: Any, *, free: bool) -> Any:
    """Time that a Hunt-Crossley hit takes; arguments as for `peak`."""
    import sympy

    from chaosdrill.model.special import hunt_crossley_duration

    lam, n, k, eps = sympy.symbols("lam n k eps", real=True)
    return hunt_crossley_duration(approach, lam, n, (1 + eps) * k if free else k)


def force(depth: Any, rate: Any) -> Any:
    """Force k d^n (1 + lam d') between bit and rock, over the static friction force."""
    import sympy

    from chaosdrill.model.special import positive_power

    lam, n, k = sympy.symbols("lam n k", real=True)
    return k * positive_power(depth, n) * (1 + lam * rate)

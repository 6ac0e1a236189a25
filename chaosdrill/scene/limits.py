"""Which numbers a parameter of the drill may be: no negative masses, stiffnesses or dampings."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf


@dataclass(frozen=True)
class Limit:
    """Allowed range, and the quantity in the reader's words."""

    quantity: str
    low: float = 0.0
    high: float = inf
    open_below: bool = False

    def refuses(self, value: float) -> str | None:
        """What to say of a value outside of the range; None for one inside."""
        below = value <= self.low if self.open_below else value < self.low
        if not below and value <= self.high:
            return None
        bounds = f"greater than {self.low:g}" if self.open_below else f"at least {self.low:g}"
        if self.high < inf:
            bounds += f" and at most {self.high:g}"
        return f"{self.quantity} must be {bounds}, received {value!r}"


_DRILL = {
    "xi": Limit("the damping ratio"),
    "eps": Limit("the mass ratio m1/m2", open_below=True),
    "eta": Limit("the frequency ratio", open_below=True),
    "lobes": Limit("the number of lobes", open_below=True),
    "spin": Limit("the rotation speed", open_below=True),
    "mu": Limit("the friction ratio mu_d/mu_e", high=1.0),
    "g": Limit("the decay rate of friction"),
    "lam": Limit("the contact's damping"),
    "n": Limit("the contact's exponent", low=1.0),
    "k": Limit("the contact's stiffness", open_below=True),
    "e": Limit("the coefficient of restitution", high=1.0),
}

LIMITS: Mapping[str, Mapping[str, Limit]] = {"percussive-drill": _DRILL, "percussive-drill-5d": _DRILL}

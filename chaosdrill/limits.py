"""Limits of parameters, declared beside these and read wherever a parameter gets a value."""

from dataclasses import dataclass
from math import inf
from sys import float_info


@dataclass(frozen=True)
class Limit:
    """Allowed range of a parameter, and the quantity in the reader's words."""

    low: float = 0.0
    high: float = inf
    """Both allowed, if finite."""
    open_below: bool = False  # whether ``low`` itself is not allowed
    quantity: str = ""  # as in ``"the damping ratio"``; what a system leaves empty is the parameter's label
    whole: bool = False  # whether only whole numbers are allowed

    def refuses(self, value: object) -> str | None:
        """The message for a value outside of the range; None for one inside, and for anything but a finite number."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= float_info.max:
            return None
        below = value <= self.low if self.open_below else value < self.low
        broken = self.whole and value != int(value)
        if not below and value <= self.high and not broken:
            return None
        bounds = f"greater than {self.low:g}" if self.open_below else f"at least {self.low:g}"
        if self.high < inf:
            bounds += f" and at most {self.high:g}"
        if self.whole:
            bounds = f"a whole number, {bounds}"
        return f"{self.quantity or 'it'} must be {bounds}, received {value!r}"


POSITIVE = Limit(open_below=True)
NOT_NEGATIVE = Limit()
RESTITUTION = Limit(high=1.0)
"""More than 1 would be a wall that gives energy."""

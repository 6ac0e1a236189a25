"""Forces and accelerations of bit and rock, in free flight and in contact.

    y' = u - w
    u' = b + load(t) - l - F             l = y + 2 xi (u - w): force of spring and damper, F: force of the contact
    w' = eps (l + F - f(w))              stick: w = 0 while l + F <= 1 (two-sided friction: abs(l + F) <= 1)

Where bit and rock move together at the stop, y = r, the contact force follows from u' = w':

    N = [b + load(t) - r - eps (r - f(w))]/(1 + eps),    at rest N = b + load(t) - r.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.model import Transition
from chaosdrill.systems.drill import contact, drive, friction, rock
from chaosdrill.systems.drill.friction import STATIC

if TYPE_CHECKING:
    from chaosdrill.model import Transition

REST = "stick"
CONTACT = "-contact"
"""What the names of modes end with in which a contact lasts."""


class Balance:
    """Symbols, forces and equations of motion of a drill with these effects, every one with its option.

    ``rests``: whether the rock can be at rest: the mode ``stick`` exists. ``slides``: modes in which the rock moves,
    and the direction in which it does. ``added``: the state that the contact adds, or None.
    """

    def __init__(self, effects: Mapping[str, str]) -> None:
        import sympy

        self.y, self.u, self.w, self.t = sympy.symbols("y u w t", real=True)
        self.xi, self.r, self.eps = sympy.symbols("xi r eps", real=True)
        load, self.period = drive.load(effects["drive"], self.t)
        self.thrust = sympy.Symbol("b", real=True) + load
        self.option = effects["friction"]
        self.moves = effects["rock"] == "moving"
        self.grips = self.option != "none"
        self.rests = self.grips or not self.moves
        added = contact.STATES.get(effects["contact"])
        self.added = None if added is None else sympy.Symbol(added, real=True)
        self.slides: dict[str, int] = {"slip": 1} if self.moves else {}
        if friction.two_sided(self.option):
            self.slides["slip-back"] = -1

    @property
    def free(self) -> dict[Any, Any]:
        """Reset that goes with every way into free flight or a held contact: what the contact added is 0."""
        return {} if self.added is None else {self.added: 0}

    @property
    def modes(self) -> tuple[str, ...]:
        """Modes of the rock."""
        return (*((REST,) if self.rests else ()), *self.slides)

    def speed(self, mode: str) -> Any:
        """Speed of the rock."""
        return 0 if mode == REST else self.w

    def spring(self, mode: str) -> Any:
        """Force of spring and damper."""
        return self.y + 2 * self.xi * (self.u - self.speed(mode))

    def friction(self, mode: str) -> Any:
        """Friction force on the sliding rock, backward positive."""
        way = self.slides[mode]
        return way * friction.resistance(self.option, way * self.w)

    def apart(self, mode: str, push: Any = 0) -> dict[Any, Any]:
        """Equations of motion of two masses that move on their own, under a contact force ``push``."""
        spring = self.spring(mode)
        field = {self.y: self.u - self.speed(mode), self.u: self.thrust - spring - push}
        if self.moves:
            field[self.w] = 0 if mode == REST else rock.acceleration(spring + push, self.friction(mode))
        return field

    def together(self, mode: str) -> dict[Any, Any]:
        """Equations of motion of two masses that move as one at the stop."""
        if mode == REST:
            return {self.y: 0, self.u: 0} | ({self.w: 0} if self.moves else {})
        common = self.eps * (self.thrust - self.friction(mode)) / (1 + self.eps)
        return {self.y: 0, self.u: common, self.w: common}

    def pressing(self, mode: str) -> Any:
        """Force N that presses the masses together at the stop."""
        if mode == REST:
            return self.thrust - self.r
        return (self.thrust - self.r - self.eps * (self.r - self.friction(mode))) / (1 + self.eps)

    def at_rest(self, mode: str) -> dict[Any, Any]:
        """Reset that goes with every way into the mode: a rock at rest has no speed, so no tangent in it either."""
        return {self.w: 0} if mode == REST and self.moves else {}

    def varies(self, expression: Any) -> bool:
        """Whether the expression can cross zero: it names a state or time, not only parameters."""
        return bool(expression.free_symbols & {self.y, self.u, self.w, self.t, self.added})


def stick_slip(
    balance: Balance, demand: Any, suffix: str, always: Mapping[Any, Any], at_rest: Mapping[Any, Any]
) -> list["Transition"]:
    """Transitions of the rock between rest and sliding.

    A rock that stops stays at rest if friction can hold it, else it slides on the other way. Where the demand stands at
    the threshold itself, its first derivative that does not vanish decides: a guard at zero lies on the side to which
    it moves.

    ``demand``: force on the rock at rest, which friction has to balance. ``suffix``: what follows the names of the
    modes: ``""``, ``"-contact"`` or ``"-held"``. ``always``, ``at_rest``: resets that go with every transition, and
    with those that bring the rock to rest.
    """
    if not balance.grips:
        return []
    rest, slip, back = (mode + suffix for mode in (REST, "slip", "slip-back"))
    stopped = {**always, **at_rest, balance.w: 0}
    way: Any = {"guard": balance.w, "direction": -1, "reset": stopped}
    two_sided = len(balance.slides) == 2
    found = []
    if balance.varies(demand):
        off: Any = {"source": rest, "reset": always, "kind": "slip"}
        found.append(Transition("release" + suffix, target=slip, guard=demand - STATIC, direction=+1, **off))
        if two_sided:
            found.append(Transition("release-back" + suffix, target=back, guard=demand + STATIC, direction=-1, **off))
    if not two_sided:
        return [*found, Transition("stick" + suffix, slip, rest, kind="stick", **way)]
    back_way = {**way, "direction": +1}
    return [
        *found,
        Transition("stick" + suffix, slip, rest, condition=demand >= -STATIC, kind="stick", **way),
        Transition("turn-back" + suffix, slip, back, kind="turn", **way),
        Transition("stick-from-back" + suffix, back, rest, condition=demand <= STATIC, kind="stick", **back_way),
        Transition("turn-forward" + suffix, back, slip, kind="turn", **back_way),
    ]

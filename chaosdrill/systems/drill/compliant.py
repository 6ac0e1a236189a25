"""Compliant contact: a force acts on bit and rock while the bit is beyond the stop.

In contact y stays at the stop and a state of its own, the depth, goes on from 0; the spring is stretched by their sum.
A depth of 1e-7 beside a stretch of 1 would lose nine of its digits, and a stiff force would turn the rest into noise:
in the force, in the tangents, and at the threshold of friction, where the rock would then stick and slip without end.
"""

from typing import TYPE_CHECKING, Any

from chaosdrill.systems.drill import contact
from chaosdrill.systems.drill.balance import CONTACT, REST, Balance
from chaosdrill.systems.drill.phases import stick_slip

if TYPE_CHECKING:
    from chaosdrill.model import Transition


def contact_modes(balance: Balance) -> dict[str, dict[Any, Any]]:
    """Equations of the modes in which the bit is beyond the stop."""
    modes = {}
    for mode in balance.modes:
        field = balance.apart(mode, _push(balance, mode))
        closing = field.pop(balance.y)
        modes[mode + CONTACT] = {balance.y: 0, balance.added: closing} | {x: _in(balance, f) for x, f in field.items()}
    return modes


def contacts(balance: Balance) -> list["Transition"]:
    """Transitions into, within and out of the contact; the force is zero at both ends, so nothing jumps."""
    from chaosdrill.model import Transition

    y, r, depth = balance.y, balance.r, balance.added
    found = []
    for mode in balance.modes:
        rest = balance.at_rest(mode)
        on: Any = {"guard": y - r, "direction": +1, "reset": {y: r, depth: y - r, **rest}}
        off: Any = {"guard": depth, "direction": -1, "reset": {y: r + depth, depth: 0, **rest}}
        found.append(Transition(f"touch-{mode}", mode, mode + CONTACT, priority=1, kind="impact", **on))
        found.append(Transition(f"part-{mode}", mode + CONTACT, mode, kind="part", **off))
    demand = _in(balance, balance.spring(REST) + _push(balance, REST))
    return found + stick_slip(balance, demand, CONTACT, {y: r}, {})


def _push(balance: Balance, mode: str) -> Any:
    return contact.force(balance.added, balance.u - balance.speed(mode))


def _in(balance: Balance, expression: Any) -> Any:
    """An expression of the stretch, in contact."""
    import sympy

    return sympy.sympify(expression).subs(balance.y, balance.y + balance.added)

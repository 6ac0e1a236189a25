"""A contact that is a phase of its own: its force acts on bit and rock while the bit is beyond the stop."""

from typing import TYPE_CHECKING, Any

from chaosdrill.systems.drill import contact
from chaosdrill.systems.drill.balance import REST, Balance
from chaosdrill.systems.drill.phases import stick_slip

if TYPE_CHECKING:
    from chaosdrill.model import Transition

CONTACT = "-contact"


def contact_modes(balance: Balance) -> dict[str, dict[Any, Any]]:
    """Equations of the modes in which the bit is beyond the stop."""
    return {mode + CONTACT: balance.apart(mode, _push(balance, mode)) for mode in balance.modes}


def contacts(balance: Balance) -> list["Transition"]:
    """Transitions into, within and out of the contact; the force is zero at both ends, so nothing jumps."""
    from chaosdrill.model import Transition

    gap = balance.y - balance.r
    found = []
    for mode in balance.modes:
        both = {"guard": gap, "reset": balance.at_rest(mode)}
        found.append(Transition(f"touch-{mode}", mode, mode + CONTACT, direction=+1, priority=1, kind="impact", **both))
        found.append(Transition(f"part-{mode}", mode + CONTACT, mode, direction=-1, kind="part", **both))
    return found + stick_slip(balance, balance.spring(REST) + _push(balance, REST), CONTACT, {}, {})


def _push(balance: Balance, mode: str) -> Any:
    return contact.force(balance.y - balance.r, balance.u - balance.speed(mode))

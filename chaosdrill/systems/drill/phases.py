"""The rock sticks and slips, in free flight and in contact."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from chaosdrill.systems.drill.balance import REST, Balance
from chaosdrill.systems.drill.friction import STATIC

if TYPE_CHECKING:
    from chaosdrill.model import Transition


def stick_slip(
    balance: Balance, demand: Any, suffix: str, always: Mapping[Any, Any], at_rest: Mapping[Any, Any]
) -> list["Transition"]:
    """Transitions of the rock between rest and sliding.

    Parameters
    ----------
    balance : Balance
        Symbols of the drill.
    demand : sympy expression
        Force on the rock at rest, which friction has to balance.
    suffix : str
        What follows the names of the modes: ``""``, ``"-contact"`` or ``"-held"``.
    always, at_rest : mapping
        Reset that goes with every transition, and with those that bring the rock to rest.

    Notes
    -----
    A rock that stops stays at rest if friction can hold it, else it slides on the other way. Where the demand stands at
    the threshold itself, its first derivative that does not vanish decides: a guard at zero lies on the side to which
    it moves.
    """
    from chaosdrill.model import Transition

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

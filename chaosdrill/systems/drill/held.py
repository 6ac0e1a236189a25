"""Held contact: bit and rock stay together at the stop until the force between them changes sign.

Newtonian rebounds that would end within a negligible time end in a held contact. A Hunt-Crossley contact loses ever
less of ever weaker hits, so its rebounds need not end; but its law is that of free masses, and where the peak force of
a hit is no larger than the force N that presses the masses together, it is beyond its validity. Such a hit is held.
"""

from typing import TYPE_CHECKING, Any

from chaosdrill.systems.drill import contact
from chaosdrill.systems.drill.balance import REST, Balance
from chaosdrill.systems.drill.phases import stick_slip

if TYPE_CHECKING:
    from chaosdrill.model import Transition

HELD = "-held"


def held_modes(balance: Balance, option: str) -> dict[str, dict[Any, Any]]:
    """Equations of the modes in which the masses move together, or both rest."""
    if not contact.jumps(option):
        return {}
    return {mode + HELD: balance.together(mode) for mode in balance.modes}


def hold(balance: Balance, option: str, mode: str, rebound: str, event: Any) -> list["Transition"]:
    """The outcome of a hit in ``mode`` after which the masses stay together, in place of the one named ``rebound``."""
    import sympy

    from chaosdrill.model import Transition

    pressing, speed = balance.pressing(mode), balance.common_speed(mode)
    tests = [pressing > 0]
    if mode != REST:
        # speeds that meet while the rock slides back but go forward together belong to another mode
        tests += [speed <= 0] if balance.slides[mode] < 0 else []
    reset = {balance.y: balance.r, balance.u: speed} | ({balance.w: speed} if balance.moves else {})
    how = {"source": mode, "target": mode + HELD, "reset": {**reset, **balance.free}, "kind": "hold", **event}
    if option == "newton":
        return [Transition(f"hold-{mode}", completes=rebound, condition=sympy.And(*tests), **how)]
    peak = contact.peak(balance.u - balance.speed(mode), free=mode != REST)
    return [Transition(f"hold-{mode}", condition=sympy.And(*tests, peak <= pressing), **how)]


def held(balance: Balance) -> list["Transition"]:
    """Transitions out of and between the modes of a held contact."""
    from chaosdrill.model import Transition

    y, u, w, r = balance.y, balance.u, balance.w, balance.r
    found = [
        Transition(
            f"part-{mode}",
            mode + HELD,
            mode,
            guard=balance.pressing(mode),
            direction=-1,
            reset={**balance.free, **balance.at_rest(mode)},
            kind="part",
        )
        for mode in balance.modes
        if balance.varies(balance.pressing(mode))
    ]
    if balance.grips and not balance.varies(balance.pressing(REST)):
        # no guard can watch a force that never changes
        loose = balance.pressing(REST) <= 0
        reset = {u: 0, w: 0, **balance.free}
        found.append(
            Transition(
                "part-at-rest", "slip" + HELD, REST, guard=w, direction=-1, reset=reset, condition=loose, kind="part"
            )
        )
    return found + stick_slip(balance, balance.thrust, HELD, {y: r, **balance.free}, {u: 0})

"""Impacts that change the speeds by a law, instantly or after the duration of the contact.

While a timed contact lasts a timer runs down and nothing else moves: y stays at the stop, and bit and rock keep the
speeds at which they met, so that the penetration goes on at the rock's. Then the new speeds hold.
"""

from typing import TYPE_CHECKING, Any

from chaosdrill.systems.drill import contact
from chaosdrill.systems.drill.balance import CONTACT, REST, Balance
from chaosdrill.systems.drill.held import hold

if TYPE_CHECKING:
    from chaosdrill.model import Transition


def hit_modes(balance: Balance) -> dict[str, dict[Any, Any]]:
    """Equations of the modes in which a contact lasts; none where it takes no time."""
    timer = balance.added
    if timer is None:
        return {}
    still = dict.fromkeys((balance.y, balance.u, *((balance.w,) if balance.moves else ())), 0) | {timer: -1}
    return {mode + CONTACT: still for mode in (REST, "slip") if mode in balance.modes}


def hits(balance: Balance, option: str) -> list["Transition"]:
    """Transitions of the stop; they act before a release at the same instant, which then follows from the hit."""
    event = {"guard": balance.y - balance.r, "direction": +1, "priority": 1}
    if balance.added is not None:
        return _timed(balance, option, {**event, "kind": "impact"}, event)
    return _instant(balance, option, {**event, "kind": "impact"}, event)


def _instant(balance: Balance, option: str, impact: Any, event: Any) -> list["Transition"]:
    from chaosdrill.model import Transition

    u, w = balance.u, balance.w
    thrown = {u: -contact.exit_speed(option, u)}
    if not balance.moves:
        return [*hold(balance, option, REST, "hit", event), Transition("hit", REST, REST, reset=thrown, **impact)]
    found = []
    if balance.rests:
        found += hold(balance, option, REST, "strong-hit", event)
        weak = contact.holds(option, u)
        if weak is not None:
            found.append(Transition("weak-hit", REST, REST, reset=thrown, condition=weak, **impact))
        after = dict(zip((u, w), contact.exchange(option, u, 0), strict=True))
        found.append(Transition("strong-hit", REST, "slip", reset=after, **impact))
    after = dict(zip((u, w), contact.exchange(option, u, w), strict=True))
    found += hold(balance, option, "slip", "hit", event)
    found.append(Transition("hit", "slip", "slip", reset=after, **impact))
    if "slip-back" in balance.slides:
        found += hold(balance, option, "slip-back", "hit-back", event)
        found.append(Transition("turning-hit", "slip-back", "slip", reset=after, condition=after[w] > 0, **impact))
        found.append(Transition("hit-back", "slip-back", "slip-back", reset=after, **impact))
    return found


def _timed(balance: Balance, option: str, impact: Any, event: Any) -> list["Transition"]:
    from chaosdrill.model import Transition

    u, w, timer = balance.u, balance.w, balance.added
    over: Any = {"guard": timer, "direction": -1, "kind": "rebound"}
    thrown = {u: -contact.exit_speed(option, u), timer: 0, **balance.at_rest(REST)}
    against_rest = {timer: contact.duration(u, free=False), **balance.at_rest(REST)}
    found = []
    if balance.rests:
        found += hold(balance, option, REST, "hit", event)
        first = "weak-hit" if balance.moves else "hit"
        weak = contact.holds(option, u) if balance.moves else None
        found.append(Transition(first, REST, REST + CONTACT, reset=against_rest, condition=weak, **impact))
    if balance.grips:
        started = {timer: contact.duration(u, free=True)}
        found.append(Transition("strong-hit", REST, "slip" + CONTACT, reset=started, **impact))
    started = {timer: contact.duration(u - w, free=True)}
    names = {"slip": "hit", "slip-back": "hit-back"}
    for mode in balance.slides:
        found += hold(balance, option, mode, names[mode], event)
        found.append(Transition(names[mode], mode, "slip" + CONTACT, reset=started, **impact))
    if balance.rests:
        found.append(Transition("rebound-from-rest", REST + CONTACT, REST, reset=thrown, **over))
    if balance.moves:
        after = {**dict(zip((u, w), contact.exchange(option, u, w), strict=True)), timer: 0}
        onward = after[w] > 0 if "slip-back" in balance.slides else None
        found.append(Transition("rebound", "slip" + CONTACT, "slip", reset=after, condition=onward, **over))
    if "slip-back" in balance.slides:
        found.append(Transition("rebound-back", "slip" + CONTACT, "slip-back", reset=after, **over))
    return found

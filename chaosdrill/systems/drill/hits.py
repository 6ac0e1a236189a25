"""What happens at the stop: impacts by a law, instant or timed, held contacts, and compliant ones.

While a timed contact lasts a timer runs down and nothing else moves: y stays at the stop, and bit and rock keep the
speeds at which they met, so that the penetration goes on at the rock's. Then the new speeds hold.

In a held contact bit and rock stay together at the stop until the force between them changes sign. Newtonian rebounds
that would end within a negligible time end in one. A Hunt-Crossley contact loses ever less of ever weaker hits, so its
rebounds need not end; but its law is that of free masses, and where the peak force of a hit is no larger than the force
N that presses the masses together, it is beyond its validity. Such a hit is held.

In a compliant contact a force acts on bit and rock while the bit is beyond the stop. y stays at the stop and a state of
its own, the depth, goes on from 0; the spring is stretched by their sum. A depth of 1e-7 beside a stretch of 1 would
lose nine of its digits, and a stiff force would turn the rest into noise: in the force, in the tangents, and at the
threshold of friction, where the rock would then stick and slip without end.
"""

from typing import Any

from chaosdrill.model import Transition
from chaosdrill.systems.drill import contact
from chaosdrill.systems.drill.balance import CONTACT, REST, Balance, stick_slip

HELD = "-held"


def hit_modes(balance: Balance) -> dict[str, dict[Any, Any]]:
    """Equations of the modes in which a contact lasts; none where it takes no time."""
    timer = balance.added
    if timer is None:
        return {}
    still = dict.fromkeys((balance.y, balance.u, *((balance.w,) if balance.moves else ())), 0) | {timer: -1}
    return {mode + CONTACT: still for mode in (REST, "slip") if mode in balance.modes}


def hits(balance: Balance, option: str) -> list[Transition]:
    """Transitions of the stop; they act before a release at the same instant, which then follows from the hit."""
    event = {"guard": balance.y - balance.r, "direction": +1, "priority": 1}
    if balance.added is not None:
        return _timed(balance, option, {**event, "kind": "impact"}, event)
    return _instant(balance, option, {**event, "kind": "impact"}, event)


def _instant(balance: Balance, option: str, impact: Any, event: Any) -> list[Transition]:
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


def _timed(balance: Balance, option: str, impact: Any, event: Any) -> list[Transition]:
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


def hold(balance: Balance, option: str, mode: str, rebound: str, event: Any) -> list[Transition]:
    """The outcome of a hit in ``mode`` after which the masses stay together, in place of the one named ``rebound``."""
    import sympy

    pressing = balance.pressing(mode)
    speed = 0 if mode == REST else (balance.eps * balance.u + balance.w) / (1 + balance.eps)
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


def held(balance: Balance) -> list[Transition]:
    """Transitions out of and between the modes of a held contact."""
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


def contact_modes(balance: Balance) -> dict[str, dict[Any, Any]]:
    """Equations of the modes in which the bit is beyond the stop."""
    modes = {}
    for mode in balance.modes:
        field = balance.apart(mode, _push(balance, mode))
        closing = field.pop(balance.y)
        modes[mode + CONTACT] = {balance.y: 0, balance.added: closing} | {x: _in(balance, f) for x, f in field.items()}
    return modes


def contacts(balance: Balance) -> list[Transition]:
    """Transitions into, within and out of the contact; the force is zero at both ends, so nothing jumps."""
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

"""Effects of the drill and their valid combinations."""

from collections.abc import Mapping
from itertools import product

from chaosdrill.errors import ModelError
from chaosdrill.limits import Limit
from chaosdrill.names import remedy
from chaosdrill.systems.drill import contact, drive, friction, rock

OPTIONS = {
    "drive": drive.OPTIONS,
    "friction": friction.OPTIONS,
    "rock": rock.OPTIONS,
    "contact": contact.OPTIONS,
}
ABSENT = {"drive": "none", "friction": "none", "rock": "fixed", "contact": "none"}
LIMITS = {
    "xi": Limit(quantity="the damping ratio"),
    **drive.LIMITS,
    **friction.LIMITS,
    **rock.LIMITS,
    **contact.LIMITS,
}
"""Of all parameters that some effect has."""

PAPER = {"drive": "harmonic", "friction": "stribeck", "rock": "moving", "contact": "hunt-crossley"}


def complete(effects: Mapping[str, str] | None) -> dict[str, str]:
    """Every effect with its option; one that is absent is not simulated. None: the paper's effects.

    Raises `ModelError` if an effect or option does not exist, or if friction is to act on a rock that never moves.
    """
    if effects is None:
        return dict(PAPER)
    for effect, option in effects.items():
        if effect not in OPTIONS:
            raise ModelError(f"unknown effect {effect!r}; {remedy(effect, OPTIONS)}")
        if not isinstance(option, str) or option not in OPTIONS[effect]:
            raise ModelError(f"{effect}: there is no {option!r}; {remedy(str(option), OPTIONS[effect])}")
    chosen = {**ABSENT, **effects}
    if chosen["rock"] == "fixed" and chosen["friction"] != "none":
        raise ModelError(
            f"friction {chosen['friction']!r} acts on a moving rock, but rock is 'fixed'; "
            "choose rock 'moving', or friction 'none'"
        )
    return chosen


def parameters(effects: Mapping[str, str] | None = None) -> dict[str, float]:
    """Names and defaults of the parameters that the chosen effects use."""
    chosen = complete(effects)
    values = {"b": 0.7, "xi": 0.06}
    for effect, part in (("drive", drive), ("rock", rock), ("friction", friction), ("contact", contact)):
        values |= part.PARAMETERS[chosen[effect]]
    return values


def unused(key: str, effects: Mapping[str, str] | None = None) -> str:
    """Say which other effects would use a parameter that the chosen ones do not; empty if there are none."""
    chosen = complete(effects)
    changes = []
    for options in product(*OPTIONS.values()):
        other = dict(zip(OPTIONS, options, strict=True))
        changes.append({effect: option for effect, option in other.items() if option != chosen[effect]})
    for change in sorted(changes, key=lambda change: (len(change), [list(OPTIONS).index(effect) for effect in change])):
        try:
            used = parameters({**chosen, **change})
        except ModelError:
            continue
        if key in used:
            now, then = (", ".join(f"{e}={given[e]!r}" for e in change) for given in (chosen, change))
            return f"not used with {now}; leave it out, or choose {then}"
    return ""


def limits(effects: Mapping[str, str] | None = None) -> dict[str, Limit]:
    """Limits of the parameters that the chosen effects use."""
    return {name: LIMITS[name] for name in parameters(effects) if name in LIMITS}


def states(effects: Mapping[str, str] | None = None) -> tuple[str, ...]:
    """Names of the states: the rock's speed w is one only where the rock moves; a contact that takes time adds one."""
    chosen = complete(effects)
    rock_speed = ("w",) if chosen["rock"] == "moving" else ()
    added = (contact.STATES[chosen["contact"]],) if chosen["contact"] in contact.STATES else ()
    return ("y", "u", *rock_speed, *added)

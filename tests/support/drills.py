"""Choices of effects of the drill: all that are possible, and few that hold every pair or every option."""

from itertools import combinations, product

import chaosdrill as cd
from chaosdrill import systems

CHOICES = [dict(zip(systems.EFFECTS, options, strict=True)) for options in product(*systems.EFFECTS.values())]
POSSIBLE = [c for c in CHOICES if c["rock"] == "moving" or c["friction"] == "none"]
"""Friction acts on a rock that moves."""


def label(effects):
    return "-".join(effects.values())


def _covering(size):
    """Drills in which any so many options that can be chosen together are chosen together at least once."""
    held = {label(e): set(combinations(e.items(), size)) for e in POSSIBLE}
    missing, found = set().union(*held.values()), []
    while missing:
        found.append(max(POSSIBLE, key=lambda e: len(held[label(e)] & missing)))
        missing -= held[label(found[-1])]
    return found


WITH_EVERY_PAIR, WITH_EVERY_OPTION = _covering(2), _covering(1)

_built = {}


def built(effects):
    """The drill of these effects, built once."""
    name = label(effects)
    if name not in _built:
        _built[name] = cd.drill(**effects)
    return _built[name]

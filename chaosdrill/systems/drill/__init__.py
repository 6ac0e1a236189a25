"""The percussive drill, assembled from effects; an effect that is left out leaves no trace."""

from chaosdrill.systems.drill.assemble import LABELS, NAME, bodies, drill, system
from chaosdrill.systems.drill.effects import limits, parameters, states, unused

__all__ = [
    "CITES",
    "GROUP",
    "LABELS",
    "NAME",
    "SUMMARY",
    "bodies",
    "drill",
    "limits",
    "parameters",
    "states",
    "system",
    "unused",
]

SUMMARY = "bit and rock, assembled from effects"
GROUP = "drilling"
CITES = ("drilling",)

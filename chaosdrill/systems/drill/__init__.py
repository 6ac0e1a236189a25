"""The percussive drill, assembled from effects; an effect that is left out leaves no trace."""

from chaosdrill.systems.drill.assemble import drill, system
from chaosdrill.systems.drill.effects import parameters, states

__all__ = ["drill", "parameters", "states", "system"]

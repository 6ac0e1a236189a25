"""A hybrid system, written down as text or in sympy, and all that is derived from it."""

from chaosdrill.model.maps import Map
from chaosdrill.model.reading import Transition
from chaosdrill.model.system import HybridSystem

__all__ = ["HybridSystem", "Map", "Transition"]

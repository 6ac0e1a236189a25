"""A hybrid system, written down in sympy and derived from there."""

from chaosdrill.model.system import HybridSystem
from chaosdrill.model.transition import Transition

__all__ = ["HybridSystem", "Transition"]

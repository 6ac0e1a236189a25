"""A hybrid system, written down as text or in sympy, and all that is derived from it."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from chaosdrill.model.system import HybridSystem
from chaosdrill.model.transition import Transition

if TYPE_CHECKING:
    from chaosdrill.model.maps import Map

__all__ = ["HybridSystem", "Map", "Transition"]


def __getattr__(name: str) -> Any:
    if name != "Map":
        raise AttributeError(f"module 'chaosdrill.model' has no attribute {name!r}")
    return import_module("chaosdrill.model.maps").Map

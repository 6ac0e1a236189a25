"""Compilation of expressions to kernels."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chaosdrill.codegen.compiled import Kernels, kernels_of

__all__ = ["Kernels", "kernels_of"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'chaosdrill.codegen' has no attribute {name!r}")
    return getattr(import_module("chaosdrill.codegen.compiled"), name)

"""Compilation of expressions to kernels."""

from chaosdrill.codegen.kernels import Kernels, kernels_of

__all__ = ["Kernels", "kernels_of"]

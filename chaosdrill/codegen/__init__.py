"""Expressions become compiled kernels."""

from chaosdrill.codegen.kernels import Kernels, compile_system

__all__ = ["Kernels", "compile_system"]

"""Expressions become compiled kernels."""

from chaosdrill.codegen.build import Kernels, compile_system

__all__ = ["Kernels", "compile_system"]

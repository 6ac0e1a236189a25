"""Analyses of hybrid systems, one file each in ``kinds``, and what they share."""

from typing import Any

from chaosdrill.analysis.registry import FUNCTIONS, function

__all__ = list(FUNCTIONS)


def __getattr__(name: str) -> Any:
    if name not in FUNCTIONS:
        raise AttributeError(f"module 'chaosdrill.analysis' has no attribute {name!r}")
    return function(name)

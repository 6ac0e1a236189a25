"""Names of kinds of analysis and of numerical methods. Imports nothing heavy."""

from importlib import import_module
from typing import Any

from chaosdrill.declared import ANALYSES, METHODS
from chaosdrill.package import modules

FUNCTIONS = tuple(modules("analysis/kinds"))
"""Names of the analysis functions: every file in ``kinds`` is one, of that name."""


def function(name: str) -> Any:
    """The analysis function of a name."""
    return getattr(import_module(f"chaosdrill.analysis.kinds.{name}"), name)


ANALYSES.completed_by(lambda: [function(name).analysis.kind for name in FUNCTIONS])
METHODS.completed_by(lambda: import_module("chaosdrill.engine.methods").NAMES)

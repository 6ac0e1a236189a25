"""One file a kind of analysis; each drives the engine and returns a labelled dataset."""

from importlib import import_module
from typing import Any

_HOME = {
    "trajectory": "trajectories",
    "poincare_section": "sections",
    "lyapunov_spectrum": "spectra",
    "bifurcation_diagram": "diagrams",
    "parameter_chart": "charts",
    "basins": "attraction",
    "periodic_orbit": "periodic_orbits",
    "continue_orbit": "continuation",
    "work_precision": "precision",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'chaosdrill.analysis' has no attribute {name!r}")
    return getattr(import_module(f"chaosdrill.analysis.{_HOME[name]}"), name)

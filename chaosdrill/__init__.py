"""chaosdrill: chaos in hybrid dynamical systems that flow, hit, stick and slip.

The public names are resolved on first use, so that importing the package costs nothing.
"""

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

from chaosdrill.analysis.registry import FUNCTIONS
from chaosdrill.declared import DISPLAYS, KEPT
from chaosdrill.errors import check_environment
from chaosdrill.version import __version__

_HOME = {
    "HybridSystem": "chaosdrill.model",
    "Map": "chaosdrill.model",
    "Transition": "chaosdrill.model",
    "filippov": "chaosdrill.model.filippov",
    "equivalent_control": "chaosdrill.model.filippov",
    "driven": "chaosdrill.model.drives",
    **dict.fromkeys(("Uniform", "Normal", "LogNormal", "Exponential", "Choice"), "chaosdrill.model.noise"),
    "in_modes": "chaosdrill.model.kinks",
    "halved": "chaosdrill.model.halved",
    "on_level": "chaosdrill.model.levels",
    "drill": "chaosdrill.systems.drill",
    "build": "chaosdrill.systems",
    "load_scene": "chaosdrill.scene",
    "parse_scene": "chaosdrill.scene",
    "save_scene": "chaosdrill.scene",
    "check": "chaosdrill.scene",
    "list_names": "chaosdrill.scene",
    "new_scene": "chaosdrill.scene",
    "run": "chaosdrill.workflow",
    "system": "chaosdrill.workflow",
    "info": "chaosdrill.workflow",
    "save": "chaosdrill.archive",
    "open": "chaosdrill.archive",
    "verify": "chaosdrill.workflow",
    "cite": "chaosdrill.workflow",
    "cut": "chaosdrill.archive",
    "join": "chaosdrill.archive",
    "recurrences": "chaosdrill.analysis.measures.pairs",
    "series_measures": "chaosdrill.analysis.measures.measured",
    "event_orders": "chaosdrill.analysis.measures.orders",
    "plot": "chaosdrill.plots",
    "plot_archive": "chaosdrill.plots",
    "animate": "chaosdrill.plots",
    "report": "chaosdrill.reports",
    "Outcome": "chaosdrill.dataset",
    "ChaosdrillError": "chaosdrill.errors",
    "ModelError": "chaosdrill.errors",
    "SettingsError": "chaosdrill.errors",
    "SceneError": "chaosdrill.errors",
    "ArchiveError": "chaosdrill.errors",
    "StartWarning": "chaosdrill.errors",
}

_HOME |= dict.fromkeys(FUNCTIONS, "chaosdrill.analysis")

__all__ = [*_HOME, "__version__"]


if "xarray" in sys.modules:
    # else its first result, or archive, gives datasets their accessor
    import_module("chaosdrill.dataset.words")


def _display(function: str) -> Callable[[Any], str | None]:
    return lambda system: getattr(import_module("chaosdrill.reports.origin"), function)(system)


def _recall(shared: Any) -> Any:
    return import_module("chaosdrill.codegen.record").recall(shared)


KEPT["recall"] = _recall
DISPLAYS |= {"html": _display("system_html"), "latex": _display("system_latex")}


def _meant(name: str) -> str:
    """The remedy of a name that is not public."""
    spelt = {
        "open": ("load", "read", "load_archive", "open_dataset"),
        "trajectory": ("simulate", "solve", "integrate", "solve_ivp", "evolve", "orbit", "odeint"),
        "lyapunov_spectrum": ("lyapunov", "lyapunovs", "lyapunov_exponents", "kaplan_yorke", "lce", "lyapunovspectrum"),
        "continue_orbit": ("continuation", "continuate", "branch"),
        "list_names": ("help", "names", "systems", "list"),
        "periodic_orbit": ("find_orbit", "shooting", "limit_cycle"),
    }
    if own := next((ours for ours, theirs in spelt.items() if name.lower() in theirs), ""):
        return f"did you mean {own!r}?"
    if name in ("with_initial", "with_noise", "with_parameters"):
        return f"systems have it, as in system.{name}(...)"
    told = import_module("chaosdrill.names").remedy(name, __all__)
    return told if told.startswith("did") else "dir(chaosdrill) lists its names"


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        way = "" if name.startswith("_") else f"; {_meant(name)}"
        raise AttributeError(f"module 'chaosdrill' has no attribute {name!r}{way}")
    check_environment()
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)

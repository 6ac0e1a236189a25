"""What diagrams, charts and basins have in common: their axes, and how results become variables."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.arguments import real
from chaosdrill.analysis.points import Axis
from chaosdrill.dataset.schema import RESERVED
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

_WORDS = {1: ("one parameter", "one parameter with its values"), 2: ("two", "two parameters with their values")}


def parameter_axes(system: "HybridSystem", sweep: Any, count: int, what: str) -> tuple[Axis, ...]:
    """The swept parameters and their values, checked; there are to be ``count`` of them."""
    example = {name: [0.5, 0.6] for name in list(system.parameters)[:count]}
    if not isinstance(sweep, Mapping):
        raise SettingsError(f"sweep is {sweep!r}; it must be {_WORDS[count][1]}, as in {example}")
    if len(sweep) != count:
        raise SettingsError(f"sweep names {sorted(map(str, sweep))}; {what} sweeps {_WORDS[count][0]}")
    return tuple(_axis(system, "sweep", "parameter", str(key), values) for key, values in sweep.items())


def state_axes(system: "HybridSystem", grid: Any) -> tuple[Axis, ...]:
    """The two states that span a grid of initial states, and their values, checked."""
    example = {name: [-1.0, 0.0, 1.0] for name in system.state_names[:2]}
    if not isinstance(grid, Mapping):
        raise SettingsError(f"grid is {grid!r}; it must be two states with their values, as in {example}")
    if len(grid) != 2:
        raise SettingsError(f"grid names {sorted(map(str, grid))}; basins are drawn over two states, as in {example}")
    return tuple(_axis(system, "grid", "state", str(key), values) for key, values in grid.items())


def _axis(system: "HybridSystem", argument: str, kind: str, name: str, given: Any) -> Axis:
    known = system.parameters if kind == "parameter" else system.state_names
    if name not in known:
        raise SettingsError(f"{argument} names {name!r}, which is no {kind} of {system.name}: {sorted(known)}")
    if name in RESERVED:
        raise SettingsError(
            f"{argument} names {name!r}, which is reserved for results and cannot be their coordinate; "
            f"rename the {kind}"
        )
    try:
        values = np.array([real(value) for value in given])
    except TypeError:
        values = np.array([])
    if isinstance(given, str | Mapping) or len(values) == 0 or not np.isfinite(values).all():
        raise SettingsError(f"{argument} of {name!r} is {given!r}; it must be a list of finite numbers, at least one")
    if len(np.unique(values)) != len(values):
        raise SettingsError(f"{argument} of {name!r} holds a value twice; every value may stand there once")
    return Axis(name, values, of_start=kind == "state")


def listed(axes: tuple[Axis, ...]) -> dict[str, list[float]]:
    """Values of the axes by name, as provenance keeps them."""
    return {axis.name: axis.values.tolist() for axis in axes}

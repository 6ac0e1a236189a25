"""The forcing period at the numbers of a run, and whether the system repeats after it there.

A sweep may change what the period is made of: a declared period is proved from the expressions, once, or else checked
at the numbers of every run.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.signatures import event_places
from chaosdrill.errors import SettingsError
from chaosdrill.model import arithmetic
from chaosdrill.model.period import is_periodic, rounding_of, strays

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


def forcing_periods(system: "HybridSystem", parameters: Mapping[str, np.ndarray], points: int) -> np.ndarray:
    """Forcing periods of many points, shape (points,), of a system that has one; NaN where it is no positive number.

    ``parameters`` holds the values, shape (points,), of those that differ from the system's own.
    """
    values = [np.asarray(parameters.get(name, own), dtype=float) for name, own in system.parameters.items()]
    with np.errstate(all="ignore"):
        found = np.broadcast_to(arithmetic.period(system, values, np), (points,))
    found = np.where(np.isreal(found), found.real, np.nan)
    return np.where((found > 0) & np.isfinite(found), found, np.nan)


def repeats(system: "HybridSystem") -> bool:
    """Whether the system is proved to repeat after its period, whatever its parameters."""
    if "repeats" not in system.shared:
        from chaosdrill.model.exponents import differences, expressions

        placed = system.placed
        system.shared["repeats"] = placed.time is None or all(
            is_periodic(placed, e) for e in differences(expressions(placed))
        )
    return bool(system.shared["repeats"])


def check_period(system: "HybridSystem", period: float) -> None:
    """Raise SettingsError if a field, a quadrature, a guard or a reset does not repeat after the period."""
    if repeats(system):
        return
    if "frozen" not in system.shared:
        from chaosdrill.model.derive import frozen_states

        system.shared["frozen"] = [system.states.index(state) for state in frozen_states(system)]
    frozen = system.shared["frozen"]
    kernels = kernels_of(system)
    n, q = len(system.state_names), len(system.quadratures)
    c = kernels.constants(system.parameters)
    place = event_places(n)
    event = np.zeros(place.size)

    def values(state: list[float], instant: float) -> list[float]:
        x, seen = np.array(state), []
        for i in frozen:
            x[i] = system.initial[system.state_names[i]]
        for mode, events in enumerate(kernels.layout.events):
            rates = np.empty(n + q)
            kernels.functions.field(mode, instant, c, x, rates)
            seen.extend(rates)
            for j in range(len(events)):
                seen.append(kernels.functions.guard(mode, j, instant, c, x, event))
                event[place.image : place.jacobian] = x
                seen.append(kernels.functions.event_map(mode, j, instant, c, x.copy(), 0, np.ones(n), 0.0, event))
                seen.extend(event[place.image : place.jacobian])
        return seen

    if strays(values, n, lambda: rounding_of(system.period, system.parameters), period):
        raise SettingsError(
            f"{system.name} does not repeat after its period {system.period} = {period:.12g} at "
            f"{system.parameters}; write the period as an expression of the parameters that set it"
        )

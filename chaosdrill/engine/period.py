"""A declared period is checked at the numbers of the run: a sweep may change what the period is made of."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.errors import SettingsError
from chaosdrill.model.derive import frozen_states

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

_TOLERANCE = 1e-8


def check_period(system: "HybridSystem", period: float) -> None:
    """Raise SettingsError if a field, a quadrature, a guard or a reset does not repeat after the period."""
    kernels = system.kernels
    n, q = len(system.states), len(system.quadratures)
    c = kernels.constants(system.parameters)
    rng = np.random.default_rng(20260104)
    gradient, jacobian = np.empty(n + 1), np.empty((n, n + 1))
    for _ in range(3):
        x, t = rng.uniform(0.1, 0.9, n), rng.uniform(0, period)
        for state in frozen_states(system):
            x[system.states.index(state)] = system.initial[state.name]
        seen = []
        for instant in (t, t + period):
            values = []
            for mode, events in enumerate(kernels.events):
                rates = np.empty(n + q)
                kernels.functions[3](mode, instant, c, x, rates)
                values.extend(rates)
                values.extend(kernels.functions[5](mode, j, instant, c, x, gradient) for j in range(len(events)))
            for transition in range(len(system.transitions)):
                image = np.empty(n)
                kernels.functions[7](transition, instant, c, x, image, jacobian)
                values.extend(image)
            seen.append(np.array(values))
        here, later = seen
        if not np.all(np.abs(later - here) <= _TOLERANCE * (1 + np.abs(here)), where=np.isfinite(here)):
            raise SettingsError(
                f"{system.name} does not repeat after its period {system.period} = {period:.6g} at "
                f"{system.parameters}; write the period as an expression of the parameters that set it"
            )

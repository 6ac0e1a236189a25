"""How a run is computed: method, tolerance, and what follows from them."""

import math
from dataclasses import dataclass

import numpy as np

from chaosdrill.engine.dop853_tables import GUARD_DEGREE
from chaosdrill.engine.methods import DEFAULT, METHODS, Method
from chaosdrill.engine.tuning import RUNS

ORDERS = np.arange(7, 28, 4)
"""Orders of the Taylor series: its coefficients are computed four at a time."""


@dataclass(frozen=True)
class Numerics:
    """How a run is computed.

    Parameters
    ----------
    method : str
        ``"taylor"``; ``"dop853"``, adaptive Runge-Kutta of order 8 for right-hand sides that are not analytic;
        ``"radau"``, implicit, for stiff modes; or ``"rk4"`` for fixed steps with bisection.
    tolerance : float
        Adaptive methods: local error a step, of every state relative to the size that it has had of late, of tangents
        to their length in these scales.
        rk4: width of the bisection for an event, in steps.
    steps : int, optional
        Steps a period, for ``"rk4"`` only; default 200.
    max_events : int, optional
        Events followed in a period, beyond which a run ends with the outcome ``event_limit``; for systems without a
        period in all of the transient, and in all of the run after it. By default 10,000, or ten million without a
        period.
    max_stalls : int, default 50
        Events in succession without time passing, beyond which a run ends with the outcome ``stalled``.
    """

    method: str = DEFAULT
    tolerance: float = 1e-12
    steps: int | None = None
    max_events: int | None = None
    max_stalls: int = 50

    @property
    def traits(self) -> Method:
        """What the method says of itself."""
        traits: Method = METHODS[self.method]
        return traits

    @property
    def steps_a_period(self) -> int:
        """Steps that a method with a fixed step takes in a period, or in a unit of time."""
        return self.steps or RUNS.fixed_steps

    @property
    def angle(self) -> float:
        """The part of a period that such a step takes, in radians."""
        return 2 * math.pi / self.steps_a_period

    @property
    def step_error(self) -> float:
        """Error that a step may make, as a part of what it moves: the tolerance, but for rounding."""
        if self.traits.fixed_step:
            return self.angle**5
        return max(self.tolerance, RUNS.rounding)

    @property
    def global_error(self) -> float:
        """Error that the steps of a forcing period make together, as a part of what they move.

        Adaptive methods are more accurate than their tolerance where motion contracts; fixed steps lose an order.
        """
        return self.step_error * (self.steps_a_period / (2 * math.pi) if self.traits.fixed_step else 1.0)

    @property
    def order(self) -> int:
        """Degree of a guard's polynomial on a step.

        Of a method of series that is their order: a step costs order**2, and its length grows like
        tolerance**(1/order).
        """
        if not self.traits.series:
            return GUARD_DEGREE
        return _nearest_order(RUNS.order, self.tolerance)

    @property
    def batch_order(self) -> int:
        """The same for runs that are stepped in lanes: there the series is the smaller part of a step's cost."""
        return self.order if not self.traits.series else _nearest_order(RUNS.batch_order, self.tolerance)


def _nearest_order(wanted: tuple[float, float], tolerance: float) -> int:
    base, slope = wanted
    return int(ORDERS[np.argmin(np.abs(ORDERS - (base + slope * math.log(tolerance))))])

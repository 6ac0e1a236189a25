"""How a run is computed: method, tolerance, and what follows from them."""

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np

from chaosdrill.declared import METHODS
from chaosdrill.engine.dop853_tables import GUARD_DEGREE
from chaosdrill.errors import SettingsError

MOST = 1_000_000_000
"""Largest limit of events."""

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
        rk4: bisection of event times.
    steps : int, optional
        Steps a period, for ``"rk4"`` only; default 200.
    max_events : int, optional
        Events followed in a period, beyond which a run ends with the outcome ``event_limit``; for systems without a
        period in all of the transient, and in all of the run after it. By default 10,000, or ten million without a
        period.
    max_stalls : int, default 50
        Events in succession without time passing, beyond which a run ends with the outcome ``stalled``.
    """

    method: str = "taylor"
    tolerance: float = 1e-12
    steps: int | None = None
    max_events: int | None = None
    max_stalls: int = 50

    def __post_init__(self) -> None:
        if not isinstance(self.method, str) or self.method not in METHODS:
            raise SettingsError(f"method is {self.method!r}; expected one of {sorted(METHODS)}")
        if not _is_real(self.tolerance) or not 1e-16 <= self.tolerance <= 1e-2:
            raise SettingsError(f"tolerance is {self.tolerance!r}; it must lie between 1e-16 and 1e-2")
        if self.steps is not None and not METHODS[self.method].fixed_step:
            raise SettingsError(f"steps is {self.steps!r}, but method {self.method!r} chooses its own; leave steps out")
        if self.steps is not None and not _is_whole(self.steps, 4, 10_000_000):
            raise SettingsError(f"steps is {self.steps!r}; it must lie between 4 and 10000000 a period, whole")
        if self.max_events is not None and not _is_whole(self.max_events, 1, MOST):
            raise SettingsError(f"max_events is {self.max_events!r}; it must lie between 1 and {MOST}, whole")
        if not _is_whole(self.max_stalls, 1, MOST):
            raise SettingsError(f"max_stalls is {self.max_stalls!r}; it must lie between 1 and {MOST}, whole")

    @property
    def step_error(self) -> float:
        """Error that a step may make, as a part of what it moves: the tolerance, but for rounding."""
        if self.method == "rk4":
            return float((2 * math.pi / (self.steps or 200)) ** 5)
        return max(self.tolerance, _ROUNDING)

    @property
    def order(self) -> int:
        """Degree of a guard's polynomial on a step.

        For ``"taylor"`` that is the order of the series: a step costs order**2, and its length grows like
        tolerance**(1/order).
        """
        if self.method != "taylor":
            return GUARD_DEGREE
        return _nearest_order(6 - 0.62 * math.log(self.tolerance))

    @property
    def batch_order(self) -> int:
        """The same for runs that are stepped in lanes: there the series is the smaller part of a step's cost."""
        return self.order if self.method != "taylor" else _nearest_order(12.5 - 0.42 * math.log(self.tolerance))


_ROUNDING = 4e-15
"""What rounding adds to a step, however small the tolerance."""


def _nearest_order(wanted: float) -> int:
    return int(ORDERS[np.argmin(np.abs(ORDERS - wanted))])


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_whole(value: object, least: int, most: int) -> bool:
    return _is_real(value) and least <= value <= most and value == int(value)  # type: ignore[operator,call-overload]

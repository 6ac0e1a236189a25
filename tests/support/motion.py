"""Hybrid motion as SciPy computes it, one arc after another: what closed forms are checked with."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Field = Callable[[float, np.ndarray], list[float]]
Guard = Callable[[float, np.ndarray], float]


def arc(field: Field, t: float, state: Any, length: float, guard: Guard | None = None) -> tuple[float, np.ndarray]:
    """Time and state where ``guard`` rises through zero, or after ``length`` if it does not."""
    settings: dict[str, Any] = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    if guard is None:
        run = solve_ivp(field, (t, t + length), state, **settings)
        return float(run.t[-1]), run.y[:, -1]

    def event(now: float, there: np.ndarray) -> float:
        # an arc that begins on its guard has to leave it first
        return guard(now, there) if now > t + 1e-9 else -1.0

    event.terminal, event.direction = True, 1  # type: ignore[attr-defined]
    run = solve_ivp(field, (t, t + length), state, events=event, max_step=length / 50, **settings)
    return float(run.t[-1]), run.y[:, -1]

"""States over time, with every event."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, settings, span, whole
from chaosdrill.dataset import Outcome, label
from chaosdrill.engine import layout as at
from chaosdrill.engine.run import Numerics, Run

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

_EVENT_ROWS = 4096


def trajectory(
    system: "HybridSystem",
    *,
    periods: int | None = None,
    duration: float | None = None,
    transient: float = 0,
    samples: int = 200,
    method: str = "taylor",
    tolerance: float = 1e-12,
    steps: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """States at equal intervals of time, and every event.

    Parameters
    ----------
    system : HybridSystem
        System with its parameters and initial state.
    periods : int
        Forcing periods to record; for systems that have a forcing period.
    duration : float
        Time to record; for systems that have none.
    transient : int or float, default 0
        Periods (or time) to run before the record starts.
    samples : int, default 200
        Samples a period (or in all of ``duration``).
    method : {"taylor", "rk4"}
        Numerical method.
    tolerance : float, default 1e-12
        Local error a step, relative to max(1, abs(x)) ("taylor"); bisection of event times ("rk4").
    steps : int, optional
        Steps a period, for "rk4" only; default 200.
    progress : callable, optional
        Called with (done, total, None).

    Returns
    -------
    xarray.Dataset
        ``state`` (time, state), ``mode`` (time), each quadrature (time), and over the dimension event: ``event_time``,
        ``event_kind``, ``event_speed``, ``event_mode_before``, ``event_state_before``, ``event_state_after``;
        ``outcome``. A run that ends early keeps what it has.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    given = settings(dict(locals()))
    plan = span(system, periods, duration, transient)
    samples = whole("samples", samples, 1)
    numerics = Numerics(method, tolerance, steps)
    run = Run(system, plan.unit, numerics, samples=samples)
    outcome = plan.settle(run)
    n, names = len(system.states), list(system.quadratures)
    start = run.elapsed
    rows = np.zeros((plan.count * samples + samples + 2, n + len(names) + 1))
    rows[0, :n], rows[0, -1] = run.x, run.carried[at.MODE]
    filled, events = 1, []
    buffer = np.zeros((_EVENT_ROWS, at.EVENT_COLUMNS + 2 * n))
    first = run.strobes
    target, pending = plan.count, outcome == Outcome.OK
    while pending:
        outcome, full = run.advance(target, rows[filled:], buffer)
        target = 0
        new_rows, new_events = run.filled()
        filled += new_rows
        events.append(buffer[:new_events].copy())
        pending = full and outcome == Outcome.OK
        if progress:
            progress(run.strobes - first, plan.count, None)
    table = np.concatenate(events) if events else np.zeros((0, buffer.shape[1]))
    rows = rows[:filled]
    ds = xr.Dataset(
        {
            "state": (("time", "state"), rows[:, :n]),
            "mode": ("time", rows[:, -1].astype(np.int8)),
            **{name: ("time", rows[:, n + i]) for i, name in enumerate(names)},
            "event_time": ("event", _event_times(table, run, start, first)),
            "event_kind": ("event", table[:, at.EVENT_KIND].astype(np.int8)),
            "event_speed": ("event", table[:, at.EVENT_SPEED]),
            "event_mode_before": ("event", table[:, at.EVENT_MODE].astype(np.int8)),
            "event_state_before": (("event", "state"), table[:, at.EVENT_COLUMNS : at.EVENT_COLUMNS + n]),
            "event_state_after": (("event", "state"), table[:, at.EVENT_COLUMNS + n :]),
            "outcome": ((), np.int8(outcome)),
        },
        coords={
            "time": start + np.arange(filled) * (plan.unit / samples),
            "state_name": ("state", list(system.state_names)),
        },
    )
    if plan.periodic:
        ds["forcing_period"] = ((), plan.unit)
    return label(ds, "trajectory", system=system, settings=given)


def _event_times(table: np.ndarray, run: Run, start: float, first: int) -> Any:
    return start + (table[:, at.EVENT_STROBES] - first) * run.period + table[:, at.EVENT_TIME]

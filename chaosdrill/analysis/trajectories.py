"""States over time, with every event."""

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import Progress, settings, span, whole
from chaosdrill.analysis.recording import record
from chaosdrill.dataset import Outcome, label
from chaosdrill.engine import layout as at
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


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
    max_events: int | None = None,
    max_stalls: int = 50,
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
    method : {"taylor", "dop853", "rk4"}
        Numerical method.
    tolerance : float, default 1e-12
        Local error a step, of every state relative to the size that it has had of late ("taylor", "dop853");
        bisection of event times ("rk4").
    steps : int, optional
        Steps a period, for "rk4" only; default 200.
    max_events : int, optional
        Events followed in a period, beyond which a run ends with the outcome ``event_limit``; for systems without a
        period in all of the transient, and in all of the run after it. By default 10,000, or ten million without a
        period.
    max_stalls : int, default 50
        Events in succession without time passing, beyond which a run ends with the outcome ``stalled``.
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
    numerics = Numerics(method, tolerance, steps, max_events, max_stalls)
    run = Run(system, plan.unit, numerics, samples=samples)
    outcome = plan.settle(run)
    n, names = len(system.states), list(system.quadratures)
    start = run.elapsed
    here = np.concatenate([run.x, np.zeros(len(names)), [run.standing["mode"]]])
    report = None if progress is None else lambda done: progress(done, plan.count, None)
    found = record(run, plan.count if outcome == Outcome.OK else 0, events=True, report=report)
    outcome = found.outcome if outcome == Outcome.OK else outcome
    rows = np.vstack([here, found.samples])
    ds = xr.Dataset(
        {
            "state": (("time", "state"), rows[:, :n]),
            "mode": ("time", rows[:, -1].astype(np.int8)),
            **{name: ("time", rows[:, n + i]) for i, name in enumerate(names)},
            "event_time": ("event", found.times),
            "event_kind": ("event", found.events[:, at.EVENT_KIND].astype(np.int8)),
            "event_speed": ("event", found.events[:, at.EVENT_SPEED]),
            "event_mode_before": ("event", found.events[:, at.EVENT_MODE].astype(np.int8)),
            "event_state_before": (("event", "state"), found.states_before()),
            "event_state_after": (("event", "state"), found.states_after()),
            "outcome": ((), np.int8(outcome)),
        },
        coords={
            "time": start + np.arange(len(rows)) * (plan.unit / samples),
            "state_name": ("state", list(system.state_names)),
        },
    )
    if plan.periodic:
        ds["forcing_period"] = ((), plan.unit)
    return label(ds, "trajectory", system=system, settings=given)

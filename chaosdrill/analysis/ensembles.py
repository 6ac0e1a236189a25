"""Trajectories as datasets: one run, or one for each of many initial states on common times."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from chaosdrill.analysis.recording import Record
from chaosdrill.analysis.sections import SAMPLES, Path, find_section, traced
from chaosdrill.analysis.starts import states_and_modes
from chaosdrill.engine import layout as at

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job
    from chaosdrill.model import HybridSystem
    from chaosdrill.progress import Progress


def one_run(system: "HybridSystem", given: Any, job: "Job") -> xr.Dataset:
    """The trajectory from the system's own initial state; see `trajectory`."""
    path = traced(find_section(system, given, job.numerics), given, job)
    n = len(system.states)
    variables: dict[str, Any] = {
        "states": (("time", "state"), path.rows[:, :n]),
        "mode": ("time", path.rows[:, -1].astype(np.int8)),
        **{name: ("time", path.rows[:, n + i]) for i, name in enumerate(system.quadratures)},
        **_events(system, [path.events]),
        "outcome": ((), np.int8(path.outcome)),
    }
    if given.tangents is not None:
        variables["initial_tangent"] = (("tangent", "state"), given.tangents)
        variables["final_tangent"] = (("tangent", "state"), path.tangents)
    return _completed(system, variables, path.times)


def ensemble(system: "HybridSystem", given: Any, job: "Job") -> xr.Dataset:
    """A trajectory from each of many initial states, on the same times; what one does not reach is NaN."""
    starts, modes = states_and_modes(system, given.initial)
    plan = given.span(system, job.numerics)
    begin = plan.transient * plan.unit if plan.periodic else plan.transient
    parts = plan.count * (given.samples or SAMPLES)
    even = begin + np.arange(parts + 1) * (plan.length / parts)
    times = even if given.times is None else np.array(given.times, dtype=float)
    n, q, runs = len(system.states), len(system.quadratures), len(starts)
    rows = np.full((runs, len(times), n + q + 1), np.nan)
    rows[..., -1] = -1
    paths: list[Path] = []
    for k, (start, mode) in enumerate(zip(starts, modes.tolist(), strict=True)):
        initial = dict(zip(system.state_names, start.tolist(), strict=True))
        own = system.with_initial(**initial, mode=system.mode_names[mode])
        progress = None if job.progress is None else _part(job.progress, k, runs)
        path = traced(find_section(own, given, job.numerics), given, replace(job, progress=progress))
        if len(path.times) and path.times[0] >= times[0]:
            rows[k, : len(path.rows)] = path.rows
        paths.append(path)
    variables: dict[str, Any] = {
        "states": (("run", "time", "state"), rows[..., :n]),
        "mode": (("run", "time"), rows[..., -1].astype(np.int8)),
        **{name: (("run", "time"), rows[..., n + i]) for i, name in enumerate(system.quadratures)},
        **_events(system, [path.events for path in paths]),
        "event_count": ("run", np.array([len(path.events.events) for path in paths], dtype=np.int32)),
        "initial_state": (("run", "state"), starts),
        "initial_mode": ("run", modes.astype(np.int8)),
        "outcome": ("run", np.array([path.outcome for path in paths], dtype=np.int8)),
    }
    if given.tangents is not None:
        variables["initial_tangent"] = (("tangent", "state"), given.tangents)
        variables["final_tangent"] = (("run", "tangent", "state"), np.array([path.tangents for path in paths]))
    return _completed(system, variables, times).assign_coords(run=np.arange(1, runs + 1, dtype=np.int32))


def _events(system: "HybridSystem", records: list[Record]) -> Mapping[str, Any]:
    """Events of one run after the other."""
    rows = np.concatenate([one.events for one in records])
    targets = np.array([system.mode_names.index(t.target) for t in system.transitions], dtype=np.int8)
    return {
        "event_time": ("event", np.concatenate([one.times for one in records])),
        "event_kind": ("event", rows[:, at.EVENT_KIND].astype(np.int8)),
        "event_speed": ("event", rows[:, at.EVENT_SPEED]),
        "event_mode_before": ("event", rows[:, at.EVENT_MODE].astype(np.int8)),
        "event_mode_after": ("event", targets[rows[:, at.EVENT_KIND].astype(int)]),
        "event_state_before": (("event", "state"), np.concatenate([one.states_before() for one in records])),
        "event_state_after": (("event", "state"), np.concatenate([one.states_after() for one in records])),
    }


def _completed(system: "HybridSystem", variables: dict[str, Any], times: np.ndarray) -> xr.Dataset:
    if system.period is not None:
        variables["forcing_period"] = ((), system.forcing_period())
    coords: dict[str, Any] = {"time": times, "state": list(system.state_names)}
    if "initial_tangent" in variables:
        coords["tangent"] = np.arange(1, len(variables["initial_tangent"][1]) + 1, dtype=np.int32)
    return xr.Dataset(variables, coords=coords)


def _part(progress: "Progress", before: int, runs: int) -> "Progress":
    """Progress of one run among several of the same length."""
    return lambda done, total, outcomes: progress(before * total + done, runs * total, outcomes)
